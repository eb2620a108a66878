//! Risers between two surfaces that run beside each other and never meet: the shoulder of a counterbore, the wall round
//! a pad, the rim of a sleeve. Where such a face is narrow a segmentation may have no region for it, and its triangles
//! belong to the two beside it; then their border is an edge that lies on neither.
//!
//! A riser stands on the border across both surfaces. Of the surfaces that do (of a region that ends there, a plane or
//! cone about their axis, a plane along the border, a cylinder through it) the first is taken that the triangles
//! between the two lie on. Whether that mends the solid is found by building (`mend`). Cost O(triangles) per attempt.

use std::collections::{BTreeMap, VecDeque};

use super::attempt::{Attempt, Bench};
use super::halfedge::HalfEdges;
use super::mend::Mend;
use crate::math::{Axis, Frame, Point3, UnitVec3, Vec3, centroid, nearest_circle, principal_axes, try_unit};
use crate::mesh::{Mesh, VertId};
use crate::recognize::{Primitive, Residual};
use crate::surface::{Cone, Cylinder, Plane, Surface};

/// Faces that are missing between two surfaces of an attempt: their primitives, whose labels follow those of the
/// bench's regions, and the changes of labels that put them there.
pub(super) fn risers(bench: &Bench, attempt: &Attempt) -> (Vec<Primitive>, Vec<Mend>) {
    let (mut primitives, mut mends) = (Vec::new(), Vec::new());
    for border in borders_apart(bench, attempt) {
        let next = (bench.closed.primitives.len() + primitives.len()) as u32;
        let Some(riser) = border.riser(bench, attempt, next) else { continue };
        primitives.extend(riser.primitive);
        mends.push(riser.mend);
    }
    (primitives, mends)
}

/// A run of chains between two regions whose surfaces do not meet there.
struct Border {
    regions: [u32; 2],
    surfaces: [Surface; 2],
    vertices: Vec<VertId>,
    /// Regions that end at its ends.
    others: Vec<u32>,
    /// Distance of the two surfaces.
    width: f64,
}

struct Riser {
    /// `None` when a region has its surface.
    primitive: Option<Primitive>,
    mend: Mend,
}

fn borders_apart(bench: &Bench, attempt: &Attempt) -> Vec<Border> {
    /// Cosine of the angle between two surfaces that run beside each other.
    const BESIDE: f64 = 0.87;
    let draft = &attempt.draft;
    let mut apart: BTreeMap<[u32; 2], Vec<(usize, f64)>> = BTreeMap::new();
    for (i, (chain, course)) in draft.topology.chains.iter().zip(&draft.courses).enumerate() {
        let Some(right) = chain.right else { continue };
        let [left, right] = [chain.left, right].map(|p| &draft.patches[p as usize]);
        let (Some(a), Some(b)) = (left.surface, right.surface) else { continue };
        let middle = course.points[course.points.len() / 2];
        if left.region == right.region || a.normal(&middle).dot(&b.normal(&middle)).abs() < BESIDE {
            continue;
        }
        let off = course.apart(bench.tolerances.spacing());
        if off > bench.limit {
            let pair = [left.region.min(right.region), left.region.max(right.region)];
            // Both surfaces are as far from where they come nearest to each other.
            apart.entry(pair).or_default().push((i, 2.0 * off));
        }
    }
    let mut borders = Vec::new();
    for (regions, chains) in apart {
        let [Some(a), Some(b)] = regions.map(|r| bench.surfaces[r as usize]) else { continue };
        for run in connected(attempt, &chains) {
            let width = run.iter().map(|(_, w)| w).sum::<f64>() / run.len() as f64;
            let chains = || run.iter().map(|(i, _)| &draft.topology.chains[*i]);
            let mut vertices: Vec<VertId> = chains().flat_map(|c| c.vertices.iter().copied()).collect();
            vertices.sort_unstable();
            vertices.dedup();
            let ends = chains().flat_map(|c| [c.start(), c.end()]);
            let corners = ends.filter_map(|v| draft.corners.corner_of[v as usize]);
            let mut others: Vec<u32> =
                corners.flat_map(|c| draft.patches_at(c)).map(|p| draft.patches[p].region).collect();
            others.sort_unstable();
            others.dedup();
            others.retain(|r| !regions.contains(r) && *r != bench.facets);
            borders.push(Border { regions, surfaces: [a, b], vertices, others, width });
        }
    }
    borders
}

/// Chains in groups that share ends.
fn connected(attempt: &Attempt, chains: &[(usize, f64)]) -> Vec<Vec<(usize, f64)>> {
    let ends = |i: usize| [attempt.draft.topology.chains[i].start(), attempt.draft.topology.chains[i].end()];
    let mut runs: Vec<Vec<(usize, f64)>> = Vec::new();
    for chain in chains {
        let touches = |run: &Vec<(usize, f64)>| {
            run.iter().any(|(j, _)| ends(*j).iter().any(|v| ends(chain.0).contains(v)))
        };
        let (joined, apart): (Vec<_>, Vec<_>) = runs.into_iter().partition(touches);
        runs = apart;
        runs.push(joined.into_iter().flatten().chain([*chain]).collect());
    }
    runs
}

impl Border {
    /// What is missing here; `next` is the label of a new region.
    fn riser(&self, bench: &Bench, attempt: &Attempt, next: u32) -> Option<Riser> {
        let mesh = &bench.closed.mesh;
        let triangles = self.beside(bench, &attempt.choice.labels);
        let centers: Vec<Point3> = triangles.iter().map(|t| mesh.triangle_center(*t as usize)).collect();
        let (known, surface) = self.surface(bench, &centers)?;
        let [first, second] = self.surfaces;
        let label = |p: &Point3| {
            let off = [&first, &second, &surface].map(|s| s.signed_distance(p).abs());
            let nearest = usize::from(off[1] < off[0]);
            if off[2] < off[nearest] { known.unwrap_or(next) } else { self.regions[nearest] }
        };
        let labels: Vec<u32> = centers.iter().map(label).collect();
        let own = triangles.iter().zip(&labels).filter(|(_, l)| **l == next).map(|(t, _)| *t as usize);
        let primitive = known.is_none().then(|| primitive(mesh, &surface, &own.collect::<Vec<_>>()));
        Some(Riser { primitive, mend: Mend::Relabel { triangles, labels } })
    }

    /// The surface of the riser, with the region that has it if one does.
    fn surface(&self, bench: &Bench, centers: &[Point3]) -> Option<(Option<u32>, Surface)> {
        /// Fewest triangles between two surfaces that show a riser.
        const FEWEST: usize = 8;
        /// In spacings: root mean square distance of these triangles from a riser that is taken at once, and from one
        /// that is taken at all; both ends of a riser are rounded.
        const GOOD: f64 = 0.35;
        const FAIR: f64 = 0.7;
        let between: Vec<Point3> = centers.iter().filter(|p| self.is_between(p)).copied().collect();
        if between.len() < FEWEST {
            return None;
        }
        let rms = |s: &Surface| {
            let sum: f64 = between.iter().map(|p| s.signed_distance(p).powi(2)).sum();
            (sum / between.len() as f64).sqrt() / bench.tolerances.spacing()
        };
        let known = self.others.iter().filter_map(|r| Some((Some(*r), bench.surfaces[*r as usize]?)));
        let new = self.candidates(bench, &between).into_iter().map(|s| (None, s));
        let rated = known.chain(new).filter(|(_, s)| s.is_finite()).map(|c| (rms(&c.1), c));
        let fair: Vec<(f64, (Option<u32>, Surface))> = rated.filter(|(rms, _)| *rms <= FAIR).collect();
        let good = fair.iter().find(|(rms, _)| *rms <= GOOD);
        good.or_else(|| fair.iter().min_by(|a, b| a.0.total_cmp(&b.0))).map(|(_, c)| *c)
    }

    /// Triangles of the two regions as near to the border as the riser is wide.
    fn beside(&self, bench: &Bench, labels: &[u32]) -> Vec<u32> {
        /// In spacings: how far the border of a segmentation may lie beside the riser.
        const WANDER: f64 = 3.0;
        let mesh = &bench.closed.mesh;
        let reach = self.width + WANDER * bench.tolerances.spacing();
        let mut found: BTreeMap<u32, VertId> = BTreeMap::new();
        let mut front: VecDeque<(u32, VertId)> = VecDeque::new();
        for v in &self.vertices {
            front.extend(bench.half_edges.leaving(*v).iter().map(|h| (HalfEdges::triangle(*h) as u32, *v)));
        }
        while let Some((t, v)) = front.pop_front() {
            let off = mesh.triangle_center(t as usize) - mesh.vertices[v as usize];
            if found.contains_key(&t)
                || !self.regions.contains(&labels[t as usize])
                || off.norm_squared() > reach * reach
            {
                continue;
            }
            found.insert(t, v);
            let around = bench.half_edges.neighbours(t as usize).into_iter().flatten();
            front.extend(around.map(|u| (u as u32, v)));
        }
        found.into_keys().collect()
    }

    /// Whether a point is between the two surfaces and well off both.
    fn is_between(&self, point: &Point3) -> bool {
        /// Shares of the width.
        const OFF: f64 = 0.25;
        const SUM: f64 = 1.5;
        let off = self.surfaces.map(|s| s.signed_distance(point).abs());
        off.iter().all(|d| *d > OFF * self.width) && off[0] + off[1] < SUM * self.width
    }

    /// Surfaces that stand on the border across both, the simplest first.
    fn candidates(&self, bench: &Bench, between: &[Point3]) -> Vec<Surface> {
        let center = centroid(between);
        let axes = self.surfaces.iter().filter_map(Surface::axis);
        let mut candidates: Vec<Surface> = axes.map(|axis| about_axis(&axis, between)).collect();
        let vertices: Vec<Point3> =
            self.vertices.iter().map(|v| bench.closed.mesh.vertices[*v as usize]).collect();
        let [_, _, (_, along)] = principal_axes(&vertices, centroid(&vertices));
        for across in self.surfaces.map(|s| s.normal(&center)) {
            if let Some(normal) = try_unit(along.cross(&across)) {
                candidates.push(Surface::Plane(Plane { point: center, normal }));
            }
            candidates.extend(through(&across, between));
        }
        candidates
    }
}

/// A surface with the evidence of its triangles; a plane's normal out of the material.
fn primitive(mesh: &Mesh, surface: &Surface, triangles: &[usize]) -> Primitive {
    let centers = || triangles.iter().map(|t| (*t, mesh.triangle_center(*t)));
    let facing: f64 = centers().map(|(t, p)| mesh.cross(t).dot(&surface.normal(&p))).sum();
    let distances: Vec<f64> = centers().map(|(_, p)| surface.signed_distance(&p)).collect();
    let (surface, outward) = match surface {
        Surface::Plane(p) if facing < 0.0 => {
            (Surface::Plane(Plane { point: p.point, normal: -p.normal }), true)
        }
        other => (*other, facing > 0.0),
    };
    let residual = Residual::from_distances(&distances);
    Primitive { surface: Some(surface), outward, residual, covariance: Vec::new(), ambiguous: None }
}

/// The plane across an axis through points beside each other, or the cone where their distance from the axis changes.
fn about_axis(axis: &Axis, points: &[Point3]) -> Surface {
    /// Slope against the plane, 30 degrees, beyond which a riser is a cone.
    const STEEP: f64 = 0.577;
    let polar: Vec<(f64, f64)> = points.iter().map(|p| (axis.radial(p).norm(), axis.height(p))).collect();
    let n = points.len() as f64;
    let mean = polar.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let moment = polar
        .iter()
        .fold((0.0, 0.0), |m, p| (m.0 + (p.0 - mean.0).powi(2), m.1 + (p.0 - mean.0) * (p.1 - mean.1)));
    let slope = if moment.0 > 0.0 { moment.1 / moment.0 } else { 0.0 };
    let point = axis.origin + axis.direction.into_inner() * mean.1;
    if slope.abs() < STEEP {
        return Surface::Plane(Plane { point, normal: axis.direction });
    }
    let direction = if slope > 0.0 { axis.direction } else { -axis.direction };
    let half_angle = (1.0 / slope.abs()).atan();
    Surface::Cone(Cone { axis: Axis { origin: point, direction }, radius: mean.0, half_angle })
}

/// The cylinder with this direction through points, by the circle that is nearest to them in the algebraic sense.
fn through(direction: &UnitVec3, points: &[Point3]) -> Option<Surface> {
    let frame = Frame::from_z(centroid(points), *direction);
    let flat = points.iter().map(|p| frame.local(p)).map(|p| (1.0, p.x, p.y));
    let ([x, y], radius) = nearest_circle(flat)?;
    let axis = Axis { origin: frame.global(&Vec3::new(x, y, 0.0)), direction: *direction };
    Some(Surface::Cylinder(Cylinder { axis, radius }))
}
