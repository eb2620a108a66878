//! Axes and centres on one line.
//!
//! Axes of one cluster of directions are compared where they cross a plane perpendicular to it. Where an axis crosses
//! that plane depends on the direction of the cluster, which is not known exactly: a position is a mean and a covariance
//! *given* the direction, and a derivative by it. Axes far apart that lie on one line therefore say more about the
//! direction than each of them does, and the cluster takes it from them before it is related to others.
//!
//! Gathered as directions are (`gather`); an axis that has nothing in common with another lies anywhere in the
//! cross-section of the part. The centre of a sphere joins a line, but founds none: any two centres lie on one.
//!
//! A narrow band shows its direction so badly that this alone joins no cluster: many fit it. Where its axis lies it shows
//! well. An axis that is alone in its cluster may therefore join a line of another by direction and position together.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix2, Matrix3x2, Vector2};

use super::directions::{self, Cluster, Direction};
use super::evidence::Position;
use super::gather::{Agreement, Group, forced, gathered};
use super::relation::Manufacture;
use crate::math::{Mat3, Point3, UnitVec3, centroid};

/// Where a line lies.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedLine {
    /// A point of it.
    pub through: Point3,
    /// Covariance of that point, given the direction; none along the line.
    pub covariance: Mat3,
    /// What the point moves by when the direction does.
    pub by_direction: Mat3,
}

/// Things on one line, at least one of them an axis.
#[derive(Debug, Clone)]
pub(super) struct Line {
    /// Indices of primitives.
    pub members: Vec<usize>,
    at: Crossing,
    /// What the members say together about the direction of the cluster: the inverse of a covariance, per radian
    /// squared, and its product with the mean, by which they would turn it.
    information: Matrix2<f64>,
    pull: Vector2<f64>,
    /// Whether anything may join.
    is_axis: bool,
}

/// A plane perpendicular to a cluster of directions.
#[derive(Debug, Clone, Copy)]
struct Section {
    /// Index of the cluster.
    cluster: usize,
    unit: UnitVec3,
    origin: Point3,
    /// Two unit vectors in the plane, as columns.
    tangents: Matrix3x2<f64>,
    /// Covariance of the cluster's direction, in `tangents`.
    direction: Matrix2<f64>,
    /// Size of the part's shadow in it, length squared.
    area: f64,
}

/// Where something crosses a section, in its tangents.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    section: Section,
    mean: Vector2<f64>,
    /// Given the direction of the cluster.
    covariance: Matrix2<f64>,
    /// What it moves by when the direction does.
    by_direction: Matrix2<f64>,
}

/// An axis or a centre.
pub(super) struct Seen {
    primitive: usize,
    is_axis: bool,
    /// One per section that it may belong to, at least one; an axis that is not alone has only that of its own cluster.
    /// That of its own cluster comes first.
    places: Vec<Place>,
}

/// A section that something may belong to.
struct Place {
    crossing: Crossing,
    /// How its own direction agrees with that of the section; `None` for a centre and in its own cluster.
    turn: Option<directions::Comparison>,
}

/// A crossing compared with that of a line.
pub(super) struct Comparison {
    crossing: Crossing,
    dimensions: usize,
    z_sq: f64,
    odds: f64,
}

impl Agreement for Comparison {
    fn dimensions(&self) -> usize {
        self.dimensions
    }

    fn z_sq(&self) -> f64 {
        self.z_sq
    }

    fn odds(&self) -> f64 {
        self.odds
    }
}

impl Line {
    /// Whether things share it.
    pub fn is_shared(&self) -> bool {
        self.members.len() > 1
    }

    /// Index of its cluster of directions.
    pub fn cluster(&self) -> usize {
        self.at.section.cluster
    }

    /// Where it lies when the direction of its cluster has become `unit`.
    pub fn placed(&self, unit: &UnitVec3) -> PlacedLine {
        let Crossing { section, mean, covariance, by_direction } = &self.at;
        let tangents = &section.tangents;
        let moved = tangents.transpose() * (unit.into_inner() - section.unit.into_inner());
        PlacedLine {
            through: section.origin + tangents * (mean + by_direction * moved),
            covariance: tangents * covariance * tangents.transpose(),
            by_direction: tangents * by_direction * tangents.transpose(),
        }
    }

    /// The direction of its cluster as it is with what the members say: mean, by which it moves, and covariance.
    fn direction(&self) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        with_information(&self.at.section.direction, &self.information, &self.pull)
    }

    fn compared(&self, place: &Place) -> Option<Comparison> {
        let crossing = &place.crossing;
        let (moved, direction) = self.direction()?;
        let lever = crossing.by_direction - self.at.by_direction;
        let deviation = crossing.mean - self.at.mean + lever * moved;
        let covariance = self.at.covariance + crossing.covariance + lever * direction * lever.transpose();
        let z_sq = deviation.dot(&(covariance.try_inverse()? * deviation));
        let odds = crossing.section.area / (TAU * covariance.determinant().max(0.0).sqrt());
        let position =
            Comparison { crossing: *crossing, dimensions: 2, z_sq, odds: odds * (-0.5 * z_sq).exp() };
        Some(match &place.turn {
            None => position,
            Some(turn) => Comparison {
                dimensions: position.dimensions + turn.dimensions(),
                z_sq: position.z_sq + turn.z_sq(),
                odds: position.odds * turn.odds(),
                ..position
            },
        })
    }
}

impl Group for Line {
    type Thing = Seen;
    type Agreement = Comparison;

    fn founded_by(seen: &Seen) -> Self {
        Self {
            members: vec![seen.primitive],
            at: seen.places[0].crossing,
            information: Matrix2::zeros(),
            pull: Vector2::zeros(),
            is_axis: seen.is_axis,
        }
    }

    fn n_members(&self) -> usize {
        self.members.len()
    }

    fn agreements(lines: &[Self], seen: &Seen) -> Vec<Option<Comparison>> {
        let compared = |line: &Self| {
            let place = seen.places.iter().find(|p| p.crossing.section.cluster == line.cluster())?;
            line.compared(place).filter(|_| line.is_axis)
        };
        lines.iter().map(compared).collect()
    }

    fn with(&self, seen: &Seen, comparison: &Comparison) -> Option<Self> {
        let crossing = &comparison.crossing;
        let weight = (self.at.covariance + crossing.covariance).try_inverse()?;
        let gain = self.at.covariance * weight;
        let deviation = crossing.mean - self.at.mean;
        let lever = crossing.by_direction - self.at.by_direction;
        Some(Self {
            members: self.members.iter().copied().chain([seen.primitive]).collect(),
            at: Crossing {
                section: self.at.section,
                mean: self.at.mean + gain * deviation,
                covariance: self.at.covariance - gain * self.at.covariance,
                by_direction: self.at.by_direction + gain * lever,
            },
            information: self.information + lever.transpose() * weight * lever,
            pull: self.pull - lever.transpose() * weight * deviation,
            is_axis: self.is_axis,
        })
    }
}

/// Mean and covariance of a direction with covariance `own` and what `information` and `pull` add.
fn with_information(
    own: &Matrix2<f64>,
    information: &Matrix2<f64>,
    pull: &Vector2<f64>,
) -> Option<(Vector2<f64>, Matrix2<f64>)> {
    let covariance = (own.try_inverse()? + information).try_inverse()?;
    Some((covariance * pull, covariance))
}

/// All lines, also of one member; the directions of `clusters` take what these say about them, and these the axes that
/// joined a line of theirs.
///
/// `directions` and `positions`: one per primitive, `None` for those without and those that are on no line. `form`: what
/// manufacture deviates by. `points`: the part. `asked`: the sets of primitives that are to be on one line; found by
/// evidence when `None`.
pub(super) fn coaxial(
    clusters: &mut Vec<Cluster>,
    directions: &[Option<Direction>],
    positions: &[Option<Position>],
    form: &Manufacture,
    points: &[Point3],
    asked: Option<&[Vec<usize>]>,
) -> Vec<Line> {
    let middle = centroid(points);
    let spread = spread_about(&middle, points);
    let sections: Vec<Section> =
        clusters.iter().enumerate().map(|(c, k)| section(c, &k.direction, middle, &spread)).collect();
    let alone = if asked.is_none() { directions } else { &[] };
    let seen = seen(clusters, &sections, alone, positions, form);
    let mut lines: Vec<Line> =
        asked.map_or_else(|| gathered(&seen), |sets| forced(&seen, sets, |seen: &Seen| seen.primitive));
    lines.retain(|line| line.is_axis);
    for (c, cluster) in clusters.iter_mut().enumerate() {
        let (mut information, mut pull) = (Matrix2::zeros(), Vector2::zeros());
        for line in lines.iter().filter(|line| line.cluster() == c) {
            information += line.information;
            pull += line.pull;
        }
        let section = &sections[c];
        if let Some((moved, covariance)) = with_information(&section.direction, &information, &pull)
            && information != Matrix2::zeros()
        {
            cluster.direction = cluster.direction.moved(&section.tangents, &moved, &covariance);
        }
    }
    join_clusters(clusters, &mut lines);
    lines
}

/// Moves what joined a line of another cluster into that; clusters that are left without members go.
fn join_clusters(clusters: &mut Vec<Cluster>, lines: &mut [Line]) {
    for line in lines.iter() {
        for &k in &line.members {
            let own = clusters.iter().position(|c| c.members.contains(&k));
            if let Some(own) = own.filter(|&own| own != line.cluster()) {
                clusters[own].members.retain(|&member| member != k);
                clusters[line.cluster()].members.push(k);
            }
        }
    }
    let mut n_kept = 0;
    let new_index: Vec<usize> = clusters
        .iter()
        .map(|cluster| {
            let index = n_kept;
            n_kept += usize::from(!cluster.members.is_empty());
            index
        })
        .collect();
    for line in lines {
        line.at.section.cluster = new_index[line.cluster()];
    }
    clusters.retain(|cluster| !cluster.members.is_empty());
}

fn section(cluster: usize, direction: &Direction, origin: Point3, spread: &Mat3) -> Section {
    let tangents = direction.tangents();
    let flat: Matrix2<f64> = tangents.transpose() * spread * tangents;
    Section {
        cluster,
        unit: direction.unit,
        origin,
        tangents,
        direction: direction.in_tangents(&tangents),
        // A filled ellipse has semi-axes of twice its standard deviations.
        area: 4.0 * PI * flat.determinant().max(0.0).sqrt(),
    }
}

/// Second moments of `points` about `middle`, length squared.
fn spread_about(middle: &Point3, points: &[Point3]) -> Mat3 {
    let sum = points.iter().fold(Mat3::zeros(), |sum, p| sum + (p - middle) * (p - middle).transpose());
    sum / points.len().max(1) as f64
}

/// All axes, then all centres, best seen first. `alone`: directions of the axes that may join another cluster than theirs.
fn seen(
    clusters: &[Cluster],
    sections: &[Section],
    alone: &[Option<Direction>],
    positions: &[Option<Position>],
    form: &Manufacture,
) -> Vec<Seen> {
    let mut all: Vec<(bool, f64, Seen)> = Vec::new();
    for (primitive, position) in positions.iter().enumerate() {
        let Some(position) = position else { continue };
        let is_axis = position.is_axis();
        let at = |section: &Section| crossing(section, position, form);
        let own = clusters.iter().position(|c| c.members.contains(&primitive)).filter(|_| is_axis);
        let mut places: Vec<Place> =
            own.iter().map(|&c| Place { crossing: at(&sections[c]), turn: None }).collect();
        let others = sections.iter().enumerate().filter(|&(c, _)| own != Some(c));
        if !is_axis {
            places.extend(others.map(|(_, section)| Place { crossing: at(section), turn: None }));
        } else if own.is_some_and(|c| clusters[c].members.len() == 1)
            && let Some(Some(direction)) = alone.get(primitive)
        {
            places.extend(others.filter_map(|(c, section)| {
                let turn = directions::Comparison::new(&clusters[c].direction, direction, None)?;
                Some(Place { crossing: at(section), turn: Some(turn) })
            }));
        }
        let Some(first) = places.first() else { continue };
        let spread = first.crossing.covariance.determinant();
        all.push((!is_axis, spread, Seen { primitive, is_axis, places }));
    }
    all.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.primitive.cmp(&b.2.primitive)));
    all.into_iter().map(|(_, _, seen)| seen).collect()
}

/// Where `position` crosses `section`, and how uncertain that is: as its points say, and what real faces deviate by.
fn crossing(section: &Section, position: &Position, form: &Manufacture) -> Crossing {
    let tangents = &section.tangents;
    let (point, by_direction) = position.given(&section.unit);
    let height = (section.origin - point).dot(&section.unit);
    let form = form.angle * position.reach;
    Crossing {
        section: *section,
        mean: tangents.transpose() * (point - section.origin),
        covariance: tangents.transpose() * position.covariance * tangents
            + Matrix2::identity() * form.powi(2),
        by_direction: tangents.transpose() * by_direction * tangents + Matrix2::identity() * height,
    }
}
