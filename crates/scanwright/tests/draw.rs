//! Tests of `brep::draw`: a primitive drawn by itself is sound, as large as what was seen, and read by Open CASCADE.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use scanwright::brep::{Problem, Solid, check, draw, tessellate};
use scanwright::fit::Fit;
use scanwright::math::{Axis, Point3, UnitVec3, Vec3};
use scanwright::segment::RegionId;
use scanwright::step::StepOptions;
use scanwright::surface::samples::{Patch, sample};
use scanwright::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};

use crate::step::{Folder, judge};

/// A surface, what is seen of it, and the area of that.
struct Seen {
    name: &'static str,
    surface: Surface,
    patch: Patch,
    area: f64,
}

fn seen() -> Vec<Seen> {
    let direction = UnitVec3::new_normalize(Vec3::new(1.0, 2.0, -0.5));
    let axis = Axis { origin: Point3::new(30.0, -20.0, 10.0), direction };
    let plane = Surface::Plane(Plane { point: axis.origin, normal: direction });
    let cylinder = Surface::Cylinder(Cylinder { axis, radius: 8.0 });
    let cone = Surface::Cone(Cone { axis, radius: 8.0, half_angle: 0.5 });
    let sphere = Surface::Sphere(Sphere { center: axis.origin, radius: 9.0 });
    let torus = Surface::Torus(Torus { axis, major_radius: 20.0, minor_radius: 5.0 });
    let lateral = |turn: f64, low: f64, high: f64| {
        let radius = |h: f64| 8.0 + h * 0.5_f64.tan();
        0.5 * turn * (radius(low) + radius(high)) * (high - low) / 0.5_f64.cos()
    };
    let apex = -8.0 / 0.5_f64.tan();
    let part = |name, surface, u, v, area| Seen { name, surface, patch: Patch { u, v }, area };
    vec![
        part("rectangle", plane, (-10.0, 10.0), (-5.0, 5.0), 200.0),
        part("cylinder", cylinder, (0.0, TAU), (-6.0, 6.0), TAU * 8.0 * 12.0),
        part("half pipe", cylinder, (1.0, 1.0 + PI), (-6.0, 6.0), PI * 8.0 * 12.0),
        part("cone", cone, (0.0, TAU), (-6.0, 6.0), lateral(TAU, -6.0, 6.0)),
        part("cone to its apex", cone, (0.0, TAU), (apex, 6.0), lateral(TAU, apex, 6.0)),
        part("part of a cone", cone, (2.0, 6.0), (-6.0, 6.0), lateral(4.0, -6.0, 6.0)),
        part("sphere", sphere, (0.0, TAU), (-FRAC_PI_2, FRAC_PI_2), 4.0 * PI * 81.0),
        part("cap", sphere, (0.0, TAU), (0.6, FRAC_PI_2), TAU * 81.0 * (1.0 - 0.6_f64.sin())),
        part("large cap", sphere, (0.0, TAU), (-0.7, FRAC_PI_2), TAU * 81.0 * (1.0 + 0.7_f64.sin())),
        part("zone", sphere, (0.0, TAU), (-0.3, 0.8), TAU * 81.0 * (0.8_f64.sin() + 0.3_f64.sin())),
        part("torus", torus, (0.0, TAU), (-PI, PI), 4.0 * PI * PI * 100.0),
        part("elbow", torus, (0.0, 1.5), (-PI, PI), 1.5 * TAU * 100.0),
        part(
            "fillet",
            torus,
            (0.0, TAU),
            (0.5, 2.0),
            TAU * 5.0 * (20.0 * 1.5 + 5.0 * (2.0_f64.sin() - 0.5_f64.sin())),
        ),
    ]
}

fn drawn(seen: &Seen, outward: bool) -> Solid {
    let points: Vec<Point3> = sample(&seen.surface, seen.patch, 8000, 0.0, 7).iter().map(|s| s.0).collect();
    draw(&Fit { surface: seen.surface, outward }, &points, RegionId(3)).expect("it spans a range")
}

#[test]
fn every_type_is_drawn_over_what_was_seen_of_it() {
    for seen in seen() {
        for outward in [true, false] {
            let solid = drawn(&seen, outward);
            // A shell has rims, and the skin of a cavity alone a negative volume.
            let is_expected = |problem: &Problem| match problem {
                Problem::EdgeUse { forward, backward, .. } => forward + backward == 1,
                Problem::Volume(volume) => !outward && *volume < 0.0,
                _ => false,
            };
            let problems: Vec<Problem> =
                check(&solid, 1e-9).into_iter().filter(|p| !is_expected(p)).collect();
            assert!(problems.is_empty(), "{} {outward}: {problems:?}", seen.name);
            let mesh = tessellate(&solid).mesh;
            let off = mesh.vertices.iter().map(|p| seen.surface.signed_distance(p).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{}: {off} off the surface", seen.name);
            // Chords of ten degrees cut off half a percent; at both ends as many points may be strays.
            let ratio = mesh.total_area() / seen.area;
            assert!((0.95..1.01).contains(&ratio), "{}: {ratio} of the area", seen.name);
            let normals = mesh.triangle_normals();
            let facing = (0..normals.len()).filter(|&t| {
                let natural = seen.surface.normal(&mesh.triangle_center(t)).dot(&normals[t]) > 0.0;
                natural == outward
            });
            assert_eq!(facing.count(), normals.len(), "{}: all triangles face one way", seen.name);
        }
    }
}

#[test]
fn shells_of_many_primitives_are_one_file_that_a_kernel_reads() {
    let mut all = Solid::default();
    for seen in seen() {
        all.append(drawn(&seen, true));
    }
    assert_eq!(all.shells.len(), seen().len());
    let n_faces = all.faces.len();
    let file = Folder::new("primitives").write("all.step", &[all], &StepOptions::default());
    let verdict = &judge(&[file])[0];
    assert_eq!(verdict["valid"], true, "{verdict}");
    let faces = verdict["faces"].as_object().unwrap().values().map(|n| n.as_u64().unwrap() as usize);
    assert_eq!(faces.sum::<usize>(), n_faces, "{verdict}");
}

#[test]
fn nothing_is_drawn_of_points_without_extent() {
    let surface = seen()[0].surface;
    let fit = Fit { surface, outward: true };
    assert!(draw(&fit, &[Point3::origin(); 2], RegionId(0)).is_none());
    assert!(draw(&fit, &[Point3::origin(); 50], RegionId(0)).is_none());
    let line: Vec<Point3> = (0..50).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
    let flat = Plane { point: Point3::origin(), normal: Vec3::z_axis() };
    assert!(draw(&Fit { surface: Surface::Plane(flat), outward: true }, &line, RegionId(0)).is_none());
}
