//! Where scans lie on models: known motions found again, with what is missing and what is symmetric.

use scanwright::align::{self, Freedom, Measure, Target, align, border_width};
use scanwright::math::{Point3, Pose};
use scanwright::mesh::Mesh;
use scanwright::prior::PriorModel;

use crate::plates::{Plate, part_of, random_pose, scan_of};

const SPACING: f64 = 0.8;
const NOISE: f64 = 0.05;

/// Root mean square over the model of where a motion puts its points and where they are.
fn displacement(model: &PriorModel, found: &Pose, truth: &Pose) -> f64 {
    let apart = found.after(truth);
    let sum: f64 = model.mesh.vertices.iter().map(|p| (apart.point(p) - p).norm_squared()).sum();
    (sum / model.mesh.vertices.len() as f64).sqrt()
}

/// The scan without all that lies beyond a plane through it: a fifth of it.
fn with_a_fifth_missing(mesh: &Mesh, seed: u64) -> Mesh {
    let direction = random_pose(seed).rotation * nalgebra::Vector3::x();
    let mut heights: Vec<f64> = mesh.vertices.iter().map(|p| p.coords.dot(&direction)).collect();
    heights.sort_by(f64::total_cmp);
    let limit = heights[heights.len() * 4 / 5];
    mesh.submesh(|t| mesh.triangle_center(t).coords.dot(&direction) < limit).0
}

#[test]
fn a_scan_anywhere_with_a_fifth_missing_is_laid_on_its_model() {
    let model = Plate::default().model();
    let mesh = Plate::default().mesh(SPACING);
    let mut worst: f64 = 0.0;
    for seed in 0..6 {
        let truth = random_pose(seed);
        let scan = scan_of(&with_a_fifth_missing(&mesh, seed), NOISE, &truth, seed);
        let part = part_of(&scan);
        let target = Target::new(&model, Measure::Surfaces, border_width(&part.tolerances)).unwrap();
        let found = align(&target, &part, &align::Options::default()).unwrap();
        let error = displacement(&model, &found.pose, &truth);
        println!(
            "seed {seed}: {error:.5} explained {:.3} vps {:.2} n {} sigma {:.4} by {:?} alternatives {} bend {:.4} +- {:.4} edge {:.3}",
            found.explained,
            found.vertices_per_sample,
            found.n_points,
            found.sigma,
            found.found_by,
            found.alternatives.len(),
            found.bend,
            found.bend_uncertainty,
            part.tolerances.edge_rounding()
        );
        worst = worst.max(error);
        assert_eq!(found.freedom, Freedom::None);
        assert!(found.alternatives.is_empty(), "{:?}", found.alternatives);
        // In the unit of its own uncertainty the error of the middle is a draw from a normal distribution.
        let middle = found.pivot - found.pose.after(&truth).inverse().point(&found.pivot);
        for axis in [nalgebra::Vector3::x(), nalgebra::Vector3::y(), nalgebra::Vector3::z()] {
            let u = found.uncertainty_at(&found.pivot, &axis);
            assert!(middle.dot(&axis).abs() < 4.5 * u, "seed {seed}: {} with u {u}", middle.dot(&axis));
        }
    }
    assert!(worst < 0.1 * NOISE, "off by {worst}");
    let _ = Point3::origin();
}
