//! Scans as they come: several parts, thin walls, plates, clutter, doubled and flipped triangles.

use scanwright::math::{Point3, Vec3};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::pipeline::{self, Options, Reconstruction};
use scanwright::progress::Progress;
use scanwright::random::Rng;
use scanwright::surface::{Surface, SurfaceKind};

use crate::scans::{block, bushing, moved, together};

#[test]
fn parts_of_one_scan_share_no_region() {
    let scan = together(block([24.0, 18.0, 12.0], 1.0), &moved(bushing(1.2), Vec3::new(60.0, 0.0, 0.0)));
    let result = run(&scan);
    let (component, n_components) = Adjacency::new(&result.mesh).components();
    assert_eq!(n_components, 2);
    let mut of_region = vec![None; result.segmentation.primitives.len()];
    for (t, label) in result.segmentation.labels.iter().enumerate() {
        let Some(region) = label else { continue };
        let seen = of_region[region.0 as usize].get_or_insert(component[t]);
        assert_eq!(*seen, component[t], "region {} lies on both parts", region.0);
    }
    assert!(kinds(&result).iter().filter(|k| **k == Some(SurfaceKind::Plane)).count() >= 6);
}

#[test]
fn walls_two_spacings_apart_stay_two() {
    let spacing = 1.0;
    let result = run(&block([40.0, 30.0, 2.0 * spacing], spacing));
    let mut heights: Vec<f64> =
        planes(&result).filter(|(_, normal)| normal.z.abs() > 0.99).map(|(point, _)| point.z).collect();
    heights.sort_by(f64::total_cmp);
    assert_eq!(heights.len(), 2, "large faces at {heights:?}");
    // Each height is the mean of over a thousand points whose noise is a fraction of the spacing.
    let bound = 0.02 * spacing;
    assert!((heights[1] - heights[0] - 2.0 * spacing).abs() < bound, "large faces at {heights:?}");
}

#[test]
fn a_plate_is_not_taken_for_its_own_table() {
    let scan = block([60.0, 40.0, 4.0], 1.0);
    let result = run(&scan);
    assert!(result.support.is_none(), "the plate was taken for a table");
    assert_eq!(kinds(&result), [Some(SurfaceKind::Plane); 6]);
    assert!(
        result.labels_of_scan(scan.triangles.len()).iter().all(Option::is_some),
        "triangles without a plane"
    );
}

#[test]
fn walls_four_spacings_wide_are_faces() {
    assert_eq!(kinds(&run(&block([60.0, 40.0, 4.0], 1.0))), [Some(SurfaceKind::Plane); 6]);
}

#[test]
fn specks_and_clutter_change_nothing_but_their_own_labels() {
    let part = block([24.0, 18.0, 12.0], 1.0);
    let mut scan = part.clone();
    let mut rng = Rng::for_task(1, "specks", 0);
    for _ in 0..30 {
        let mut place = || 40.0 * (rng.uniform() - 0.3);
        let at = Vec3::new(place(), place(), place() + 30.0);
        scan = together(scan, &moved(tetrahedron(0.6), at));
    }
    let (clean, cluttered) = (run(&part), run(&scan));
    assert_eq!(kinds(&cluttered), kinds(&clean));
    let labels = cluttered.labels_of_scan(scan.triangles.len());
    let n = part.triangles.len();
    assert!(labels[n..].iter().all(Option::is_none), "specks have labels");
    assert!(labels[..n].iter().all(Option::is_some), "the part lost triangles");
}

#[test]
fn doubled_and_flipped_triangles_are_put_right() {
    let part = block([24.0, 18.0, 12.0], 1.0);
    let mut scan = part.clone();
    for triangle in scan.triangles.iter_mut().step_by(5) {
        triangle.swap(1, 2);
    }
    let doubled: Vec<_> = scan.triangles.iter().copied().step_by(7).collect();
    scan.triangles.extend(doubled);
    let (clean, repaired) = (run(&part), run(&scan));
    assert_eq!(kinds(&repaired), kinds(&clean));
    let center = Point3::new(12.0, 9.0, 6.0);
    for (point, normal) in planes(&repaired) {
        assert!((point - center).dot(&normal) > 0.0, "the plane at {point} looks inwards");
    }
}

fn run(scan: &Mesh) -> Reconstruction {
    pipeline::run(scan, &Options::default(), &Progress::none()).unwrap()
}

fn kinds(result: &Reconstruction) -> Vec<Option<SurfaceKind>> {
    let mut kinds: Vec<_> =
        result.segmentation.primitives.iter().map(scanwright::recognize::Primitive::kind).collect();
    kinds.sort();
    kinds
}

fn planes(result: &Reconstruction) -> impl Iterator<Item = (Point3, Vec3)> {
    result.segmentation.primitives.iter().filter_map(|primitive| match primitive.surface {
        Some(Surface::Plane(plane)) => Some((plane.point, plane.normal.into_inner())),
        _ => None,
    })
}

fn tetrahedron(size: f64) -> Mesh {
    let corner = |x: f64, y: f64, z: f64| Point3::new(size * x, size * y, size * z);
    let vertices =
        vec![corner(0.0, 0.0, 0.0), corner(1.0, 0.0, 0.0), corner(0.0, 1.0, 0.0), corner(0.0, 0.0, 1.0)];
    Mesh { vertices, triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] }
}
