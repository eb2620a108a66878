//! Bores that meet unseen inside the material: their mouths are seen, the crossing is not.
//!
//! Every mouth is taken as a drilled hole: a cylinder from the mouth, ending flat on the axis of the bore it runs into
//! unless its other mouth is seen. The air is their union. Its surface is extracted from the field
//! `max(distance to the cylinder, distance beyond its end)`, minimum over the bores, by marching tetrahedra on a cubic
//! grid of one spacing, cut off where the bores reach their mouths; the ring left there is joined to the mouth's rim on
//! the cylinder. Triangles take the label of the cylinder or end that is the field there.
//!
//! Marching tetrahedra: A. Doi and A. Koide, "An efficient method of triangulating equi-valued surfaces by using
//! tetrahedral cells", IEICE Transactions E74 (1991). Cost: linear in the volume of the crossing over the spacing
//! cubed. Fails (the mouths are capped one by one) when the cut does not leave one ring per mouth.

use super::fill::fill_on_surface;
use super::mouth::{Mouth, mouth};
use super::shell::{Hole, Shell};
use crate::math::{Point3, UnitVec3, Vec3};
use crate::mesh::{Adjacency, Mesh};
use crate::par;
use crate::surface::{Cylinder, Plane, Surface};
use std::collections::BTreeMap;

/// The surface starts this far behind the rim's deepest vertex, in spacings: room for the joining strip.
const START: f64 = 1.5;
/// The ring left at a mouth lies this near its cut, in spacings: cells of the grid, and where another bore opens beside the
/// mouth, what is left of it there.
const RAGGED: f64 = 3.0;
/// Axes this nearly parallel (cosine) do not cross.
const PARALLEL: f64 = 0.9;
/// A crossing farther behind a mouth than this many radii is not believed.
const MAX_DEPTH: f64 = 60.0;
/// Largest number of grid points: protects memory when radii are absurd for the spacing.
const MAX_GRID: f64 = 2.0e7;

/// One bore of a crossing.
#[derive(Debug, Clone)]
struct Drill {
    hole: usize,
    label: u32,
    cylinder: Cylinder,
    /// Into the material.
    direction: UnitVec3,
    /// Heights along `direction` over the axis' origin: where the new surface starts, and where the bore ends.
    start: f64,
    end: f64,
}

impl Drill {
    fn height(&self, point: &Point3) -> f64 {
        (point - self.cylinder.axis.origin).dot(&self.direction)
    }

    /// Negative in the bore's air, and whether the end rules there.
    fn field(&self, point: &Point3) -> (f64, bool) {
        let wall = self.cylinder.signed_distance(point);
        let end = self.height(point) - self.end;
        (wall.max(end), end > wall)
    }
}

/// Closes every group of bores that cross; their holes are emptied. Returns the labels of the flat ends.
pub(super) fn close_crossings(shell: &mut Shell, holes: &mut Vec<Hole>) -> Vec<u32> {
    let mut caps = Vec::new();
    for group in crossings(shell, holes) {
        let backup = shell.clone();
        match close_group(shell, holes, &group) {
            Some(ends) => {
                caps.extend(ends);
                for drill in &group {
                    holes[drill.hole].rim.clear();
                }
            }
            None => *shell = backup,
        }
    }
    holes.retain(|hole| !hole.rim.is_empty());
    caps
}

/// Groups of two or more bores whose extensions cross.
fn crossings(shell: &Shell, holes: &[Hole]) -> Vec<Vec<Drill>> {
    let mut drills: Vec<Drill> =
        (0..holes.len()).filter_map(|i| drill(shell, i, &mouth(shell, &holes[i])?)).collect();
    let n = drills.len();
    let mut group: Vec<usize> = (0..n).collect();
    let mut ends = vec![None::<f64>; n];
    for i in 0..n {
        for j in i + 1..n {
            let Some((at_i, at_j)) = crossing(&drills[i], &drills[j]) else { continue };
            ends[i] = Some(ends[i].map_or(at_i, |e| e.max(at_i)));
            ends[j] = Some(ends[j].map_or(at_j, |e| e.max(at_j)));
            let (a, b) = (group[i].min(group[j]), group[i].max(group[j]));
            for g in &mut group {
                if *g == b {
                    *g = a;
                }
            }
        }
    }
    for (drill, end) in drills.iter_mut().zip(&ends) {
        drill.end = end.unwrap_or(drill.end);
    }
    (0..n)
        .map(|g| (0..n).filter(|&i| group[i] == g).map(|i| drills[i].clone()).collect::<Vec<_>>())
        .filter(|members| members.len() > 1)
        .collect()
}

fn drill(shell: &Shell, hole: usize, mouth: &Mouth) -> Option<Drill> {
    let Some(Surface::Cylinder(cylinder)) = shell.surface(mouth.label) else { return None };
    if shell.primitives[mouth.label as usize].outward || cylinder.radius < 2.0 * shell.spacing {
        return None;
    }
    let start = mouth.depth + START * shell.spacing;
    let direction = mouth.direction;
    Some(Drill { hole, label: mouth.label, cylinder: *cylinder, direction, start, end: start })
}

/// Heights at which the axes of two bores pass each other, along either, if both lie behind the mouths and the bores
/// meet there.
fn crossing(a: &Drill, b: &Drill) -> Option<(f64, f64)> {
    let (d, e) = (a.direction.into_inner(), b.direction.into_inner());
    let cosine = d.dot(&e);
    if cosine.abs() > PARALLEL {
        return None;
    }
    let offset = b.cylinder.axis.origin - a.cylinder.axis.origin;
    let sine_sq = 1.0 - cosine * cosine;
    let at_a = (offset.dot(&d) - offset.dot(&e) * cosine) / sine_sq;
    let at_b = (offset.dot(&d) * cosine - offset.dot(&e)) / sine_sq;
    let apart = (offset + e * at_b - d * at_a).norm();
    let radii = a.cylinder.radius.min(b.cylinder.radius);
    let meet = apart < radii;
    let behind = |at: f64, drill: &Drill, other: &Drill| {
        at + other.cylinder.radius > drill.start && at - drill.start < MAX_DEPTH * drill.cylinder.radius
    };
    (meet && behind(at_a, a, b) && behind(at_b, b, a)).then_some((at_a, at_b))
}

fn close_group(shell: &mut Shell, holes: &[Hole], drills: &[Drill]) -> Option<Vec<u32>> {
    let all_run_on = drills.iter().all(|d| d.end > d.start);
    if !all_run_on {
        return None;
    }
    let surface = air_surface(drills, shell.spacing)?;
    let (patch, owners) = cut_at_mouths(&surface, drills);
    // Label of each drill's wall, then of its end.
    let mut ends: Vec<Option<u32>> = vec![None; drills.len()];
    let first = shell.mesh.vertices.len() as u32;
    shell.mesh.vertices.extend(patch.vertices.iter().copied());
    for (triangle, owner) in patch.triangles.iter().zip(&owners) {
        let label = match *owner {
            (i, false) => drills[i].label,
            (i, true) => *ends[i].get_or_insert_with(|| {
                let drill = &drills[i];
                let point = drill.cylinder.axis.origin + drill.direction.into_inner() * drill.end;
                shell.add_plane(Plane { point, normal: -drill.direction })
            }),
        };
        shell.add_triangle(triangle.map(|v| v + first), label);
    }
    let mut rings = rings_of(&patch)?;
    if rings.len() != drills.len() {
        return None;
    }
    for drill in drills {
        let nearest = rings.iter().position(|ring| {
            ring.iter().all(|&v| {
                let point = patch.vertices[v as usize];
                let off = drill.cylinder.signed_distance(&point).abs();
                off.max((drill.height(&point) - drill.start).abs()) < RAGGED * shell.spacing
            })
        })?;
        let ring: Vec<u32> = rings.remove(nearest).into_iter().map(|v| v + first).collect();
        if !fill_on_surface(shell, &[&holes[drill.hole].rim, &ring], drill.label) {
            return None;
        }
    }
    Some(ends.into_iter().flatten().collect())
}

/// The open border of `patch` as loops with the hole on their left.
fn rings_of(patch: &Mesh) -> Option<Vec<Vec<u32>>> {
    let adjacency = Adjacency::new(patch);
    let mut next: BTreeMap<u32, u32> = BTreeMap::new();
    for (t, triangle) in patch.triangles.iter().enumerate() {
        for k in 0..3 {
            if adjacency.across[t][k].is_none() {
                // Against the triangle's sense.
                let replaced = next.insert(triangle[(k + 1) % 3], triangle[k]);
                if replaced.is_some() {
                    return None;
                }
            }
        }
    }
    let mut rings = Vec::new();
    while let Some((&start, _)) = next.first_key_value() {
        let mut ring = Vec::new();
        let mut v = start;
        while let Some(w) = next.remove(&v) {
            ring.push(v);
            v = w;
        }
        if v != start {
            return None;
        }
        rings.push(ring);
    }
    Some(rings)
}

/// The part of the surface behind the mouths, and whose each triangle is.
fn cut_at_mouths(surface: &Mesh, drills: &[Drill]) -> (Mesh, Vec<(usize, bool)>) {
    let owner = |point: &Point3| {
        let fields = drills.iter().map(|d| d.field(point));
        let best = fields.enumerate().min_by(|a, b| a.1.0.total_cmp(&b.1.0));
        best.map_or((0, false), |(i, (_, end))| (i, end))
    };
    let owners: Vec<(usize, bool)> =
        (0..surface.triangles.len()).map(|t| owner(&surface.triangle_center(t))).collect();
    let (patch, old, _) = surface.submesh(|t| {
        let (i, is_end) = owners[t];
        is_end || drills[i].height(&surface.triangle_center(t)) > drills[i].start
    });
    let kept: Vec<(usize, bool)> = old.iter().map(|&t| owners[t as usize]).collect();
    let teeth = teeth_of(&patch);
    let (patch, old, _) = patch.submesh(|t| !teeth[t]);
    (patch, old.iter().map(|&t| kept[t as usize]).collect())
}

/// Triangles with two or more open edges, taken away in turn.
fn teeth_of(patch: &Mesh) -> Vec<bool> {
    let adjacency = Adjacency::new(patch);
    let mut gone = vec![false; patch.triangles.len()];
    loop {
        let is_open = |u: &Option<u32>| u.is_none_or(|u| gone[u as usize]);
        let more: Vec<usize> = (0..gone.len())
            .filter(|&t| !gone[t] && adjacency.across[t].iter().filter(|u| is_open(u)).count() > 1)
            .collect();
        if more.is_empty() {
            return gone;
        }
        for t in more {
            gone[t] = true;
        }
    }
}

/// The surface of the union of the bores, seen from the material, by marching tetrahedra.
fn air_surface(drills: &[Drill], step: f64) -> Option<Mesh> {
    let (mut lo, mut hi) =
        (Point3::new(f64::MAX, f64::MAX, f64::MAX), Point3::new(f64::MIN, f64::MIN, f64::MIN));
    for drill in drills {
        for height in [drill.start - 3.0 * step, drill.end] {
            let center = drill.cylinder.axis.origin + drill.direction.into_inner() * height;
            let reach = Vec3::from_element(drill.cylinder.radius + 2.0 * step);
            lo = lo.inf(&(center - reach));
            hi = hi.sup(&(center + reach));
        }
    }
    let dims = (hi - lo).map(|d| (d / step).ceil() + 1.0);
    let fits = dims.x * dims.y * dims.z < MAX_GRID;
    if !fits {
        return None;
    }
    let [nx, ny, nz] = [dims.x as usize, dims.y as usize, dims.z as usize];
    let node = |i: usize, j: usize, k: usize| lo + Vec3::new(i as f64, j as f64, k as f64) * step;
    let field_at = |point: &Point3| drills.iter().map(|d| d.field(point).0).fold(f64::MAX, f64::min);
    let field: Vec<f64> = par::map_indices(nx, |i| {
        (0..ny * nz).map(|jk| field_at(&node(i, jk / nz, jk % nz))).collect::<Vec<_>>()
    })
    .concat();
    let index = |i: usize, j: usize, k: usize| (i * ny + j) * nz + k;
    let point_of = |n: usize| node(n / (ny * nz), n / nz % ny, n % nz);
    let mut marcher = Marcher { mesh: Mesh::default(), crossings: BTreeMap::new() };
    for i in 0..nx - 1 {
        for j in 0..ny - 1 {
            for k in 0..nz - 1 {
                for path in PATHS {
                    let mut at = [i, j, k];
                    let mut corners = [index(i, j, k); 4];
                    for (corner, axis) in corners[1..].iter_mut().zip(path) {
                        at[axis] += 1;
                        *corner = index(at[0], at[1], at[2]);
                    }
                    marcher.tetrahedron(corners, &field, &point_of);
                }
            }
        }
    }
    Some(marcher.mesh)
}

/// The six paths along edges from one corner of a cube to the opposite one: the tetrahedra of H. Kuhn's subdivision.
const PATHS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

struct Marcher {
    mesh: Mesh,
    /// Vertex on each crossed edge of the grid.
    crossings: BTreeMap<(usize, usize), u32>,
}

impl Marcher {
    fn tetrahedron(&mut self, corners: [usize; 4], field: &[f64], point_of: &impl Fn(usize) -> Point3) {
        let (air, solid): (Vec<usize>, Vec<usize>) = corners.iter().partition(|&&c| field[c] < 0.0);
        let mut vertex = |a: usize, b: usize| {
            let mesh = &mut self.mesh;
            *self.crossings.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let (p, q) = (point_of(a), point_of(b));
                let share = (field[a] / (field[a] - field[b])).clamp(NEAREST, 1.0 - NEAREST);
                mesh.vertices.push(p + (q - p) * share);
                mesh.vertices.len() as u32 - 1
            })
        };
        let polygon: Vec<u32> = match (air.as_slice(), solid.as_slice()) {
            ([a], [p, q, r]) | ([p, q, r], [a]) => vec![vertex(*a, *p), vertex(*a, *q), vertex(*a, *r)],
            ([a, b], [p, q]) => vec![vertex(*a, *p), vertex(*a, *q), vertex(*b, *q), vertex(*b, *p)],
            _ => return,
        };
        let middle = |group: &[usize]| {
            let sum: Vec3 = group.iter().map(|&c| point_of(c).coords).sum();
            sum / group.len() as f64
        };
        let outward = middle(&air) - middle(&solid);
        for i in 1..polygon.len() - 1 {
            let mut triangle = [polygon[0], polygon[i], polygon[i + 1]];
            let [a, b, c] = triangle.map(|v| self.mesh.vertices[v as usize]);
            if (b - a).cross(&(c - a)).dot(&outward) < 0.0 {
                triangle.swap(1, 2);
            }
            self.mesh.triangles.push(triangle);
        }
    }
}

/// Crossings keep this share of an edge from its ends, so that no triangle vanishes.
const NEAREST: f64 = 0.05;
