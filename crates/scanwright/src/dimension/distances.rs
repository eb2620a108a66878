//! Distances and angles between faces.

use std::collections::BTreeSet;

use super::known::Known;
use super::{Dimension, DimensionKind, dimension};
use crate::math::{UnitVec3, Vec3, angle_between};
use crate::mesh::Adjacency;
use crate::segment::Segmentation;
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// Sine of the angle up to which directions are one: relations make them so to rounding.
const PARALLEL: f64 = Tolerances::SAME;
/// Axes of one direction up to which every two have a distance; of more, each has one to its nearest.
const MOST_IN_PAIRS: usize = 8;

/// Pairs of regions that touch, smaller number first.
pub(super) struct Neighbors(BTreeSet<(u32, u32)>);

impl Neighbors {
    pub fn new(adjacency: &Adjacency, segmentation: &Segmentation) -> Self {
        let labels = &segmentation.labels;
        let mut pairs = BTreeSet::new();
        for (t, across) in adjacency.across.iter().enumerate() {
            for u in across.iter().flatten() {
                if let (Some(a), Some(b)) = (labels[t], labels[*u as usize])
                    && a.0 < b.0
                {
                    pairs.insert((a.0, b.0));
                }
            }
        }
        Self(pairs)
    }

    fn touch(&self, a: &Known, b: &Known) -> bool {
        self.0.contains(&(a.id.min(b.id), a.id.max(b.id)))
    }
}

/// Distances and angles of all pairs that a drawing would have.
pub(super) fn of(known: &[Known], neighbors: &Neighbors) -> Vec<Dimension> {
    let planes: Vec<&Known> = known.iter().filter(|k| k.is_plane()).collect();
    let axes: Vec<&Known> = known.iter().filter(|k| k.surface.axis().is_some()).collect();
    let families = families(&planes);
    let mut all = Vec::new();
    for family in &families {
        all.extend(family.distances());
        all.extend(family.walls());
    }
    let lines = lines(&axes);
    all.extend(between_lines(&lines));
    for line in &lines {
        all.extend(families.iter().filter_map(|family| to_datum(line, family)));
    }
    all.extend(axes.iter().flat_map(|bore| depths(bore, &planes, neighbors)));
    all.extend(angles(&planes, neighbors));
    all
}

/// Planes of one direction, the largest first.
struct Family<'a> {
    normal: UnitVec3,
    planes: Vec<&'a Known>,
}

fn families<'a>(planes: &[&'a Known]) -> Vec<Family<'a>> {
    let mut by_area = planes.to_vec();
    by_area.sort_by(|a, b| b.area.total_cmp(&a.area).then(a.id.cmp(&b.id)));
    let mut families: Vec<Family> = Vec::new();
    for plane in by_area {
        let Some(normal) = plane.direction() else { continue };
        match families.iter_mut().find(|f| are_parallel(&f.normal, &normal)) {
            Some(family) => family.planes.push(plane),
            None => families.push(Family { normal, planes: vec![plane] }),
        }
    }
    families
}

fn are_parallel(a: &UnitVec3, b: &UnitVec3) -> bool {
    a.cross(b).norm() < PARALLEL
}

impl Family<'_> {
    fn height(&self, plane: &Known) -> f64 {
        match &plane.surface {
            Surface::Plane(s) => self.normal.dot(&s.point.coords),
            _ => 0.0,
        }
    }

    /// Distance of two planes with its variance: where the smaller is, from the larger continued there.
    fn between(&self, one: &Known, other: &Known) -> (f64, f64) {
        let (large, small) = if one.area < other.area { (other, one) } else { (one, other) };
        let at = small.frame.origin;
        let normal = self.normal.into_inner();
        let variance = large.variance_at(&at, &normal) + small.variance_at(&at, &normal);
        ((self.height(other) - self.height(one)).abs(), variance)
    }

    /// From the largest plane to each level.
    fn distances(&self) -> Vec<Dimension> {
        let Some((datum, others)) = self.planes.split_first() else { return Vec::new() };
        let mut levels: Vec<f64> = vec![self.height(datum)];
        let mut all = Vec::new();
        for plane in others {
            let height = self.height(plane);
            // Coplanar faces are one level: relations make them so to rounding.
            let scale = height.abs().max(self.height(datum).abs()).max(plane.area.sqrt());
            if levels.iter().any(|level| (level - height).abs() < PARALLEL * scale) {
                continue;
            }
            levels.push(height);
            let (value, variance) = self.between(datum, plane);
            all.push(dimension(DimensionKind::Distance, &[datum, plane], value, variance));
        }
        all
    }

    /// Walls and gaps: each plane with the nearest that faces it or turns its back on it, where the two overlap.
    fn walls(&self) -> Vec<Dimension> {
        let mut all = Vec::new();
        for (i, plane) in self.planes.iter().enumerate() {
            let own = plane.direction().map_or(1.0, |n| n.dot(&self.normal).signum());
            // Inward of it is material: what turns its back on it there is the other side of a wall.
            for (kind, side) in [(DimensionKind::Thickness, -own), (DimensionKind::Width, own)] {
                let opposite = self.planes.iter().enumerate().filter(|(j, other)| {
                    let facing = other.direction().is_some_and(|n| n.dot(&self.normal) * own < 0.0);
                    *j != i && facing && (self.height(other) - self.height(plane)) * side > 0.0
                });
                let overlapping = opposite.filter(|(_, other)| self.overlap(plane, other));
                let nearest = overlapping.min_by(|a, b| {
                    let gap = |other: &Known| (self.height(other) - self.height(plane)).abs();
                    gap(a.1).total_cmp(&gap(b.1)).then(a.0.cmp(&b.0))
                });
                // Each pair once, from its larger plane.
                if let Some((j, other)) = nearest
                    && i < j
                {
                    let (value, variance) = self.between(plane, other);
                    all.push(dimension(kind, &[plane, other], value, variance));
                }
            }
        }
        all
    }

    /// Whether some points of the smaller plane lie over those of the larger.
    fn overlap(&self, a: &Known, b: &Known) -> bool {
        let (large, small) = if a.area < b.area { (b, a) } else { (a, b) };
        let near = (large.area / large.points.len().max(1) as f64).sqrt() * 2.0;
        small.points.iter().any(|p| {
            large.points.iter().any(|q| {
                let apart = p - q;
                let along = self.normal.into_inner() * self.normal.dot(&apart);
                (apart - along).norm() < near
            })
        })
    }
}

/// One primitive per line that axes lie on, the largest; in order of size.
fn lines<'a>(axes: &[&'a Known]) -> Vec<&'a Known> {
    let mut by_area = axes.to_vec();
    by_area.sort_by(|a, b| b.area.total_cmp(&a.area).then(a.id.cmp(&b.id)));
    let mut lines: Vec<&Known> = Vec::new();
    for known in by_area {
        let Some(axis) = known.surface.axis() else { continue };
        let is_new = lines.iter().all(|line| {
            line.surface.axis().is_none_or(|other| {
                let apart = other.radial(&axis.origin).norm();
                !are_parallel(&other.direction, &axis.direction) || apart > PARALLEL * known.area.sqrt()
            })
        });
        if is_new {
            lines.push(known);
        }
    }
    lines
}

/// Distances of parallel axes.
fn between_lines(lines: &[&Known]) -> Vec<Dimension> {
    let distance = |a: &&Known, b: &&Known| -> Option<Dimension> {
        let (one, other) = (a.surface.axis()?, b.surface.axis()?);
        if !are_parallel(&one.direction, &other.direction) {
            return None;
        }
        let across = one.radial(&b.frame.origin) - other.radial(&b.frame.origin);
        let along = across.try_normalize(0.0)?;
        let at = b.frame.origin;
        let variance = a.variance_at(&at, &along) + b.variance_at(&at, &along);
        Some(dimension(DimensionKind::AxisDistance, &[a, b], across.norm(), variance))
    };
    let mut all = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let before: Vec<Dimension> = lines[..i].iter().filter_map(|other| distance(other, line)).collect();
        if before.len() < MOST_IN_PAIRS {
            all.extend(before);
        } else {
            all.extend(before.into_iter().min_by(|a, b| a.value.total_cmp(&b.value)));
        }
    }
    all
}

/// From the largest plane of a direction to an axis along it.
fn to_datum(line: &Known, family: &Family) -> Option<Dimension> {
    let axis = line.surface.axis()?;
    let datum = family.planes.first()?;
    if axis.direction.dot(&family.normal).abs() > PARALLEL {
        return None;
    }
    let at = axis.foot(&line.frame.origin);
    let normal = family.normal.into_inner();
    let value = (normal.dot(&at.coords) - family.height(datum)).abs();
    let variance = datum.variance_at(&at, &normal) + line.variance_at(&at, &normal);
    Some(dimension(DimensionKind::AxisToPlane, &[datum, line], value, variance))
}

/// From the planes that a bore opens in to its floor: both face the same way.
fn depths(bore: &Known, planes: &[&Known], neighbors: &Neighbors) -> Vec<Dimension> {
    let (Surface::Cylinder(s), false) = (&bore.surface, bore.outward) else { return Vec::new() };
    let direction = s.axis.direction;
    let ends: Vec<&&Known> = planes
        .iter()
        .filter(|p| neighbors.touch(bore, p) && p.direction().is_some_and(|n| are_parallel(&n, &direction)))
        .collect();
    let mut all = Vec::new();
    for (i, a) in ends.iter().enumerate() {
        for b in &ends[i + 1..] {
            let (Some(na), Some(nb)) = (a.direction(), b.direction()) else { continue };
            let family = Family { normal: na, planes: vec![a, b] };
            let (value, variance) = family.between(a, b);
            if na.dot(&nb) > 0.0 && value > 0.0 {
                // The floor is the lower of the two along their normal.
                let (top, floor) = if family.height(a) > family.height(b) { (a, b) } else { (b, a) };
                let mut depth = dimension(DimensionKind::Depth, &[top, floor], value, variance);
                depth.of.push(bore.id);
                all.push(depth);
            }
        }
    }
    all
}

/// Angles of planes that touch, neither parallel nor at a right angle.
fn angles(planes: &[&Known], neighbors: &Neighbors) -> Vec<Dimension> {
    let angle = |a: &Known, b: &Known| -> Option<Dimension> {
        let (u, v) = (a.direction()?, b.direction()?);
        if are_parallel(&u, &v) || u.dot(&v).abs() < PARALLEL || !neighbors.touch(a, b) {
            return None;
        }
        let between = angle_between(&u, &v);
        let value = between.min(std::f64::consts::PI - between);
        // A direction moves the angle along the plane of both.
        let towards = |from: &UnitVec3, to: &UnitVec3| -> Option<Vec3> {
            (to.into_inner() - from.into_inner() * from.dot(to)).try_normalize(0.0)
        };
        let variance =
            a.variance_of_direction(&towards(&u, &v)?) + b.variance_of_direction(&towards(&v, &u)?);
        Some(dimension(DimensionKind::Angle, &[a, b], value, variance))
    };
    let pairs = planes.iter().enumerate().flat_map(|(i, a)| planes[i + 1..].iter().map(move |b| (a, b)));
    pairs.filter_map(|(a, b)| angle(a, b)).collect()
}
