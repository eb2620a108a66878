//! A run of narrow turned faces between wide ones, and the faces that its profile shows.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector2;

use super::chain::{Arc, Chain, Element, Line, Misfit, Outline, Piece, Scale};
use super::generatrix::surface_of_arc;
use super::profile::{self, Mean};
use super::search::best_chain;
use super::{level_sectors, turned_line};
use crate::fit::Fit;
use crate::math::{Axis, Frame, UnitVec3, Vec3, stats};
use crate::mesh::connected;
use crate::par;
use crate::segment::field::{Field, Scratch};
use crate::segment::finish::Regions;
use crate::surface::{Surface, SurfaceKind};
use crate::tolerance::Tolerances;

/// Rings between the middle of the widest narrow face and its border.
const NARROW_RINGS: usize = 6;
/// Share of a narrow face's vertices within those rings.
const NARROW_SHARE: f64 = 0.95;
/// Cost by which the new faces must describe the profile better than those that were there.
const CLEARLY_BETTER: f64 = 12.0;
/// Share of their cost that may remain: a model that is little better is as wrong.
const REMAINING: f64 = 0.6;
/// Largest systematic deviation of the new faces, sigmas of one vertex.
const MAX_SYSTEMATIC: f64 = 0.8;
/// Sine of the angle to the axis, or to a plane across it, within which a face is turned about it.
const ALIGNED: f64 = 0.06;
/// Spacings from the axis within which a centre or another axis is on it.
const OFF_AXIS: f64 = 2.0;
/// Sectors of the turn, and of a quarter of it.
pub(super) const N_SECTORS: usize = 36;
pub(super) const MIN_SECTORS: usize = 9;
/// Vertices of a face, at least.
const MIN_FACE: usize = 20;

/// Narrow regions that turn about one axis, side by side, and the wide ones at their ends.
#[derive(Debug)]
pub(super) struct Run {
    pub regions: Vec<u32>,
    /// The regions at its ends; none for the table.
    ends: Vec<(Option<u32>, Piece)>,
    frame: Frame,
}

/// All runs about an axis. `settled`: regions that stay as they are.
pub(super) fn runs(
    field: &Field,
    regions: &Regions,
    members: &[Vec<u32>],
    axis: &Axis,
    settled: &[u32],
) -> Vec<Run> {
    let frame = Frame::from_z(axis.origin, axis.direction);
    let about = par::map_indices(members.len(), |k| turns(field, axis, &members[k]));
    let narrow = par::map_indices(members.len(), |k| {
        about[k] && !settled.contains(&(k as u32)) && is_narrow(field, &members[k])
    });
    let mut touching: Vec<(u32, u32)> = Vec::new();
    for v in 0..field.n_vertices() {
        let Some(a) = regions.of_vertex[v] else { continue };
        for &u in field.rings.row(v) {
            if let Some(b) = regions.of_vertex[u as usize].filter(|b| *b != a && narrow[a as usize]) {
                touching.push((a, b));
            }
        }
    }
    touching.sort_unstable();
    let mut beside: Vec<Vec<(u32, usize)>> = vec![Vec::new(); members.len()];
    for pairs in touching.chunk_by(|x, y| x == y) {
        beside[pairs[0].0 as usize].push((pairs[0].1, pairs.len()));
    }
    let neighbours =
        |k: u32| beside[k as usize].iter().map(|n| n.0).filter(|&n| narrow[n as usize]).collect::<Vec<_>>();
    connected(members.len(), |k| narrow[k as usize].then_some(()), neighbours)
        .into_iter()
        .filter_map(|((), run)| {
            let mut contacts = vec![0; members.len()];
            for &(n, count) in run.iter().flat_map(|&k| &beside[k as usize]) {
                contacts[n as usize] += if about[n as usize] && !narrow[n as usize] { count } else { 0 };
            }
            let ends = ends(field, regions, members, &frame, &run, &contacts)?;
            Some(Run { regions: run, ends, frame })
        })
        .collect()
}

/// What is at the two ends of a run: of the wide faces about its axis, the two with most `contacts`, or the table.
/// `None` where a third has many, or where an end is no piece of the profile.
fn ends(
    field: &Field,
    regions: &Regions,
    members: &[Vec<u32>],
    frame: &Frame,
    run: &[u32],
    contacts: &[usize],
) -> Option<Vec<(Option<u32>, Piece)>> {
    /// Share of the second end's contacts from which a third makes the run no chain.
    const FORK: f64 = 0.2;
    let mut beside: Vec<u32> = (0..members.len() as u32).filter(|&n| contacts[n as usize] > 0).collect();
    beside.sort_by_key(|&n| (std::cmp::Reverse(contacts[n as usize]), n));
    let count = |place: usize| beside.get(place).map_or(0, |&n| contacts[n as usize]) as f64;
    if beside.is_empty() || count(2) > FORK * count(1) {
        return None;
    }
    beside.truncate(2);
    let end = |k: u32| {
        let fit = regions.fits[k as usize]?;
        Some((Some(k), piece_of(field, frame, &fit, &members[k as usize])?))
    };
    let mut ends: Vec<(Option<u32>, Piece)> = beside.into_iter().map(end).collect::<Option<_>>()?;
    if ends.len() < 2 {
        ends.extend(ground(field, frame, run, members));
    }
    Some(ends)
}

/// Whether a region turns about an axis, over a quarter turn at least.
fn turns(field: &Field, axis: &Axis, members: &[u32]) -> bool {
    level_sectors(field, axis, members).is_some_and(|s| s.iter().filter(|s| **s).count() >= MIN_SECTORS)
}

fn is_narrow(field: &Field, members: &[u32]) -> bool {
    let depths = field.depths(members, NARROW_RINGS, false, &mut Scratch::new(field.n_vertices()));
    let n_narrow = depths.iter().filter(|d| usize::from(**d) < NARROW_RINGS).count();
    !members.is_empty() && n_narrow as f64 >= NARROW_SHARE * members.len() as f64
}

/// The surface as a piece of the profile; `None` when it is none about that axis.
fn piece_of(field: &Field, frame: &Frame, fit: &Fit, members: &[u32]) -> Option<Piece> {
    let side = if fit.outward { 1.0 } else { -1.0 };
    let normal = match fit.surface {
        Surface::Plane(p) => {
            let along = p.normal.dot(&frame.z);
            if along.abs() < (1.0 - ALIGNED * ALIGNED).sqrt() {
                return None;
            }
            Vector2::new(0.0, along.signum() * side)
        }
        Surface::Cylinder(s) => is_along(&s.axis, frame, field.spacing).then(|| Vector2::new(side, 0.0))?,
        Surface::Cone(s) => {
            let (sin, cos) = s.half_angle.sin_cos();
            let up = s.axis.direction.dot(&frame.z).signum();
            is_along(&s.axis, frame, field.spacing).then(|| Vector2::new(cos, -sin * up) * side)?
        }
        Surface::Sphere(s) => {
            let center = frame.local(&s.center);
            let is_centered = center.x.hypot(center.y) < OFF_AXIS * field.spacing;
            let center = Vector2::new(0.0, center.z);
            return is_centered.then_some(Piece::Arc(Arc { center, radius: s.radius, convex: fit.outward }));
        }
        Surface::Torus(s) => {
            let center = Vector2::new(s.major_radius, frame.local(&s.axis.origin).z);
            return is_along(&s.axis, frame, field.spacing).then_some(Piece::Arc(Arc {
                center,
                radius: s.minor_radius,
                convex: fit.outward,
            }));
        }
    };
    let interior = field.eroded(members, 3, MIN_FACE, &mut Scratch::new(field.n_vertices()));
    let stride = interior.len().div_ceil(400).max(1);
    let mut offsets: Vec<f64> = interior
        .iter()
        .step_by(stride)
        .map(|&v| normal.dot(&profile::in_half_plane(frame, &field.points[v as usize])))
        .collect();
    let offset = stats::median(&mut offsets)?;
    Some(Piece::Line(Line { angle: normal.y.atan2(normal.x), offset }))
}

/// The table as the end of a run that stands on it.
fn ground(field: &Field, frame: &Frame, run: &[u32], members: &[Vec<u32>]) -> Option<(Option<u32>, Piece)> {
    let fit = field.ground?;
    let stands = run.iter().flat_map(|&k| &members[k as usize]).any(|&v| field.ground_near(v).is_some());
    let Surface::Plane(plane) = fit.surface else { return None };
    let up = plane.normal.dot(&frame.z);
    let height = frame.local(&plane.point).z;
    (stands && up.abs() > (1.0 - ALIGNED * ALIGNED).sqrt())
        .then(|| (None, Piece::Line(Line { angle: up.signum() * FRAC_PI_2, offset: up.signum() * height })))
}

fn is_along(axis: &Axis, frame: &Frame, spacing: f64) -> bool {
    axis.direction.cross(&frame.z).norm() < ALIGNED && axis.radial(&frame.origin).norm() < OFF_AXIS * spacing
}

/// What a run shows.
#[derive(Debug)]
pub(in crate::segment) struct Resolved {
    /// The faces in place of the run, with their vertices.
    pub faces: Vec<(Fit, Vec<u32>)>,
    /// The regions at its ends, with vertices that are theirs.
    pub ends: Vec<(u32, Vec<u32>)>,
}

impl Run {
    /// The faces that the profile shows, if it shows them clearly better than the regions that are there.
    pub fn resolved(&self, field: &Field, regions: &Regions, members: &[Vec<u32>]) -> Option<Resolved> {
        let (vertices, start) = self.vertices(field, regions, members);
        let means = profile::means(field, &self.frame, &vertices, &start)?;
        let scale = Scale { sigma: field.weights.distance_sigma, blur: field.blur, spacing: field.spacing };
        let before = self.before(field, regions, members, &vertices, &means, &scale)?;
        let pieces: Vec<Piece> = self.ends.iter().map(|end| end.1).collect();
        let best = best_chain(&pieces, &means, &scale)?;
        let enough = (before.cost - CLEARLY_BETTER).min(REMAINING * before.cost);
        if best.misfit.systematic > MAX_SYSTEMATIC || best.misfit.cost > enough {
            return None;
        }
        let outline = best.chain.outline(&means, field.spacing)?;
        self.faces(field, members, &vertices, &best.chain, &outline)
    }

    /// Vertices of the run and of the ends beside it, without those that other faces round; and those of the first end.
    fn vertices(&self, field: &Field, regions: &Regions, members: &[Vec<u32>]) -> (Vec<u32>, Vec<u32>) {
        const BESIDE: usize = 5;
        let spot = (2.0 * field.blur / field.spacing).ceil() as usize;
        let mut scratch = Scratch::new(field.n_vertices());
        let own: Vec<u32> = self.regions.iter().flat_map(|&k| members[k as usize].iter().copied()).collect();
        let around = field.dilated(&own, BESIDE + spot, &mut scratch);
        let is_part = |v: u32| {
            regions.of_vertex[v as usize]
                .is_some_and(|k| self.regions.contains(&k) || self.ends.iter().any(|e| e.0 == Some(k)))
        };
        let foreign: Vec<u32> = around.iter().copied().filter(|&v| !is_part(v)).collect();
        let mut near = field.dilated(&foreign, spot, &mut scratch);
        near.sort_unstable();
        let mut kept: Vec<u32> = around.into_iter().filter(|v| near.binary_search(v).is_err()).collect();
        kept.sort_unstable();
        let first = self.ends[0].0;
        let start = kept.iter().copied().filter(|&v| regions.of_vertex[v as usize] == first).collect();
        (kept, start)
    }

    /// How well the regions that are there describe the profile; not at all where one has no surface.
    fn before(
        &self,
        field: &Field,
        regions: &Regions,
        members: &[Vec<u32>],
        vertices: &[u32],
        means: &[Mean],
        scale: &Scale,
    ) -> Option<Misfit> {
        const N_TURNS: usize = 4;
        let mut votes: Vec<Vec<(u32, usize)>> = vec![Vec::new(); means.len()];
        for &v in vertices {
            let at = profile::in_half_plane(&self.frame, &field.points[v as usize]);
            let off = |m: &Mean| (m.at - at).norm_squared();
            let nearest = (0..means.len()).min_by(|a, b| off(&means[*a]).total_cmp(&off(&means[*b])))?;
            let region = regions.of_vertex[v as usize]?;
            match votes[nearest].iter_mut().find(|vote| vote.0 == region) {
                Some(vote) => vote.1 += 1,
                None => votes[nearest].push((region, 1)),
            }
        }
        let (mut feet, mut normals, mut order) = (Vec::new(), Vec::new(), Vec::new());
        for (mean, votes) in means.iter().zip(&votes) {
            let Some(&(region, _)) = votes.iter().max_by_key(|vote| (vote.1, vote.0)) else { continue };
            let Some(fit) = regions.fits[region as usize] else { return Some(Misfit::NOTHING) };
            let off = |turn: usize| {
                let (sin, cos) = (std::f64::consts::TAU * turn as f64 / N_TURNS as f64).sin_cos();
                let local = Vec3::new(mean.at.x * cos, mean.at.x * sin, mean.at.y);
                fit.distance_and_outward_normal(&self.frame.global(&local)).0
            };
            let distance = (0..N_TURNS).map(off).sum::<f64>() / N_TURNS as f64;
            feet.push(mean.at - mean.normal * distance);
            normals.push(mean.normal);
            order.push((region, mean.at));
        }
        let freedom = |k: &u32| match regions.fits[*k as usize].map(|f| f.surface.kind()) {
            Some(SurfaceKind::Plane | SurfaceKind::Cylinder) => 1,
            Some(SurfaceKind::Cone | SurfaceKind::Sphere) => 2,
            _ => 3,
        };
        let n_free = self.regions.iter().map(freedom).sum();
        // A line through the feet cuts the corners between faces; a chain of the faces does not.
        let bevelled = Outline::through(feet, &normals).held_against(means, scale, n_free);
        let chain = self.chain_of(field, regions, members, means, &order);
        let chained =
            chain.and_then(|c| c.outline(means, scale.spacing)).map(|o| o.held_against(means, scale, n_free));
        Some(match chained {
            Some(chained) if chained.cost < bevelled.cost => chained,
            _ => bevelled,
        })
    }

    /// The regions that are there as a chain. `order`: the region of every place of the profile. `None` where they do not
    /// follow one another each once from end to end.
    fn chain_of(
        &self,
        field: &Field,
        regions: &Regions,
        members: &[Vec<u32>],
        means: &[Mean],
        order: &[(u32, Vector2<f64>)],
    ) -> Option<Chain> {
        let groups: Vec<&[(u32, Vector2<f64>)]> = order.chunk_by(|a, b| a.0 == b.0).collect();
        let mut seen: Vec<u32> = groups.iter().map(|g| g[0].0).collect();
        let last = self.ends.get(1).copied();
        let from_end_to_end = seen.first().copied() == self.ends.first()?.0
            && last.is_none_or(|end| end.0.is_none() || seen.last().copied() == end.0);
        seen.sort_unstable();
        seen.dedup();
        if !from_end_to_end || seen.len() < groups.len() {
            return None;
        }
        let piece = |region: u32| {
            let end = self.ends.iter().find(|end| end.0 == Some(region));
            let fit = regions.fits[region as usize]?;
            end.map_or_else(
                || piece_of(field, &self.frame, &fit, &members[region as usize]),
                |end| Some(end.1),
            )
        };
        let mut pieces: Vec<Piece> = groups.iter().map(|g| piece(g[0].0)).collect::<Option<_>>()?;
        let mut hints: Vec<Vector2<f64>> = groups
            .windows(2)
            .map(|g| nalgebra::center(&g[0][g[0].len() - 1].1.into(), &g[1][0].1.into()).coords)
            .collect();
        // The table is no region of the profile.
        if let Some((None, table)) = last {
            pieces.push(table);
            hints.push(order.last()?.1);
        }
        (pieces.len() > 1).then(|| Chain {
            radii: vec![0.0; hints.len()],
            hints,
            pieces,
            material_right: profile::has_material_right(means),
            known: [true, last.is_some()],
        })
    }

    fn faces(
        &self,
        field: &Field,
        members: &[Vec<u32>],
        vertices: &[u32],
        chain: &Chain,
        outline: &Outline,
    ) -> Option<Resolved> {
        let last = chain.pieces.len() - 1;
        let end_of = |element: Element| match element {
            Element::Piece(0) => Some(self.ends[0].0),
            Element::Piece(k) if k == last => self.ends.get(1).map(|e| e.0),
            _ => None,
        };
        let is_ground = |element: Element| end_of(element) == Some(None);
        let mut all: Vec<u32> =
            self.regions.iter().flat_map(|&k| members[k as usize].iter().copied()).collect();
        all.extend(vertices);
        all.sort_unstable();
        all.dedup();
        let mut groups: Vec<(Element, Vec<u32>)> =
            outline.elements().into_iter().map(|e| (e, Vec::new())).collect();
        for &v in &all {
            let element =
                outline.nearest(&profile::in_half_plane(&self.frame, &field.points[v as usize]), is_ground);
            groups.iter_mut().find(|g| g.0 == element)?.1.push(v);
        }
        let mut resolved = Resolved { faces: Vec::new(), ends: Vec::new() };
        for (element, members) in groups {
            if let Some(end) = end_of(element) {
                resolved.ends.extend(end.map(|end| (end, members)));
                continue;
            }
            if members.len() < MIN_FACE {
                return None;
            }
            let fit = match element {
                Element::Corner(k) => self.surface_of_arc(&chain.rounding(k)?)?,
                Element::Piece(k) => match &chain.pieces[k] {
                    Piece::Arc(arc) => self.surface_of_arc(arc)?,
                    Piece::Line(line) => self.surface_of_line(
                        line,
                        &profile::in_half_plane(&self.frame, &field.points[members[0] as usize]),
                    ),
                },
            };
            resolved.faces.push((fit, members));
        }
        Some(resolved)
    }

    /// A line turned about the axis; `near`: a place on it.
    fn surface_of_line(&self, line: &Line, near: &Vector2<f64>) -> Fit {
        let n = line.normal();
        let at = near - n * (n.dot(near) - line.offset);
        let Frame { origin, x, z, .. } = self.frame;
        let point = origin + x.into_inner() * at.x + z.into_inner() * at.y;
        let normal = x.into_inner() * n.x + z.into_inner() * n.y;
        turned_line(
            &Axis { origin, direction: z },
            &point,
            &UnitVec3::new_normalize(normal),
            Tolerances::SAME,
        )
    }

    /// A narrow arc turned about the axis: no lemon, whose tip lies on it.
    fn surface_of_arc(&self, arc: &Arc) -> Option<Fit> {
        let fit = surface_of_arc(&self.frame, &arc.center, arc.radius, arc.convex)?;
        (arc.center.x > 0.0 || fit.surface.kind() == SurfaceKind::Sphere).then_some(fit)
    }
}
