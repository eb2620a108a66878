//! Where surfaces that run on into each other change over: a pipe into its bend, a rod into its round end.
//!
//! Along such a border one surface leaves the other with the square of the distance only, and for a long way the noise
//! hides which is nearer; but the surfaces themselves say where they touch: on the plane across the spine through the
//! bend's centre, or across the axis through the contact circle of the sphere. Triangles on the wrong side of it that the
//! other surface describes as well go there.

use super::RegionId;
use crate::math::{UnitVec3, try_unit};
use crate::mesh::{Adjacency, Mesh};
use crate::recognize::Primitive;
use crate::surface::{Plane, Surface, Torus};

/// Root mean square residuals within which the other surface describes a triangle.
const MAX_RMS: f64 = 3.0;
/// Edges that two regions share at least.
const MIN_EDGES: usize = 6;

/// Moves triangles to the side of the contact that they are on. `spacing`: length by which surfaces may miss each other.
pub(super) fn settle(
    mesh: &Mesh,
    adjacency: &Adjacency,
    labels: &mut [Option<RegionId>],
    primitives: &[Primitive],
    spacing: f64,
) {
    for (a, b) in neighbours(adjacency, labels) {
        let [first, second] = [a, b].map(|k| &primitives[k.0 as usize]);
        let (Some(s), Some(t)) = (first.surface, second.surface) else { continue };
        let Some(plane) = contact_plane(&s, &t, spacing).filter(|_| first.outward == second.outward) else {
            continue;
        };
        let near = spacing.max(MAX_RMS * first.residual.rms.max(second.residual.rms));
        // The pieces of both near the border, each with its side of the plane.
        let beside: Vec<(usize, RegionId, f64)> = (0..labels.len())
            .filter_map(|k| {
                let label = labels[k].filter(|l| [a, b].contains(l))?;
                let center = mesh.triangle_center(k);
                let is_near = [s, t].iter().all(|x| x.signed_distance(&center).abs() < near);
                is_near.then(|| (k, label, plane.signed_distance(&center)))
            })
            .collect();
        let mean = |k: RegionId| {
            let sides = beside.iter().filter(|x| x.1 == k).map(|x| x.2);
            let (sum, n) = sides.fold((0.0, 0.0), |(sum, n), side| (sum + side, n + 1.0));
            sum / f64::max(n, 1.0)
        };
        // Both on one side of their contact: it is not this one.
        if mean(a) * mean(b) >= 0.0 {
            continue;
        }
        let sign = mean(a).signum();
        for (k, _, side) in beside {
            labels[k] = Some(if side * sign > 0.0 { a } else { b });
        }
    }
}

/// The plane on which two surfaces touch that run on into each other; `None` when they do not. `slack`: length by which
/// they may miss each other.
fn contact_plane(a: &Surface, b: &Surface, slack: f64) -> Option<Plane> {
    /// Sine of the angle by which directions may miss each other.
    const ALIGNED: f64 = 0.1;
    match (a, b) {
        (Surface::Torus(bend), Surface::Cylinder(pipe)) | (Surface::Cylinder(pipe), Surface::Torus(bend)) => {
            let off = pipe.axis.radial(&bend.axis.origin);
            let continues = (pipe.radius - bend.minor_radius).abs() < slack
                && (off.norm() - bend.major_radius).abs() < slack
                && pipe.axis.direction.dot(&bend.axis.direction).abs() < ALIGNED
                && off.dot(&bend.axis.direction).abs() < slack.max(ALIGNED * off.norm());
            continues.then_some(Plane { point: bend.axis.origin, normal: pipe.axis.direction })
        }
        (Surface::Torus(one), Surface::Torus(other)) => between_bends(one, other, slack, ALIGNED),
        (Surface::Sphere(ball), Surface::Cylinder(rod)) | (Surface::Cylinder(rod), Surface::Sphere(ball)) => {
            let continues =
                (ball.radius - rod.radius).abs() < slack && rod.axis.radial(&ball.center).norm() < slack;
            continues.then_some(Plane { point: ball.center, normal: rod.axis.direction })
        }
        (Surface::Sphere(ball), Surface::Cone(taper)) | (Surface::Cone(taper), Surface::Sphere(ball)) => {
            let continues = (taper.signed_distance(&ball.center).abs() - ball.radius).abs() < slack
                && taper.axis.radial(&ball.center).norm() < slack;
            // A cone's normal leans back along its axis.
            let down = ball.radius * taper.half_angle.sin();
            let point = ball.center - taper.axis.direction.into_inner() * down;
            continues.then_some(Plane { point, normal: taper.axis.direction })
        }
        _ => None,
    }
}

/// Two bends of one pipe in one plane: they touch on the line of their centres.
fn between_bends(one: &Torus, other: &Torus, slack: f64, aligned: f64) -> Option<Plane> {
    let between = other.axis.origin - one.axis.origin;
    let apart = between.norm();
    let sum = one.major_radius + other.major_radius;
    let difference = (one.major_radius - other.major_radius).abs();
    let continues = (one.minor_radius - other.minor_radius).abs() < slack
        && one.axis.direction.cross(&other.axis.direction).norm() < aligned
        && between.dot(&one.axis.direction).abs() < slack.max(aligned * apart)
        && ((apart - sum).abs() < slack || (apart - difference).abs() < slack && apart > slack);
    let normal: UnitVec3 = try_unit(one.axis.direction.cross(&between)).filter(|_| continues)?;
    Some(Plane { point: one.axis.origin, normal })
}

/// Pairs of regions that share edges, ascending.
fn neighbours(adjacency: &Adjacency, labels: &[Option<RegionId>]) -> Vec<(RegionId, RegionId)> {
    let mut shared = Vec::new();
    for (t, across) in adjacency.across.iter().enumerate() {
        for u in across.iter().flatten() {
            if let (Some(a), Some(b)) = (labels[t], labels[*u as usize])
                && a < b
            {
                shared.push((a, b));
            }
        }
    }
    shared.sort_unstable();
    shared.chunk_by(|x, y| x == y).filter(|run| run.len() >= MIN_EDGES).map(|run| run[0]).collect()
}
