//! A scan that is turned, moved or scaled has the turned, moved or scaled result.

use scanwright::math::{Point3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::pipeline::{self, Options, Reconstruction};
use scanwright::progress::Progress;
use scanwright::surface::{Surface, SurfaceKind};

use crate::scans::{block, bushing, turned};

/// How far a result may differ from the transformed original, in standard deviations of one point's noise. Parameters
/// are means over hundreds of points; the noise seen along other axes, and ties broken the other way, move them by
/// less than one point's noise.
const SIGMAS: f64 = 3.0;

#[test]
fn a_block_turned_moved_or_scaled_stays_itself() {
    check_all("block", &block([24.0, 18.0, 12.0], 1.2));
}

#[test]
fn a_bushing_turned_moved_or_scaled_stays_itself() {
    check_all("bushing", &bushing(1.2));
}

#[test]
fn a_knob_turned_moved_or_scaled_stays_itself() {
    // A cylinder with a bore and a spherical end.
    let quarter = (0..=12).map(|i| (f64::from(i) / 12.0 * std::f64::consts::FRAC_PI_2).sin_cos());
    let mut outline = vec![(3.0, 0.0), (10.0, 0.0), (10.0, 14.0)];
    outline.extend(
        quarter.map(|(sin, cos)| (10.0 * cos, 14.0 + 10.0 * sin)).skip(1).take_while(|(r, _)| *r > 3.0),
    );
    outline.push((3.0, 14.0 + 91.0_f64.sqrt()));
    check_all("knob", &turned(&outline, 1.1));
}

fn check_all(name: &str, scan: &Mesh) {
    let original = run(scan);
    for scale in [1e-3, 1e3] {
        let result = run(&Similarity { scale, ..Similarity::identity() }.of_mesh(scan));
        check(name, &format!("scaled by {scale}"), &original, &result, scale, |p| {
            Point3::from(p.coords * scale)
        });
    }
    let rotation = nalgebra::Rotation3::from_euler_angles(0.7, -1.1, 2.3);
    let result = run(&Similarity { rotation, ..Similarity::identity() }.of_mesh(scan));
    check(name, "turned", &original, &result, 1.0, |p| rotation * p);
    let translation = Vec3::new(0.6, -0.5, 0.62) * (1e4 * scan.diagonal());
    let result = run(&Similarity { translation, ..Similarity::identity() }.of_mesh(scan));
    check(name, "moved", &original, &result, 1.0, |p| p + translation);
}

/// Checks that every primitive of `original` has a counterpart in `result` and the other way round.
fn check(
    name: &str,
    how: &str,
    original: &Reconstruction,
    result: &Reconstruction,
    scale: f64,
    map: impl Fn(Point3) -> Point3,
) {
    assert_eq!(kinds(result), kinds(original), "{name} {how}");
    let noise = scale * original.measured.noise;
    assert!(
        (result.measured.noise / noise - 1.0).abs() < 0.05,
        "{name} {how}: noise {}",
        result.measured.noise
    );
    for (i, primitive) in original.segmentation.primitives.iter().enumerate() {
        let Some(surface) = primitive.surface else { continue };
        let candidates = result.segmentation.primitives.iter().filter_map(|p| p.surface);
        let candidates = candidates.filter(|s| s.kind() == surface.kind());
        // Where the region lies: the distance of its points, carried over, to the counterpart.
        let triangles = original.segmentation.labels.iter().enumerate();
        let points: Vec<Point3> = triangles
            .filter(|(_, label)| label.is_some_and(|r| r.0 as usize == i))
            .map(|(t, _)| map(surface.project(&original.mesh.triangle_center(t))))
            .collect();
        let worst = |s: &Surface| points.iter().map(|p| s.signed_distance(p).abs()).fold(0.0, f64::max);
        let nearest = candidates.map(|s| worst(&s)).fold(f64::INFINITY, f64::min);
        assert!(
            nearest < SIGMAS * noise,
            "{name} {how}: {surface:?} has no counterpart within {}, the nearest is {nearest} off",
            SIGMAS * noise
        );
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

/// Rotation, then scaling, then translation.
struct Similarity {
    rotation: nalgebra::Rotation3<f64>,
    scale: f64,
    translation: Vec3,
}

impl Similarity {
    fn identity() -> Self {
        Self { rotation: nalgebra::Rotation3::identity(), scale: 1.0, translation: Vec3::zeros() }
    }

    fn of_mesh(&self, mesh: &Mesh) -> Mesh {
        let map = |p: &Point3| self.rotation * Point3::from(p.coords * self.scale) + self.translation;
        Mesh { vertices: mesh.vertices.iter().map(map).collect(), triangles: mesh.triangles.clone() }
    }
}
