//! The generated database: its meshes lie on their surfaces, it is the same every time, and its splits share no shape.

use std::collections::BTreeMap;

use scanwright::gprimdb::{Class, Manifest, Model, Noise, Split, Tier, Triangulation};
use scanwright::math::{Axis, Point3, UnitVec3, Vec3};
use scanwright::mesh::{Adjacency, boundary_loops};
use scanwright::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};

/// A manifest of 12 shapes per type, without noise unless `noises` has some.
fn small(triangulation: Triangulation, resolutions: Vec<u32>, noises: Vec<Noise>) -> Manifest {
    let mut manifest = Manifest::of_tier(Tier::Hard);
    manifest.shapes.retain(|s| Class::PRIMITIVES.contains(&s.class));
    for shapes in &mut manifest.shapes {
        shapes.count = 12;
    }
    Manifest { copies: 1, triangulations: vec![triangulation], resolutions, noises, ..manifest }
}

fn surface_of(model: &Model) -> Surface {
    let truth = |name: &str| model.truth.parameter(name).unwrap_or_else(|| panic!("no {name}"));
    let point = Point3::new(truth("x"), truth("y"), truth("z"));
    let direction = || UnitVec3::new_normalize(Vec3::new(truth("axis_x"), truth("axis_y"), truth("axis_z")));
    let axis = || Axis { origin: point, direction: direction() };
    match model.truth.class {
        Class::Plane => Surface::Plane(Plane { point, normal: direction() }),
        Class::Cylinder => Surface::Cylinder(Cylinder { axis: axis(), radius: truth("radius") }),
        Class::Cone => {
            Surface::Cone(Cone { axis: axis(), radius: truth("radius"), half_angle: truth("half_angle") })
        }
        Class::Sphere => Surface::Sphere(Sphere { center: point, radius: truth("radius") }),
        Class::Torus => Surface::Torus(Torus {
            axis: axis(),
            major_radius: truth("major_radius"),
            minor_radius: truth("minor_radius"),
        }),
        other => panic!("{other:?} has no analytic surface"),
    }
}

#[test]
fn clean_vertices_satisfy_their_equation_and_triangles_face_out_of_the_material() {
    for triangulation in Triangulation::ALL {
        let manifest = small(triangulation, vec![16], vec![Noise::None]);
        for k in 0..manifest.n_models() {
            let model = manifest.model(k);
            let name = &model.truth.name;
            let surface = surface_of(&model);
            let size = model.mesh.diagonal();
            for (vertex, normal) in model.mesh.vertices.iter().zip(&model.normals) {
                let (distance, natural) = surface.distance_and_normal(vertex);
                assert!(distance.abs() < 1e-9 * size, "{triangulation:?} {name}: {distance} off");
                let side = if model.truth.outward { 1.0 } else { -1.0 };
                assert!((natural.into_inner() * side - normal).norm() < 1e-6, "{triangulation:?} {name}");
            }
            let facing = |t: &usize| {
                let at = model.mesh.triangles[*t].map(|v| model.normals[v as usize]);
                model.mesh.cross(*t).dot(&(at[0] + at[1] + at[2])) > 0.0
            };
            let n = model.mesh.triangles.len();
            let n_facing = (0..n).filter(facing).count();
            assert_eq!(n_facing, n, "{triangulation:?} {name}: triangles that face in");
        }
    }
}

#[test]
fn areas_at_the_finest_level_are_within_half_a_percent() {
    for triangulation in [Triangulation::Grid, Triangulation::Isotropic, Triangulation::Irregular] {
        let manifest = small(triangulation, vec![128], vec![Noise::None]);
        for k in 0..manifest.n_models() {
            let model = manifest.model(k);
            let off = model.mesh.total_area() / model.truth.area - 1.0;
            assert!(off.abs() < 0.005, "{triangulation:?} {}: area {off} off", model.truth.name);
        }
    }
}

#[test]
fn complete_models_have_the_borders_of_their_type() {
    let manifest = Manifest { partial: 0.0, ..small(Triangulation::Isotropic, vec![16], vec![Noise::None]) };
    for k in 0..manifest.n_models() {
        let model = manifest.model(k);
        let n_loops = boundary_loops(&model.mesh, &Adjacency::new(&model.mesh)).len();
        let expected = match model.truth.class {
            Class::Sphere | Class::Torus => 0..=0,
            Class::Cylinder => 2..=2,
            // A whole cone has a tip, a plane perhaps a hole.
            _ => 1..=2,
        };
        assert!(expected.contains(&n_loops), "{}: {n_loops} borders", model.truth.name);
    }
}

#[test]
fn the_same_manifest_gives_the_same_bytes_and_another_seed_others() {
    let manifest = small(Triangulation::Scanner, vec![8, 16], Noise::all());
    let bytes = |m: &Manifest| -> Vec<u64> {
        (0..m.n_models())
            .flat_map(|k| m.model(k).mesh.vertices.into_iter().flat_map(|p| [p.x, p.y, p.z]))
            .map(f64::to_bits)
            .collect()
    };
    assert_eq!(bytes(&manifest), bytes(&manifest.clone()));
    assert_ne!(bytes(&manifest), bytes(&Manifest { seed: 7, ..manifest.clone() }));
}

#[test]
fn no_shape_is_in_two_splits() {
    let manifest = Manifest { copies: 4, ..small(Triangulation::Grid, vec![8], Noise::all()) };
    let mut split_of: BTreeMap<u32, Split> = BTreeMap::new();
    let mut shapes: BTreeMap<Vec<u64>, u32> = BTreeMap::new();
    for k in 0..manifest.n_models() {
        let truth = manifest.model(k).truth;
        assert_eq!(*split_of.entry(truth.group).or_insert(truth.split), truth.split, "{}", truth.name);
        // What does not change with the pose.
        let sizes = truth.class.sizes().iter().filter_map(|name| truth.parameter(name));
        let key: Vec<u64> = sizes.chain([truth.area]).map(f64::to_bits).collect();
        assert_eq!(*shapes.entry(key).or_insert(truth.group), truth.group, "{} is a copy", truth.name);
    }
    assert_eq!(split_of.len() * 4, manifest.n_models());
}

#[test]
fn noise_has_the_level_that_was_asked_for() {
    for (noise, level) in [
        (Noise::Normal { level: 0.25 }, 0.25),
        (Noise::Isotropic { level: 0.4 }, 0.4),
        (Noise::Correlated { level: 0.25, length: 3.0 }, 0.25),
    ] {
        let manifest = small(Triangulation::Isotropic, vec![64], vec![noise]);
        let model = manifest.model(40);
        let surface = surface_of(&model);
        let off: Vec<f64> = model.mesh.vertices.iter().map(|p| surface.signed_distance(p)).collect();
        let rms = (off.iter().map(|d| d * d).sum::<f64>() / off.len() as f64).sqrt() / model.truth.edge;
        // The deviation of a deviation, for the few independent values of correlated noise.
        let n_independent = off.len() as f64 / 30.0;
        assert!((rms / level - 1.0).abs() < 5.0 / (2.0 * n_independent).sqrt(), "{noise:?}: {rms}");
    }
}

#[test]
fn what_is_wrong_with_a_manifest_is_said_by_its_field() {
    let good = Manifest::of_tier(Tier::Faithful);
    assert_eq!(good.problem(), None);
    let mut bad = good.clone();
    bad.ranges.radius = [5.0, 1.0];
    assert!(bad.problem().is_some_and(|p| p.starts_with("ranges.radius")));
    bad = Manifest { copies: 0, ..good.clone() };
    assert!(bad.problem().is_some_and(|p| p.starts_with("copies")));
    bad = Manifest { noises: Vec::new(), ..good.clone() };
    assert!(bad.problem().is_some_and(|p| p.contains("noises")));
    bad = Manifest { noises: vec![Noise::Correlated { level: 0.1, length: 1e6 }], ..good.clone() };
    assert!(bad.problem().is_some_and(|p| p.contains("length")));
    bad = Manifest { noises: vec![Noise::Normal { level: f64::NAN }], ..good.clone() };
    assert!(bad.problem().is_some_and(|p| p.contains("level")));
    bad = good.clone();
    bad.shapes.push(bad.shapes[0]);
    assert!(bad.problem().is_some_and(|p| p.contains("twice")));
    bad = Manifest { copies: u32::MAX, ..good };
    assert!(bad.problem().is_some_and(|p| p.starts_with("copies")));
}
