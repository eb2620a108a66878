//! Segmentations of others on a part whose faces are known: a box with a bore.

use std::f64::consts::TAU;

use scanwright::math::Point3;
use scanwright::mesh::Mesh;
use scanwright::par;
use scanwright::segment::{Baseline, SegmentMethod, Segmentation};

use crate::scanned::{box_distance, scan, with_noise};
use crate::segmentation::kinds;
use crate::spectral::segmented;

/// Half lengths of the box, and the radius of the bore about z. Vertices are one apart.
const HALF: [f64; 3] = [20.0, 15.0, 10.0];
const RADIUS: f64 = 7.0;
/// Six planes and the wall of the bore.
const N_FACES: usize = 7;

/// A scan with noise of a twentieth of its spacing, and the face of every triangle.
fn bored_box() -> (Mesh, Vec<usize>) {
    let bore = |p: &Point3| RADIUS - p.x.hypot(p.y);
    // Off the grid, so that no vertex lies on two faces.
    let reach = HALF.map(|half| half + 2.3);
    let sharp = scan(|p| box_distance(p, [0.0; 3], HALF).max(bore(p)), reach.map(|r| -r), reach, 1.0);
    let face = |p: Point3| {
        let mut off: Vec<f64> = (0..3).flat_map(|k| [p[k] - HALF[k], -p[k] - HALF[k]]).collect();
        off.push(bore(&p));
        (0..N_FACES).min_by(|&a, &b| off[a].abs().total_cmp(&off[b].abs())).expect("there are faces")
    };
    let faces = (0..sharp.triangles.len()).map(|t| face(sharp.triangle_center(t))).collect();
    (with_noise(&sharp, 0.05, 7), faces)
}

/// Mean over the faces of the best intersection over union, by area, with any region.
fn overlap(mesh: &Mesh, faces: &[usize], segmentation: &Segmentation) -> f64 {
    let n_regions = segmentation.primitives.len();
    let (mut both, mut of_face, mut of_region) =
        (vec![vec![0.0; n_regions]; N_FACES], [0.0; N_FACES], vec![0.0; n_regions]);
    for (t, &face) in faces.iter().enumerate() {
        let region = segmentation.labels[t].expect("every triangle has a region").0 as usize;
        let area = mesh.area(t);
        both[face][region] += area;
        of_face[face] += area;
        of_region[region] += area;
    }
    let best = |face: usize| {
        let shares = (0..n_regions).map(|k| both[face][k] / (of_face[face] + of_region[k] - both[face][k]));
        shares.fold(0.0, f64::max)
    };
    (0..N_FACES).map(best).sum::<f64>() / N_FACES as f64
}

/// The overlap when every border lies a spacing off, a triangle's width, so that a strip along it is lost or won.
fn least_overlap() -> f64 {
    let [x, y, z] = HALF.map(|half| 2.0 * half);
    let rim = TAU * RADIUS;
    // Area and length of the borders of each pair of sides, and of the bore's wall.
    let sides = [(y * z, 2.0 * (y + z)), (z * x, 2.0 * (z + x))];
    let ends = (x * y - 0.5 * RADIUS * rim, 2.0 * (x + y) + rim);
    let share = |(area, border): (f64, f64)| (area - border) / (area + border);
    (2.0 * (share(sides[0]) + share(sides[1]) + share(ends)) + share((rim * z, 2.0 * rim))) / N_FACES as f64
}

fn methods() -> [SegmentMethod; 3] {
    let told = Baseline { n_regions: Some(N_FACES), ..Baseline::default() };
    [SegmentMethod::Hfp(told), SegmentMethod::LiuZhang(told), SegmentMethod::Xiao { seed: 1 }]
}

#[test]
fn baselines_cut_a_bored_box_into_its_faces() {
    let (mesh, faces) = bored_box();
    for method in methods() {
        let segmentation = segmented(&mesh, method);
        let overlap = overlap(&mesh, &faces, &segmentation);
        assert!(overlap > least_overlap(), "{method:?}: {overlap}, {:?}", kinds(&segmentation));
    }
}

#[test]
fn baselines_do_not_depend_on_the_number_of_threads() {
    let (mesh, _) = bored_box();
    for method in methods() {
        let by = |n| par::with_threads(Some(n), || segmented(&mesh, method));
        assert_eq!(by(1), by(4), "{method:?}");
    }
}

#[test]
fn numbers_that_are_not_given_are_found() {
    let (mesh, faces) = bored_box();
    for method in [SegmentMethod::Hfp(Baseline::default()), SegmentMethod::LiuZhang(Baseline::default())] {
        let segmentation = segmented(&mesh, method);
        let overlap = overlap(&mesh, &faces, &segmentation);
        assert!(overlap > least_overlap(), "{method:?}: {overlap}, {:?}", kinds(&segmentation));
    }
}
