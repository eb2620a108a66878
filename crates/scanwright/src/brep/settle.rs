//! Moves surfaces a little so that edges and corners lie on all of theirs.
//!
//! Fitted surfaces that should be tangent, or should pass through one corner, miss each other by a share of the
//! spacing. In turn, edges are placed between their surfaces and surfaces are refitted to the edges that do not lie on
//! them; each surface is held by points of its own face, as many as the face has vertices, so weak faces move and
//! strong ones stay. Block coordinate descent on one least-squares problem: the gaps fall by about half per round.
//! A surface that would leave its own points is not moved. Cost O(borders) per round.

use super::assemble::ChainEdge;
use super::chains::{Chain, Topology};
use super::geometry::Corners;
use super::split::Patch;
use crate::math::least_squares::{Normal, minimize};
use crate::math::{Axis, Point3, UnitVec3, Vec3, any_perpendicular, centroid};
use crate::mesh::Mesh;
use crate::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};

/// Weight of a border point against a point of the face: enough to win over a few hundred of them.
const BORDER_WEIGHT: f64 = 60.0;
/// Points of a face that hold its surface; more add nothing to at most seven unknowns.
const N_HOLDING: usize = 120;
/// Root mean square move of a face's points, in spacings, beyond which the surface is left where it was.
const MAX_MOVE: f64 = 0.35;
/// Gaps beyond this many spacings show wrong topology, which moving surfaces would only hide.
const WRONG: f64 = 0.6;
/// Half-angles, radians, that a cone keeps clear of: there it is a cylinder or a plane.
const CONE_MARGIN: f64 = 0.01;

/// The data of one settling round.
pub(super) struct Round<'a> {
    pub mesh: &'a Mesh,
    pub patches: &'a [Patch],
    pub topology: &'a Topology,
    pub corners: &'a Corners,
    pub edges: &'a [Option<ChainEdge>],
    /// One per region: whether the natural normal points out of the material.
    pub outward: &'a [bool],
}

impl Round<'_> {
    /// New surfaces, one per region. `original`: where each surface was before any round.
    pub(super) fn settled(
        &self,
        original: &[Option<Surface>],
        current: &[Option<Surface>],
        tolerance: f64,
        spacing: f64,
    ) -> Vec<Option<Surface>> {
        let pulls = self.pulls(current, tolerance, spacing);
        let mut triangles: Vec<Vec<u32>> = vec![Vec::new(); current.len()];
        for patch in self.patches {
            triangles[patch.region as usize].extend(&patch.triangles);
        }
        crate::par::map_indices(current.len(), |r| {
            let (Some(surface), Some(start)) = (current[r], original[r]) else { return current[r] };
            if pulls[r].is_empty() || triangles[r].is_empty() {
                return current[r];
            }
            refit(&surface, &start, &self.holding(&triangles[r], &start), &pulls[r], spacing).or(current[r])
        })
    }

    /// Per region: points of bad edges and corners that it should pass through.
    fn pulls(&self, current: &[Option<Surface>], tolerance: f64, spacing: f64) -> Vec<Vec<Point3>> {
        let mut pulls: Vec<Vec<Point3>> = vec![Vec::new(); current.len()];
        for (chain, edge) in self.topology.chains.iter().zip(self.edges) {
            let Some(right) = chain.right else { continue };
            let regions = [chain.left, right].map(|p| self.patches[p as usize].region as usize);
            if regions[0] == regions[1] || self.back_to_back(chain, regions, current) {
                continue;
            }
            for v in [chain.start(), chain.end()] {
                let Some(c) = self.corners.corner_of[v as usize] else { continue };
                let corner = &self.corners.corners[c as usize];
                if corner.residual > tolerance && corner.residual < WRONG * spacing {
                    for r in regions {
                        pulls[r].push(corner.point);
                    }
                }
            }
            let Some(edge) = edge.as_ref().filter(|e| e.gap > tolerance && e.gap < WRONG * spacing) else {
                continue;
            };
            for r in regions {
                pulls[r].extend(&edge.samples);
            }
        }
        pulls
    }

    /// Whether two surfaces are the sides of a thin wall beside a chain: what lies between them is no error.
    fn back_to_back(&self, chain: &Chain, regions: [usize; 2], current: &[Option<Surface>]) -> bool {
        /// Cosine of 150 degrees between the sides.
        const OPPOSITE: f64 = -0.87;
        let at = &self.mesh.vertices[chain.vertices[chain.vertices.len() / 2] as usize];
        let out = regions.map(|r| {
            let normal = current[r].map(|s| s.normal(at).into_inner());
            normal.map(|n| if self.outward[r] { n } else { -n })
        });
        matches!(out, [Some(a), Some(b)] if a.dot(&b) < OPPOSITE)
    }

    /// Points of a region's mesh on its original surface, each with the number of vertices it stands for.
    fn holding(&self, triangles: &[u32], original: &Surface) -> (Vec<Point3>, f64) {
        let step = triangles.len().div_ceil(N_HOLDING);
        let points: Vec<Point3> = triangles
            .iter()
            .step_by(step)
            .map(|t| original.project(&self.mesh.triangle_center(*t as usize)))
            .collect();
        // A mesh has about half as many vertices as triangles.
        let weight = 0.5 * triangles.len() as f64 / points.len() as f64;
        (points, weight)
    }
}

/// The surface through the pulls that stays with its holding points; `None` when it would have to leave them.
fn refit(
    surface: &Surface,
    original: &Surface,
    (holding, weight): &(Vec<Point3>, f64),
    pulls: &[Point3],
    spacing: f64,
) -> Option<Surface> {
    let center = centroid(holding);
    let extent = holding.iter().map(|p| (p - center).norm()).fold(spacing, f64::max);
    let start = centered(surface, &center);
    let linearize = |s: &Surface| {
        let mut normal = Normal::<8>::zero();
        /// Of the spacing, for central differences: truncation at 1e-8, rounding at 1e-12 of the value.
        const STEP: f64 = 1e-4;
        let step = STEP * spacing;
        let moved: Vec<[Option<Surface>; 2]> = (0..8)
            .map(|i| {
                [step, -step].map(|d| {
                    let mut delta = [0.0; 8];
                    delta[i] = d;
                    perturbed(s, &delta, extent)
                })
            })
            .collect();
        let weighted = holding.iter().map(|p| (p, *weight)).chain(pulls.iter().map(|p| (p, BORDER_WEIGHT)));
        for (point, w) in weighted {
            let residual = s.signed_distance(point);
            let row: [f64; 8] = std::array::from_fn(|i| match &moved[i] {
                [Some(a), Some(b)] => (a.signed_distance(point) - b.signed_distance(point)) / (2.0 * step),
                _ => 0.0,
            });
            normal.add([residual], &[row], w);
            normal.cost += w * residual * residual;
        }
        normal
    };
    /// A good start: a handful of steps reach the minimum.
    const MAX_ITERATIONS: usize = 8;
    let retract =
        |s: &Surface, d: &nalgebra::SVector<f64, 8>| perturbed(s, &std::array::from_fn(|i| d[i]), extent);
    let (found, ..) = minimize(start, MAX_ITERATIONS, linearize, retract);
    let mean_sq =
        holding.iter().map(|p| found.signed_distance(p).powi(2)).sum::<f64>() / holding.len() as f64;
    let turned = holding.iter().all(|p| found.normal(p).dot(&original.normal(p)) > 0.0);
    (turned && mean_sq.sqrt() <= MAX_MOVE * spacing).then_some(found)
}

/// The same surface with its reference point beside `center`.
fn centered(surface: &Surface, center: &Point3) -> Surface {
    match surface {
        Surface::Plane(s) => Surface::Plane(Plane {
            point: center - s.normal.into_inner() * s.signed_distance(center),
            normal: s.normal,
        }),
        Surface::Cylinder(s) => {
            Surface::Cylinder(Cylinder { axis: Axis { origin: s.axis.foot(center), ..s.axis }, ..*s })
        }
        Surface::Cone(s) => {
            let radius = s.radius + s.axis.height(center) * s.half_angle.tan();
            let axis = Axis { origin: s.axis.foot(center), ..s.axis };
            if radius > 0.0 {
                Surface::Cone(Cone { axis, radius, half_angle: s.half_angle })
            } else {
                *surface
            }
        }
        Surface::Sphere(_) | Surface::Torus(_) => *surface,
    }
}

/// A surface after a small change: two turns and three moves of its frame, then its sizes, all as lengths.
fn perturbed(surface: &Surface, d: &[f64; 8], extent: f64) -> Option<Surface> {
    let turn = |z: &UnitVec3| {
        let x = any_perpendicular(z);
        let y = z.cross(&x);
        UnitVec3::new_normalize(z.into_inner() + x.into_inner() * (d[0] / extent) + y * (d[1] / extent))
    };
    let moved = |p: &Point3, z: &UnitVec3| {
        let x = any_perpendicular(z);
        let y = z.cross(&x);
        p + x.into_inner() * d[2] + y * d[3]
    };
    let axis = |a: &Axis| Axis { origin: moved(&a.origin, &a.direction), direction: turn(&a.direction) };
    let positive = |r: f64| (r.is_finite() && r > 0.0).then_some(r);
    Some(match surface {
        Surface::Plane(s) => {
            Surface::Plane(Plane { point: s.point + s.normal.into_inner() * d[2], normal: turn(&s.normal) })
        }
        Surface::Cylinder(s) => {
            Surface::Cylinder(Cylinder { axis: axis(&s.axis), radius: positive(s.radius + d[4])? })
        }
        Surface::Cone(s) => {
            let half_angle = s.half_angle + d[5] / extent;
            if half_angle <= CONE_MARGIN || half_angle >= std::f64::consts::FRAC_PI_2 - CONE_MARGIN {
                return None;
            }
            Surface::Cone(Cone { axis: axis(&s.axis), radius: positive(s.radius + d[4])?, half_angle })
        }
        Surface::Sphere(s) => Surface::Sphere(Sphere {
            center: s.center + Vec3::new(d[0], d[1], d[2]),
            radius: positive(s.radius + d[4])?,
        }),
        Surface::Torus(s) => {
            let mut axis = axis(&s.axis);
            axis.origin += s.axis.direction.into_inner() * d[4];
            let major_radius = s.major_radius + d[5];
            if major_radius * s.major_radius <= 0.0 {
                return None;
            }
            Surface::Torus(Torus { axis, major_radius, minor_radius: positive(s.minor_radius + d[6])? })
        }
    })
}
