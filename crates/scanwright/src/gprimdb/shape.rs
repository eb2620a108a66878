//! Bounded surfaces: the five types with their complete and partial domains, and surfaces that are none of them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use serde::{Deserialize, Serialize};

use super::manifest::Ranges;
use crate::math::{Axis, Point3, Vec3};
use crate::random::Rng;
use crate::surface::samples::point_at;
use crate::surface::{Cone, Cylinder, Plane, Sphere, Surface, SurfaceKind, Torus};

/// What a model is an example of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// A plane.
    Plane,
    /// A cylinder.
    Cylinder,
    /// A cone.
    Cone,
    /// A sphere.
    Sphere,
    /// A torus.
    Torus,
    /// None of the five: an ellipsoid of three different axes.
    Ellipsoid,
    /// None of the five: a hyperbolic paraboloid.
    Saddle,
    /// None of the five: a helicoid.
    Helicoid,
    /// None of the five: a tube whose radius grows along an arc, as a blend of varying radius does.
    Horn,
    /// None of the five: a gently waved sheet.
    Wave,
}

impl Class {
    /// The five types, in the order of [`SurfaceKind::ALL`].
    pub const PRIMITIVES: [Self; 5] = [Self::Plane, Self::Cylinder, Self::Cone, Self::Sphere, Self::Torus];
    /// What is none of them.
    pub const OTHERS: [Self; 5] = [Self::Ellipsoid, Self::Saddle, Self::Helicoid, Self::Horn, Self::Wave];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ellipsoid => "ellipsoid",
            Self::Saddle => "saddle",
            Self::Helicoid => "helicoid",
            Self::Horn => "horn",
            Self::Wave => "wave",
            primitive => primitive.kind().map_or("", SurfaceKind::name),
        }
    }

    /// The type of its surface; `None` for what is none of the five.
    pub fn kind(self) -> Option<SurfaceKind> {
        let place = Self::PRIMITIVES.iter().position(|class| *class == self)?;
        Some(SurfaceKind::ALL[place])
    }

    /// Names of the parameters that do not change when a model is moved: radii, and of a cone, whose radius is another at
    /// every height, the half-angle.
    pub fn sizes(self) -> &'static [&'static str] {
        match self {
            Self::Cylinder | Self::Sphere => &["radius"],
            Self::Cone => &["half_angle"],
            Self::Torus => &["major_radius", "minor_radius"],
            _ => &[],
        }
    }
}

/// A surface over a domain of rows: `v` runs across the rows, `u` along them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// What it is an example of.
    pub class: Class,
    /// Its geometry.
    pub geometry: Geometry,
    /// Range of `u`; the whole turn is closed where `wraps` says so.
    pub u: [f64; 2],
    /// Range of `v`.
    pub v: [f64; 2],
    /// Whether rows are closed, and whether the last row is the first.
    pub wraps: [bool; 2],
    /// Share of the complete surface that the domain covers; one for planes and what is none of the five.
    pub coverage: f64,
}

/// How `(u, v)` become a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Geometry {
    /// By the natural coordinates of a surface.
    Natural(Surface),
    /// A plane's disc or ring: `u` is the angle, `v` the radius.
    Disc(Plane),
    /// A cylinder cut obliquely: `v` from 0 to 1, the height at angle `u` being `height + slant * radius * cos u`.
    Oblique(Cylinder, f64, f64),
    /// None of the five, with its three sizes.
    Other(Class, [f64; 3]),
}

fn z_axis() -> Axis {
    Axis { origin: Point3::origin(), direction: Vec3::z_axis() }
}

impl Shape {
    /// Draws a shape about the origin and the z axis.
    pub fn draw(class: Class, partial: bool, ranges: &Ranges, rng: &mut Rng) -> Self {
        match class {
            Class::Plane => plane(ranges, rng),
            Class::Cylinder => cylinder(partial, ranges, rng),
            Class::Cone => cone(partial, ranges, rng),
            Class::Sphere => sphere(partial, ranges, rng),
            Class::Torus => torus(partial, ranges, rng),
            other => self::other(other, rng),
        }
    }

    /// The point at natural coordinates.
    pub fn point(&self, u: f64, v: f64) -> Point3 {
        match self.geometry {
            Geometry::Natural(surface) => point_at(&surface, u, v),
            Geometry::Disc(plane) => point_at(&Surface::Plane(plane), v * u.cos(), v * u.sin()),
            Geometry::Oblique(cylinder, height, slant) => {
                let top = height + slant * cylinder.radius * u.cos();
                point_at(&Surface::Cylinder(cylinder), u, v * top)
            }
            Geometry::Other(class, size) => other_point(class, size, u, v),
        }
    }

    /// Normal at natural coordinates: across both of its tangents, as the triangles are oriented.
    pub fn normal(&self, u: f64, v: f64) -> Vec3 {
        if let Some(surface) = self.surface() {
            return surface.normal(&self.point(u, v)).into_inner();
        }
        /// Of the domain, for central differences: truncation and rounding leave nine digits of a direction.
        const STEP: f64 = 1e-6;
        let (du, dv) = (STEP * (self.u[1] - self.u[0]), STEP * (self.v[1] - self.v[0]));
        let along = self.point(u + du, v) - self.point(u - du, v);
        let across = self.point(u, v + dv) - self.point(u, v - dv);
        along.cross(&across).try_normalize(0.0).unwrap_or_else(Vec3::z)
    }

    /// The analytic surface; `None` for what is none of the five.
    pub fn surface(&self) -> Option<Surface> {
        match self.geometry {
            Geometry::Natural(surface) => Some(surface),
            Geometry::Disc(plane) => Some(Surface::Plane(plane)),
            Geometry::Oblique(cylinder, ..) => Some(Surface::Cylinder(cylinder)),
            Geometry::Other(..) => None,
        }
    }

    /// Area: exact for the five types, by a fine grid for the others.
    pub fn area(&self) -> f64 {
        let [u0, u1] = self.u;
        let [v0, v1] = self.v;
        let sweep = u1 - u0;
        match self.geometry {
            Geometry::Natural(Surface::Plane(_)) => sweep * (v1 - v0),
            Geometry::Natural(Surface::Cylinder(s)) => s.radius * sweep * (v1 - v0),
            Geometry::Natural(Surface::Cone(s)) => {
                let mean_radius = s.radius + 0.5 * (v0 + v1) * s.half_angle.tan();
                mean_radius * sweep * (v1 - v0) / s.half_angle.cos()
            }
            Geometry::Natural(Surface::Sphere(s)) => s.radius * s.radius * sweep * (v1.sin() - v0.sin()),
            Geometry::Natural(Surface::Torus(s)) => {
                let spine = s.major_radius * (v1 - v0) + s.minor_radius * (v1.sin() - v0.sin());
                s.minor_radius * sweep * spine
            }
            Geometry::Disc(_) => 0.5 * sweep * (v1 * v1 - v0 * v0),
            Geometry::Oblique(s, height, slant) => {
                s.radius * (height * sweep + slant * s.radius * (u1.sin() - u0.sin()))
            }
            Geometry::Other(..) => self.area_by_grid(),
        }
    }

    fn area_by_grid(&self) -> f64 {
        const N: usize = 100;
        let at = |i: usize, j: usize| {
            let share = |range: [f64; 2], k: usize| range[0] + (range[1] - range[0]) * k as f64 / N as f64;
            self.point(share(self.u, i), share(self.v, j))
        };
        let cell = |i: usize, j: usize| {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            0.5 * (c - a).cross(&(d - b)).norm()
        };
        (0..N).flat_map(|i| (0..N).map(move |j| (i, j))).map(|(i, j)| cell(i, j)).sum()
    }
}

fn log_uniform(rng: &mut Rng, [low, high]: [f64; 2]) -> f64 {
    low * (high / low).powf(rng.uniform())
}

fn uniform(rng: &mut Rng, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * rng.uniform()
}

fn angle(rng: &mut Rng, [low, high]: [f64; 2]) -> f64 {
    uniform(rng, [low, high]).to_radians()
}

/// A whole turn, or a part of it that starts anywhere: its range, and whether it is whole.
fn turn(partial: bool, sweep_deg: [f64; 2], rng: &mut Rng) -> ([f64; 2], bool) {
    if !partial {
        return ([0.0, TAU], true);
    }
    let start = TAU * rng.uniform();
    let sweep = angle(rng, sweep_deg);
    if sweep >= TAU { ([0.0, TAU], true) } else { ([start, start + sweep], false) }
}

/// A rectangle, a disc, or a disc with a hole.
fn plane(ranges: &Ranges, rng: &mut Rng) -> Shape {
    let plane = Plane { point: Point3::origin(), normal: Vec3::z_axis() };
    let width = log_uniform(rng, ranges.plane_width);
    let outline = rng.below(3);
    let (geometry, u, v, wraps) = if outline == 0 {
        let length = width * log_uniform(rng, ranges.plane_aspect);
        let centered = |size: f64| [-0.5 * size, 0.5 * size];
        (Geometry::Natural(Surface::Plane(plane)), centered(length), centered(width), [false, false])
    } else {
        let radius = 0.5 * width;
        let hole = if outline == 1 { 0.0 } else { radius * uniform(rng, [0.1, 0.8]) };
        (Geometry::Disc(plane), [0.0, TAU], [hole, radius], [true, false])
    };
    Shape { class: Class::Plane, geometry, u, v, wraps, coverage: 1.0 }
}

/// A whole turn; partial: a part of it, or cut obliquely at one end.
fn cylinder(partial: bool, ranges: &Ranges, rng: &mut Rng) -> Shape {
    let radius = log_uniform(rng, ranges.radius);
    let height = radius * log_uniform(rng, ranges.cylinder_height);
    let cylinder = Cylinder { axis: z_axis(), radius };
    let oblique = partial && rng.below(2) == 0;
    let (u, whole) = turn(partial && !oblique, ranges.sweep_deg, rng);
    if oblique {
        // The cut may reach down to a fifth of the height.
        let slant = 0.8 * height / radius * rng.uniform();
        let geometry = Geometry::Oblique(cylinder, height, slant);
        return Shape {
            class: Class::Cylinder,
            geometry,
            u,
            v: [0.0, 1.0],
            wraps: [true, false],
            coverage: 1.0,
        };
    }
    let geometry = Geometry::Natural(Surface::Cylinder(cylinder));
    let coverage = (u[1] - u[0]) / TAU;
    Shape { class: Class::Cylinder, geometry, u, v: [0.0, height], wraps: [whole, false], coverage }
}

/// From the base towards the tip; partial: a part of the turn.
fn cone(partial: bool, ranges: &Ranges, rng: &mut Rng) -> Shape {
    let base = log_uniform(rng, ranges.radius);
    let half_angle = angle(rng, ranges.half_angle_deg);
    let height = base / half_angle.tan();
    // A slender cone is cut so that it is no longer than a slender cylinder.
    let longest = ranges.cylinder_height[1] * base;
    let kept = (height * (1.0 - uniform(rng, ranges.truncation))).min(longest);
    let (u, whole) = turn(partial, ranges.sweep_deg, rng);
    // The radius grows along the axis: the tip is below.
    let cone = Cone { axis: z_axis(), radius: base, half_angle };
    let coverage = (u[1] - u[0]) / TAU;
    let geometry = Geometry::Natural(Surface::Cone(cone));
    Shape { class: Class::Cone, geometry, u, v: [-kept, 0.0], wraps: [whole, false], coverage }
}

/// The whole sphere; partial: a cap, a wedge, an octant or a zone.
fn sphere(partial: bool, ranges: &Ranges, rng: &mut Rng) -> Shape {
    let radius = log_uniform(rng, ranges.radius);
    let sphere = Sphere { center: Point3::origin(), radius };
    let part = if partial { rng.below(4) } else { 4 };
    let (u, v, whole) = match part {
        0 => ([0.0, TAU], [FRAC_PI_2 - angle(rng, ranges.cap_deg), FRAC_PI_2], true),
        1 => ([0.0, angle(rng, [30.0, 330.0])], [-FRAC_PI_2, FRAC_PI_2], false),
        2 => ([0.0, FRAC_PI_2], [0.0, FRAC_PI_2], false),
        3 => {
            let low = angle(rng, [-70.0, 40.0]);
            ([0.0, TAU], [low, low + angle(rng, [15.0, 40.0])], true)
        }
        _ => ([0.0, TAU], [-FRAC_PI_2, FRAC_PI_2], true),
    };
    let coverage = (u[1] - u[0]) * (v[1].sin() - v[0].sin()) / (2.0 * TAU);
    let geometry = Geometry::Natural(Surface::Sphere(sphere));
    Shape { class: Class::Sphere, geometry, u, v, wraps: [whole, false], coverage }
}

/// The whole ring; partial: a part of the turn, of the tube (its outer or inner half, a quarter as fillets have, any), or of
/// both.
fn torus(partial: bool, ranges: &Ranges, rng: &mut Rng) -> Shape {
    let minor_radius = log_uniform(rng, ranges.minor_radius);
    let major_radius = minor_radius * log_uniform(rng, ranges.torus_ratio);
    let torus = Torus { axis: z_axis(), major_radius, minor_radius };
    let part = if partial { rng.below(3) } else { 3 };
    let (u, whole) = turn(part == 0 || part == 2, ranges.sweep_deg, rng);
    let (v, tube) = if part == 1 || part == 2 { tube_arc(ranges, rng) } else { ([0.0, TAU], true) };
    let shape = Shape {
        class: Class::Torus,
        geometry: Geometry::Natural(Surface::Torus(torus)),
        u,
        v,
        wraps: [whole, tube],
        coverage: 1.0,
    };
    Shape { coverage: shape.area() / (TAU * TAU * minor_radius * major_radius), ..shape }
}

/// Part of a torus's tube, and whether it is all of it.
fn tube_arc(ranges: &Ranges, rng: &mut Rng) -> ([f64; 2], bool) {
    let arc = angle(rng, ranges.tube_arc_deg);
    let any = TAU * rng.uniform();
    match rng.below(4) {
        0 => ([-FRAC_PI_2, FRAC_PI_2], false),
        1 => ([FRAC_PI_2, FRAC_PI_2 + PI], false),
        2 => ([PI, PI + FRAC_PI_2], false),
        _ if arc < TAU => ([any, any + arc], false),
        _ => ([0.0, TAU], true),
    }
}

fn other(class: Class, rng: &mut Rng) -> Shape {
    let size = log_uniform(rng, [5.0, 100.0]);
    let ratios = [uniform(rng, [0.35, 0.75]), uniform(rng, [0.35, 0.75])];
    let (sizes, u, v, wraps) = match class {
        // Three different half-axes.
        Class::Ellipsoid => {
            let half_axes = [size, size * ratios[0], size * ratios[0] * ratios[1]];
            (half_axes, [0.0, TAU], [-FRAC_PI_2, FRAC_PI_2], [true, false])
        }
        // Side and the heights of the two parabolas.
        Class::Saddle => {
            ([size, size * ratios[0], -size * ratios[1]], [-0.5, 0.5], [-0.5, 0.5], [false, false])
        }
        // Outer radius, inner radius, pitch.
        Class::Helicoid => {
            let turns = uniform(rng, [0.5, 1.5]);
            ([size, 0.3 * size, size * 2.0 * ratios[0]], [0.0, TAU * turns], [0.0, 1.0], [false, false])
        }
        // Radius of the spine, and of the tube at its two ends.
        Class::Horn => {
            let arc = angle(rng, [60.0, 270.0]);
            ([size, 0.12 * size, 0.4 * size * ratios[0] + 0.2 * size], [0.0, TAU], [0.0, arc], [true, false])
        }
        // Side, height and number of waves.
        _ => (
            [size, 0.15 * size * ratios[0], uniform(rng, [1.0, 2.0])],
            [-0.5, 0.5],
            [-0.5, 0.5],
            [false, false],
        ),
    };
    Shape { class, geometry: Geometry::Other(class, sizes), u, v, wraps, coverage: 1.0 }
}

fn other_point(class: Class, [a, b, c]: [f64; 3], u: f64, v: f64) -> Point3 {
    let (sin, cos) = u.sin_cos();
    match class {
        Class::Ellipsoid => Point3::new(a * cos * v.cos(), b * sin * v.cos(), c * v.sin()),
        Class::Saddle => Point3::new(a * u, a * v, b * u * u + c * v * v),
        Class::Helicoid => {
            let radius = b + (a - b) * v;
            Point3::new(radius * cos, radius * sin, c * u / TAU)
        }
        Class::Horn => {
            // `v` is the angle along the spine, over which the tube grows by its share of a half turn.
            let tube = b + (c - b) * v / PI;
            let radius = a + tube * cos;
            Point3::new(radius * v.cos(), radius * v.sin(), tube * sin)
        }
        _ => Point3::new(a * u, a * v, b * (TAU * c * u).sin() * (TAU * c * v).cos()),
    }
}
