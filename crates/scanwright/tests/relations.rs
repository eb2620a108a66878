//! Which relations are found on parts of known design, which are not, and what is asked for by name.

use std::collections::BTreeSet;

use scanwright::fit::{Fit, Noise, Samples, Weights, correlated_covariance, refine};
use scanwright::math::{Axis, Frame, Point3, UnitVec3, Vec3};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::random::Rng;
use scanwright::recognize::{Primitive, Residual};
use scanwright::regularize::{
    Listed, Manufacture, RegularizeOptions, Regularized, RelationKind, Relations, regularize,
};
use scanwright::segment::{RegionId, Segmentation};
use scanwright::surface::{Cylinder, Plane, Surface};
use scanwright::tolerance::{Measured, Tolerances};
use scanwright::uncertainty::Interior;

const SPACING: f64 = 1.0;

/// A scan of faces that do not touch, each fitted on its own.
struct Scan {
    mesh: Mesh,
    segmentation: Segmentation,
    noise: f64,
    rng: Rng,
}

impl Scan {
    fn new(noise: f64, seed: u64) -> Self {
        Self {
            mesh: Mesh::default(),
            segmentation: Segmentation { labels: Vec::new(), primitives: Vec::new() },
            noise,
            rng: Rng::for_task(seed, "relations", 0),
        }
    }

    /// Scans a grid of `n` by `m` points of `truth` and fits it; returns its number.
    fn add(&mut self, [n, m]: [usize; 2], at: impl Fn(usize, usize) -> Point3, truth: Surface) -> u32 {
        let first = self.mesh.vertices.len() as u32;
        let region = self.segmentation.primitives.len() as u32;
        let mut points = Vec::new();
        for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
            let exact = at(i, j);
            points.push(exact + truth.normal(&exact).into_inner() * (self.noise * self.rng.normal()));
        }
        for (i, j) in (1..n).flat_map(|i| (1..m).map(move |j| (i, j))) {
            let v = |di: usize, dj: usize| first + ((i - di) * m + j - dj) as u32;
            self.mesh.triangles.extend([[v(1, 1), v(0, 1), v(0, 0)], [v(1, 1), v(0, 0), v(1, 0)]]);
            self.segmentation.labels.extend([Some(RegionId(region)); 2]);
        }
        let samples = Samples {
            normals: points.iter().map(|p| truth.normal(p).into_inner()).collect(),
            points: points.clone(),
        };
        let weights = Weights { distance_sigma: self.noise, normal_sigma: 1.0, normal_weight: 0.0 };
        let surface = refine(&Fit { surface: truth, outward: true }, &samples, &weights, 40).unwrap().surface;
        let distances: Vec<f64> = points.iter().map(|p| surface.signed_distance(p)).collect();
        let covariance = correlated_covariance(&surface, &samples, points.len(), &[self.measured()], |_| 0.0);
        self.segmentation.primitives.push(Primitive {
            surface: Some(surface),
            residual: Residual::from_distances(&distances),
            covariance,
            ..Primitive::freeform()
        });
        self.mesh.vertices.extend(points);
        region
    }

    /// A square face of 30 lengths about `center`.
    fn plane(&mut self, center: Point3, normal: UnitVec3) -> u32 {
        const N: usize = 31;
        let frame = Frame::from_z(center, normal);
        let at = |i: usize, j: usize| {
            frame.global(&Vec3::new(i as f64 * SPACING - 15.0, j as f64 * SPACING - 15.0, 0.0))
        };
        self.add([N, N], at, Surface::Plane(Plane { point: center, normal }))
    }

    /// Three quarters of a cylinder along `direction`, 20 lengths high.
    fn cylinder(&mut self, center: Point3, direction: UnitVec3, radius: f64) -> u32 {
        const ARC: f64 = 4.7;
        let frame = Frame::from_z(center, direction);
        let n = (ARC * radius / SPACING) as usize + 2;
        let at = |i: usize, j: usize| {
            let (sin, cos) = (ARC * i as f64 / (n - 1) as f64).sin_cos();
            frame.global(&Vec3::new(radius * cos, radius * sin, j as f64 * SPACING))
        };
        let axis = Axis { origin: center, direction };
        self.add([n, 21], at, Surface::Cylinder(Cylinder { axis, radius }))
    }

    fn measured(&self) -> Noise {
        Noise { white: self.noise, correlated: 0.0, length: SPACING }
    }

    fn regularized(&self, relations: Relations) -> Regularized {
        let tolerances = Tolerances::new(
            Measured {
                largest_coordinate: self.mesh.largest_coordinate(),
                diagonal: self.mesh.diagonal(),
                spacing: SPACING,
                noise: self.noise,
                normal_noise: self.noise,
                edge_rounding: 0.0,
            },
            None,
        );
        let interior =
            Interior::new(&self.mesh, &Adjacency::new(&self.mesh), &self.segmentation, &tolerances);
        let manufacture = Manufacture { length: 0.0, angle: 0.0 };
        let options = RegularizeOptions { relations, manufacture, sizes: true };
        regularize(&self.mesh, &interior, &self.segmentation, &self.measured(), &tolerances, &options)
    }

    fn standard_uncertainty(&self, k: u32, parameter: usize) -> f64 {
        self.segmentation.primitives[k as usize].covariance[parameter][parameter].sqrt()
    }
}

/// Every two members of each accepted relation.
fn pairs(regularized: &Regularized) -> BTreeSet<(RelationKind, u32, u32)> {
    let mut pairs = BTreeSet::new();
    for relation in regularized.relations.iter().filter(|r| r.accepted) {
        for (i, &a) in relation.of.iter().enumerate() {
            pairs.extend(relation.of[i + 1..].iter().map(|&b| (relation.kind, a.min(b), a.max(b))));
        }
    }
    // The best seen of two directions stand for all of them; arrangements have tests of their own.
    let arranged = [
        RelationKind::CircularPattern,
        RelationKind::EqualSpacing,
        RelationKind::RectangularPattern,
        RelationKind::Perpendicular,
    ];
    pairs.retain(|pair| !arranged.contains(&pair.0));
    pairs
}

/// A part of random design, and all pairs of it that are related.
fn designed(noise: f64, seed: u64) -> (Scan, BTreeSet<(RelationKind, u32, u32)>) {
    let mut scan = Scan::new(noise, seed);
    let mut draw = Rng::for_task(seed, "design", 0);
    let mut truth = BTreeSet::new();
    let axes = [Vec3::x_axis(), Vec3::y_axis(), Vec3::z_axis()];
    // Of each face: direction, and its place or line and radius in whole numbers.
    let mut planes: Vec<(u32, usize, i32)> = Vec::new();
    let mut cylinders: Vec<(u32, usize, i32, i32)> = Vec::new();
    for k in 0..12 {
        let axis = draw.below(3);
        let level = 3 * draw.below(4) as i32;
        let aside = Vec3::new(draw.uniform(), draw.uniform(), draw.uniform()) * 150.0;
        let direction = axes[axis].into_inner();
        let center = Point3::from(aside - direction * direction.dot(&aside) + direction * f64::from(level));
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        let id = scan.plane(center, UnitVec3::new_unchecked(direction * sign));
        planes.push((id, axis, level));
    }
    for _ in 0..10 {
        let line = draw.below(4) as i32;
        let radius = 5 + draw.below(4) as i32;
        let center = Point3::new(40.0 * f64::from(line), 300.0, 60.0 * draw.uniform());
        let id = scan.cylinder(center, axes[2], f64::from(radius));
        cylinders.push((id, 2, line, radius));
    }
    let directions = planes.iter().map(|p| (p.0, p.1)).chain(cylinders.iter().map(|c| (c.0, c.1)));
    let directions: Vec<(u32, usize)> = directions.collect();
    for (i, a) in directions.iter().enumerate() {
        truth.extend(
            directions[i + 1..].iter().filter(|b| a.1 == b.1).map(|b| (RelationKind::Parallel, a.0, b.0)),
        );
    }
    for (i, a) in planes.iter().enumerate() {
        let same = planes[i + 1..].iter().filter(|b| a.1 == b.1 && a.2 == b.2);
        truth.extend(same.map(|b| (RelationKind::Coplanar, a.0, b.0)));
    }
    for (i, a) in cylinders.iter().enumerate() {
        let others = &cylinders[i + 1..];
        truth.extend(others.iter().filter(|b| a.2 == b.2).map(|b| (RelationKind::Coaxial, a.0, b.0)));
        truth.extend(others.iter().filter(|b| a.3 == b.3).map(|b| (RelationKind::EqualRadius, a.0, b.0)));
    }
    (scan, truth)
}

#[test]
fn relations_of_a_design_are_found_and_no_others() {
    for noise in [0.02, 0.07, 0.2] {
        let (mut n_right, mut n_found, mut n_true) = (0, 0, 0);
        for seed in 0..8 {
            let (scan, truth) = designed(noise, seed);
            let found = pairs(&scan.regularized(Relations::Auto));
            n_right += found.intersection(&truth).count();
            n_found += found.len();
            n_true += truth.len();
        }
        let (precision, recall) = (n_right as f64 / n_found as f64, n_right as f64 / n_true as f64);
        println!("noise {noise}: precision {precision:.4}, recall {recall:.4} of {n_true} pairs");
        assert!(precision >= 0.98, "noise {noise}: precision {precision}");
        assert!(recall >= 0.90, "noise {noise}: recall {recall}");
    }
}

#[test]
fn sizes_and_planes_that_differ_by_six_uncertainties_stay_apart() {
    const SIGMAS: f64 = 6.0;
    const N: u64 = 60;
    let mut n_accepted = 0;
    for seed in 0..N {
        let mut scan = Scan::new(0.05, 100 + seed);
        let below = scan.plane(Point3::origin(), Vec3::z_axis());
        let bore = scan.cylinder(Point3::new(0.0, 60.0, 0.0), Vec3::z_axis(), 6.0);
        let apart = |u: f64| SIGMAS * std::f64::consts::SQRT_2 * u;
        let radius = apart(scan.standard_uncertainty(bore, 4));
        // Beside it the direction of the two together, half as uncertain squared as that of each, has a lever.
        const AWAY: f64 = 35.0;
        let lever = 0.5 * AWAY * scan.standard_uncertainty(below, 2);
        let height = apart(scan.standard_uncertainty(below, 0).hypot(lever));
        scan.plane(Point3::new(AWAY, 0.0, height), Vec3::z_axis());
        scan.cylinder(Point3::new(60.0, 60.0, 0.0), Vec3::z_axis(), 6.0 + radius);
        let found = pairs(&scan.regularized(Relations::Auto));
        let wrong = |kind| found.iter().filter(|pair| pair.0 == kind).count();
        n_accepted += wrong(RelationKind::Coplanar) + wrong(RelationKind::EqualRadius);
    }
    // One in a hundred of the 120 pairs.
    assert!(n_accepted <= 1, "{n_accepted} of {} were made equal", 2 * N);
}

#[test]
fn sizes_that_are_equal_are_exactly_so_and_nearer_to_the_truth() {
    let (mut before, mut after) = (0.0, 0.0);
    for seed in 0..30 {
        let mut scan = Scan::new(0.1, 500 + seed);
        let bores: Vec<u32> = (0..6)
            .map(|k| scan.cylinder(Point3::new(40.0 * f64::from(k), 0.0, 0.0), Vec3::z_axis(), 6.0))
            .collect();
        let result = scan.regularized(Relations::Auto);
        let radius = |segmentation: &Segmentation, k: u32| match segmentation.primitives[k as usize].surface {
            Some(Surface::Cylinder(s)) => s.radius,
            ref other => panic!("{other:?} is no cylinder"),
        };
        for &k in &bores {
            before += (radius(&scan.segmentation, k) - 6.0).powi(2);
            after += (radius(&result.segmentation, k) - 6.0).powi(2);
        }
        let certificate = result.relations.iter().find(|r| r.kind == RelationKind::EqualRadius).unwrap();
        // One in eighty is farther off than is made equal.
        assert!(certificate.accepted && certificate.of.len() >= 5 && certificate.shift > 0.0);
        let first = radius(&result.segmentation, certificate.of[0]);
        assert!(certificate.of.iter().all(|&k| radius(&result.segmentation, k) == first));
        assert!(certificate.z < 3.5 && certificate.z_statistical >= certificate.z);
        assert!(certificate.after < 1.05 * certificate.before, "{certificate:?}");
    }
    // The mean of six: of 30 means, a sixth of the square within four standard deviations.
    assert!(after < 0.34 * before, "{before} became {after}");
}

#[test]
fn relations_can_be_left_out_or_asked_for() {
    let mut scan = Scan::new(0.05, 9);
    let a = scan.plane(Point3::origin(), Vec3::z_axis());
    let b = scan.plane(Point3::new(35.0, 0.0, 0.0), Vec3::z_axis());
    // So little off that the scan shows it clearly, and that a user may want it level nevertheless.
    let c = scan.plane(Point3::new(0.0, 35.0, 0.03), Vec3::z_axis());
    // Planes that have nothing in common lie anywhere in the height of the part.
    scan.plane(Point3::new(0.0, 0.0, 50.0), Vec3::z_axis());
    let off = scan.regularized(Relations::Off);
    assert_eq!(off.segmentation.primitives, scan.segmentation.primitives);
    assert!(off.relations.is_empty());

    let auto = pairs(&scan.regularized(Relations::Auto));
    assert!(auto.contains(&(RelationKind::Coplanar, a, b)), "{auto:?}");
    assert!(!auto.contains(&(RelationKind::Coplanar, a, c)), "{auto:?}");

    let list = vec![Listed { kind: RelationKind::Coplanar, of: vec![a, c], degrees: None }];
    let asked = scan.regularized(Relations::Listed(list));
    assert_eq!(
        pairs(&asked).into_iter().collect::<Vec<_>>(),
        [(RelationKind::Parallel, a, c), (RelationKind::Coplanar, a, c)]
    );
    let plane = |k: u32| match asked.segmentation.primitives[k as usize].surface {
        Some(Surface::Plane(plane)) => plane,
        ref other => panic!("{other:?} is no plane"),
    };
    assert!(plane(a).signed_distance(&plane(c).point).abs() < 1e-12);
    assert_eq!(plane(a).normal, plane(c).normal);
    let told = asked.relations.iter().find(|r| r.kind == RelationKind::Coplanar).unwrap();
    assert!(told.z > 2.5, "what the scan contradicts is said: {told:?}");
    assert_eq!(asked.segmentation.primitives[b as usize], scan.segmentation.primitives[b as usize]);
}

/// Where the axis of a cylinder comes nearest to the origin: axes that are parallel cross one plane there.
fn crossing(segmentation: &Segmentation, k: u32) -> Point3 {
    let Some(Surface::Cylinder(Cylinder { axis, .. })) = segmentation.primitives[k as usize].surface else {
        panic!("{k} is no cylinder")
    };
    axis.foot(&Point3::origin())
}

/// Bores at `places` with a large face beside them; `off` moves the first.
fn bores(seed: u64, places: &[(f64, f64)], off: f64) -> (Scan, Vec<u32>) {
    let mut scan = Scan::new(0.1, seed);
    scan.plane(Point3::new(0.0, 90.0, 20.0), Vec3::z_axis());
    let bore = |(i, &(x, y)): (usize, &(f64, f64))| {
        let x = if i == 0 { x + off } else { x };
        scan.cylinder(Point3::new(x, y, 0.0), Vec3::z_axis(), 6.0)
    };
    let numbers = places.iter().enumerate().map(bore).collect();
    (scan, numbers)
}

/// Places around a circle of radius 40.
fn around(n: usize) -> Vec<(f64, f64)> {
    let place = |i: usize| (std::f64::consts::TAU * i as f64 / n as f64 + 0.3).sin_cos();
    (0..n).map(place).map(|(sin, cos)| (40.0 * cos, 40.0 * sin)).collect()
}

fn pattern(result: &Regularized, kind: RelationKind) -> Option<Vec<u32>> {
    let found = result.relations.iter().find(|relation| relation.kind == kind && relation.accepted)?;
    assert!(found.z < 4.5 && found.shift > 0.0, "{found:?}");
    Some(found.of.clone())
}

#[test]
fn bores_around_a_circle_are_exactly_so_and_nearer_to_the_truth() {
    let (mut before, mut after, mut n_found) = (0.0, 0.0, 0);
    for seed in 0..20 {
        let mut places = around(6);
        places.push((0.0, 0.0));
        let (scan, numbers) = bores(700 + seed, &places, 0.0);
        let result = scan.regularized(Relations::Auto);
        let Some(of) = pattern(&result, RelationKind::CircularPattern) else { continue };
        n_found += 1;
        assert_eq!(of.last(), numbers.last(), "the middle comes last");
        let at: Vec<Point3> = of.iter().map(|&k| crossing(&result.segmentation, k)).collect();
        let arms: Vec<Vec3> = at[..6].iter().map(|p| p - at[6]).collect();
        for (a, b) in arms.iter().zip(arms.iter().cycle().skip(1)) {
            // Sides of a regular hexagon are as long as its arms.
            assert!((a.norm() - arms[0].norm()).abs() < 1e-9 && ((b - a).norm() - a.norm()).abs() < 1e-9);
        }
        for (&k, &(x, y)) in numbers.iter().zip(&places) {
            let truth = Point3::new(x, y, 0.0);
            before += (crossing(&scan.segmentation, k) - truth).norm_squared();
            after += (crossing(&result.segmentation, k) - truth).norm_squared();
        }
    }
    assert!(n_found >= 18, "{n_found} of 20");
    // Fourteen coordinates, four parameters; parallel axes gain too.
    assert!(after < 0.45 * before, "{before} became {after}");
}

#[test]
fn rows_and_rectangles_of_bores_are_found() {
    let row: Vec<(f64, f64)> = (0..5).map(|i| (25.0 * f64::from(i), 10.0 * f64::from(i))).collect();
    let rectangle = [(0.0, 0.0), (60.0, 0.0), (60.0, 35.0), (0.0, 35.0)];
    let square = [(0.0, 0.0), (60.0, 0.0), (60.0, 60.0), (0.0, 60.0)];
    let mut n_found = [0; 3];
    for seed in 0..10 {
        let cases: [(&[(f64, f64)], RelationKind); 3] = [
            (&row, RelationKind::EqualSpacing),
            (&rectangle, RelationKind::RectangularPattern),
            (&square, RelationKind::CircularPattern),
        ];
        for ((places, kind), n_found) in cases.into_iter().zip(&mut n_found) {
            let (scan, _) = bores(800 + seed, places, 0.0);
            let result = scan.regularized(Relations::Auto);
            let Some(of) = pattern(&result, kind) else { continue };
            *n_found += 1;
            let at: Vec<Point3> = of.iter().map(|&k| crossing(&result.segmentation, k)).collect();
            if kind == RelationKind::EqualSpacing {
                assert!(at.windows(3).all(|w| ((w[1] - w[0]) - (w[2] - w[1])).norm() < 1e-9));
            } else {
                assert!(((at[1] - at[0]) - (at[2] - at[3])).norm() < 1e-9);
                assert!((at[1] - at[0]).dot(&(at[3] - at[0])).abs() < 1e-7);
            }
        }
    }
    assert!(n_found.iter().all(|&n| n >= 9), "{n_found:?} of 10");
}

#[test]
fn a_bore_that_is_out_of_place_by_six_uncertainties_is_in_no_pattern() {
    let mut n_wrong = 0;
    for seed in 0..40 {
        let (scan, numbers) = bores(900 + seed, &around(5), 0.0);
        let u = scan.standard_uncertainty(numbers[0], 0).max(scan.standard_uncertainty(numbers[0], 1));
        let (scan, _) = bores(900 + seed, &around(5), 6.0 * std::f64::consts::SQRT_2 * u);
        n_wrong +=
            usize::from(pattern(&scan.regularized(Relations::Auto), RelationKind::CircularPattern).is_some());
    }
    // The circle gives way by a quarter of it: chi squared is then so small in one of a hundred.
    assert!(n_wrong <= 1, "{n_wrong} of 40");
}

#[test]
fn faces_at_a_common_angle_are_exactly_so_and_others_are_left() {
    let slope = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        UnitVec3::new_normalize(Vec3::new(sin, 0.0, cos))
    };
    let made = |degrees: f64, seed: u64| {
        let mut scan = Scan::new(0.05, seed);
        scan.plane(Point3::origin(), Vec3::z_axis());
        scan.plane(Point3::new(60.0, 0.0, 0.0), slope(degrees));
        let result = scan.regularized(Relations::Auto);
        let angle =
            result.relations.iter().find(|r| r.kind == RelationKind::CommonAngle && r.accepted)?.angle;
        let normal = |k: usize| match result.segmentation.primitives[k].surface {
            Some(Surface::Plane(plane)) => plane.normal,
            ref other => panic!("{other:?} is no plane"),
        };
        let exact = normal(0).dot(&normal(1)).abs().acos();
        assert!((exact - angle.unwrap()).abs() < 1e-9);
        Some(exact.to_degrees())
    };
    let common: Vec<f64> = (0..20).filter_map(|seed| made(150.0, 1000 + seed)).collect();
    assert!(common.len() >= 18 && common.iter().all(|a| (a - 30.0).abs() < 1e-6), "{common:?}");
    assert_eq!((0..20).filter_map(|seed| made(31.0, 1100 + seed)).count(), 0);

    let mut scan = Scan::new(0.05, 7);
    scan.plane(Point3::origin(), Vec3::z_axis());
    scan.plane(Point3::new(60.0, 0.0, 0.0), slope(20.1));
    let list = vec![Listed { kind: RelationKind::CommonAngle, of: vec![0, 1], degrees: Some(20.0) }];
    let asked = scan.regularized(Relations::Listed(list));
    assert_eq!(asked.relations[0].angle, Some(20.0_f64.to_radians()), "{:?}", asked.relations);
}

/// Distance at which two axes pass each other.
fn apart(segmentation: &Segmentation, a: u32, b: u32) -> f64 {
    let axis = |k: u32| segmentation.primitives[k as usize].surface.unwrap().axis().unwrap();
    let (one, other) = (axis(a), axis(b));
    let normal = one.direction.cross(&other.direction).normalize();
    normal.dot(&(other.origin - one.origin)).abs()
}

/// A bore along z and one along x, which passes it at `distance`.
fn crossed(seed: u64, distance: f64) -> (Scan, [u32; 2]) {
    let mut scan = Scan::new(0.1, seed);
    let upright = scan.cylinder(Point3::origin(), Vec3::z_axis(), 6.0);
    // Beside their middles: far away their directions would have a lever.
    let lying = scan.cylinder(Point3::new(-10.0, distance, 8.0), Vec3::x_axis(), 5.0);
    scan.plane(Point3::new(0.0, 60.0, 20.0), Vec3::z_axis());
    scan.plane(Point3::new(60.0, 60.0, 0.0), Vec3::x_axis());
    (scan, [upright, lying])
}

#[test]
fn axes_that_meet_do_so_exactly_and_others_stay_apart() {
    let met = |result: &Regularized| {
        result.relations.iter().any(|r| r.kind == RelationKind::Intersecting && r.accepted)
    };
    let mut n_found = 0;
    for seed in 0..20 {
        let (scan, [a, b]) = crossed(1200 + seed, 0.0);
        let result = scan.regularized(Relations::Auto);
        if met(&result) {
            n_found += 1;
            assert!(apart(&result.segmentation, a, b) < 1e-9);
        }
    }
    assert!(n_found >= 18, "{n_found} of 20");
    let mut n_wrong = 0;
    for seed in 0..20 {
        let (scan, [a, b]) = crossed(1300 + seed, 0.0);
        let u = [a, b].map(|k| scan.standard_uncertainty(k, 0).max(scan.standard_uncertainty(k, 1)));
        let (scan, _) = crossed(1300 + seed, 6.0 * u[0].hypot(u[1]));
        n_wrong += usize::from(met(&scan.regularized(Relations::Auto)));
    }
    assert_eq!(n_wrong, 0, "of 20");
}

#[test]
fn a_pattern_that_was_found_can_be_asked_for_as_it_was_told() {
    let mut places = around(6);
    places.push((0.0, 0.0));
    let (scan, _) = bores(700, &places, 0.0);
    let found = scan.regularized(Relations::Auto);
    let of = pattern(&found, RelationKind::CircularPattern).expect("seed 700 shows it");
    let list = vec![Listed { kind: RelationKind::CircularPattern, of: of.clone(), degrees: None }];
    let asked = scan.regularized(Relations::Listed(list));
    assert_eq!(pattern(&asked, RelationKind::CircularPattern).unwrap().last(), of.last(), "its middle");
    let at: Vec<Point3> = of.iter().map(|&k| crossing(&asked.segmentation, k)).collect();
    assert!(at[..6].iter().all(|p| ((p - at[6]).norm() - (at[0] - at[6]).norm()).abs() < 1e-9));
}
