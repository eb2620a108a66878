//! Which parts of a model's faces no scan is near.
//!
//! Faces that were extended over a hole are partly seen. Their triangles are cut until they are as small as the scan's
//! detail, and those that lie farther from the scan than noise and rounding explain become faces of their own, assumed.

use std::collections::{BTreeMap, BTreeSet};

use super::scene::{Face, ModelView};
use crate::deviation::Nearest;
use crate::mesh::Mesh;
use crate::par;

/// Longest edge of a cut triangle, in reaches.
const FINENESS: f64 = 1.0;
/// Triangles that the faces are cut into at most: beyond, they are cut more coarsely.
const MOST_TRIANGLES: f64 = 30_000.0;
/// Faces with many thin triangles give more of them; the cutting then ends here.
const ENOUGH_TRIANGLES: usize = 300_000;
/// Every pass halves the longest edges.
const MOST_PASSES: usize = 24;

/// The model with the unseen parts of `regions` as faces of their own. `reach`: what is farther from `scan` was not seen.
pub(super) fn separated(model: &ModelView, scan: &Mesh, regions: &BTreeSet<u32>, reach: f64) -> ModelView {
    let concerned: Vec<bool> =
        model.faces.iter().map(|f| !f.assumed && f.region.is_some_and(|r| regions.contains(&r))).collect();
    let is_concerned = |face: u32| concerned.get(face as usize).copied().unwrap_or(false);
    let area: f64 = (0..model.mesh.triangles.len())
        .filter(|t| is_concerned(model.face_of[*t]))
        .map(|t| model.mesh.area(t))
        .sum();
    let nearest = Nearest::new(scan).filter(|_| area > 0.0 && reach > 0.0);
    let Some(nearest) = nearest else { return model.clone() };
    // A square of this side for every two triangles.
    let longest = (FINENESS * reach).max((2.0 * area / MOST_TRIANGLES).sqrt());
    let mut view = model.clone();
    for _ in 0..MOST_PASSES {
        if view.mesh.triangles.len() > ENOUGH_TRIANGLES || !cut(&mut view, longest, &is_concerned) {
            break;
        }
    }
    let unseen = par::map_indices(view.mesh.triangles.len(), |t| {
        is_concerned(view.face_of[t]) && nearest.signed_distance(&view.mesh.triangle_center(t)).abs() > reach
    });
    let mut faces = BTreeMap::new();
    for (t, _) in unseen.iter().enumerate().filter(|(_, unseen)| **unseen) {
        let seen = view.face_of[t];
        view.face_of[t] = *faces.entry(seen).or_insert_with(|| {
            view.faces.push(Face { assumed: true, ..view.faces[seen as usize] });
            (view.faces.len() - 1) as u32
        });
    }
    view
}

/// Halves every edge of a concerned face that is longer than `longest`, in all triangles that have it. Returns whether
/// there was one.
fn cut(view: &mut ModelView, longest: f64, is_concerned: &impl Fn(u32) -> bool) -> bool {
    let mesh = &mut view.mesh;
    let key = |a: u32, b: u32| (a.min(b), a.max(b));
    let mut middles = BTreeMap::new();
    for (triangle, face) in mesh.triangles.iter().zip(&view.face_of) {
        for k in 0..3 {
            let (a, b) = key(triangle[k], triangle[(k + 1) % 3]);
            let (p, q) = (mesh.vertices[a as usize], mesh.vertices[b as usize]);
            if is_concerned(*face) && (q - p).norm() > longest && !middles.contains_key(&(a, b)) {
                middles.insert((a, b), mesh.vertices.len() as u32);
                mesh.vertices.push(nalgebra::center(&p, &q));
            }
        }
    }
    if middles.is_empty() {
        return false;
    }
    let (triangles, faces) = (std::mem::take(&mut mesh.triangles), std::mem::take(&mut view.face_of));
    for (triangle, face) in triangles.into_iter().zip(faces) {
        let middle = |k: usize| middles.get(&key(triangle[k], triangle[(k + 1) % 3])).copied();
        let pieces = pieces(triangle, [0, 1, 2].map(middle));
        view.face_of.extend(std::iter::repeat_n(face, pieces.len()));
        mesh.triangles.extend(pieces);
    }
    true
}

/// The pieces of a triangle; `middles`: of the edges from its first, second and third corner, where they are halved.
fn pieces(triangle: [u32; 3], middles: [Option<u32>; 3]) -> Vec<[u32; 3]> {
    // Turned so that the first edge is halved, and the third is not unless all are.
    let n = middles.iter().flatten().count();
    let turn = (0..3).find(|k| middles[*k].is_some() && (n == 3 || middles[(k + 2) % 3].is_none()));
    let Some(turn) = turn else { return vec![triangle] };
    let [a, b, c] = [0, 1, 2].map(|k| triangle[(turn + k) % 3]);
    let [ab, bc, ca] = [0, 1, 2].map(|k| middles[(turn + k) % 3]);
    match (ab, bc, ca) {
        (Some(ab), Some(bc), Some(ca)) => vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]],
        (Some(ab), Some(bc), None) => vec![[ab, b, bc], [a, ab, bc], [a, bc, c]],
        (Some(ab), ..) => vec![[a, ab, c], [ab, b, c]],
        _ => vec![triangle],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Point3;

    /// A square of two triangles in z = 0, one face.
    fn square(side: f64) -> ModelView {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let vertices = corners.iter().map(|(x, y)| Point3::new(side * x, side * y, 0.0)).collect();
        let mesh = Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] };
        ModelView {
            mesh,
            face_of: vec![0; 2],
            faces: vec![Face { region: Some(0), kind: None, assumed: false }],
        }
    }

    #[test]
    fn the_half_that_was_not_scanned_is_found_and_nothing_is_lost() {
        let model = square(10.0);
        let mut scan = square(10.0).mesh;
        for vertex in &mut scan.vertices {
            vertex.x *= 0.5;
            vertex.z += 0.01;
        }
        let reach = 0.5;
        let view = separated(&model, &scan, &BTreeSet::from([0]), reach);
        let area = |assumed: bool| -> f64 {
            let of = |t: &usize| view.faces[view.face_of[*t] as usize].assumed == assumed;
            (0..view.mesh.triangles.len()).filter(of).map(|t| view.mesh.area(t)).sum()
        };
        assert!((area(true) + area(false) - 100.0).abs() < 1e-9);
        // The border between seen and unseen lies a reach beyond the scan, within the size of a cut triangle.
        assert!((area(true) - 45.0).abs() < 10.0 * reach, "{}", area(true));
        let normals_agree = (0..view.mesh.triangles.len()).all(|t| view.mesh.cross(t).z > 0.0);
        assert!(normals_agree, "a piece is turned over");
        // Every inner edge has two sides: the cuts of neighbours meet.
        let mut sides = BTreeMap::new();
        for triangle in &view.mesh.triangles {
            for k in 0..3 {
                *sides.entry((triangle[k], triangle[(k + 1) % 3])).or_insert(0) += 1;
            }
        }
        let single = sides.keys().filter(|(a, b)| !sides.contains_key(&(*b, *a)));
        for (a, b) in single {
            let [p, q] = [a, b].map(|v| view.mesh.vertices[*v as usize]);
            let on_rim = |k: usize| p[k] == q[k] && (p[k] == 0.0 || p[k] == 10.0);
            assert!(on_rim(0) || on_rim(1), "{p} {q} has one side");
        }
    }

    #[test]
    fn what_is_not_asked_for_stays_as_it_is() {
        let model = square(10.0);
        let far = {
            let mut mesh = square(1.0).mesh;
            mesh.vertices.iter_mut().for_each(|v| v.z = 99.0);
            mesh
        };
        let view = separated(&model, &far, &BTreeSet::from([5]), 0.5);
        assert_eq!((view.mesh.triangles.len(), view.faces.len()), (2, 1));
    }
}
