//! Recognition on the Gaussian sphere, on generated primitives.

use scanwright::gprimdb::{Class, Manifest, Tier, Triangulation};
use scanwright::math::Vec3;
use scanwright::random::Rng;
use scanwright::recognize::gauss::{
    Accumulator, Cells, Classifier, Example, GaussImage, N_CELLS, Rules, Voting, cross_validated,
};
use scanwright::surface::SurfaceKind;

/// 100 complete models of `class`, each of about two thousand triangles.
fn complete(class: Class, triangulation: Triangulation) -> Vec<GaussImage> {
    let mut manifest = Manifest::of_tier(Tier::Faithful);
    manifest.shapes.retain(|s| s.class == class);
    let manifest =
        Manifest { partial: 0.0, resolutions: vec![32], triangulations: vec![triangulation], ..manifest };
    (0..100).map(|k| GaussImage::of_mesh(&manifest.model(k).mesh)).collect()
}

fn skewness(image: &GaussImage, voting: Voting) -> f64 {
    Accumulator::new(image, &Cells::new(N_CELLS), voting).skewness()
}

#[test]
fn skewness_of_areas_tells_all_spheres_from_all_tori() {
    for triangulation in [Triangulation::Grid, Triangulation::Isotropic] {
        for (class, is_gathered) in [(Class::Sphere, false), (Class::Torus, true)] {
            for (k, image) in complete(class, triangulation).iter().enumerate() {
                assert!(image.normals.len() >= 1000, "{} triangles", image.normals.len());
                let skewness = skewness(image, Voting::Area);
                assert_eq!(skewness > 1.5, is_gathered, "{triangulation:?} {class:?} {k}: {skewness}");
            }
        }
    }
}

#[test]
fn skewness_of_counts_takes_spheres_with_dense_poles_for_tori() {
    let spheres = complete(Class::Sphere, Triangulation::Grid);
    let n_wrong = spheres.iter().filter(|s| skewness(s, Voting::Count) > 1.5).count();
    assert!(n_wrong > 90, "only {n_wrong} of 100 are distorted");
}

#[test]
fn a_torus_with_its_axis_in_a_cap_has_the_density_of_theory_there() {
    // Density relative to uniform is 2 / (pi cos latitude): over a cap of colatitude t the mean is 2 t / (pi (1 - cos t)) / 2.
    let n = 400;
    let mut image = GaussImage::default();
    for i in 0..n {
        for j in 0..n {
            let at = |k: usize| std::f64::consts::TAU * (k as f64 + 0.5) / n as f64;
            let (u, v) = (at(i), at(j));
            image.normals.push(Vec3::new(u.cos() * v.cos(), u.sin() * v.cos(), v.sin()));
            // A ring torus of ratio 3.
            image.areas.push(3.0 + v.cos());
        }
    }
    let accumulator = Accumulator::new(&image, &Cells::new(N_CELLS), Voting::Area);
    let cap = 2.0 * (1.0 / 202.0_f64.sqrt()).asin();
    let expected = 202.0 * cap / std::f64::consts::PI;
    // Rows of normals end in the cap or outside: one row in how many there are.
    let bound = expected * (std::f64::consts::TAU / n as f64) / cap;
    assert!((accumulator.votes[0] - expected).abs() < bound, "{} of {expected}", accumulator.votes[0]);
}

#[test]
fn the_descriptor_of_a_turned_region_is_nearly_the_same() {
    let image = &complete(Class::Torus, Triangulation::Isotropic)[0];
    let mut rng = Rng::for_task(1, "turns", 0);
    let cells = Cells::new(N_CELLS);
    let first = Accumulator::new(image, &cells, Voting::Area).descriptor();
    for _ in 0..5 {
        let turn = nalgebra::Rotation3::new(Vec3::new(rng.normal(), rng.normal(), rng.normal()));
        let turned = GaussImage {
            normals: image.normals.iter().map(|n| turn * n).collect(),
            areas: image.areas.clone(),
        };
        let other = Accumulator::new(&turned, &cells, Voting::Area).descriptor();
        // Most cells are alike; those at the poles depend on where their borders fall.
        let apart: f64 = first.histogram.iter().zip(&other.histogram).map(|(a, b)| (a - b).abs()).sum();
        assert!(apart / 202.0 < 0.15, "{apart}");
    }
}

#[test]
fn chance_alone_is_no_dispersion() {
    let mut rng = Rng::for_task(2, "normals", 0);
    let mut image = GaussImage::default();
    for _ in 0..2000 {
        image.normals.push(Vec3::new(rng.normal(), rng.normal(), rng.normal()).normalize());
        image.areas.push(1.0);
    }
    let dispersion =
        |image: &GaussImage| Accumulator::new(image, &Cells::new(N_CELLS), Voting::Area).dispersion();
    // Ten votes per cell scatter by a third; a third of that is left, as a third itself is known to 5 %.
    assert!(dispersion(&image) < 0.11, "{}", dispersion(&image));
    // By theory 0.86 for every complete torus.
    let torus = dispersion(&complete(Class::Torus, Triangulation::Isotropic)[5]);
    assert!((torus - 0.86).abs() < 0.2, "{torus}");
}

#[test]
fn rules_name_every_complete_primitive() {
    let rules = Rules::default();
    for (class, kind) in [
        (Class::Plane, SurfaceKind::Plane),
        (Class::Cylinder, SurfaceKind::Cylinder),
        (Class::Cone, SurfaceKind::Cone),
        (Class::Sphere, SurfaceKind::Sphere),
        (Class::Torus, SurfaceKind::Torus),
    ] {
        for (k, image) in complete(class, Triangulation::Grid).iter().enumerate() {
            let verdict = rules.recognize(image).expect("it has an area");
            assert_eq!(verdict.kind, kind, "{class:?} {k}: {verdict:?}");
            assert!(verdict.certain, "{class:?} {k}: {verdict:?}");
        }
    }
}

#[test]
fn rules_are_right_about_partial_primitives_whenever_they_are_certain() {
    let manifest = Manifest { partial: 1.0, ..Manifest::of_tier(Tier::Faithful) };
    let rules = Rules::default();
    let (mut n_certain, mut wrong) = (0, Vec::new());
    for k in 0..manifest.n_models() {
        let model = manifest.model(k);
        let verdict = rules.recognize(&GaussImage::of_mesh(&model.mesh)).expect("it has an area");
        n_certain += usize::from(verdict.certain);
        if verdict.certain && model.truth.class.kind() != Some(verdict.kind) {
            wrong.push(model.truth.name);
        }
    }
    assert!(wrong.len() <= manifest.n_models() / 100, "{} wrong: {wrong:?}", wrong.len());
    // Planes, cylinders and cones: three of five, less those of short arcs.
    assert!(n_certain >= manifest.n_models() / 2, "certain of {n_certain} only");
}

/// Descriptors of 40 complete models per type.
fn examples() -> Vec<Example> {
    let mut manifest = Manifest { partial: 0.0, resolutions: vec![16], ..Manifest::of_tier(Tier::Faithful) };
    for shapes in &mut manifest.shapes {
        shapes.count = 40;
    }
    let cells = Cells::new(N_CELLS);
    (0..manifest.n_models())
        .map(|k| {
            let model = manifest.model(k);
            let votes = Accumulator::new(&GaussImage::of_mesh(&model.mesh), &cells, Voting::Area);
            let kind = model.truth.class.kind().expect("it is one of the five");
            Example { values: votes.descriptor().values(), kind, group: model.truth.group }
        })
        .collect()
}

#[test]
fn the_classifier_names_shapes_that_are_new_to_it() {
    let folds = cross_validated(&examples(), 4).expect("there are enough");
    let n_right: usize =
        folds.iter().flat_map(|f| &f.answers).filter(|(truth, answer)| truth == answer).count();
    // Coarse complete models: one in ten may be a cone so slender or so flat that it looks like another type.
    assert!(n_right >= 180, "{n_right} of 200");
    assert_eq!(folds.iter().map(|f| f.answers.len()).sum::<usize>(), 200, "every example is tested once");
}

#[test]
fn a_classifier_read_back_gives_the_same_probabilities() {
    let train = |examples: &[Example]| Classifier::train(examples, N_CELLS, "forty of each");
    let classifier = train(&examples()).expect("there are enough");
    let text = classifier.to_text();
    assert_eq!(text, train(&examples()).expect("there are enough").to_text(), "trained twice");
    assert!(train(&examples()[..40]).is_err(), "one type alone");
    assert!(train(&[]).is_err(), "nothing");
    let read = Classifier::from_text(&text).expect("it is what was written");
    assert_eq!(read.provenance, "forty of each");
    for class in [Class::Cone, Class::Torus] {
        let image = &complete(class, Triangulation::Grid)[3];
        let (written, read) = (classifier.classify(image), read.classify(image));
        assert_eq!(written, read);
        let sum: f64 = written.iter().map(|w| w.1).sum();
        assert!((sum - 1.0).abs() < 1e-6 && written.windows(2).all(|w| w[0].1 >= w[1].1), "{written:?}");
    }
    assert!(Classifier::from_text(&text.replacen("scanwright", "another", 1)).is_err());
    assert!(Classifier::from_text(&text[..text.len() / 2]).is_err());
    let other_cells = text.replacen("\n202\n", "\n52\n", 1);
    assert!(Classifier::from_text(&other_cells).is_err(), "features of another number of cells");
}

#[test]
fn a_box_is_no_plane_and_noise_makes_no_cylinder_of_a_sphere_for_certain() {
    let mut opposite = GaussImage::default();
    for normal in [Vec3::x(), Vec3::y(), Vec3::z()] {
        opposite.normals.extend([normal, -normal]);
        opposite.areas.extend([1.0, 1.0]);
    }
    let verdict = Rules::default().recognize(&opposite).expect("it has an area");
    assert_ne!(verdict.kind, SurfaceKind::Plane, "{verdict:?}");
    for (class, kind) in [(Class::Sphere, SurfaceKind::Sphere), (Class::Torus, SurfaceKind::Torus)] {
        for normal_noise in [0.1, 0.2, 0.3, 0.5] {
            let rules = Rules { normal_noise, ..Rules::default() };
            for image in complete(class, Triangulation::Isotropic).iter().take(20) {
                let verdict = rules.recognize(image).expect("it has an area");
                assert!(verdict.kind == kind || !verdict.certain, "{normal_noise}: {verdict:?}");
            }
        }
    }
}

#[test]
fn an_image_without_area_has_no_type() {
    assert_eq!(Rules::default().recognize(&GaussImage::default()), None);
}
