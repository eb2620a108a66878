//! Where scans lie on models: known motions found again, with what is missing and what is symmetric.

use scanwright::align::{self, AlignError, Freedom, Measure, Target, align, border_width, model_of, refine};
use scanwright::math::{Frame, Point3, Pose, UnitVec3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::pipeline::{self, Options};
use scanwright::prior::PriorModel;
use scanwright::progress::Progress;
use scanwright::random::Rng;
use scanwright::surface::Surface;

use crate::plates::{Plate, bare_part, part_of, random_pose, scan_of};
use crate::scans;

const SPACING: f64 = 1.0;
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

/// How far a motion found is from the truth, in the target: a turn about the pivot and a way.
fn error_of(found: &align::Alignment, truth: &Pose) -> [f64; 6] {
    let apart = found.pose.after(truth);
    let turn = apart.rotation.scaled_axis();
    let way = apart.point(&found.pivot) - found.pivot;
    [turn.x, turn.y, turn.z, way.x, way.y, way.z]
}

/// Squares of an error in units of its covariance, one per direction that is determined.
fn whitened(found: &align::Alignment, error: &[f64; 6]) -> Vec<f64> {
    let unit = |i: usize| if i < 3 { 1.0 / found.radius } else { 1.0 };
    let covariance = nalgebra::Matrix6::from_fn(|i, j| found.covariance[i][j] / unit(i) / unit(j));
    let error = nalgebra::Vector6::from_fn(|i, _| error[i] / unit(i));
    let eigen = covariance.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let pairs = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    pairs.filter(|(v, _)| **v > 1e-9 * largest).map(|(v, d)| d.dot(&error).powi(2) / v).collect()
}

#[test]
fn a_scan_anywhere_with_a_fifth_missing_is_laid_on_its_model() {
    let model = Plate::default().model();
    // How near a place is known follows from how many vertices there are.
    let mesh = Plate::default().mesh(0.75 * SPACING);
    for seed in 0..3 {
        let truth = random_pose(seed);
        let scan = scan_of(&with_a_fifth_missing(&mesh, seed), NOISE, &truth, seed);
        let part = part_of(&scan);
        let target = Target::new(&model, Measure::Surfaces, border_width(&part.tolerances)).unwrap();
        let found = align(&target, &part, &align::Options::default()).unwrap();
        assert_eq!(found.freedom, Freedom::None);
        assert!(found.alternatives.is_empty(), "{:?}", found.alternatives);
        let error = displacement(&model, &found.pose, &truth);
        assert!(error < 0.1 * NOISE, "seed {seed}: off by {error}");
    }
}

#[test]
fn the_uncertainty_of_a_place_is_that_of_its_errors() {
    let model = Plate::default().model();
    let mesh = Plate::default().mesh(SPACING);
    let (mut squares, mut worst) = (Vec::new(), 0.0_f64);
    for seed in 0..16 {
        let truth = random_pose(seed);
        let part = bare_part(&scan_of(&with_a_fifth_missing(&mesh, seed), NOISE, &truth, seed));
        let target = Target::new(&model, Measure::Surfaces, border_width(&part.tolerances)).unwrap();
        // A tenth of a degree and a spacing off.
        let step = nalgebra::SVector::<f64, 6>::from([2e-3, -1e-3, 2e-3, 0.5, -0.5, 0.5]);
        let start = Pose::of_step(&step, &Point3::origin()).after(&truth.inverse());
        let found = refine(&target, &part, &start).unwrap();
        squares.extend(whitened(&found, &error_of(&found, &truth)));
        worst = worst.max(displacement(&model, &found.pose, &truth));
    }
    assert_eq!(squares.len(), 96);
    let spread = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    // 96 draws know their deviation to 7 %; counting correlation can only make uncertainties larger.
    assert!((0.7..1.25).contains(&spread), "errors are {spread} of their uncertainties");
    assert!(worst < 0.15 * NOISE, "off by {worst} at the worst");
}

#[test]
fn placements_that_explain_a_box_as_well_are_told() {
    let size = [24.0, 18.0, 12.0];
    let scan = scans::block(size, SPACING);
    let segmented = pipeline::segment(&scan, &Options::default(), &Progress::none()).unwrap();
    // Its own noise would tell one corner from the others: the model is the box that was meant.
    let mut model = model_of(&segmented);
    for face in &mut model.faces {
        if let Some(Surface::Plane(plane)) = &mut face.surface {
            let axis = plane.normal.iamax();
            let side = plane.normal[axis].signum();
            let mut normal = Vec3::zeros();
            normal[axis] = side;
            plane.normal = UnitVec3::new_unchecked(normal);
            plane.point = Point3::from(normal * (if side > 0.0 { size[axis] } else { 0.0 }));
        }
    }
    let part = part_of(&scan.moved(&random_pose(21)));
    let target = Target::new(&model, Measure::Surfaces, border_width(&part.tolerances)).unwrap();
    let found = align(&target, &part, &align::Options::default()).unwrap();
    assert_eq!(found.freedom, Freedom::None);
    let turns: Vec<f64> =
        found.alternatives.iter().map(|a| a.turn_from(&found.pose).unwrap().0.to_degrees()).collect();
    assert_eq!(turns.len(), 3, "half a turn about each axis: {turns:?}");
    assert!(turns.iter().all(|t| (t - 180.0).abs() < 1.0), "{turns:?}");
}

#[test]
fn a_turned_part_says_that_its_turn_is_free() {
    let scan = scans::bushing(SPACING);
    let segmented = pipeline::segment(&scan, &Options::default(), &Progress::none()).unwrap();
    let model = model_of(&segmented);
    let truth = random_pose(22);
    let part = part_of(&scan.moved(&truth));
    let target = Target::new(&model, Measure::Surfaces, border_width(&part.tolerances)).unwrap();
    let found = align(&target, &part, &align::Options::default()).unwrap();
    let Freedom::Turn(axis) = found.freedom else { panic!("{:?}", found.freedom) };
    assert!(axis.direction.z.abs() > 0.999_9 && axis.radial(&Point3::origin()).norm() < 0.1, "{axis:?}");
    assert!(found.alternatives.is_empty(), "turned over it is another part: {:?}", found.alternatives);
    // What is determined is right: the axis comes to lie on itself, and its ends on their heights.
    let back = found.pose.after(&truth);
    for height in [0.0, 28.0] {
        let end = back.point(&Point3::new(0.0, 0.0, height));
        assert!((end - Point3::new(0.0, 0.0, height)).norm() < 0.4 * NOISE, "{end}");
    }
}

#[test]
fn a_table_under_the_part_does_not_pull_it() {
    let plate = Plate::default();
    let model = plate.model();
    let (lo, hi) = ([-45.0, -35.0, -1.5], [45.0, 35.0, 18.0]);
    let on_table = |p: &Point3| plate.distance(p).min(p.z - 0.001);
    let mesh = crate::scanned::scan(on_table, lo, hi, 1.2);
    let truth = random_pose(23);
    let part = part_of(&scan_of(&mesh, NOISE, &truth, 4));
    assert!(part.mesh.vertices.len() * 10 < mesh.vertices.len() * 9, "a table was taken away");
    let target = Target::new(&model, Measure::Surfaces, border_width(&part.tolerances)).unwrap();
    let found = align(&target, &part, &align::Options::default()).unwrap();
    let error = displacement(&model, &found.pose, &truth);
    assert!(error < 0.2 * NOISE, "off by {error}");
}

#[test]
fn a_scan_of_something_else_is_refused() {
    let model = Plate::default().model();
    let mut rng = Rng::for_task(9, "something else", 0);
    // Shreds all over the place: no placement explains them.
    let frames = (0..400).map(|_| {
        let mut at = || 60.0 * (rng.uniform() - 0.5);
        let origin = Point3::new(at(), at(), at());
        Frame::from_z(origin, UnitVec3::new_normalize(Vec3::new(at(), at(), at())))
    });
    let mut mesh = Mesh::default();
    for frame in frames {
        let first = mesh.vertices.len() as u32;
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        mesh.vertices.extend(corners.map(|c| frame.global(&c)));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    let part = bare_part(&mesh);
    let target = Target::new(&model, Measure::Surfaces, border_width(&part.tolerances)).unwrap();
    let refused = align(&target, &part, &align::Options::default());
    assert!(matches!(refused, Err(AlignError::NoPlacement(_))), "{refused:?}");
    let few = bare_part(&mesh.submesh(|t| t < 5).0);
    assert_eq!(align(&target, &few, &align::Options::default()), Err(AlignError::TooFewPoints(15)));
}
