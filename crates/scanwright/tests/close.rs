//! Tests of `brep::close`: solids made of grids with known surfaces, from which triangles are taken.

use proptest::prelude::*;
use scanwright::brep::close::{Assumption, Closed, close};
use scanwright::condition::Support;
use scanwright::math::{Axis, Point3, UnitVec3, Vec3};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::par;
use scanwright::recognize::{Primitive, Residual};
use scanwright::segment::{RegionId, Segmentation};
use scanwright::surface::{Cylinder, Plane, Surface};
use scanwright::tolerance::{Measured, Tolerances};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Edge length of all generated grids.
const STEP: f64 = 1.0;

#[test]
fn a_closed_mesh_is_left_as_it_is() {
    let part = block([12.0, 10.0, 8.0]);
    let closed = part.close(None);
    assert_eq!(closed.labelled.mesh, part.mesh);
    assert!(closed.assumed_faces.is_empty() && closed.open.is_empty());
}

#[test]
fn a_bore_seen_from_both_ends_becomes_one_face() {
    let (outer, inner, height) = (14.0, 6.0, 40.0);
    let whole = pipe(outer, inner, height);
    // Teeth of one step in the rim, as scanners leave them.
    let seen = whole.without(|t, p| t == 1 && p.z.abs() < 10.0 + STEP * (5.0 * p.y.atan2(p.x)).sin());
    let closed = seen.close(None);
    assert_closed(&closed);
    assert_eq!(assumptions(&closed), [(1, Assumption::Extended)]);
    // Edges of up to two steps on a cylinder lie inside it by their sagitta.
    let sagitta = (2.0 * STEP).powi(2) / (8.0 * inner);
    let unseen = TAU * inner * 22.0;
    assert_near(closed.labelled.mesh.signed_volume(), whole.mesh.signed_volume(), unseen * sagitta, "volume");
}

#[test]
fn two_regions_of_one_bore_are_merged() {
    let mut seen = pipe(14.0, 6.0, 40.0).without(|t, p| t == 1 && p.z.abs() < 9.0);
    let second = seen.primitives.len() as u32;
    seen.primitives.push(seen.primitives[1].clone());
    for t in 0..seen.labels.len() {
        if seen.labels[t] == 1 && seen.mesh.triangle_center(t).z < 0.0 {
            seen.labels[t] = second;
        }
    }
    let closed = seen.close(None);
    assert_closed(&closed);
    let labels: Vec<u32> = closed.labelled.labels.iter().map(|l| l.0).collect();
    assert!(labels.contains(&1) != labels.contains(&second), "one of the two remains");
}

#[test]
fn a_bore_without_a_visible_end_is_capped_where_sight_ends() {
    let whole = pipe(14.0, 6.0, 40.0);
    let depth = 5.0;
    let seen = whole.without(|t, p| t == 3 || (t == 1 && p.z < depth));
    // The lower end is a disc without a bore.
    let seen = seen.with_disc(14.0, -20.0);
    let closed = seen.close(None);
    assert_closed(&closed);
    let caps: Vec<_> = closed.assumed_faces.iter().filter(|f| f.assumption == Assumption::Cap).collect();
    assert_eq!(caps.len(), 1, "{:?}", closed.assumed_faces);
    let cap = &closed.labelled.primitives[caps[0].region.0 as usize];
    let Some(Surface::Plane(plane)) = cap.surface else { panic!("a cap is flat") };
    assert_near(plane.normal.z, 1.0, 1e-9, "the cap faces the air above it");
    assert_near(plane.point.z, depth, 2.0 * STEP, "height of the cap");
}

#[test]
fn a_box_on_the_table_gets_its_bottom() {
    let size = [12.0, 10.0, 8.0];
    let whole = block(size);
    // The bottom and two steps of skirt are missing.
    let seen = whole.without(|t, p| t == BOTTOM || p.z < 2.0);
    let closed = seen.close(Some(&table(0.0)));
    assert_closed(&closed);
    let kinds: Vec<Assumption> = closed.assumed_faces.iter().map(|f| f.assumption).collect();
    assert_eq!(kinds.iter().filter(|k| **k == Assumption::Support).count(), 1);
    // Walls and plane are exact, so is their intersection.
    assert_near(closed.labelled.mesh.signed_volume(), size.iter().product(), 1e-6, "volume");
}

#[test]
fn a_bore_goes_down_to_the_table() {
    let whole = pipe(14.0, 6.0, 40.0);
    let seen = whole.without(|t, p| t == 3 || (t == 0 && p.z < -18.0) || (t == 1 && p.z < 3.0));
    let closed = seen.close(Some(&table(-20.0)));
    assert_closed(&closed);
    let made: Vec<Assumption> = closed.assumed_faces.iter().map(|f| f.assumption).collect();
    assert!(!made.contains(&Assumption::Cap), "the bore is open below: {made:?}");
    let sagitta = (2.0 * STEP).powi(2) / (8.0 * 6.0);
    let unseen = TAU * (6.0 * 23.0 + 14.0 * 2.0);
    assert_near(closed.labelled.mesh.signed_volume(), whole.mesh.signed_volume(), unseen * sagitta, "volume");
}

#[test]
fn a_missing_corner_grows_back_from_its_three_faces() {
    let size = [16.0, 14.0, 12.0];
    let corner = Point3::from(Vec3::from(size));
    let whole = block(size);
    let seen = whole.without(|_, p| (p - corner).norm() < 5.0);
    let closed = seen.close(None);
    assert_closed(&closed);
    let nearest = closed.labelled.mesh.vertices.iter().map(|p| (p - corner).norm()).fold(f64::MAX, f64::min);
    assert!(nearest < STEP, "a vertex comes to the corner, but the nearest is {nearest} away");
    // What may be cut off: a bevel half a step wide along three edges five steps long.
    let bevel = 3.0 * 5.0 * 0.5 * (0.5 * STEP).powi(2);
    assert_near(closed.labelled.mesh.signed_volume(), size.iter().product(), bevel, "volume");
    let invented = (0..closed.labelled.labels.len()).filter(|&t| closed.labelled.assumed[t]);
    let mut labels: Vec<u32> = invented.map(|t| closed.labelled.labels[t].0).collect();
    labels.sort_unstable();
    labels.dedup();
    assert_eq!(labels.len(), 3, "three faces are extended: {labels:?}");
}

#[test]
fn a_window_in_a_wall_takes_the_wall() {
    let whole = pipe(14.0, 6.0, 40.0);
    let seen = whole.without(|t, p| t == 0 && p.x > 0.0 && p.y.hypot(p.z) < 7.0);
    let closed = seen.close(None);
    assert_closed(&closed);
    assert_eq!(assumptions(&closed), [(0, Assumption::Extended)]);
    // All new vertices lie on the wall.
    for p in &closed.labelled.mesh.vertices[seen.mesh.vertices.len()..] {
        assert_near(p.x.hypot(p.y), 14.0, 1e-9, "radius");
    }
}

#[test]
fn bores_that_meet_unseen_are_joined() {
    let (half, radius) = (20.0, 5.0);
    let part = block_with_two_bores(half, radius, 6.0);
    let closed = part.close(None);
    assert_closed(&closed);
    // Both bores end flat on the other's axis; half cylinders overlap in a quarter of Steinmetz's 16 r^3 / 3.
    let air = 2.0 * PI * radius * radius * half - 4.0 * radius.powi(3) / 3.0;
    // Facets of the grid lie up to a third of a step off the sharp edges, and inside the cylinders by a sagitta.
    let edge_loss = (3.0 * TAU * radius) * (STEP / 3.0).powi(2);
    let sagitta = (2.0 * STEP).powi(2) / (8.0 * radius) * (2.0 * TAU * radius * half);
    let volume = closed.labelled.mesh.signed_volume();
    assert_near(volume, (2.0 * half).powi(3) - air, edge_loss + sagitta, "volume");
    // A cap at each mouth would leave the middle solid; that is not what happened.
    let solid_middle = PI * radius * radius * 6.0;
    assert!((2.0 * half).powi(3) - volume > 2.0 * solid_middle + 0.5 * air);
}

#[test]
fn the_result_moves_and_scales_with_the_scan() {
    let seen = pipe(14.0, 6.0, 40.0).without(|t, p| t == 3 || (t == 1 && p.z < 5.0)).with_disc(14.0, -20.0);
    let volume = seen.close(None).labelled.mesh.signed_volume();
    let rotation = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    for scale in [1e-3, 1.0, 1e3] {
        let moved = seen.moved(&rotation, scale, &(Vec3::new(3.0, -70.0, 9.0) * scale));
        let closed = moved.close(None);
        assert_closed(&closed);
        // The grid of the fill turns with the frame: facets differ by sagittas of the new area at most.
        let allowed = TAU * 6.0 * 5.0 * (2.0 * STEP).powi(2) / (8.0 * 6.0);
        assert_near(closed.labelled.mesh.signed_volume() / scale.powi(3), volume, allowed, "volume");
    }
}

#[test]
fn the_result_does_not_depend_on_threads() {
    let seen = pipe(14.0, 6.0, 40.0).without(|t, p| t == 1 && p.z.abs() < 8.0);
    let one = par::with_threads(Some(1), || seen.close(None));
    let two = par::with_threads(Some(2), || seen.close(None));
    assert_eq!(one, two);
}

#[test]
fn a_mesh_without_surfaces_is_still_closed() {
    let mut seen = block([8.0; 3]).without(|t, p| t == BOTTOM && p.x < 4.0);
    for primitive in &mut seen.primitives {
        primitive.surface = None;
    }
    assert_closed(&seen.close(None));
}

#[test]
fn absurd_input_does_not_panic() {
    let nothing = Part::default();
    assert!(nothing.close(None).labelled.labels.is_empty());
    let mut flap = block([4.0; 3]).without(|t, _| t != BOTTOM);
    flap.close(Some(&table(0.0)));
    flap.labels.clear();
    flap.primitives.clear();
    flap.close(None);
    let mut broken = pipe(14.0, 6.0, 40.0).without(|t, p| t == 1 && p.z < 0.0);
    broken.primitives[1].surface = Some(Surface::Cylinder(Cylinder {
        axis: Axis { origin: Point3::new(f64::NAN, 0.0, 0.0), direction: Vec3::z_axis() },
        radius: 0.0,
    }));
    broken.close(None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn triangle_soup_does_not_panic(
        points in prop::collection::vec((-5.0..5.0, -5.0..5.0, -5.0..5.0), 4..24),
        corners in prop::collection::vec((0_usize..24, 0_usize..24, 0_usize..24), 1..40),
        labels in prop::collection::vec(prop::option::of(0_u32..9), 0..40),
    ) {
        let n = points.len();
        let vertices = points.into_iter().map(|(x, y, z)| Point3::new(x, y, z)).collect();
        let triangles = corners.into_iter().map(|(a, b, c)| [a % n, b % n, c % n].map(|v| v as u32)).collect();
        let mesh = Mesh { vertices, triangles };
        let primitives = pipe(3.0, 1.0, 4.0).primitives;
        let labels = labels.into_iter().map(|l| l.map(RegionId)).collect();
        let closed = close(&mesh, &Segmentation { labels, primitives }, Some(&table(-3.0)), &tolerances(1.0));
        prop_assert_eq!(closed.labelled.labels.len(), closed.labelled.mesh.triangles.len());
        prop_assert_eq!(closed.labelled.assumed.len(), closed.labelled.mesh.triangles.len());
    }

    #[test]
    fn random_damage_of_a_block_is_closed(holes in prop::collection::vec((0.0..12.0, 0.0..10.0, 0.0..8.0, 0.8..3.5), 1..4)) {
        let seen = block([12.0, 10.0, 8.0]).without(|_, p| {
            holes.iter().any(|&(x, y, z, r)| (p - Point3::new(x, y, z)).norm() < r)
        });
        let closed = seen.close(None);
        prop_assert!(closed.open.is_empty());
        prop_assert!(is_closed(&closed.labelled.mesh));
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Solids made of grids.

/// Label of the lower face of `block`.
const BOTTOM: u32 = 4;

#[derive(Debug, Clone, Default)]
struct Part {
    mesh: Mesh,
    labels: Vec<u32>,
    primitives: Vec<Primitive>,
    welded: BTreeMap<[i64; 3], u32>,
    scale: f64,
}

impl Part {
    fn new() -> Self {
        Self { scale: 1.0, ..Self::default() }
    }

    fn vertex(&mut self, p: Point3) -> u32 {
        let key = [p.x, p.y, p.z].map(|c| (c * 1e6).round() as i64);
        *self.welded.entry(key).or_insert_with(|| {
            self.mesh.vertices.push(p);
            self.mesh.vertices.len() as u32 - 1
        })
    }

    /// A grid over the unit square, whose picture by `point` is seen from outside with u to the right and v up.
    fn grid(&mut self, label: u32, nu: usize, nv: usize, point: impl Fn(f64, f64) -> Point3) {
        let at = |i: usize, j: usize| point(i as f64 / nu as f64, j as f64 / nv as f64);
        for i in 0..nu {
            for j in 0..nv {
                let [a, b, c, d] =
                    [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)].map(|p| self.vertex(p));
                for triangle in [[a, b, c], [a, c, d]] {
                    self.mesh.triangles.push(triangle);
                    self.labels.push(label);
                }
            }
        }
    }

    fn without(&self, drop: impl Fn(u32, Point3) -> bool) -> Self {
        let (mesh, old, _) = self.mesh.submesh(|t| !drop(self.labels[t], self.mesh.triangle_center(t)));
        let labels = old.iter().map(|&t| self.labels[t as usize]).collect();
        let mut part = Self { mesh, labels, primitives: self.primitives.clone(), ..Self::new() };
        for (v, p) in part.mesh.vertices.iter().enumerate() {
            part.welded.insert([p.x, p.y, p.z].map(|c| (c * 1e6).round() as i64), v as u32);
        }
        part
    }

    /// Adds the full disc that closes a pipe below.
    fn with_disc(mut self, radius: f64, z: f64) -> Self {
        let label = self.primitives.len() as u32;
        self.primitives.push(plane(Point3::new(0.0, 0.0, z), -Vec3::z()));
        let n = around(radius);
        self.grid(label, n, 12, |u, v| {
            let (sin, cos) = (-TAU * u).sin_cos();
            // A tiny pin hole in the middle, closed below, keeps the grid free of triangles without area.
            let r = radius + (0.3 - radius) * v;
            Point3::new(r * cos, r * sin, z)
        });
        let rim: Vec<u32> = (0..n)
            .map(|i| {
                let (sin, cos) = (-TAU * i as f64 / n as f64).sin_cos();
                self.vertex(Point3::new(0.3 * cos, 0.3 * sin, z))
            })
            .collect();
        let center = self.vertex(Point3::new(0.0, 0.0, z));
        for i in 0..n {
            self.mesh.triangles.push([rim[i], rim[(i + 1) % n], center]);
            self.labels.push(label);
        }
        self
    }

    fn moved(&self, rotation: &nalgebra::Rotation3<f64>, scale: f64, translation: &Vec3) -> Self {
        let mut moved = self.clone();
        moved.scale = scale;
        for p in &mut moved.mesh.vertices {
            *p = rotation * Point3::from(p.coords * scale) + translation;
        }
        for primitive in &mut moved.primitives {
            primitive.surface = primitive.surface.map(|s| s.transformed(rotation, scale, translation));
        }
        moved
    }

    fn close(&self, support: Option<&Support>) -> Closed {
        let labels = self.labels.iter().map(|&l| Some(RegionId(l))).collect();
        let segmentation = Segmentation { labels, primitives: self.primitives.clone() };
        close(&self.mesh, &segmentation, support, &tolerances(STEP * self.scale))
    }
}

fn primitive(surface: Surface, outward: bool) -> Primitive {
    Primitive {
        surface: Some(surface),
        outward,
        residual: Residual::default(),
        covariance: Vec::new(),
        ambiguous: None,
    }
}

fn plane(point: Point3, normal: Vec3) -> Primitive {
    primitive(Surface::Plane(Plane { point, normal: UnitVec3::new_normalize(normal) }), true)
}

fn cylinder(direction: UnitVec3, radius: f64, outward: bool) -> Primitive {
    let axis = Axis { origin: Point3::origin(), direction };
    primitive(Surface::Cylinder(Cylinder { axis, radius }), outward)
}

fn table(height: f64) -> Support {
    let plane = Plane { point: Point3::new(0.0, 0.0, height), normal: Vec3::z_axis() };
    Support { plane, on_table: Vec::new(), outlines: Vec::new() }
}

fn tolerances(spacing: f64) -> Tolerances {
    let measured = Measured {
        largest_coordinate: 50.0 * spacing,
        diagonal: 50.0 * spacing,
        spacing,
        noise: 0.0,
        normal_noise: 0.0,
        edge_rounding: 0.0,
    };
    Tolerances::new(measured, None)
}

fn around(radius: f64) -> usize {
    (TAU * radius / STEP).round() as usize
}

/// A box from the origin to `size`; label 4 is below.
fn block(size: [f64; 3]) -> Part {
    let mut part = Part::new();
    for axis in 0..3 {
        for upper in [true, false] {
            let label = if axis == 2 && !upper {
                BOTTOM
            } else if axis == 2 {
                5
            } else {
                (2 * axis + usize::from(upper)) as u32
            };
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            let [nu, nv] = [b, c].map(|k| (size[k] / STEP).round() as usize);
            let at = |u: f64, v: f64| {
                let mut p = [0.0; 3];
                p[axis] = if upper { size[axis] } else { 0.0 };
                p[b] = size[b] * if upper { u } else { 1.0 - u };
                p[c] = size[c] * v;
                Point3::from(p)
            };
            part.grid(label, nu, nv, at);
        }
    }
    part.primitives = (0..6)
        .map(|label| {
            let (axis, upper) = (label / 2, label % 2 == 1);
            let mut normal = Vec3::zeros();
            normal[axis] = if upper { 1.0 } else { -1.0 };
            let point = if upper { Point3::from(Vec3::from(size)) } else { Point3::origin() };
            plane(point, normal)
        })
        .collect();
    part
}

/// A pipe about z, centred: wall 0, bore 1, upper end 2, lower end 3.
fn pipe(outer: f64, inner: f64, height: f64) -> Part {
    let mut part = Part::new();
    let n = around(outer);
    let nz = (height / STEP).round() as usize;
    let nr = ((outer - inner) / STEP).round() as usize;
    let point =
        |radius: f64, u: f64, z: f64| Point3::new(radius * (TAU * u).cos(), radius * (TAU * u).sin(), z);
    let half = 0.5 * height;
    part.grid(0, n, nz, |u, v| point(outer, u, height * v - half));
    part.grid(1, n, nz, |u, v| point(inner, -u, height * v - half));
    part.grid(2, n, nr, |u, v| point(outer + (inner - outer) * v, u, half));
    part.grid(3, n, nr, |u, v| point(outer + (inner - outer) * v, -u, -half));
    part.primitives = vec![
        cylinder(Vec3::z_axis(), outer, true),
        cylinder(Vec3::z_axis(), inner, false),
        plane(Point3::new(0.0, 0.0, half), Vec3::z()),
        plane(Point3::new(0.0, 0.0, -half), -Vec3::z()),
    ];
    part
}

/// A cube about the origin with bores from above (label 6) and from +x (label 7), each seen down to `seen` only.
fn block_with_two_bores(half: f64, radius: f64, seen: f64) -> Part {
    let cube = block([2.0 * half; 3]);
    let mut part = cube.without(|label, _| label == 5 || label == 1);
    let shift = Vec3::from_element(half);
    for p in &mut part.mesh.vertices {
        *p -= shift;
    }
    part.welded = BTreeMap::new();
    for (v, p) in part.mesh.vertices.iter().enumerate() {
        part.welded.insert([p.x, p.y, p.z].map(|c| (c * 1e6).round() as i64), v as u32);
    }
    for primitive in &mut part.primitives {
        primitive.surface =
            primitive.surface.map(|s| s.transformed(&nalgebra::Rotation3::identity(), 1.0, &-shift));
    }
    part.primitives.push(cylinder(Vec3::z_axis(), radius, false));
    part.primitives.push(cylinder(Vec3::x_axis(), radius, false));
    let upright = |p: Point3| p;
    let sideways = |p: Point3| Point3::new(p.z, p.x, p.y);
    let n = 4 * (2.0 * half / STEP).round() as usize;
    for (face, bore, turn) in [(5, 6, upright as fn(Point3) -> Point3), (1, 7, sideways)] {
        // From the square's border, walked counter-clockwise in equal steps, to the circle.
        let border = |u: f64| {
            let side = (4.0 * u).floor().min(3.0);
            let along = 2.0 * half * (4.0 * u - side) - half;
            let (sin, cos) = (side * FRAC_PI_2).sin_cos();
            (half * cos - along * sin, half * sin + along * cos)
        };
        let circle = |u: f64| {
            let (x, y) = border(u);
            let r = radius / x.hypot(y);
            (x * r, y * r)
        };
        part.grid(face, n, 15, |u, v| {
            let ((x, y), (cx, cy)) = (border(u), circle(u));
            turn(Point3::new(x + (cx - x) * v, y + (cy - y) * v, half))
        });
        part.grid(bore, n, 6, |u, v| {
            let (cx, cy) = circle(u);
            turn(Point3::new(cx, cy, half - seen * v))
        });
    }
    part
}

// ---------------------------------------------------------------------------------------------------------------------
// Checks.

/// Whether every edge is used once in each sense.
fn is_closed(mesh: &Mesh) -> bool {
    let mut edges: Vec<(u32, u32)> =
        mesh.triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3]))).collect();
    edges.sort_unstable();
    edges.windows(2).all(|pair| pair[0] != pair[1])
        && edges.iter().all(|e| edges.binary_search(&(e.1, e.0)).is_ok())
}

fn assert_closed(closed: &Closed) {
    let labelled = &closed.labelled;
    assert!(closed.open.is_empty(), "left open: {:?}", closed.open);
    assert!(is_closed(&labelled.mesh), "some edge is not used once in each sense");
    assert_eq!(Adjacency::new(&labelled.mesh).components().1, 1, "one piece");
    assert!(labelled.labels.iter().all(|l| (l.0 as usize) < labelled.primitives.len()));
    assert!(labelled.mesh.vertices.iter().all(|p| p.coords.iter().all(|c| c.is_finite())));
}

fn assumptions(closed: &Closed) -> Vec<(u32, Assumption)> {
    closed.assumed_faces.iter().map(|f| (f.region.0, f.assumption)).collect()
}

#[track_caller]
fn assert_near(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance, "{what}: {a} is not within {tolerance} of {b}");
}
