//! A run of narrow turned faces between wide ones, and the faces that its profile shows.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector2;

use super::chain::{Arc, BEYOND, Chain, Element, Fitted, Line, Outline, PRICE, Piece, Scale};
use super::profile::{self, Mean};
use crate::fit::Fit;
use crate::math::{Axis, Frame, nearest_circle, stats};
use crate::mesh::connected;
use crate::par;
use crate::recognize::is_ring_or_lemon;
use crate::segment::field::{Field, Scratch};
use crate::segment::finish::Regions;
use crate::surface::{Cone, Cylinder, Plane, Sphere, Surface, SurfaceKind, Torus};

/// Rings between the middle of the widest narrow face and its border.
const NARROW_RINGS: usize = 6;
/// Share of a narrow face's vertices within those rings.
const NARROW_SHARE: f64 = 0.95;
/// Lines of a run, at most.
const MOST_LINES: usize = 5;
/// Cost by which the new faces must describe the profile better than those that were there.
const CLEARLY_BETTER: f64 = 12.0;
/// Share of their cost that may remain: a model that is little better is as wrong.
const REMAINING: f64 = 0.6;
/// Largest systematic deviation of the new faces, sigmas of one vertex.
const MAX_SYSTEMATIC: f64 = 0.8;
/// Shortest line, spacings.
const SHORTEST: f64 = 1.0;
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

/// All runs about an axis. `tried`: regions that are left as they are.
pub(super) fn runs(
    field: &Field,
    regions: &Regions,
    members: &[Vec<u32>],
    axis: &Axis,
    tried: &[u32],
) -> Vec<Run> {
    let frame = Frame::from_z(axis.origin, axis.direction);
    let about = par::map_indices(members.len(), |k| turns(field, axis, &members[k]));
    let narrow = par::map_indices(members.len(), |k| {
        about[k] && !tried.contains(&(k as u32)) && is_narrow(field, &members[k])
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
        .filter_map(|((), regions_of_run)| {
            let mut contacts = vec![0; members.len()];
            for &k in &regions_of_run {
                for &(n, count) in beside[k as usize].iter().filter(|n| about[n.0 as usize]) {
                    contacts[n as usize] += if narrow[n as usize] { 0 } else { count };
                }
            }
            let mut ends: Vec<u32> =
                (0..members.len() as u32).filter(|&n| contacts[n as usize] > 0).collect();
            ends.sort_by_key(|&n| (std::cmp::Reverse(contacts[n as usize]), n));
            /// Share of the second end's contacts from which a third makes the run no chain.
            const FORK: f64 = 0.2;
            if ends.len() > 2 && contacts[ends[2] as usize] as f64 > FORK * contacts[ends[1] as usize] as f64
            {
                return None;
            }
            ends.truncate(2);
            let ends: Option<Vec<(Option<u32>, Piece)>> = ends
                .into_iter()
                .map(|k| {
                    let fit = regions.fits[k as usize]?;
                    Some((Some(k), piece_of(field, &frame, &fit, &members[k as usize])?))
                })
                .collect();
            let mut ends = ends.filter(|ends| !ends.is_empty())?;
            if ends.len() < 2 {
                ends.extend(ground(field, &frame, &regions_of_run, members));
            }
            Some(Run { regions: regions_of_run, ends, frame })
        })
        .collect()
}

/// Whether a region turns about an axis: its normals point to it, over a quarter turn at least.
fn turns(field: &Field, axis: &Axis, members: &[u32]) -> bool {
    const N_TEST: usize = 300;
    /// Component of a normal along the turn, and share of normals with less.
    const LEVEL: f64 = 0.3;
    const SHARE: f64 = 0.9;
    const N_SECTORS: usize = 36;
    const MIN_SECTORS: usize = 9;
    let frame = Frame::from_z(axis.origin, axis.direction);
    let (mut n, mut n_level, mut sectors) = (0_usize, 0_usize, [false; N_SECTORS]);
    for &v in members.iter().step_by(members.len().div_ceil(N_TEST).max(1)) {
        let radial = axis.radial(&field.points[v as usize]);
        if radial.norm() < 2.0 * field.spacing {
            continue;
        }
        let along = axis.direction.cross(&radial) / radial.norm();
        n += 1;
        n_level += usize::from(field.normals[v as usize].dot(&along).abs() < LEVEL);
        let local = frame.local(&field.points[v as usize]);
        let turn = (local.y.atan2(local.x) / std::f64::consts::TAU).rem_euclid(1.0);
        sectors[((turn * N_SECTORS as f64) as usize).min(N_SECTORS - 1)] = true;
    }
    let n_sectors = sectors.iter().filter(|s| **s).count();
    n > 0 && n_level as f64 > SHARE * n as f64 && n_sectors >= MIN_SECTORS
}

fn is_narrow(field: &Field, members: &[u32]) -> bool {
    let depths = field.depths(members, NARROW_RINGS, &mut Scratch::new(field.n_vertices()));
    let n_narrow = depths.iter().filter(|d| usize::from(**d) < NARROW_RINGS).count();
    !members.is_empty() && n_narrow as f64 >= NARROW_SHARE * members.len() as f64
}

/// The surface as a piece of the profile; `None` when it is none about that axis.
fn piece_of(field: &Field, frame: &Frame, fit: &Fit, members: &[u32]) -> Option<Piece> {
    /// Sine of the angle to the axis, and to the radial plane, within which a face is turned about it.
    const ALIGNED: f64 = 0.06;
    let side = if fit.outward { 1.0 } else { -1.0 };
    let normal = match fit.surface {
        Surface::Plane(p) => {
            let along = p.normal.dot(&frame.z);
            if along.abs() < (1.0 - ALIGNED * ALIGNED).sqrt() {
                return None;
            }
            Vector2::new(0.0, along.signum() * side)
        }
        Surface::Cylinder(s) => {
            is_along(&s.axis, frame, ALIGNED, field.spacing).then(|| Vector2::new(side, 0.0))?
        }
        Surface::Cone(s) => {
            let (sin, cos) = s.half_angle.sin_cos();
            let up = s.axis.direction.dot(&frame.z).signum();
            is_along(&s.axis, frame, ALIGNED, field.spacing).then(|| Vector2::new(cos, -sin * up) * side)?
        }
        Surface::Sphere(s) => {
            let center = frame.local(&s.center);
            let is_centered = center.x.hypot(center.y) < 2.0 * field.spacing;
            let center = Vector2::new(0.0, center.z);
            return is_centered.then_some(Piece::Arc(Arc { center, radius: s.radius, convex: fit.outward }));
        }
        Surface::Torus(s) => {
            let center = Vector2::new(s.major_radius, frame.local(&s.axis.origin).z);
            return is_along(&s.axis, frame, ALIGNED, field.spacing).then_some(Piece::Arc(Arc {
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
        .map(|&v| normal.dot(&profile::in_half_plane(frame, field, v)))
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
    (stands && up.abs() > 0.998)
        .then(|| (None, Piece::Line(Line { angle: up.signum() * FRAC_PI_2, offset: up.signum() * height })))
}

fn is_along(axis: &Axis, frame: &Frame, sine: f64, distance: f64) -> bool {
    axis.direction.cross(&frame.z).norm() < sine && axis.radial(&frame.origin).norm() < 2.0 * distance
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
        let before = self.before(field, regions, &vertices, &means, &scale)?;
        let best = self.best_chain(&means, &scale)?;
        if best.systematic > MAX_SYSTEMATIC
            || best.cost > (before.cost - CLEARLY_BETTER).min(REMAINING * before.cost)
        {
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

    /// How well the regions that are there describe the profile.
    fn before(
        &self,
        field: &Field,
        regions: &Regions,
        vertices: &[u32],
        means: &[Mean],
        scale: &Scale,
    ) -> Option<Fitted> {
        const N_TURNS: usize = 4;
        let mut votes: Vec<Vec<(u32, usize)>> = vec![Vec::new(); means.len()];
        for &v in vertices {
            let at = profile::in_half_plane(&self.frame, field, v);
            let off = |m: &Mean| (m.at - at).norm_squared();
            let nearest = (0..means.len()).min_by(|a, b| off(&means[*a]).total_cmp(&off(&means[*b])))?;
            let region = regions.of_vertex[v as usize]?;
            match votes[nearest].iter_mut().find(|vote| vote.0 == region) {
                Some(vote) => vote.1 += 1,
                None => votes[nearest].push((region, 1)),
            }
        }
        let (mut feet, mut normals) = (Vec::new(), Vec::new());
        for (mean, votes) in means.iter().zip(&votes) {
            let Some(&(region, _)) = votes.iter().max_by_key(|vote| (vote.1, vote.0)) else { continue };
            let fit = regions.fits[region as usize]?;
            let off = |turn: usize| {
                let (sin, cos) = (std::f64::consts::TAU * turn as f64 / N_TURNS as f64).sin_cos();
                let local = crate::math::Vec3::new(mean.at.x * cos, mean.at.x * sin, mean.at.y);
                fit.distance_and_outward_normal(&self.frame.global(&local)).0
            };
            let distance = (0..N_TURNS).map(off).sum::<f64>() / N_TURNS as f64;
            feet.push(mean.at - mean.normal * distance);
            normals.push(mean.normal);
        }
        let freedom = |k: &u32| match regions.fits[*k as usize].map(|f| f.surface.kind()) {
            Some(SurfaceKind::Plane | SurfaceKind::Cylinder) => 1,
            Some(SurfaceKind::Cone | SurfaceKind::Sphere) => 2,
            _ => 3,
        };
        let n_free = self.regions.iter().map(freedom).sum();
        let chain = Chain {
            pieces: Vec::new(),
            hints: Vec::new(),
            radii: Vec::new(),
            material_right: true,
            known: [true; 2],
        };
        Some(Outline::through(feet, &normals).held_against(means, scale, n_free, chain))
    }

    /// The chain that describes the profile best.
    fn best_chain(&self, means: &[Mean], scale: &Scale) -> Option<Fitted> {
        let turn: f64 = means.windows(2).map(|m| m[0].normal.perp(&(m[1].at - m[0].at))).sum();
        let material_right = turn < 0.0;
        let mut best: Option<Fitted> = None;
        for cut in self.cuts(means) {
            let chain = Chain {
                radii: vec![0.0; cut.starts.len()],
                hints: cut.starts.iter().map(|&i| means[i.min(means.len() - 1)].at).collect(),
                pieces: cut.pieces,
                material_right,
                known: [true, self.ends.len() > 1],
            };
            let Some(fitted) = chain.fitted(means, scale, &[]).and_then(|f| refined(f, means, scale)) else {
                continue;
            };
            if best.as_ref().is_none_or(|b| fitted.cost < b.cost) {
                best = Some(fitted);
            }
        }
        best
    }

    /// First lines: the best cuts of the profile into none, one, two ... lines between its ends.
    fn cuts(&self, means: &[Mean]) -> Vec<Cut> {
        let n = means.len();
        let sums = Sums::of(means);
        let first = self.ends[0].1;
        let last = self.ends.get(1).map(|e| e.1);
        let off = |piece: &Piece, m: &Mean| m.weight * piece.distance(&m.at).powi(2);
        let mut on_first = vec![0.0];
        for m in means {
            on_first.push(on_first[on_first.len() - 1] + off(&first, m));
        }
        let mut on_last = vec![0.0; n + 1];
        for i in (0..n).rev() {
            on_last[i] = on_last[i + 1] + last.map_or(f64::INFINITY, |piece| off(&piece, &means[i]));
        }
        // best[k][to]: the first end and k lines up to `to`, and where the last of them begins.
        let mut best: Vec<Vec<(f64, usize)>> = vec![on_first.iter().map(|c| (*c, 0)).collect()];
        let mut found = Vec::new();
        for k in 0..=MOST_LINES {
            if k > 0 {
                let before = &best[k - 1];
                let next = (0..=n)
                    .map(|to| {
                        (k..to)
                            .map(|from| (before[from].0 + sums.residual(from, to), from))
                            .min_by(|a, b| a.0.total_cmp(&b.0))
                            .unwrap_or((f64::INFINITY, 0))
                    })
                    .collect();
                best.push(next);
            }
            let end =
                (1..=n).min_by(|&a, &b| (best[k][a].0 + on_last[a]).total_cmp(&(best[k][b].0 + on_last[b])));
            let Some(mut to) = (if last.is_some() { end } else { Some(n) }) else { continue };
            if last.is_none() && k == 0 {
                continue;
            }
            let mut cut = Cut { pieces: last.into_iter().collect(), starts: Vec::new() };
            if last.is_some() {
                cut.starts.push(to);
            }
            for level in (1..=k).rev() {
                let from = best[level][to].1;
                cut.pieces.push(Piece::Line(sums.line(from, to, means)));
                cut.starts.push(from);
                to = from;
            }
            cut.pieces.push(first);
            cut.pieces.reverse();
            cut.starts.reverse();
            found.push(cut);
        }
        found
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
            let element = outline.nearest(&profile::in_half_plane(&self.frame, field, v), is_ground);
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
                    Piece::Line(line) => {
                        self.surface_of_line(line, &profile::in_half_plane(&self.frame, field, members[0]))
                    }
                },
            };
            resolved.faces.push((fit, members));
        }
        Some(resolved)
    }

    /// A line turned about the axis; `near`: a place on it.
    fn surface_of_line(&self, line: &Line, near: &Vector2<f64>) -> Fit {
        /// Component of a normal below which it is none.
        const NONE: f64 = 1e-9;
        let n = line.normal();
        let at = near - n * (n.dot(near) - line.offset);
        let Frame { origin, z, .. } = self.frame;
        let center = origin + z.into_inner() * at.y;
        if n.x.abs() < NONE {
            let normal = if n.y > 0.0 { z } else { -z };
            return Fit { surface: Surface::Plane(Plane { point: center, normal }), outward: true };
        }
        let outward = n.x > 0.0;
        let axis = Axis { origin: center, direction: z };
        if n.y.abs() < NONE {
            return Fit { surface: Surface::Cylinder(Cylinder { axis, radius: at.x }), outward };
        }
        // The natural normal points away from the axis and against the growing radius.
        let sin = -n.y * n.x.signum();
        let direction = if sin > 0.0 { z } else { -z };
        let half_angle = sin.abs().asin();
        let surface =
            Surface::Cone(Cone { axis: Axis { origin: center, direction }, radius: at.x, half_angle });
        Fit { surface, outward }
    }

    fn surface_of_arc(&self, arc: &Arc) -> Option<Fit> {
        /// Radius of the tube's circle over that of the tube below which it is a sphere.
        const CENTERED: f64 = 0.05;
        let origin = self.frame.origin + self.frame.z.into_inner() * arc.center.y;
        let (major_radius, minor_radius) = (arc.center.x, arc.radius);
        let surface = if major_radius.abs() < CENTERED * minor_radius {
            Surface::Sphere(Sphere { center: origin, radius: minor_radius })
        } else {
            let axis = Axis { origin, direction: self.frame.z };
            Surface::Torus(Torus { axis, major_radius, minor_radius })
        };
        let is_one = surface.kind() == SurfaceKind::Sphere
            || major_radius > 0.0 && is_ring_or_lemon(major_radius / minor_radius);
        is_one.then_some(Fit { surface, outward: arc.convex })
    }
}

/// A profile cut into pieces.
struct Cut {
    pieces: Vec<Piece>,
    /// Where each piece but the first begins.
    starts: Vec<usize>,
}

/// The chain with corners rounded where that pays, and lines along or across the axis where they may be; `None` where a
/// line is too short to be one.
fn refined(mut best: Fitted, means: &[Mean], scale: &Scale) -> Option<Fitted> {
    while let Some(better) = with_arc(&best, means, scale) {
        best = better;
    }
    best = rounded(best, means, scale);
    best = squared(best, means, scale);
    let outline = best.chain.outline(means, scale.spacing)?;
    let long = |e: Element| outline.length(e) >= SHORTEST * scale.spacing;
    outline.elements().into_iter().all(long).then_some(best)
}

/// The best chain with one arc in place of neighbouring pieces, if it is better.
fn with_arc(best: &Fitted, means: &[Mean], scale: &Scale) -> Option<Fitted> {
    let chain = &best.chain;
    let outline = chain.outline(means, scale.spacing)?;
    let element = |m: &Mean| match outline.nearest(&m.at, |_| false) {
        Element::Piece(k) | Element::Corner(k) => k,
    };
    let pieces: Vec<usize> = means.iter().map(element).collect();
    let n = chain.pieces.len();
    let (low, high) = (usize::from(chain.known[0]), n - usize::from(chain.known[1]));
    let mut found: Option<Fitted> = None;
    for from in low..high {
        for to in from + 2..=high {
            let range: Vec<&Mean> =
                means.iter().zip(&pieces).filter(|(_, k)| (from..to).contains(k)).map(|(m, _)| m).collect();
            let circle = nearest_circle(range.iter().map(|m| (m.weight, m.at.x, m.at.y)));
            let Some(([x, y], radius)) = circle else { continue };
            let center = Vector2::new(x, y);
            let facing: f64 = range.iter().map(|m| m.normal.dot(&(m.at - center)) * m.weight).sum();
            let arc = Piece::Arc(Arc { center, radius, convex: facing > 0.0 });
            let mut next = chain.clone();
            next.pieces.splice(from..to, [arc]);
            // Corners between the pieces that are gone.
            next.hints.drain(from..to - 1);
            next.radii.drain(from..to - 1);
            for k in [from.checked_sub(1), Some(from)].into_iter().flatten() {
                if let Some(radius) = next.radii.get_mut(k) {
                    *radius = 0.0;
                }
            }
            let Some(fitted) = next.fitted(means, scale, &[]) else { continue };
            if fitted.cost < found.as_ref().map_or(best.cost, |f| f.cost) {
                found = Some(fitted);
            }
        }
    }
    found
}

/// The chain with corners between lines rounded where that pays.
fn rounded(mut best: Fitted, means: &[Mean], scale: &Scale) -> Fitted {
    /// First radii, spacings.
    const RADII: [f64; 2] = [1.6, 3.2];
    for k in 0..best.chain.radii.len() {
        if !best.chain.pieces[k..k + 2].iter().all(|p| matches!(p, Piece::Line(_))) {
            continue;
        }
        for radius in RADII {
            let mut chain = best.chain.clone();
            chain.radii[k] = radius * scale.spacing;
            if let Some(rounded) = chain.fitted(means, scale, &[])
                && rounded.cost < best.cost - PRICE
                && rounded.chain.radii[k] > RADII[0] * scale.spacing
            {
                best = rounded;
            }
        }
    }
    best
}

/// Lines nearly along or across the axis made so, where they depart from it by less than a scan shows, or where that
/// costs no more than their angle does.
fn squared(mut best: Fitted, means: &[Mean], scale: &Scale) -> Fitted {
    /// Angle from which a line is a cone's whatever it costs, radians.
    const FAR: f64 = 0.2;
    /// Departure over the length of a line that says nothing, noise.
    const UNSEEN: f64 = 2.0;
    let mut fixed = Vec::new();
    for k in 0..best.chain.pieces.len() {
        let is_known =
            k == 0 && best.chain.known[0] || k + 1 == best.chain.pieces.len() && best.chain.known[1];
        let Piece::Line(line) = best.chain.pieces[k] else { continue };
        let square = (line.angle / FRAC_PI_2).round() * FRAC_PI_2;
        let tilt = (line.angle - square).abs();
        let Some(outline) = best.chain.outline(means, scale.spacing) else { continue };
        if is_known || tilt > FAR {
            continue;
        }
        // The last line goes on beyond what was seen of it.
        let is_last = k + 1 == best.chain.pieces.len();
        let length = outline.length(Element::Piece(k)) - if is_last { BEYOND * scale.spacing } else { 0.0 };
        let departure = length * tilt;
        let mut chain = best.chain.clone();
        chain.pieces[k] = Piece::Line(line.turned_to(square, means));
        fixed.push(k);
        let is_unseen = departure < UNSEEN * scale.sigma;
        match chain.fitted(means, scale, &fixed) {
            Some(other) if is_unseen || other.cost <= best.cost => best = other,
            None if is_unseen => best.chain = chain,
            _ => {
                fixed.pop();
            }
        }
    }
    best
}

/// Sums of weights and moments of all means before each.
struct Sums(Vec<[f64; 6]>);

impl Sums {
    fn of(means: &[Mean]) -> Self {
        let mut sums = vec![[0.0; 6]];
        for m in means {
            let mut next = sums[sums.len() - 1];
            let (w, x, y) = (m.weight, m.at.x, m.at.y);
            for (sum, term) in next.iter_mut().zip([w, w * x, w * y, w * x * x, w * x * y, w * y * y]) {
                *sum += term;
            }
            sums.push(next);
        }
        Self(sums)
    }

    /// Weight, centre, and second moments about it.
    fn moments(&self, from: usize, to: usize) -> (f64, Vector2<f64>, [f64; 3]) {
        let (a, b) = (&self.0[from], &self.0[to]);
        let d: Vec<f64> = b.iter().zip(a).map(|(b, a)| b - a).collect();
        let w = d[0].max(f64::MIN_POSITIVE);
        let center = Vector2::new(d[1] / w, d[2] / w);
        let second =
            [d[3] - w * center.x * center.x, d[4] - w * center.x * center.y, d[5] - w * center.y * center.y];
        (d[0], center, second)
    }

    /// Sum of squared distances to the line that fits best.
    fn residual(&self, from: usize, to: usize) -> f64 {
        if to < from + 2 {
            return 0.0;
        }
        let (_, _, [xx, xy, yy]) = self.moments(from, to);
        (0.5 * (xx + yy) - (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt()).max(0.0)
    }

    /// The line that fits best; through a single mean across its normal.
    fn line(&self, from: usize, to: usize, means: &[Mean]) -> Line {
        let range = &means[from.min(means.len() - 1)..to.clamp(from + 1, means.len())];
        let facing: Vector2<f64> = range.iter().map(|m| m.normal * m.weight).sum();
        let (_, center, [xx, xy, yy]) = self.moments(from, to);
        let normal = if range.len() < 2 {
            facing
        } else {
            let along = 0.5 * (2.0 * xy).atan2(xx - yy);
            let normal = Vector2::new(-along.sin(), along.cos());
            if normal.dot(&facing) < 0.0 { -normal } else { normal }
        };
        let normal = normal / normal.norm().max(f64::MIN_POSITIVE);
        Line { angle: normal.y.atan2(normal.x), offset: normal.dot(&center) }
    }
}
