//! Solids with known surfaces, made of labelled grids.

use scanwright::brep::LabelledMesh;
use scanwright::brep::close::{Closed, close};
use scanwright::condition::Support;
use scanwright::math::{Axis, Point3, UnitVec3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::recognize::{Primitive, Residual};
use scanwright::segment::{RegionId, Segmentation};
use scanwright::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};
use scanwright::tolerance::{Measured, Tolerances};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// Edge length of all generated grids.
pub const STEP: f64 = 1.0;

/// Label of the lower face of `block`.
pub const BOTTOM: u32 = 4;

#[derive(Debug, Clone, Default)]
pub struct Part {
    pub mesh: Mesh,
    pub labels: Vec<u32>,
    pub primitives: Vec<Primitive>,
    welded: BTreeMap<[i64; 3], u32>,
    pub scale: f64,
}

impl Part {
    pub fn new() -> Self {
        Self { scale: 1.0, ..Self::default() }
    }

    pub fn vertex(&mut self, p: Point3) -> u32 {
        let key = [p.x, p.y, p.z].map(|c| (c * 1e6).round() as i64);
        *self.welded.entry(key).or_insert_with(|| {
            self.mesh.vertices.push(p);
            self.mesh.vertices.len() as u32 - 1
        })
    }

    /// A grid over the unit square, whose picture by `point` is seen from outside with u to the right and v up.
    pub fn grid(&mut self, label: u32, nu: usize, nv: usize, point: impl Fn(f64, f64) -> Point3) {
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

    pub fn without(&self, drop: impl Fn(u32, Point3) -> bool) -> Self {
        let (mesh, old, _) = self.mesh.submesh(|t| !drop(self.labels[t], self.mesh.triangle_center(t)));
        let labels = old.iter().map(|&t| self.labels[t as usize]).collect();
        let mut part = Self { mesh, labels, primitives: self.primitives.clone(), ..Self::new() };
        for (v, p) in part.mesh.vertices.iter().enumerate() {
            part.welded.insert([p.x, p.y, p.z].map(|c| (c * 1e6).round() as i64), v as u32);
        }
        part
    }

    /// Adds the full disc that closes a pipe below.
    pub fn with_disc(mut self, radius: f64, z: f64) -> Self {
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

    pub fn moved(&self, rotation: &nalgebra::Rotation3<f64>, scale: f64, translation: &Vec3) -> Self {
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

    pub fn close(&self, support: Option<&Support>) -> Closed {
        let labels = self.labels.iter().map(|&l| Some(RegionId(l))).collect();
        let segmentation = Segmentation { labels, primitives: self.primitives.clone() };
        close(&self.mesh, &segmentation, support, &tolerances(STEP * self.scale))
    }

    /// What the builder takes, nothing of it assumed.
    pub fn labelled(&self) -> LabelledMesh {
        LabelledMesh {
            mesh: self.mesh.clone(),
            labels: self.labels.iter().map(|&l| RegionId(l)).collect(),
            primitives: self.primitives.clone(),
            assumed: vec![false; self.labels.len()],
        }
    }
}

pub fn primitive(surface: Surface, outward: bool) -> Primitive {
    Primitive {
        surface: Some(surface),
        outward,
        residual: Residual::default(),
        covariance: Vec::new(),
        ambiguous: None,
    }
}

pub fn plane(point: Point3, normal: Vec3) -> Primitive {
    primitive(Surface::Plane(Plane { point, normal: UnitVec3::new_normalize(normal) }), true)
}

pub fn cylinder(direction: UnitVec3, radius: f64, outward: bool) -> Primitive {
    let axis = Axis { origin: Point3::origin(), direction };
    primitive(Surface::Cylinder(Cylinder { axis, radius }), outward)
}

pub fn tolerances(spacing: f64) -> Tolerances {
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

pub fn around(radius: f64) -> usize {
    (TAU * radius / STEP).round() as usize
}

/// A box from the origin to `size`; label 4 is below.
pub fn block(size: [f64; 3]) -> Part {
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
pub fn pipe(outer: f64, inner: f64, height: f64) -> Part {
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

/// A post about z with a bore through it: a wide foot below, a stem, a head as wide as nothing below it but the foot, each
/// `height` tall and in this order from z = 0. Walls 0 to 2, shoulder of the foot 3, underside of the head 4, top 5, bottom
/// 6, bore 7.
pub fn post([foot, stem, head]: [f64; 3], bore: f64, height: f64) -> Part {
    let mut part = Part::new();
    let n = around(foot);
    let nz = (height / STEP).round() as usize;
    let turned = |r: f64, u: f64, z: f64| Point3::new(r * (TAU * u).cos(), r * (TAU * u).sin(), z);
    for (label, radius) in [(0, foot), (1, stem), (2, head)] {
        let from = height * f64::from(label);
        part.grid(label, n, nz, |u, v| turned(radius, u, from + height * v));
        part.primitives.push(cylinder(Vec3::z_axis(), radius, true));
    }
    let rings = [
        (foot, stem, height, true),
        (stem, head, 2.0 * height, false),
        (head, bore, 3.0 * height, true),
        (bore, foot, 0.0, false),
    ];
    for (label, (from, to, z, up)) in (3..).zip(rings) {
        let nr = ((from - to).abs() / STEP).round() as usize;
        // Seen from above the turn runs to the right as the radius falls, from below as it grows.
        part.grid(label, n, nr, |u, v| turned(from + (to - from) * v, u, z));
        part.primitives.push(plane(Point3::new(0.0, 0.0, z), if up { Vec3::z() } else { -Vec3::z() }));
    }
    part.grid(7, n, 3 * nz, |u, v| turned(bore, -u, 3.0 * height * v));
    part.primitives.push(cylinder(Vec3::z_axis(), bore, false));
    part
}

/// A pipe about z with a groove round its wall, a tube open by a third of its turn: wall above 0, below 4, groove 5.
pub fn grooved_pipe(outer: f64, inner: f64, height: f64, tube: f64) -> Part {
    const OPEN: f64 = TAU / 6.0;
    let mut part = pipe(outer, inner, height).without(|label, _| label == 0);
    let n = around(outer);
    let rim = tube * OPEN.sin();
    let major_radius = outer - tube * OPEN.cos();
    let turned = |r: f64, u: f64, z: f64| Point3::new(r * (TAU * u).cos(), r * (TAU * u).sin(), z);
    let wall = 0.5 * height - rim;
    let n_wall = (wall / STEP).round() as usize;
    part.grid(4, n, n_wall, |u, v| turned(outer, u, wall * v - 0.5 * height));
    let swept = TAU - 2.0 * OPEN;
    part.grid(5, n, (swept * tube / STEP).round() as usize, |u, v| {
        let (sin, cos) = (TAU - OPEN - swept * v).sin_cos();
        turned(major_radius + tube * cos, u, tube * sin)
    });
    part.grid(0, n, n_wall, |u, v| turned(outer, u, rim + wall * v));
    let axis = Axis { origin: Point3::origin(), direction: Vec3::z_axis() };
    let groove = Torus { axis, major_radius, minor_radius: tube };
    part.primitives.extend([part.primitives[0].clone(), primitive(Surface::Torus(groove), false)]);
    part
}

/// A turned cap about z with all five types of surface: bottom 0, wall 1, fillet 2, rim 3, spherical dish 4, conical
/// bore 5.
pub fn cap() -> Part {
    let mut part = Part::new();
    let n = around(CAP_RADIUS);
    let arc = |r: f64, z: f64, radius: f64, from: f64, to: f64| {
        move |v: f64| {
            let (sin, cos) = (from + (to - from) * v).sin_cos();
            (r + radius * cos, z + radius * sin)
        }
    };
    let straight =
        |a: (f64, f64), b: (f64, f64)| move |v: f64| (a.0 + (b.0 - a.0) * v, a.1 + (b.1 - a.1) * v);
    // The dish runs from the rim, over the lowest quarter of its circle, to the bore.
    let [from, to] = [9.0_f64, 5.0].map(|r| -(r / DISH_RADIUS).acos());
    let bore_end = (5.0, DISH_HEIGHT + DISH_RADIUS * to.sin());
    let mut turn = |label: u32, n_steps: usize, at: &dyn Fn(f64) -> (f64, f64)| {
        part.grid(label, n, n_steps, |u, v| {
            let (r, z) = at(v);
            Point3::new(r * (TAU * u).cos(), r * (TAU * u).sin(), z)
        });
    };
    turn(0, 10, &straight((4.0, 0.0), (CAP_RADIUS, 0.0)));
    turn(1, 10, &straight((CAP_RADIUS, 0.0), (CAP_RADIUS, 10.0)));
    turn(2, 5, &arc(11.0, 10.0, 3.0, 0.0, FRAC_PI_2));
    turn(3, 2, &straight((11.0, 13.0), (9.0, 13.0)));
    turn(4, 5, &arc(0.0, DISH_HEIGHT, DISH_RADIUS, from, to));
    turn(5, 11, &straight(bore_end, (4.0, 0.0)));
    let axis = |z: f64| Axis { origin: Point3::new(0.0, 0.0, z), direction: Vec3::z_axis() };
    part.primitives = vec![
        plane(Point3::origin(), -Vec3::z()),
        cylinder(Vec3::z_axis(), CAP_RADIUS, true),
        primitive(Surface::Torus(Torus { axis: axis(10.0), major_radius: 11.0, minor_radius: 3.0 }), true),
        plane(Point3::new(0.0, 0.0, 13.0), Vec3::z()),
        primitive(Surface::Sphere(Sphere { center: axis(DISH_HEIGHT).origin, radius: DISH_RADIUS }), false),
        primitive(
            Surface::Cone(Cone { axis: axis(0.0), radius: 4.0, half_angle: (1.0 / bore_end.1).atan() }),
            false,
        ),
    ];
    part
}

/// A sleeve about z with a counterbore: lower end 0, wall 1, upper end 2, counterbore 3, step 4, bore 5.
pub fn counterbored(step: f64) -> Part {
    let mut part = Part::new();
    let inner = 8.0 - step;
    let n = around(14.0);
    let corners: [(f64, f64); 6] =
        [(inner, 0.0), (14.0, 0.0), (14.0, 12.0), (8.0, 12.0), (8.0, 6.0), (inner, 6.0)];
    for (label, (r, z)) in corners.into_iter().enumerate() {
        let (next_r, next_z) = corners[(label + 1) % corners.len()];
        let n_steps = ((next_r - r).hypot(next_z - z) / STEP).round().max(2.0) as usize;
        part.grid(label as u32, n, n_steps, |u, v| {
            let r = r + (next_r - r) * v;
            Point3::new(r * (TAU * u).cos(), r * (TAU * u).sin(), z + (next_z - z) * v)
        });
    }
    let level = |z: f64, up: f64| plane(Point3::new(0.0, 0.0, z), Vec3::z() * up);
    let round = |radius: f64, outward: bool| cylinder(Vec3::z_axis(), radius, outward);
    part.primitives = vec![
        level(0.0, -1.0),
        round(14.0, true),
        level(12.0, 1.0),
        round(8.0, false),
        level(6.0, 1.0),
        round(inner, false),
    ];
    part
}

/// A rod about z with a conical dent: wall 0, upper end 1, dent 2 down to its apex, lower end 3.
pub fn dented() -> Part {
    let mut part = Part::new();
    let n = around(10.0);
    let corners: [(f64, f64); 4] = [(10.0, 0.0), (10.0, 12.0), (6.0, 12.0), (0.5, 6.5)];
    for (label, pair) in corners.windows(2).enumerate() {
        let [(r, z), (next_r, next_z)] = [pair[0], pair[1]];
        let n_steps = ((next_r - r).hypot(next_z - z) / STEP).round() as usize;
        part.grid(label as u32, n, n_steps, |u, v| {
            let r = r + (next_r - r) * v;
            Point3::new(r * (TAU * u).cos(), r * (TAU * u).sin(), z + (next_z - z) * v)
        });
    }
    let apex = part.vertex(Point3::new(0.0, 0.0, 6.0));
    for i in 0..n {
        let [a, b] = [i, i + 1].map(|i| {
            let (sin, cos) = (TAU * i as f64 / n as f64).sin_cos();
            part.vertex(Point3::new(0.5 * cos, 0.5 * sin, 6.5))
        });
        part.mesh.triangles.push([a, b, apex]);
        part.labels.push(2);
    }
    let axis = Axis { origin: Point3::new(0.0, 0.0, 12.0), direction: Vec3::z_axis() };
    part.primitives = vec![
        cylinder(Vec3::z_axis(), 10.0, true),
        plane(Point3::new(0.0, 0.0, 12.0), Vec3::z()),
        primitive(Surface::Cone(Cone { axis, radius: 6.0, half_angle: FRAC_PI_4 }), false),
    ];
    part.with_disc(10.0, 0.0)
}

/// Radius of `cap`.
const CAP_RADIUS: f64 = 14.0;
/// Centre height and radius of the dish in `cap`: through the inner rim at radius 9 and height 13.
const DISH_HEIGHT: f64 = 25.0;
const DISH_RADIUS: f64 = 15.0;

/// A cube about the origin with bores from above (label 6) and from +x (label 7), each seen down to `seen` only.
pub fn block_with_two_bores(half: f64, radius: f64, seen: f64) -> Part {
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
