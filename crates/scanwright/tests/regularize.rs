//! Relations between primitives on planted faces: what is found, what is left alone, what it is worth.

use nalgebra::Rotation3;
use scanwright::fit::{Fit, Noise, Samples, Weights, parameter_covariance, refine};
use scanwright::math::{Axis, Frame, Point3, UnitVec3, Vec3, angle_between};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::par;
use scanwright::random::Rng;
use scanwright::recognize::{Primitive, Residual};
use scanwright::regularize::{Manufacture, RegularizeOptions, Relations, regularize};
use scanwright::segment::{RegionId, Segmentation};
use scanwright::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};
use scanwright::tolerance::{Measured, Tolerances};
use scanwright::uncertainty::Interior;

const SPACING: f64 = 0.5;
const NOISE: f64 = 0.05;
/// Vertices per independent sample of the noise, as `fit` and `regularize` count them.
const VERTICES_PER_SAMPLE: f64 = 80.0;

/// A segmented scan made of faces that do not touch.
#[derive(Clone, Default)]
struct Scene {
    mesh: Mesh,
    segmentation: Segmentation,
}

impl Scene {
    /// Adds a grid of `n` by `m` vertices `at` its coordinates, fitted by `surface`; returns its region.
    fn add(&mut self, n: [usize; 2], at: impl Fn(usize, usize) -> Point3, surface: Surface) -> usize {
        let first = self.mesh.vertices.len() as u32;
        let region = self.segmentation.primitives.len();
        let points: Vec<Point3> =
            (0..n[0]).flat_map(|i| (0..n[1]).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect();
        for (i, j) in (1..n[0]).flat_map(|i| (1..n[1]).map(move |j| (i, j))) {
            let v = |di: usize, dj: usize| first + ((i - di) * n[1] + j - dj) as u32;
            self.mesh.triangles.extend([[v(1, 1), v(0, 1), v(0, 0)], [v(1, 1), v(0, 0), v(1, 0)]]);
            self.segmentation.labels.extend([Some(RegionId(region as u32)); 2]);
        }
        let distances: Vec<f64> = points.iter().map(|p| surface.signed_distance(p)).collect();
        let residual = Residual::from_distances(&distances);
        let normals = points.iter().map(|p| surface.normal(p).into_inner()).collect();
        let samples = Samples { points: points.clone(), normals };
        let n_effective = points.len() as f64 / VERTICES_PER_SAMPLE;
        let covariance = parameter_covariance(&surface, &samples, residual.rms, n_effective);
        self.mesh.vertices.extend(points);
        self.segmentation.primitives.push(Primitive {
            surface: Some(surface),
            outward: true,
            residual,
            covariance,
            ambiguous: None,
        });
        region
    }

    /// Adds a flat face about `center`, `size` wide along the first two directions of `frame_of(normal)`, whose fit is
    /// wrong by `sigmas` standard uncertainties in each of the two tilts.
    fn add_plane(&mut self, center: [f64; 3], normal: Vec3, size: [f64; 2], sigmas: [f64; 2]) -> usize {
        let center = Point3::from(center);
        let truth = Frame::from_z(center, UnitVec3::new_normalize(normal));
        let u = tilt_uncertainties(size);
        let turn = truth.x.into_inner() * (sigmas[0] * u[0]) + truth.y.into_inner() * (sigmas[1] * u[1]);
        let fitted = Rotation3::new(turn) * truth.z;
        let seen = Frame {
            origin: center,
            x: Rotation3::new(turn) * truth.x,
            y: Rotation3::new(turn) * truth.y,
            z: fitted,
        };
        let mut rng = Rng::for_task(7, "faces", self.mesh.vertices.len() as u64);
        let n = size.map(|s| (s / SPACING).round() as usize + 1);
        let noise: Vec<f64> = (0..n[0] * n[1]).map(|_| NOISE * rng.normal()).collect();
        let at = |i: usize, j: usize| {
            let (x, y) = (i as f64 * SPACING - 0.5 * size[0], j as f64 * SPACING - 0.5 * size[1]);
            seen.global(&Vec3::new(x, y, noise[i * n[1] + j]))
        };
        self.add(n, at, Surface::Plane(Plane { point: center, normal: fitted }))
    }

    fn regularized(&self) -> Segmentation {
        // White noise of which one in so many vertices counts.
        let noise = Noise { white: NOISE * VERTICES_PER_SAMPLE.sqrt(), correlated: 0.0, length: SPACING };
        let options = RegularizeOptions {
            relations: Relations::Auto,
            manufacture: Manufacture::default(),
            sizes: true,
        };
        let (segmentation, tolerances) = (&self.segmentation, &self.tolerances());
        let interior = Interior::new(&self.mesh, &Adjacency::new(&self.mesh), segmentation, tolerances);
        regularize(&self.mesh, &interior, segmentation, &noise, tolerances, &options).segmentation
    }

    fn tolerances(&self) -> Tolerances {
        let measured = Measured {
            largest_coordinate: self.mesh.largest_coordinate(),
            diagonal: self.mesh.diagonal(),
            spacing: SPACING,
            noise: NOISE,
            normal_noise: 0.1,
            edge_rounding: 0.0,
        };
        Tolerances::new(measured, None)
    }
}

/// Standard uncertainties of the tilts about the two edges of a face: `sigma / (rms lever * sqrt(n_effective))`.
fn tilt_uncertainties(size: [f64; 2]) -> [f64; 2] {
    let n = (size[0] / SPACING + 1.0) * (size[1] / SPACING + 1.0) / VERTICES_PER_SAMPLE;
    // A tilt about the first edge is levered by the second.
    [size[1], size[0]].map(|s| NOISE / ((s + SPACING) / 12.0_f64.sqrt() * n.sqrt()))
}

fn direction(primitive: &Primitive) -> Vec3 {
    match primitive.surface.as_ref().unwrap() {
        Surface::Plane(plane) => plane.normal.into_inner(),
        other => other.axis().unwrap().direction.into_inner(),
    }
}

/// Angle between two lines, radians.
fn angle(a: &Vec3, b: &Vec3) -> f64 {
    angle_between(a, b).min(angle_between(a, &-b))
}

const LARGE: [f64; 2] = [40.0, 30.0];
const STRIP: [f64; 2] = [20.0, 2.0];

/// Three large faces of a box, the first as well seen as all, and strips beside them.
fn box_with_strips() -> (Scene, Vec<(usize, Vec3)>) {
    let mut scene = Scene::default();
    // A draw in which every strip joins: of 20 draws 8 of the 12 do so on average, as so narrow a strip fits many directions.
    let mut rng = Rng::for_task(15, "strips", 0);
    let mut draw = move || [rng.normal(), rng.normal()];
    let axes = [Vec3::z(), Vec3::x(), Vec3::y()];
    for (k, axis) in axes.into_iter().enumerate() {
        scene.add_plane([100.0 * k as f64, 0.0, 0.0], axis, LARGE, draw());
        scene.add_plane([100.0 * k as f64, 0.0, 50.0], -axis, LARGE, draw());
    }
    let strips = (0..12)
        .map(|k| {
            let normal = axes[k % 3] * if k % 2 == 0 { 1.0 } else { -1.0 };
            (scene.add_plane([0.0, 100.0 + 10.0 * k as f64, 0.0], normal, STRIP, draw()), normal)
        })
        .collect();
    (scene, strips)
}

#[test]
fn strips_take_their_direction_from_large_faces() {
    let (scene, strips) = box_with_strips();
    let result = scene.regularized();
    let rms = |segmentation: &Segmentation| {
        let errors = strips.iter().map(|(k, truth)| angle(&direction(&segmentation.primitives[*k]), truth));
        (errors.map(|e| e * e).sum::<f64>() / strips.len() as f64).sqrt()
    };
    let (before, after) = (rms(&scene.segmentation), rms(&result));
    assert!(2.0 * after < before, "errors of strips fell from {before} to {after} radians only");
    // What is left is the error of two large faces: two tilts, three sigmas.
    let bound = 3.0 * tilt_uncertainties(LARGE).map(|u| u * u).iter().sum::<f64>().sqrt();
    assert!(after < bound, "strips are {after} off, large faces {bound}");
    for (k, truth) in strips {
        let own = direction(&result.primitives[k]);
        assert!(own.dot(&truth) > 0.0, "a normal stays outward: {own}");
    }
}

#[test]
fn directions_of_a_box_are_exactly_parallel_or_perpendicular() {
    let (scene, _) = box_with_strips();
    let result = scene.regularized();
    for (i, j) in (0..18).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let cosine = direction(&result.primitives[i]).dot(&direction(&result.primitives[j])).abs();
        assert!(cosine < 1e-14 || (cosine - 1.0).abs() < 1e-14, "faces {i} and {j}: cosine {cosine}");
    }
}

#[test]
fn covariances_shrink_and_stay_covariances() {
    let (scene, strips) = box_with_strips();
    let result = scene.regularized();
    for (k, _) in strips {
        let (before, after) =
            (&scene.segmentation.primitives[k].covariance, &result.primitives[k].covariance);
        assert_eq!(after.len(), before.len());
        let n = after.len();
        let matrix = nalgebra::DMatrix::from_fn(n, n, |i, j| after[i][j]);
        let least = matrix.symmetric_eigen().eigenvalues.min();
        assert!(least > 0.0, "strip {k}: eigenvalue {least}");
        let trace = |c: &[Vec<f64>]| c[1][1] + c[2][2];
        assert!(trace(after) < 0.1 * trace(before), "strip {k}: {} to {}", trace(before), trace(after));
    }
}

#[test]
fn a_draft_that_is_well_seen_stays() {
    let draft = 0.5_f64.to_radians();
    let (mut scene, _) = box_with_strips();
    let u = tilt_uncertainties(LARGE);
    assert!(u[0].max(u[1]) < 0.2 * draft, "the draft is well seen: {u:?}");
    let walls: Vec<usize> = [draft, -draft]
        .into_iter()
        .map(|turn| {
            scene.add_plane(
                [0.0, -100.0, 0.0],
                Rotation3::new(Vec3::y() * turn) * Vec3::x(),
                LARGE,
                [0.3, -0.4],
            )
        })
        .collect();
    let result = scene.regularized();
    for &wall in &walls {
        let turned = angle(&direction(&result.primitives[wall]), &Vec3::x());
        let bound = 3.0 * (u[0] * u[0] + u[1] * u[1]).sqrt();
        assert!((turned - draft).abs() < bound, "a draft of {draft} became {turned}");
        // It is drawn about y, and so stays perpendicular to y.
        assert!(direction(&result.primitives[wall]).dot(&direction(&result.primitives[4])).abs() < 1e-9);
    }
}

/// The angle between a large face and another after one of them was fitted `sigmas` off, and that before.
fn angle_of_pair(other: [f64; 2], sigmas: f64) -> (f64, f64) {
    let mut scene = Scene::default();
    scene.add_plane([0.0; 3], Vec3::z(), LARGE, [0.0; 2]);
    scene.add_plane([0.0, 0.0, 50.0], Vec3::z(), LARGE, [0.0; 2]);
    // The other's own uncertainty and that of real faces, which every direction has.
    let u = tilt_uncertainties(other);
    let form = Manufacture::default().angle;
    let (large, n) = (tilt_uncertainties(LARGE), 2.0);
    let total = (u[0] * u[0] + form * form + (large[0] * large[0] + form * form) / n).sqrt();
    let strip = scene.add_plane([0.0, 0.0, 100.0], Vec3::z(), other, [sigmas * total / u[0], 0.0]);
    let of = |s: &Segmentation| angle(&direction(&s.primitives[strip]), &direction(&s.primitives[0]));
    (of(&scene.segmentation), of(&scene.regularized()))
}

#[test]
fn a_relation_is_made_at_one_sigma_and_not_at_four() {
    for size in [STRIP, [20.0, 10.0], LARGE] {
        let (before, after) = angle_of_pair(size, 1.0);
        assert!(before > 0.0 && after < 1e-9, "{size:?}: from {before} to {after}");
        let (before, after) = angle_of_pair(size, 4.0);
        assert_eq!(before, after, "{size:?}: a relation that the scan contradicts");
    }
}

#[test]
fn flanks_of_a_gear_that_fit_many_directions_get_none() {
    // Thirty flanks seven degrees apart or nearly so, each seen to two degrees: every flank fits several others.
    let mut scene = Scene::default();
    scene.add_plane([0.0; 3], Vec3::z(), LARGE, [0.0; 2]);
    scene.add_plane([0.0, 0.0, 50.0], Vec3::z(), LARGE, [0.0; 2]);
    let size = [20.0, 1.5];
    let mut rng = Rng::for_task(5, "flanks", 0);
    let flanks: Vec<(usize, Vec3)> = (0..25)
        .map(|k| {
            let turn = (7.0 * f64::from(k)).to_radians();
            let truth = Rotation3::new(Vec3::z() * turn) * Vec3::x();
            (scene.add_plane([100.0, 0.0, 10.0 * f64::from(k)], truth, size, [rng.normal(), 0.0]), truth)
        })
        .collect();
    let result = scene.regularized();
    let u = tilt_uncertainties(size);
    for (k, truth) in flanks {
        let off = angle(&direction(&result.primitives[k]), &truth);
        let before = angle(&direction(&scene.segmentation.primitives[k]), &truth);
        assert!(off < before + 0.5 * u[0], "flank {k}: {before} became {off}, uncertain to {}", u[0]);
    }
}

/// The surface fitted to a grid of points near `truth`.
fn fitted(n: [usize; 2], at: impl Fn(usize, usize) -> Point3, truth: Surface) -> Surface {
    let points: Vec<Point3> =
        (0..n[0]).flat_map(|i| (0..n[1]).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect();
    let normals = points.iter().map(|p| truth.normal(p).into_inner()).collect();
    let start = Fit { surface: truth, outward: true };
    let weights = Weights { distance_sigma: NOISE, normal_sigma: 0.1, normal_weight: 0.0 };
    refine(&start, &Samples { points, normals }, &weights, 40).unwrap().surface
}

/// A bore seen on an arc, fitted to points with noise, below a large face that it is perpendicular to.
fn bore(seed: u64) -> (Scene, usize, Cylinder) {
    let truth = Cylinder {
        axis: Axis { origin: Point3::new(5.0, -3.0, 0.0), direction: Vec3::z_axis() },
        radius: 8.0,
    };
    let (arc, height) = (2.0, 10.0);
    let n = [(arc * truth.radius / SPACING) as usize, (height / SPACING) as usize];
    let mut rng = Rng::for_task(seed, "bore", 0);
    let noise: Vec<f64> = (0..n[0] * n[1]).map(|_| NOISE * rng.normal()).collect();
    let at = |i: usize, j: usize| {
        let (sin, cos) = (arc * i as f64 / (n[0] - 1) as f64).sin_cos();
        let radius = truth.radius + noise[i * n[1] + j];
        truth.axis.origin + Vec3::new(radius * cos, radius * sin, j as f64 * SPACING - 0.5 * height)
    };
    let surface = fitted(n, at, Surface::Cylinder(truth));
    let mut scene = Scene::default();
    for height in [50.0, 60.0, 70.0, 80.0] {
        scene.add_plane([0.0, 0.0, height], Vec3::z(), LARGE, [0.0; 2]);
    }
    let region = scene.add(n, at, surface);
    (scene, region, truth)
}

#[test]
fn position_of_a_bore_follows_its_axis() {
    let (mut before, mut after) = (0.0, 0.0);
    for seed in 0..20 {
        let (scene, region, truth) = bore(seed);
        let result = scene.regularized();
        let off = |segmentation: &Segmentation, at: f64| {
            let axis = segmentation.primitives[region].surface.unwrap().axis().unwrap();
            let height = at - axis.origin.z;
            let point = axis.origin + axis.direction.into_inner() * (height / axis.direction.z);
            (point - truth.axis.origin).xy().norm_squared()
        };
        assert!(
            angle(&direction(&result.primitives[region]), &direction(&result.primitives[0])) < 1e-14,
            "seed {seed}: the axis is found"
        );
        // At both ends of the bore, where the tilt of its own fit carries the axis away.
        for end in [-5.0, 5.0] {
            before += off(&scene.segmentation, end);
            after += off(&result, end);
        }
    }
    assert!(after < before, "positions went from {before} to {after}");
}

/// A surface of revolution about z with a meridian, `(radius, height)` at each of `n` steps of 0 to 1, seen on an arc.
struct Turned {
    truth: Surface,
    meridian: fn(f64) -> (f64, f64),
    /// Radians.
    arc: (f64, f64),
    n: [usize; 2],
}

fn line_through(x: f64, z: f64) -> Axis {
    Axis { origin: Point3::new(x, 0.0, z), direction: Vec3::z_axis() }
}

/// Surfaces on the line `x = 0, y = 0`.
fn shaft() -> Vec<Turned> {
    let cylinder = |radius| Surface::Cylinder(Cylinder { axis: line_through(0.0, 0.0), radius });
    vec![
        Turned { truth: cylinder(8.0), meridian: |t| (8.0, 20.0 * t), arc: (0.0, 4.0), n: [64, 40] },
        Turned { truth: cylinder(12.0), meridian: |t| (12.0, 30.0 + 10.0 * t), arc: (1.0, 4.5), n: [84, 20] },
        Turned {
            truth: Surface::Cone(Cone {
                axis: line_through(0.0, 40.0),
                radius: 12.0,
                half_angle: 0.5_f64.atan(),
            }),
            meridian: |t| (12.0 + 5.0 * t, 40.0 + 10.0 * t),
            arc: (2.0, 6.0),
            n: [100, 22],
        },
        Turned {
            truth: Surface::Torus(Torus {
                axis: line_through(0.0, 60.0),
                major_radius: 10.0,
                minor_radius: 4.0,
            }),
            meridian: |t| (10.0 + 4.0 * (2.0 * t).cos(), 60.0 + 4.0 * (2.0 * t).sin()),
            arc: (0.0, 5.0),
            n: [100, 18],
        },
        Turned {
            truth: Surface::Sphere(Sphere { center: Point3::new(0.0, 0.0, 80.0), radius: 6.0 }),
            meridian: |t| (6.0 * t.cos(), 80.0 + 6.0 * t.sin()),
            arc: (0.0, 5.0),
            n: [60, 14],
        },
    ]
}

impl Turned {
    /// Adds it to a scene, moved by `x`, fitted to points with noise; returns its region.
    fn add_to(&self, scene: &mut Scene, x: f64, seed: u64) -> usize {
        let truth = self.truth.transformed(&Rotation3::identity(), 1.0, &Vec3::new(x, 0.0, 0.0));
        let n = self.n;
        let mut rng = Rng::for_task(seed, "turned", scene.mesh.vertices.len() as u64);
        let noise: Vec<f64> = (0..n[0] * n[1]).map(|_| NOISE * rng.normal()).collect();
        let at = |i: usize, j: usize| {
            let angle = self.arc.0 + (self.arc.1 - self.arc.0) * i as f64 / (n[0] - 1) as f64;
            let (radius, height) = (self.meridian)(j as f64 / (n[1] - 1) as f64);
            let point = Point3::new(x + radius * angle.cos(), radius * angle.sin(), height);
            point + truth.normal(&point).into_inner() * noise[i * n[1] + j]
        };
        scene.add(n, at, fitted(n, at, truth))
    }
}

/// Large faces across z, so that its direction is known.
fn caps() -> Scene {
    let mut scene = Scene::default();
    for height in [150.0, 160.0, 170.0, 180.0] {
        scene.add_plane([0.0, 0.0, height], Vec3::z(), LARGE, [0.0; 2]);
    }
    scene
}

/// A point of the axis, or the centre.
fn place(primitive: &Primitive) -> Point3 {
    match primitive.surface.as_ref().unwrap() {
        Surface::Sphere(sphere) => sphere.center,
        other => other.axis().unwrap().origin,
    }
}

#[test]
fn surfaces_on_one_line_share_it_exactly() {
    let (mut before, mut after) = (0.0, 0.0);
    for seed in 0..8 {
        let mut scene = caps();
        let members: Vec<usize> = shaft().iter().map(|t| t.add_to(&mut scene, 0.0, seed)).collect();
        let result = scene.regularized();
        let line = result.primitives[members[0]].surface.unwrap().axis().unwrap();
        for &k in &members {
            let primitive = &result.primitives[k];
            let off = line.radial(&place(primitive)).norm();
            assert!(off < 1e-12 * 200.0, "seed {seed}: surface {k} lies {off} beside the line");
            if let Some(axis) = primitive.surface.unwrap().axis() {
                let cosine = axis.direction.dot(&line.direction).abs();
                assert!((cosine - 1.0).abs() < 1e-14, "seed {seed}: surface {k}, cosine {cosine}");
            }
            before += place(&scene.segmentation.primitives[k]).coords.xy().norm_squared();
            after += place(primitive).coords.xy().norm_squared();
        }
    }
    assert!(2.0 * after < before, "squared offsets went from {before} to {after}");
}

#[test]
fn a_line_is_shared_within_the_uncertainty_and_not_beyond() {
    for (offset, shared) in [(0.02, true), (0.3, false), (-0.3, false), (5.0, false)] {
        let mut scene = caps();
        let parts = shaft();
        let first = parts[0].add_to(&mut scene, 0.0, 1);
        let second = parts[1].add_to(&mut scene, offset, 2);
        let sphere = parts[4].add_to(&mut scene, offset, 3);
        let result = scene.regularized();
        let line = result.primitives[first].surface.unwrap().axis().unwrap();
        let off = line.radial(&place(&result.primitives[second])).norm();
        assert_eq!(off < 1e-10, shared, "axes {offset} apart came out {off} apart");
        if !shared {
            assert!((off - offset.abs()).abs() < 0.2 * offset.abs(), "{offset} became {off}");
            // The sphere belongs to the second.
            let line = result.primitives[second].surface.unwrap().axis().unwrap();
            let off = line.radial(&place(&result.primitives[sphere])).norm();
            assert!(off < 1e-10, "the sphere lies {off} beside its line");
        }
    }
}

#[test]
fn what_hardly_shows_stays_where_it_was() {
    // A narrow band of a tube so wide that its centre may be anywhere along its meridian: a turn would take it along.
    let (major, minor) = (8.0, 55.0);
    let (mut moved_most, mut n_turned): (f64, usize) = (0.0, 0);
    for seed in 0..8 {
        let mut scene = caps();
        let band = Turned {
            truth: Surface::Torus(Torus {
                axis: line_through(0.0, -46.0),
                major_radius: major,
                minor_radius: minor,
            }),
            meridian: |t| {
                let angle = 1.25 + 0.08 * t;
                (8.0 + 55.0 * f64::cos(angle), -46.0 + 55.0 * f64::sin(angle))
            },
            arc: (0.0, 1.0),
            n: [50, 10],
        };
        let k = band.add_to(&mut scene, 0.0, seed);
        let (old, new) = (&scene.segmentation.primitives[k], &scene.regularized().primitives[k]);
        if new.surface != old.surface {
            n_turned += 1;
            assert!(angle(&direction(new), &Vec3::z()) < 1e-3, "seed {seed}: it was turned to the others");
        }
        let size = |p: &Primitive| match p.surface {
            Some(Surface::Torus(torus)) => torus.minor_radius,
            _ => unreachable!("a torus was added"),
        };
        moved_most = moved_most.max((size(new) - size(old)).abs());
    }
    assert!(n_turned >= 2, "{n_turned} bands were turned");
    assert!(moved_most < SPACING, "a radius changed by {moved_most}");
}

#[test]
fn nothing_depends_on_how_the_part_lies() {
    let (mut scene, _) = box_with_strips();
    for turned in shaft() {
        turned.add_to(&mut scene, 30.0, 11);
    }
    let rotation = Rotation3::new(Vec3::new(0.4, -1.1, 0.7));
    let mut turned = scene.clone();
    for p in &mut turned.mesh.vertices {
        *p = rotation * *p;
    }
    for primitive in &mut turned.segmentation.primitives {
        primitive.surface = primitive.surface.map(|s| s.transformed(&rotation, 1.0, &Vec3::zeros()));
    }
    let (lying, turned) = (scene.regularized(), turned.regularized());
    // Faces that are seen equally well may come in another order, which matters to second order of their deviations.
    const SECOND_ORDER: f64 = 1e-4;
    let u = tilt_uncertainties(LARGE)[0];
    for (k, (a, b)) in lying.primitives.iter().zip(&turned.primitives).enumerate() {
        if !matches!(a.surface, Some(Surface::Sphere(_))) {
            let off = angle(&(rotation * direction(a)), &direction(b));
            assert!(off < SECOND_ORDER * u, "face {k}: {off} radians off");
        }
        let center = scene.mesh.vertices[0];
        let (a, b) = (a.surface.unwrap(), b.surface.unwrap());
        let off = a.signed_distance(&center) - b.signed_distance(&(rotation * center));
        assert!(off.abs() < SECOND_ORDER * NOISE, "face {k}: {off} off");
    }
}

#[test]
fn nothing_depends_on_the_number_of_threads() {
    let (scene, _) = box_with_strips();
    let one = par::with_threads(Some(1), || scene.regularized());
    let four = par::with_threads(Some(4), || scene.regularized());
    assert_ne!(one.primitives, scene.segmentation.primitives, "something was made parallel");
    assert_eq!(one, four);
}
