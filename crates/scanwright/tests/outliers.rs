//! Outliers among normals, planted in generated primitives.

use scanwright::gprimdb::{Class, Manifest, Model, Noise, Tier, Triangulation};
use scanwright::math::Vec3;
use scanwright::mesh::{Adjacency, Csr, Mesh, TriId};
use scanwright::par;
use scanwright::random::Rng;
use scanwright::recognize::gauss::{GaussImage, OutlierSearch, Outliers, Threshold, rings};

const BOTH: [Threshold; 2] = [Threshold::MeanAndDeviation, Threshold::MedianAndMad];

/// Complete models of `class`, each of about two thousand triangles.
fn models(class: Class, level: f64, n: usize) -> Vec<Model> {
    let mut manifest = Manifest::of_tier(Tier::Faithful);
    manifest.shapes.retain(|s| s.class == class);
    let noise = if level > 0.0 { Noise::Normal { level } } else { Noise::None };
    let manifest = Manifest {
        partial: 0.0,
        resolutions: vec![32],
        triangulations: vec![Triangulation::Isotropic],
        noises: vec![noise],
        ..manifest
    };
    (0..n).map(|k| manifest.model(k)).collect()
}

fn all(mesh: &Mesh) -> Vec<TriId> {
    (0..mesh.triangles.len() as TriId).collect()
}

fn image_and_rings(model: &Model) -> (GaussImage, Csr) {
    (GaussImage::of_mesh(&model.mesh), rings(&model.mesh, &Adjacency::new(&model.mesh), &all(&model.mesh)))
}

/// Turns a share of the normals anywhere; says which.
fn plant(image: &mut GaussImage, share: f64, seed: u64) -> Vec<bool> {
    let mut rng = Rng::for_task(seed, "outliers", 0);
    let mut turn = |normal: &mut Vec3| {
        let is_planted = rng.uniform() < share;
        if is_planted {
            *normal = Vec3::new(rng.normal(), rng.normal(), rng.normal()).normalize();
        }
        is_planted
    };
    image.normals.iter_mut().map(&mut turn).collect()
}

fn search(threshold: Threshold) -> OutlierSearch {
    OutlierSearch { threshold, ..OutlierSearch::default() }
}

/// Shares of the planted that were found, and of the others that were not kept.
fn shares(planted: &[bool], found: &Outliers) -> (f64, f64) {
    let share = |of: bool| {
        let all = planted.iter().zip(&found.is_outlier).filter(|(p, _)| **p == of);
        let (n, n_found) = all.fold((0, 0), |(n, k): (u32, u32), (_, f)| (n + 1, k + u32::from(*f)));
        f64::from(n_found) / f64::from(n.max(1))
    };
    (share(true), share(false))
}

#[test]
fn planted_outliers_are_found_and_the_others_kept() {
    // Normals of clean models leave most directions free. With noise of 8 degrees three deviations are a band of 50
    // degrees: about four in ten directions are in that of a circle, and are outliers of nothing.
    for (level, least_found) in [(0.0, 0.9), (0.1, 0.55)] {
        for class in [Class::Plane, Class::Cylinder, Class::Cone] {
            let each: Vec<(f64, f64)> = (0..5)
                .zip(models(class, level, 5))
                .map(|(k, model)| {
                    let (mut image, rings) = image_and_rings(&model);
                    let planted = plant(&mut image, 0.05, k);
                    let outliers = search(Threshold::MedianAndMad).run(&image, &rings);
                    assert!(outliers.is_one_primitive, "{class:?} {level} {k}: {}", outliers.share);
                    shares(&planted, &outliers)
                })
                .collect();
            let mean = |of: fn(&(f64, f64)) -> f64| each.iter().map(of).sum::<f64>() / 5.0;
            let (found, lost) = (mean(|e| e.0), mean(|e| e.1));
            assert!(found > least_found, "{class:?} {level}: {found} found");
            assert!(lost < 0.01, "{class:?} {level}: {lost} lost");
        }
    }
}

#[test]
fn clean_planes_lose_nothing_at_the_least_threshold() {
    for threshold in BOTH {
        for model in models(Class::Plane, 0.0, 5) {
            let (image, rings) = image_and_rings(&model);
            let outliers = search(threshold).run(&image, &rings);
            assert!(outliers.is_outlier.iter().all(|is| !is), "{threshold:?}: {}", outliers.share);
            assert_eq!(outliers.threshold, 1e-6, "{threshold:?}");
        }
    }
}

#[test]
fn uneven_densities_and_rims_are_no_outliers() {
    for class in [Class::Sphere, Class::Torus, Class::Cylinder, Class::Cone] {
        for level in [0.0, 0.1] {
            for (k, model) in models(class, level, 5).iter().enumerate() {
                let (image, rings) = image_and_rings(model);
                let outliers = search(Threshold::MedianAndMad).run(&image, &rings);
                assert!(outliers.is_one_primitive, "{class:?} {level} {k}");
                // Of a Rayleigh distribution 0.6 % lies beyond median and three MADs; a few models vary by as much.
                assert!(outliers.share < 0.02, "{class:?} {level} {k}: {}", outliers.share);
            }
        }
    }
}

#[test]
fn what_is_not_one_primitive_is_said_and_left_alone() {
    for threshold in BOTH {
        let (mut image, rings) = image_and_rings(&models(Class::Plane, 0.1, 1)[0]);
        plant(&mut image, 0.4, 1);
        let strict = OutlierSearch { max_share: 0.05, ..search(threshold) };
        for search in [search(threshold), strict] {
            let outliers = search.run(&image, &rings);
            let share = outliers.is_outlier.iter().filter(|is| **is).count() as f64
                / outliers.is_outlier.len() as f64;
            assert!(share <= 1.3 * search.max_share, "{threshold:?}: {share}");
            assert_eq!(outliers.is_one_primitive, outliers.share <= search.max_share);
            assert!(outliers.is_one_primitive || share == 0.0, "{threshold:?}");
        }
    }
    let (mut image, rings) = image_and_rings(&models(Class::Plane, 0.0, 1)[0]);
    plant(&mut image, 0.3, 1);
    assert!(!search(Threshold::MedianAndMad).run(&image, &rings).is_one_primitive);
}

#[test]
fn what_is_kept_is_not_changed_whatever_the_number_of_threads() {
    let model = &models(Class::Cone, 0.25, 1)[0];
    let adjacency = Adjacency::new(&model.mesh);
    for threshold in BOTH {
        let with = |n| {
            par::with_threads(Some(n), || {
                GaussImage::without_outliers(&model.mesh, &adjacency, &search(threshold))
            })
        };
        let (image, outliers) = with(1);
        assert_eq!((&image, &outliers), (&with(2).0, &with(2).1));
        let all = GaussImage::of_mesh(&model.mesh);
        let kept = all.normals.iter().zip(&outliers.is_outlier).filter(|(_, is)| !**is).map(|(n, _)| *n);
        assert_eq!(image.normals, kept.collect::<Vec<Vec3>>());
    }
}

#[test]
fn an_empty_image_has_no_outliers() {
    for threshold in BOTH {
        let outliers = search(threshold).run(&GaussImage::default(), &Csr::from_pairs(0, std::iter::empty()));
        assert!(outliers.is_outlier.is_empty() && outliers.is_one_primitive);
    }
}
