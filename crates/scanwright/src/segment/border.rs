//! Where one face ends and the next begins, triangle by triangle.
//!
//! Labels of vertices are decided with rough fits and a price for every border; once the surfaces are final, a
//! triangle at a border belongs to whichever of the surfaces that meet there its centre is nearest to. Across a sharp
//! edge, as round as the scanner makes it, that is the edge's bisector. Between tangent surfaces one distance says
//! nothing: where a fillet meets its sides, or a cylinder a plane, the mean over a ring does; between other tangent
//! surfaces the curvatures are too alike, and labels stay.

use super::RegionId;
use crate::math::{Point3, Vec3};
use crate::mesh::{Adjacency, Mesh, connected};
use crate::par;
use crate::recognize::Primitive;
use crate::surface::SurfaceKind;

/// Angle between two normals, radians, below which distances do not tell their surfaces apart.
const TANGENT: f64 = 0.35;
/// Smaller pieces of a region, in triangles, go to what surrounds them.
const ISLAND: usize = 12;

type Labels = [Option<RegionId>];

/// Labels of triangles with sharp borders. Only triangles at a border change, to a label that meets them there.
/// `fillets`: regions that are tangent to their neighbours by construction, ascending.
pub(super) fn sharpened(
    mesh: &Mesh,
    adjacency: &Adjacency,
    labels: &Labels,
    primitives: &[Primitive],
    fillets: &[u32],
) -> Vec<Option<RegionId>> {
    let normals = mesh.triangle_normals();
    let mut sharp: Vec<Option<RegionId>> = par::map_indices(labels.len(), |t| {
        let current = labels[t]?;
        let mut around: Vec<RegionId> = mesh.triangles[t]
            .iter()
            .flat_map(|&v| adjacency.vertex_triangles.row(v as usize))
            .filter_map(|&u| labels[u as usize])
            .filter(|&k| k != current)
            .collect();
        around.sort_unstable();
        around.dedup();
        let center = mesh.triangle_center(t);
        let is_fillet = |k: RegionId| fillets.binary_search(&k.0).is_ok();
        let mut best = current;
        for k in around {
            let (now, next) = (&primitives[best.0 as usize], &primitives[k.0 as usize]);
            let is_contact = is_fillet(k) || is_fillet(best) || are_plane_and_cylinder(now, next);
            if faces(next, &normals[t], &center)
                && (is_nearer(next, now, &center)
                    || is_contact && is_nearer_around(next, now, &ring(mesh, adjacency, t)))
            {
                best = k;
            }
        }
        Some(best)
    });
    while give_away_islands(adjacency, &mut sharp) {}
    sharp
}

/// Whether the first surface is nearer to a point than the second, and not tangent to it.
fn is_nearer(a: &Primitive, b: &Primitive, point: &Point3) -> bool {
    let (Some(a), Some(b)) = (a.fit(), b.fit()) else { return false };
    let (da, na) = a.distance_and_outward_normal(point);
    let (db, nb) = b.distance_and_outward_normal(point);
    na.dot(&nb) < TANGENT.cos() && da.abs() < db.abs()
}

/// Whether the first surface is nearer to points on the whole than the second, which is tangent to it.
fn is_nearer_around(a: &Primitive, b: &Primitive, points: &[Point3]) -> bool {
    let (Some(a), Some(b)) = (a.fit(), b.fit()) else { return false };
    let mut excess = 0.0;
    for point in points {
        let (da, na) = a.distance_and_outward_normal(point);
        let (db, nb) = b.distance_and_outward_normal(point);
        if na.dot(&nb) < TANGENT.cos() {
            return false;
        }
        excess += da.abs() - db.abs();
    }
    excess < 0.0
}

fn are_plane_and_cylinder(a: &Primitive, b: &Primitive) -> bool {
    use SurfaceKind::{Cylinder, Plane};
    matches!((a.kind(), b.kind()), (Some(Plane), Some(Cylinder)) | (Some(Cylinder), Some(Plane)))
}

/// Corners of a triangle and the vertices around them.
fn ring(mesh: &Mesh, adjacency: &Adjacency, triangle: usize) -> Vec<Point3> {
    let mut ring: Vec<u32> = mesh.triangles[triangle]
        .iter()
        .flat_map(|&v| adjacency.vertex_vertices.row(v as usize))
        .copied()
        .collect();
    ring.sort_unstable();
    ring.dedup();
    ring.into_iter().map(|v| mesh.vertices[v as usize]).collect()
}

/// Whether a surface faces the way that a triangle does: the other side of a thin wall does not.
fn faces(primitive: &Primitive, normal: &Vec3, point: &Point3) -> bool {
    primitive.fit().is_some_and(|fit| fit.distance_and_outward_normal(point).1.dot(normal) > 0.0)
}

/// Gives small pieces of regions to the neighbour they share most edges with; whether any changed.
fn give_away_islands(adjacency: &Adjacency, labels: &mut Labels) -> bool {
    let across = |t: u32| adjacency.across[t as usize].into_iter().flatten();
    let pieces = connected(labels.len(), |t| labels[t as usize], across);
    let mut largest: Vec<usize> = Vec::new();
    for (label, piece) in &pieces {
        let at = label.0 as usize;
        if largest.len() <= at {
            largest.resize(at + 1, 0);
        }
        largest[at] = largest[at].max(piece.len());
    }
    let mut is_changed = false;
    for (label, piece) in pieces {
        if piece.len() >= ISLAND || piece.len() == largest[label.0 as usize] {
            continue;
        }
        let mut around: Vec<RegionId> = piece
            .iter()
            .flat_map(|&t| adjacency.across[t as usize])
            .flatten()
            .filter_map(|u| labels[u as usize])
            .filter(|&k| k != label)
            .collect();
        around.sort_unstable();
        let most = around.chunk_by(|a, b| a == b).max_by_key(|run| (run.len(), std::cmp::Reverse(run[0])));
        if let Some(run) = most {
            for &t in &piece {
                labels[t as usize] = Some(run[0]);
            }
            is_changed = true;
        }
    }
    is_changed
}
