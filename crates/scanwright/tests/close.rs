//! Tests of `brep::close`: solids made of grids with known surfaces, from which triangles are taken.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use scanwright::brep::close::{Assumption, Closed, close};
use scanwright::condition::Support;
use scanwright::math::{Axis, Point3, Vec3};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::par;
use scanwright::segment::{RegionId, Segmentation};
use scanwright::surface::{Cylinder, Plane, Surface};
use std::f64::consts::{PI, TAU};

use crate::parts::{BOTTOM, Part, STEP, block, block_with_two_bores, pipe, post, tolerances};

#[test]
fn a_closed_mesh_is_left_as_it_is() {
    let part = block([12.0, 10.0, 8.0]);
    let closed = part.close(None);
    assert_eq!(closed.labelled.mesh, part.mesh);
    assert!(closed.assumed_faces.is_empty() && closed.open.is_empty());
}

#[test]
fn a_bore_seen_from_both_ends_becomes_one_face() {
    let (outer, inner, height) = (14.0, 6.0, 40.0);
    let whole = pipe(outer, inner, height);
    // Teeth of one step in the rim, as scanners leave them.
    let seen = whole.without(|t, p| t == 1 && p.z.abs() < 10.0 + STEP * (5.0 * p.y.atan2(p.x)).sin());
    let closed = seen.close(None);
    assert_closed(&closed);
    assert_eq!(assumptions(&closed), [(1, Assumption::Extended)]);
    // Edges of up to two steps on a cylinder lie inside it by their sagitta.
    let sagitta = (2.0 * STEP).powi(2) / (8.0 * inner);
    let unseen = TAU * inner * 22.0;
    assert_near(closed.labelled.mesh.signed_volume(), whole.mesh.signed_volume(), unseen * sagitta, "volume");
}

#[test]
fn two_regions_of_one_bore_are_merged() {
    let mut seen = pipe(14.0, 6.0, 40.0).without(|t, p| t == 1 && p.z.abs() < 9.0);
    let second = seen.primitives.len() as u32;
    seen.primitives.push(seen.primitives[1].clone());
    for t in 0..seen.labels.len() {
        if seen.labels[t] == 1 && seen.mesh.triangle_center(t).z < 0.0 {
            seen.labels[t] = second;
        }
    }
    let closed = seen.close(None);
    assert_closed(&closed);
    let labels: Vec<u32> = closed.labelled.labels.iter().map(|l| l.0).collect();
    assert!(labels.contains(&1) != labels.contains(&second), "one of the two remains");
}

#[test]
fn a_bore_without_a_visible_end_is_capped_where_sight_ends() {
    let whole = pipe(14.0, 6.0, 40.0);
    let depth = 5.0;
    let seen = whole.without(|t, p| t == 3 || (t == 1 && p.z < depth));
    // The lower end is a disc without a bore.
    let seen = seen.with_disc(14.0, -20.0);
    let closed = seen.close(None);
    assert_closed(&closed);
    let caps: Vec<_> = closed.assumed_faces.iter().filter(|f| f.assumption == Assumption::Cap).collect();
    assert_eq!(caps.len(), 1, "{:?}", closed.assumed_faces);
    let cap = &closed.labelled.primitives[caps[0].region.0 as usize];
    let Some(Surface::Plane(plane)) = cap.surface else { panic!("a cap is flat") };
    assert_near(plane.normal.z, 1.0, 1e-9, "the cap faces the air above it");
    assert_near(plane.point.z, depth, 2.0 * STEP, "height of the cap");
}

#[test]
fn a_box_on_the_table_gets_its_bottom() {
    let size = [12.0, 10.0, 8.0];
    let whole = block(size);
    // The bottom and two steps of skirt are missing.
    let seen = whole.without(|t, p| t == BOTTOM || p.z < 2.0);
    let closed = seen.close(Some(&table(0.0)));
    assert_closed(&closed);
    let kinds: Vec<Assumption> = closed.assumed_faces.iter().map(|f| f.assumption).collect();
    assert_eq!(kinds.iter().filter(|k| **k == Assumption::Support).count(), 1);
    // Walls and plane are exact, so is their intersection.
    assert_near(closed.labelled.mesh.signed_volume(), size.iter().product(), 1e-6, "volume");
}

#[test]
fn a_shadow_that_reaches_the_table_does_not_keep_the_bottom_open() {
    let size = [24.0, 20.0, 18.0];
    let whole = block(size);
    // Unseen: the bottom, a skirt, and on two of the walls and round a corner what something above them hid.
    let shadow =
        |p: Point3| p.z < 14.0 && ((p.x - 12.0).abs() < 5.0 && p.y < 1.0 || p.x > 23.0 && p.y > 15.0);
    let seen = whole.without(|t, p| t == BOTTOM || p.z < 2.0 || shadow(p));
    let closed = seen.close(Some(&table(0.0)));
    assert_closed(&closed);
    let supports = closed.assumed_faces.iter().filter(|f| f.assumption == Assumption::Support).count();
    assert_eq!(supports, 1, "{:?}", assumptions(&closed));
    // The membrane cuts the corner that it grows back by less than a triangle.
    let cut = 14.0 * STEP * STEP / 2.0;
    assert_near(closed.labelled.mesh.signed_volume(), size.iter().product(), cut, "volume");
}

#[test]
fn a_bore_goes_down_to_the_table() {
    let whole = pipe(14.0, 6.0, 40.0);
    let seen = whole.without(|t, p| t == 3 || (t == 0 && p.z < -18.0) || (t == 1 && p.z < 3.0));
    let closed = seen.close(Some(&table(-20.0)));
    assert_closed(&closed);
    let made: Vec<Assumption> = closed.assumed_faces.iter().map(|f| f.assumption).collect();
    assert!(!made.contains(&Assumption::Cap), "the bore is open below: {made:?}");
    let sagitta = (2.0 * STEP).powi(2) / (8.0 * 6.0);
    let unseen = TAU * (6.0 * 23.0 + 14.0 * 2.0);
    assert_near(closed.labelled.mesh.signed_volume(), whole.mesh.signed_volume(), unseen * sagitta, "volume");
}

#[test]
fn a_head_does_not_go_down_to_the_table_through_its_foot_and_a_bore_does() {
    let (bore, height) = (4.0, 12.0);
    let whole = post([18.0, 8.0, 14.0], bore, height);
    // Unseen: the bottom, the lower bore, the underside of the head and what it shadows of the stem.
    let seen = whole.without(|label, p| match label {
        0 => p.z < 2.0,
        1 => p.z > 2.0 * height - 3.0,
        4 | 6 => true,
        7 => p.z < 2.5 * height,
        _ => false,
    });
    let closed = seen.close(Some(&table(0.0)));
    assert_closed(&closed);
    let bores = closed.labelled.mesh.triangles.iter().zip(&closed.labelled.labels).filter(|(_, l)| l.0 == 7);
    let lowest = bores.map(|(t, _)| closed.labelled.mesh.vertices[t[0] as usize].z).fold(f64::MAX, f64::min);
    assert_near(lowest, 0.0, 1e-6, "end of the bore");
    let head = closed.labelled.mesh.triangles.iter().zip(&closed.labelled.labels).filter(|(_, l)| l.0 == 2);
    let lowest = head.map(|(t, _)| closed.labelled.mesh.vertices[t[0] as usize].z).fold(f64::MAX, f64::min);
    assert!(lowest > 1.5 * height, "the head goes down to {lowest}");
}

#[test]
fn a_pinhole_in_a_low_top_is_no_way_to_the_table() {
    let size = [12.0, 10.0, 3.0];
    let pinhole = |p: Point3| (p.x - 6.5).hypot(p.y - 5.5) < 0.5;
    let seen = block(size).without(|t, p| t == BOTTOM || p.z < 0.6 || (p.z > 2.9 && pinhole(p)));
    let closed = seen.close(Some(&table(0.0)));
    assert_closed(&closed);
    // A way to the table would take a cone as high as the block.
    let full = block(size).without(|t, p| t == BOTTOM || p.z < 0.6).close(Some(&table(0.0)));
    let [with, without] = [&closed, &full].map(|c| c.labelled.mesh.signed_volume());
    assert_near(with, without, 1e-6, "volume");
}

#[test]
fn a_missing_corner_grows_back_from_its_three_faces() {
    let size = [16.0, 14.0, 12.0];
    let corner = Point3::from(Vec3::from(size));
    let whole = block(size);
    let seen = whole.without(|_, p| (p - corner).norm() < 5.0);
    let closed = seen.close(None);
    assert_closed(&closed);
    let nearest = closed.labelled.mesh.vertices.iter().map(|p| (p - corner).norm()).fold(f64::MAX, f64::min);
    assert!(nearest < STEP, "a vertex comes to the corner, but the nearest is {nearest} away");
    // What may be cut off: a bevel half a step wide along three edges five steps long.
    let bevel = 3.0 * 5.0 * 0.5 * (0.5 * STEP).powi(2);
    assert_near(closed.labelled.mesh.signed_volume(), size.iter().product(), bevel, "volume");
    let invented = (0..closed.labelled.labels.len()).filter(|&t| closed.labelled.assumed[t]);
    let mut labels: Vec<u32> = invented.map(|t| closed.labelled.labels[t].0).collect();
    labels.sort_unstable();
    labels.dedup();
    assert_eq!(labels.len(), 3, "three faces are extended: {labels:?}");
}

#[test]
fn a_window_in_a_wall_takes_the_wall() {
    let whole = pipe(14.0, 6.0, 40.0);
    let seen = whole.without(|t, p| t == 0 && p.x > 0.0 && p.y.hypot(p.z) < 7.0);
    let closed = seen.close(None);
    assert_closed(&closed);
    assert_eq!(assumptions(&closed), [(0, Assumption::Extended)]);
    // All new vertices lie on the wall.
    for p in &closed.labelled.mesh.vertices[seen.mesh.vertices.len()..] {
        assert_near(p.x.hypot(p.y), 14.0, 1e-9, "radius");
    }
}

#[test]
fn bores_that_meet_unseen_are_joined() {
    let (half, radius) = (20.0, 5.0);
    let part = block_with_two_bores(half, radius, 6.0);
    let closed = part.close(None);
    assert_closed(&closed);
    // Both bores end flat on the other's axis; half cylinders overlap in a quarter of Steinmetz's 16 r^3 / 3.
    let air = 2.0 * PI * radius * radius * half - 4.0 * radius.powi(3) / 3.0;
    // Facets of the grid lie up to a third of a step off the sharp edges, and inside the cylinders by a sagitta.
    let edge_loss = (3.0 * TAU * radius) * (STEP / 3.0).powi(2);
    let sagitta = (2.0 * STEP).powi(2) / (8.0 * radius) * (2.0 * TAU * radius * half);
    let volume = closed.labelled.mesh.signed_volume();
    assert_near(volume, (2.0 * half).powi(3) - air, edge_loss + sagitta, "volume");
    // A cap at each mouth would leave the middle solid; that is not what happened.
    let solid_middle = PI * radius * radius * 6.0;
    assert!((2.0 * half).powi(3) - volume > 2.0 * solid_middle + 0.5 * air);
}

#[test]
fn the_result_moves_and_scales_with_the_scan() {
    let seen = pipe(14.0, 6.0, 40.0).without(|t, p| t == 3 || (t == 1 && p.z < 5.0)).with_disc(14.0, -20.0);
    let volume = seen.close(None).labelled.mesh.signed_volume();
    let rotation = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    for scale in [1e-3, 1.0, 1e3] {
        let moved = seen.moved(&rotation, scale, &(Vec3::new(3.0, -70.0, 9.0) * scale));
        let closed = moved.close(None);
        assert_closed(&closed);
        // The grid of the fill turns with the frame: facets differ by sagittas of the new area at most.
        let allowed = TAU * 6.0 * 5.0 * (2.0 * STEP).powi(2) / (8.0 * 6.0);
        assert_near(closed.labelled.mesh.signed_volume() / scale.powi(3), volume, allowed, "volume");
    }
}

#[test]
fn the_result_does_not_depend_on_threads() {
    let seen = pipe(14.0, 6.0, 40.0).without(|t, p| t == 1 && p.z.abs() < 8.0);
    let one = par::with_threads(Some(1), || seen.close(None));
    let two = par::with_threads(Some(2), || seen.close(None));
    assert_eq!(one, two);
}

#[test]
fn a_mesh_without_surfaces_is_still_closed() {
    let mut seen = block([8.0; 3]).without(|t, p| t == BOTTOM && p.x < 4.0);
    for primitive in &mut seen.primitives {
        primitive.surface = None;
    }
    assert_closed(&seen.close(None));
}

#[test]
fn absurd_input_does_not_panic() {
    let nothing = Part::default();
    assert!(nothing.close(None).labelled.labels.is_empty());
    let mut flap = block([4.0; 3]).without(|t, _| t != BOTTOM);
    flap.close(Some(&table(0.0)));
    flap.labels.clear();
    flap.primitives.clear();
    flap.close(None);
    let mut broken = pipe(14.0, 6.0, 40.0).without(|t, p| t == 1 && p.z < 0.0);
    broken.primitives[1].surface = Some(Surface::Cylinder(Cylinder {
        axis: Axis { origin: Point3::new(f64::NAN, 0.0, 0.0), direction: Vec3::z_axis() },
        radius: 0.0,
    }));
    broken.close(None);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn triangle_soup_does_not_panic(
        points in prop::collection::vec((-5.0..5.0, -5.0..5.0, -5.0..5.0), 4..24),
        corners in prop::collection::vec((0_usize..24, 0_usize..24, 0_usize..24), 1..40),
        labels in prop::collection::vec(prop::option::of(0_u32..9), 0..40),
    ) {
        let n = points.len();
        let vertices = points.into_iter().map(|(x, y, z)| Point3::new(x, y, z)).collect();
        let triangles = corners.into_iter().map(|(a, b, c)| [a % n, b % n, c % n].map(|v| v as u32)).collect();
        let mesh = Mesh { vertices, triangles };
        let primitives = pipe(3.0, 1.0, 4.0).primitives;
        let labels = labels.into_iter().map(|l| l.map(RegionId)).collect();
        let closed = close(&mesh, &Segmentation { labels, primitives }, Some(&table(-3.0)), &tolerances(1.0));
        prop_assert_eq!(closed.labelled.labels.len(), closed.labelled.mesh.triangles.len());
        prop_assert_eq!(closed.labelled.assumed.len(), closed.labelled.mesh.triangles.len());
    }

    #[test]
    fn random_damage_of_a_block_is_closed(holes in prop::collection::vec((0.0..12.0, 0.0..10.0, 0.0..8.0, 0.8..3.5), 1..4)) {
        let seen = block([12.0, 10.0, 8.0]).without(|_, p| {
            holes.iter().any(|&(x, y, z, r)| (p - Point3::new(x, y, z)).norm() < r)
        });
        let closed = seen.close(None);
        prop_assert!(closed.open.is_empty());
        prop_assert!(is_closed(&closed.labelled.mesh));
    }
}

fn table(height: f64) -> Support {
    let plane = Plane { point: Point3::new(0.0, 0.0, height), normal: Vec3::z_axis() };
    Support { plane, on_table: Vec::new(), outlines: Vec::new() }
}

// ---------------------------------------------------------------------------------------------------------------------
// Checks.

/// Whether every edge is used once in each sense.
fn is_closed(mesh: &Mesh) -> bool {
    let mut edges: Vec<(u32, u32)> =
        mesh.triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3]))).collect();
    edges.sort_unstable();
    edges.windows(2).all(|pair| pair[0] != pair[1])
        && edges.iter().all(|e| edges.binary_search(&(e.1, e.0)).is_ok())
}

fn assert_closed(closed: &Closed) {
    let labelled = &closed.labelled;
    assert!(closed.open.is_empty(), "left open: {:?}", closed.open);
    assert!(is_closed(&labelled.mesh), "some edge is not used once in each sense");
    assert_eq!(Adjacency::new(&labelled.mesh).components().1, 1, "one piece");
    assert!(labelled.labels.iter().all(|l| (l.0 as usize) < labelled.primitives.len()));
    assert!(labelled.mesh.vertices.iter().all(|p| p.coords.iter().all(|c| c.is_finite())));
}

fn assumptions(closed: &Closed) -> Vec<(u32, Assumption)> {
    closed.assumed_faces.iter().map(|f| (f.region.0, f.assumption)).collect()
}

#[track_caller]
fn assert_near(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance, "{what}: {a} is not within {tolerance} of {b}");
}
