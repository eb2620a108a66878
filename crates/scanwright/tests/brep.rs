//! Tests of `brep`: solids from labelled grids with known surfaces, and whether the check refuses spoiled ones.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use scanwright::brep::{
    Built, Curve, EdgeId, EdgeUse, Geometry, IssueCode, LabelledMesh, Problem, Solid, Validity, build, check,
    tessellate, validity,
};
use scanwright::math::{Point3, Vec3};
use scanwright::par;
use scanwright::segment::RegionId;
use scanwright::surface::{Surface, SurfaceKind};
use std::f64::consts::PI;

use crate::parts::{
    Part, STEP, block, block_with_two_bores, cap, counterbored, dented, grooved_pipe, pipe, plane, tolerances,
};

/// Largest gap that the check allows here: what default tolerances allow.
const GAP: f64 = 0.05 * STEP;

// -------------------------------------------------------------------------------------------------- what is built

#[test]
fn a_block_has_the_counts_of_a_block() {
    let size = [12.0, 10.0, 8.0];
    let solid = sound(&block(size));
    assert_eq!((solid.faces.len(), solid.edges.len(), solid.vertices.len()), (6, 12, 8));
    assert!(solid.edges.iter().all(|e| matches!(e.curve, Curve::Line { .. })));
    assert!(solid.gap < 1e-9, "exact planes meet exactly, not within {}", solid.gap);
    assert_near(volume(&solid), size.iter().product(), 1e-9, "volume");
}

#[test]
fn round_faces_are_cut_and_keep_their_surfaces() {
    let (outer, inner, height) = (14.0, 6.0, 40.0);
    let solid = sound(&pipe(outer, inner, height));
    assert_eq!(kinds(&solid), [(SurfaceKind::Plane, 2), (SurfaceKind::Cylinder, 4)]);
    // Two halves of wall and bore: two circles of two arcs at each end, and two straight cuts per cylinder.
    assert_eq!((solid.edges.len(), solid.vertices.len()), (12, 8));
    let radii: Vec<f64> = solid
        .surfaces
        .iter()
        .filter_map(|g| match g {
            Geometry::Analytic(Surface::Cylinder(c)) => Some(c.radius),
            _ => None,
        })
        .collect();
    assert!(radii.iter().all(|r| *r == outer || *r == inner), "{radii:?}");
    // Chords of the tessellation leave out a share of the disc that falls with the square of their angle.
    let exact = PI * (outer * outer - inner * inner) * height;
    assert_near(volume(&solid), exact, 0.01 * exact, "volume");
}

#[test]
fn no_triangle_spans_a_bore() {
    let (outer, inner) = (14.0, 6.0);
    // Whether samples of a circle lie on one line of the parameter plane is a matter of rounding: turn it about.
    for turn in 0..24 {
        let rotation =
            nalgebra::Rotation3::from_euler_angles(0.3 * f64::from(turn), 0.7 * f64::from(turn), 0.1);
        let solid = sound(&pipe(outer, inner, 40.0).moved(&rotation, 1.0, &Vec3::new(3.0, -50.0, 7.0)));
        let made = tessellate(&solid);
        for (t, face) in made.faces.iter().enumerate() {
            let Geometry::Analytic(Surface::Cylinder(c)) = solid.geometry(&solid.faces[face.0 as usize])
            else {
                continue;
            };
            let depth = -c.signed_distance(&made.mesh.triangle_center(t));
            assert!(
                depth < 0.05 * c.radius,
                "turn {turn}: a triangle lies {depth} inside a wall of {}",
                c.radius
            );
        }
    }
}

#[test]
fn all_five_types_of_surface_and_tangent_pairs_become_faces() {
    let solid = sound(&cap());
    let expected = [
        SurfaceKind::Plane,
        SurfaceKind::Cylinder,
        SurfaceKind::Cone,
        SurfaceKind::Sphere,
        SurfaceKind::Torus,
    ];
    assert_eq!(kinds(&solid).iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), expected);
    // All surfaces share one axis, so every edge is a circle about it or a cut that a plane through it makes.
    let off_plane = solid.vertices.iter().filter(|v| ![0.0, 10.0, 13.0].contains(&round(v.point.z)));
    assert!(off_plane.count() > 0 && solid.edges.iter().all(|e| !matches!(e.curve, Curve::Ellipse { .. })));
    let exact = cap().mesh.signed_volume();
    // The grid lies inside its round faces by up to a sagitta of (TAU / 88)^2 / 2 of the radius.
    assert_near(volume(&solid), exact, 0.005 * exact, "volume");
}

#[test]
fn a_groove_is_cut_through_its_bottom_and_not_through_its_opening() {
    // Down to a groove that fairing would fill: its meridian is six edges long.
    for tube in [6.0, 3.0, 1.5] {
        let part = grooved_pipe(14.0, 6.0, 30.0, tube);
        let solid = sound(&part);
        let expected = [(SurfaceKind::Plane, 2), (SurfaceKind::Cylinder, 6), (SurfaceKind::Torus, 2)];
        assert_eq!(kinds(&solid), expected, "tube {tube}");
        let exact = part.mesh.signed_volume();
        assert_near(volume(&solid), exact, 0.01 * exact, "volume");
    }
}

#[test]
fn bores_that_cross_meet_in_edges_of_both_cylinders() {
    let closed = block_with_two_bores(20.0, 5.0, 6.0).close(None);
    let built = build(&closed.labelled, &tolerances(STEP));
    assert_eq!(built.solids.len(), 1);
    let solid = &built.solids[0];
    assert!(solid.is_closed());
    assert!(solid.faces.iter().any(|face| face.assumed), "nobody saw the crossing");
    assert_near(volume(solid), closed.labelled.mesh.signed_volume(), 0.005 * 40.0_f64.powi(3), "volume");
}

#[test]
fn pieces_of_a_mesh_become_solids_of_their_own() {
    let (a, b) = (block([8.0; 3]), pipe(14.0, 6.0, 10.0));
    let mut both = a.labelled();
    let other = b.labelled();
    let (n_vertices, n_regions) = (both.mesh.vertices.len() as u32, both.primitives.len() as u32);
    let far = Vec3::new(50.0, 0.0, 0.0);
    both.mesh.vertices.extend(other.mesh.vertices.iter().map(|p| p + far));
    both.mesh.triangles.extend(other.mesh.triangles.iter().map(|t| t.map(|v| v + n_vertices)));
    both.labels.extend(other.labels.iter().map(|l| RegionId(l.0 + n_regions)));
    both.assumed.extend(&other.assumed);
    both.primitives.extend(b.moved(&nalgebra::Rotation3::identity(), 1.0, &far).primitives);
    let built = build(&both, &tolerances(STEP));
    assert_eq!(built.solids.iter().map(|s| s.faces.len()).collect::<Vec<_>>(), [6, 6]);
    for solid in &built.solids {
        assert_eq!(check(solid, GAP), []);
    }
}

#[test]
fn a_region_without_a_surface_becomes_a_spline_face() {
    let mut part = block([12.0, 10.0, 8.0]);
    part.primitives[5].surface = None;
    let built = build(&part.labelled(), &tolerances(STEP));
    assert!(built.issues.iter().any(|i| i.code == IssueCode::Freeform && i.region == Some(RegionId(5))));
    let solid = &built.solids[0];
    assert_eq!(check(solid, GAP), []);
    let splines = solid.faces.iter().filter(|f| solid.geometry(f).kind().is_none());
    assert_eq!(splines.map(|f| f.region).collect::<Vec<_>>(), [RegionId(5)]);
    assert_near(volume(solid), 960.0, 0.01, "volume");
}

#[test]
fn a_step_that_no_region_was_found_for_is_put_between_the_faces_beside_it() {
    for width in [1.5, 2.5] {
        let part = counterbored(width);
        let whole = sound(&part);
        let mut labelled = part.labelled();
        // Shared between counterbore and bore, as a segmentation does with a strip that is too narrow for it.
        for (t, label) in labelled.labels.iter_mut().enumerate().filter(|(_, l)| l.0 == 4) {
            let center = labelled.mesh.triangle_center(t);
            *label = RegionId(if center.x.hypot(center.y) > 8.0 - 0.5 * width { 3 } else { 5 });
        }
        let built = build(&labelled, &tolerances(STEP));
        let issues: Vec<_> = built.issues.iter().map(|i| (i.code, i.region)).collect();
        // The region of the step is known, but nothing belongs to it.
        assert_eq!(issues, [(IssueCode::FaceAdded, Some(RegionId(6)))], "{width}");
        assert_eq!(built.primitives.len(), 7);
        let solid = &built.solids[0];
        assert_eq!(check(solid, GAP), []);
        assert_eq!(kinds(solid), kinds(&whole));
        assert_near(volume(solid), volume(&whole), 1e-3 * volume(&whole), "volume");
    }
}

#[test]
fn a_cone_down_to_its_apex_is_two_faces_that_end_there() {
    let solid = sound(&dented());
    assert_eq!(kinds(&solid), [(SurfaceKind::Plane, 2), (SurfaceKind::Cylinder, 2), (SurfaceKind::Cone, 2)]);
    let apex = solid.vertices.iter().filter(|v| (v.point - Point3::new(0.0, 0.0, 6.0)).norm() < 1e-9);
    assert_eq!(apex.count(), 1);
    let exact = PI * (100.0 * 12.0 - 36.0 * 6.0 / 3.0);
    assert_near(volume(&solid), exact, 0.01 * exact, "volume");
}

#[test]
fn the_two_sides_of_a_thin_plate_are_not_given_to_each_other() {
    // The top was read as a plane that leaves the mesh, so its face is flawed and has to be mended somehow.
    for tilt in [0.05, 0.2, 1.0] {
        let mut part = block([12.0, 10.0, 1.0]);
        part.primitives[5] = plane(Point3::new(6.0, 5.0, 1.0), Vec3::new(tilt, 0.3 * tilt, 1.0));
        let built = build(&part.labelled(), &tolerances(STEP));
        let mut regions: Vec<u32> = built.solids[0].faces.iter().map(|f| f.region.0).collect();
        regions.sort_unstable();
        regions.dedup();
        assert!(regions.contains(&4) && regions.contains(&5), "{tilt}: {regions:?}");
        assert_near(volume(&built.solids[0]), 120.0, 12.0, "volume");
    }
}

#[test]
fn a_mesh_with_a_hole_gives_an_open_shell_that_is_called_open() {
    let part = block([12.0, 10.0, 8.0]).without(|label, p| label == 5 && (p.x - 6.0).hypot(p.y - 5.0) < 2.0);
    let built = build(&part.labelled(), &tolerances(STEP));
    assert!(built.issues.iter().any(|i| i.code == IssueCode::OpenShell));
    assert!(!built.solids[0].is_closed());
    assert_eq!(validity(&check(&built.solids[0], GAP)), Validity::Open);
}

#[test]
fn assumed_triangles_make_assumed_faces() {
    let mut labelled = block([12.0, 10.0, 8.0]).labelled();
    for (t, label) in labelled.labels.iter().enumerate() {
        // All of one face, a corner of another: most of a face decides.
        labelled.assumed[t] = label.0 == 2 || (label.0 == 3 && labelled.mesh.triangle_center(t).x < 3.0);
    }
    let built = build(&labelled, &tolerances(STEP));
    let assumed = built.solids[0].faces.iter().filter(|f| f.assumed).map(|f| f.region);
    assert_eq!(assumed.collect::<Vec<_>>(), [RegionId(2)]);
}

#[test]
fn solids_do_not_depend_on_threads_and_move_and_scale_with_the_mesh() {
    let part = cap();
    let one = par::with_threads(Some(1), || build(&part.labelled(), &tolerances(STEP)));
    let two = par::with_threads(Some(2), || build(&part.labelled(), &tolerances(STEP)));
    assert_eq!(one, two);
    let exact = volume(&one.solids[0]);
    let rotation = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    for scale in [1e-3, 1e3] {
        let moved = part.moved(&rotation, scale, &(Vec3::new(3.0, -70.0, 9.0) * scale));
        let solid = &build(&moved.labelled(), &tolerances(STEP * scale)).solids[0];
        assert_eq!(kinds(solid), kinds(&one.solids[0]));
        assert_eq!(check(solid, GAP * scale), []);
        // The seams turn with the frame, so the triangles of round faces are others.
        assert_near(volume(solid) / scale.powi(3), exact, 1e-3 * exact, "volume");
    }
}

// ----------------------------------------------------------------------------------------------- what is refused

#[test]
fn a_face_turned_over_is_refused() {
    each_face(|solid, f| {
        solid.faces[f].same_sense = !solid.faces[f].same_sense;
        Validity::Closed
    });
    // Turned with its loops, it runs the right way round and its neighbours do not agree.
    each_face(|solid, f| {
        solid.faces[f].same_sense = !solid.faces[f].same_sense;
        for run in &mut solid.faces[f].loops {
            reverse(&mut run.uses);
        }
        Validity::Closed
    });
}

#[test]
fn a_solid_turned_inside_out_is_refused() {
    for (name, mut solid) in solids() {
        for face in &mut solid.faces {
            face.same_sense = !face.same_sense;
            for run in &mut face.loops {
                reverse(&mut run.uses);
            }
        }
        let problems = check(&solid, GAP);
        assert!(problems.iter().any(|p| matches!(p, Problem::Volume(_))), "{name}: {problems:?}");
    }
}

#[test]
fn a_missing_or_doubled_face_is_refused() {
    each_face(|solid, f| {
        solid.faces.remove(f);
        Validity::Open
    });
    each_face(|solid, f| {
        solid.faces.push(solid.faces[f].clone());
        Validity::Open
    });
}

#[test]
fn a_vertex_moved_off_its_curves_is_refused() {
    for (name, solid) in solids() {
        for v in 0..solid.vertices.len() {
            for by in [3.0 * GAP, 5.0 * STEP, f64::NAN] {
                let mut spoiled = solid.clone();
                // Across no edge of the test parts alone: all lie along or about the axes.
                spoiled.vertices[v].point += Vec3::new(1.0, 0.9, 1.1) * by;
                let problems = check(&spoiled, GAP);
                let named = |p: &Problem| matches!(p, Problem::VertexOffCurve { vertex, .. } if vertex.0 as usize == v);
                assert!(problems.iter().any(named), "{name}, vertex {v} by {by}: {problems:?}");
                assert!(validity(&problems) < Validity::Valid);
            }
        }
    }
}

#[test]
fn loops_that_are_swapped_reversed_or_torn_are_refused() {
    each_face(|solid, f| {
        let next = (f + 1) % solid.faces.len();
        let run = solid.faces[f].loops[0].clone();
        solid.faces[f].loops[0] = std::mem::replace(&mut solid.faces[next].loops[0], run);
        Validity::Oriented
    });
    each_face(|solid, f| {
        reverse(&mut solid.faces[f].loops[0].uses);
        Validity::Closed
    });
    each_face(|solid, f| {
        solid.faces[f].loops[0].uses.pop();
        Validity::Open
    });
    each_face(|solid, f| {
        let edge_use = &mut solid.faces[f].loops[0].uses[0];
        edge_use.forward = !edge_use.forward;
        Validity::Open
    });
    each_face(|solid, f| {
        solid.faces[f].loops[0].uses.clear();
        Validity::Open
    });
}

#[test]
fn a_surface_moved_away_from_its_edges_is_refused() {
    for (name, solid) in solids() {
        for s in 0..solid.surfaces.len() {
            let Geometry::Analytic(surface) = &solid.surfaces[s] else { panic!("{name} has no splines") };
            // No test part has a surface that this leaves in place.
            let by = Vec3::new(1.0, 0.9, 1.1) * (5.0 * GAP);
            let moved = surface.transformed(&nalgebra::Rotation3::identity(), 1.0, &by);
            let mut spoiled = solid.clone();
            spoiled.surfaces[s] = Geometry::Analytic(moved);
            let problems = check(&spoiled, GAP);
            let off = problems.iter().any(|p| matches!(p, Problem::CurveOffSurface { .. }));
            assert!(off, "{name}, surface {s}: {problems:?}");
        }
    }
}

#[test]
fn loops_that_cross_are_refused() {
    // The inner circle of a pipe's end, moved until it crosses the outer one.
    let mut solid = sound(&pipe(14.0, 6.0, 40.0));
    let by = Vec3::new(10.0, 0.0, 0.0);
    for vertex in &mut solid.vertices {
        if vertex.point.x.hypot(vertex.point.y) < 10.0 {
            vertex.point += by;
        }
    }
    for edge in &mut solid.edges {
        match &mut edge.curve {
            Curve::Circle { frame, radius } if *radius < 10.0 => frame.origin += by,
            Curve::Line { origin, .. } if origin.x.hypot(origin.y) < 10.0 => *origin += by,
            _ => {}
        }
    }
    let crossed = check(&solid, GAP).iter().filter(|p| matches!(p, Problem::LoopsCross { .. })).count();
    assert_eq!(crossed, 2, "both ends");
}

#[test]
fn a_loop_that_goes_round_its_surface_is_refused() {
    // Both halves of the circle at one end of a pipe, as the loop of one half of its wall.
    let mut solid = sound(&pipe(14.0, 6.0, 40.0));
    let at_end = |v: u32| solid.vertices[v as usize].point.z > 19.0;
    let circle: Vec<EdgeUse> = (0..solid.edges.len() as u32)
        .map(|e| EdgeUse { edge: EdgeId(e), forward: true })
        .filter(|u| match &solid.edge(u.edge).curve {
            Curve::Circle { radius, .. } => *radius > 10.0 && at_end(solid.edge(u.edge).start.0),
            _ => false,
        })
        .collect();
    assert_eq!(circle.len(), 2);
    let uses_it = |f: &usize| solid.faces[*f].loops[0].uses.iter().any(|u| u.edge == circle[0].edge);
    let wall = (0..solid.faces.len())
        .filter(uses_it)
        .find(|f| solid.geometry(&solid.faces[*f]).kind() == Some(SurfaceKind::Cylinder))
        .expect("a half of the wall ends there");
    solid.faces[wall].loops[0].uses = circle;
    let winds = |p: &Problem| matches!(p, Problem::LoopWinds { face, index: 0 } if face.0 as usize == wall);
    let problems = check(&solid, GAP);
    assert!(problems.iter().any(winds), "{problems:?}");
}

#[test]
fn counts_that_no_solid_has_are_refused() {
    let mut solid = sound(&block([12.0, 10.0, 8.0]));
    solid.shells.clear();
    let problems = check(&solid, GAP);
    assert!(
        matches!(problems[..], [Problem::Euler { vertices: 8, edges: 12, faces: 6, holes: 0 }]),
        "{problems:?}"
    );
}

// ------------------------------------------------------------------------------------------------- hostile input

#[test]
fn nothing_and_nonsense_are_built_without_panic() {
    let empty = LabelledMesh { labels: Vec::new(), assumed: Vec::new(), ..cap().labelled() };
    let built = build(&empty, &tolerances(STEP));
    assert!(built.solids.is_empty() && built.issues.iter().any(|i| i.code == IssueCode::Empty));
    let mut broken = pipe(14.0, 6.0, 40.0);
    let nan = Vec3::from_element(f64::NAN);
    broken.primitives[1].surface =
        broken.primitives[1].surface.map(|s| s.transformed(&nalgebra::Rotation3::identity(), 1.0, &nan));
    let built = build(&broken.labelled(), &tolerances(STEP));
    assert!(built.solids.iter().all(|s| !check(s, GAP).is_empty() || s.gap.is_finite()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    /// Whatever the labels, a closed mesh becomes a sound solid, in the end one of facets.
    #[test]
    fn any_labels_give_a_sound_solid(labels in prop::collection::vec(0_u32..6, 384)) {
        let mut part = block([8.0; 3]).labelled();
        prop_assert_eq!(labels.len() * 2, part.labels.len());
        for (t, label) in labels.into_iter().enumerate() {
            part.labels[2 * t] = RegionId(label);
        }
        let Built { solids, .. } = build(&part, &tolerances(STEP));
        prop_assert_eq!(solids.len(), 1);
        prop_assert_eq!(check(&solids[0], GAP), []);
        prop_assert!(solids[0].is_closed());
    }
}

// ------------------------------------------------------------------------------------------------------- helpers

/// The one solid of a part, without any problem.
fn sound(part: &Part) -> Solid {
    let built = build(&part.labelled(), &tolerances(STEP));
    assert_eq!(built.issues, []);
    assert_eq!(built.solids.len(), 1);
    let solid = built.solids.into_iter().next().unwrap();
    let problems = check(&solid, GAP);
    assert_eq!(problems, []);
    assert_eq!(validity(&problems), Validity::Valid);
    assert!(solid.is_closed() && solid.gap <= GAP);
    solid
}

fn solids() -> Vec<(&'static str, Solid)> {
    vec![
        ("block", sound(&block([12.0, 10.0, 8.0]))),
        ("pipe", sound(&pipe(14.0, 6.0, 40.0))),
        ("cap", sound(&cap())),
        ("dented", sound(&dented())),
    ]
}

/// Spoils every face of every solid in turn; `spoil` returns the highest rung that may be left.
fn each_face(spoil: impl Fn(&mut Solid, usize) -> Validity) {
    for (name, solid) in solids() {
        for f in 0..solid.faces.len() {
            let mut spoiled = solid.clone();
            let highest = spoil(&mut spoiled, f);
            let problems = check(&spoiled, GAP);
            assert!(!problems.is_empty(), "{name}: face {f} passed");
            assert!(validity(&problems) <= highest, "{name}, face {f}: {problems:?}");
        }
    }
}

fn reverse(uses: &mut [EdgeUse]) {
    uses.reverse();
    for edge_use in uses {
        edge_use.forward = !edge_use.forward;
    }
}

fn volume(solid: &Solid) -> f64 {
    tessellate(solid).mesh.signed_volume()
}

/// Number of faces by type.
fn kinds(solid: &Solid) -> Vec<(SurfaceKind, usize)> {
    let mut kinds: Vec<SurfaceKind> = solid.faces.iter().filter_map(|f| solid.geometry(f).kind()).collect();
    kinds.sort_unstable();
    kinds.chunk_by(|a, b| a == b).map(|same| (same[0], same.len())).collect()
}

fn round(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

#[track_caller]
fn assert_near(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance, "{what}: {a} is not within {tolerance} of {b}");
}
