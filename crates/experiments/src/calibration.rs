//! Whether stated uncertainties are the errors that are made, over many draws of noise.

use std::f64::consts::TAU;

use scanwright::fit::{Fit, Noise, Samples, Weights, parameter_names, refine};
use scanwright::math::{Axis, Point3, Vec3};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::par;
use scanwright::random::Rng;
use scanwright::recognize::Primitive;
use scanwright::segment::{RegionId, Segmentation};
use scanwright::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};
use scanwright::tolerance::{Measured, Tolerances};
use scanwright::uncertainty::{self, Interior};

use crate::Context;
use crate::table::Table;

/// Draws of noise in each cell: a standard deviation is known within 3 %, a coverage of 95 % within 1 %.
const N_DRAWS: u64 = 500;
const SEED: u64 = 2026;
/// Turns that are seen, degrees.
const ARCS: [f64; 3] = [330.0, 180.0, 90.0];
/// Standard deviation of the noise, in vertex spacings.
const LEVEL: f64 = 0.1;
/// Distance over which correlated noise is shared, in vertex spacings.
const LENGTH: f64 = 8.0;
/// Steps of a fit, which starts at the truth.
const STEPS: usize = 12;
/// Standard uncertainties of a 95 % interval.
const WIDE: f64 = 1.96;

/// Each error over its stated uncertainty: standard deviation, and how many 95 % intervals hold the truth.
///
/// One face of each type, its vertices one length apart, beside a plane of 40 by 40 that the noise is measured on together
/// with it; white noise, correlated noise, and both in equal parts.
pub fn calibration(context: &Context) -> anyhow::Result<Table> {
    let mut table = Table::new(&["face", "arc, degrees", "noise", "size", "deviation", "within 95 %, %"]);
    for (name, white, correlated) in
        [("white", LEVEL, 0.0), ("correlated", 0.0, LEVEL), ("both", LEVEL, LEVEL)]
    {
        let noise = Noise { white, correlated, length: LENGTH };
        for (face, arc) in faces() {
            let draws = par::map_indices(N_DRAWS as usize, |draw| drawn(&face, &noise, draw as u64));
            for (i, size) in sizes(&face.surface).iter().enumerate() {
                let of_size: Vec<f64> = draws.iter().flatten().map(|of_draw| of_draw[i]).collect();
                let n = of_size.len() as f64;
                let deviation = (of_size.iter().map(|z| z * z).sum::<f64>() / n).sqrt();
                let within = of_size.iter().filter(|z| z.abs() <= WIDE).count() as f64 / n;
                table.row(vec![
                    face.surface.kind().name().to_owned(),
                    arc.map_or_else(|| "-".to_owned(), |arc| format!("{arc:.0}")),
                    name.to_owned(),
                    size.replace('_', " "),
                    format!("{deviation:.2}"),
                    format!("{:.1}", 100.0 * within),
                ]);
            }
        }
    }
    table.write(&context.output, "calibration")?;
    Ok(table)
}

/// Sizes that are judged: of a plane its place.
fn sizes(surface: &Surface) -> &'static [&'static str] {
    match surface {
        Surface::Plane(_) => &["offset"],
        Surface::Cylinder(_) | Surface::Sphere(_) => &["radius"],
        Surface::Cone(_) => &["half_angle"],
        Surface::Torus(_) => &["major_radius", "minor_radius"],
    }
}

/// A grid of points of a surface.
struct Face {
    surface: Surface,
    points: Vec<Point3>,
    n_rows: usize,
}

impl Face {
    /// `across` and `along`: largest lengths in the two directions, one vertex per length; `at` of shares of both.
    fn new(surface: Surface, [across, along]: [f64; 2], at: impl Fn(f64, f64) -> Point3) -> Self {
        let (n, m) = (across as usize, along as usize);
        let share = |i: usize, n: usize| i as f64 / n as f64;
        let places = (0..=n).flat_map(|i| (0..=m).map(move |j| (i, j)));
        let points = places.map(|(i, j)| at(share(i, n), share(j, m))).collect();
        Self { surface, points, n_rows: m + 1 }
    }

    fn triangles(&self, first: u32) -> Vec<[u32; 3]> {
        let m = self.n_rows as u32;
        let n = self.points.len() as u32 / m;
        let corners = (1..n).flat_map(|i| (1..m).map(move |j| first + i * m + j));
        corners.flat_map(|v| [[v, v - m, v - m - 1], [v, v - m - 1, v - 1]]).collect()
    }
}

/// The faces that are drawn, with their arcs.
fn faces() -> Vec<(Face, Option<f64>)> {
    const R: f64 = 20.0;
    const TUBE: f64 = 8.0;
    const SLOPE: f64 = 0.35;
    let axis = Axis { origin: Point3::origin(), direction: Vec3::z_axis() };
    let mut faces = vec![(plane(Point3::origin(), [40.0, 30.0]), None)];
    for degrees in ARCS {
        let arc = degrees / 360.0 * TAU;
        let round = move |share: f64, radius: f64, height: f64| {
            let (sin, cos) = (arc * share).sin_cos();
            Point3::new(radius * cos, radius * sin, height)
        };
        let cylinder = Surface::Cylinder(Cylinder { axis, radius: R });
        let cone = Surface::Cone(Cone { axis, radius: R, half_angle: SLOPE });
        let sphere = Surface::Sphere(Sphere { center: axis.origin, radius: R });
        let torus = Surface::Torus(Torus { axis, major_radius: R, minor_radius: TUBE });
        let size = [arc * R, 30.0];
        let of_arc = [
            Face::new(cylinder, size, |u, v| round(u, R, 30.0 * v - 15.0)),
            Face::new(cone, size, |u, v| {
                let along = 30.0 * v - 15.0;
                round(u, R + along * SLOPE.sin(), along * SLOPE.cos())
            }),
            Face::new(sphere, size, |u, v| {
                let (sin, cos) = (1.5 * (v - 0.5)).sin_cos();
                round(u, R * cos, R * sin)
            }),
            Face::new(torus, [arc * (R + 0.5 * TUBE), 0.5 * TAU * TUBE], |u, v| {
                let (sin, cos) = (0.5 * TAU * (v - 0.5)).sin_cos();
                round(u, R + TUBE * cos, TUBE * sin)
            }),
        ];
        faces.extend(of_arc.into_iter().map(|face| (face, Some(degrees))));
    }
    faces
}

fn plane(corner: Point3, [x, y]: [f64; 2]) -> Face {
    let surface = Surface::Plane(Plane { point: corner, normal: Vec3::z_axis() });
    Face::new(surface, [x, y], |u, v| corner + Vec3::new(x * u, y * v, 0.0))
}

/// Errors of the sizes of `face` over their stated uncertainties in one draw of noise; `None` where no fit was found.
fn drawn(face: &Face, noise: &Noise, draw: u64) -> Option<Vec<f64>> {
    let mut rng = Rng::for_task(SEED, "calibration", draw);
    let beside = plane(Point3::new(100.0, 0.0, 0.0), [40.0, 40.0]);
    let mut mesh = Mesh::default();
    let mut labels = Vec::new();
    for (k, face) in [face, &beside].into_iter().enumerate() {
        let first = mesh.vertices.len() as u32;
        mesh.triangles.extend(face.triangles(first));
        labels.resize(mesh.triangles.len(), Some(RegionId(k as u32)));
        let field = Field::new(noise, &mut rng);
        let moved = face
            .points
            .iter()
            .map(|p| p + face.surface.normal(p).into_inner() * (field.at(p) + noise.white * rng.normal()));
        mesh.vertices.extend(moved.collect::<Vec<_>>());
    }
    let adjacency = Adjacency::new(&mesh);
    let tolerances = tolerances(&mesh, noise);
    let mut segmentation = Segmentation { labels, primitives: vec![Primitive::freeform(); 2] };
    let interior = Interior::new(&mesh, &adjacency, &segmentation, &tolerances);
    let normals = mesh.vertex_normals();
    for (k, face) in [face, &beside].into_iter().enumerate() {
        let core = interior.core(k);
        let samples = Samples {
            points: core.iter().map(|&v| mesh.vertices[v as usize]).collect(),
            normals: core.iter().map(|&v| normals[v as usize]).collect(),
        };
        let weights = Weights { distance_sigma: noise.sigma(), normal_sigma: 1.0, normal_weight: 0.0 };
        let start = Fit { surface: face.surface, outward: true };
        segmentation.primitives[k].surface = Some(refine(&start, &samples, &weights, STEPS)?.surface);
    }
    let measured = uncertainty::measure(&mesh, &adjacency, &interior, &segmentation, &tolerances);
    let stated = uncertainty::stated(&mesh, &interior, &segmentation, &measured, &tolerances);
    let primitive = &stated.primitives[0];
    let surface = primitive.surface.as_ref()?;
    let names = parameter_names(surface);
    let z = |size: &&str| {
        let place = names.iter().position(|name| name == size)?;
        Some(
            error(&face.surface, surface, size, &face.points)?
                / primitive.covariance.get(place)?[place].sqrt(),
        )
    };
    sizes(surface).iter().map(z).collect()
}

fn error(truth: &Surface, found: &Surface, size: &str, points: &[Point3]) -> Option<f64> {
    match (truth, found, size) {
        (Surface::Plane(_), Surface::Plane(found), _) => {
            Some(found.signed_distance(&scanwright::math::centroid(points)))
        }
        (Surface::Cylinder(a), Surface::Cylinder(b), _) => Some(b.radius - a.radius),
        (Surface::Sphere(a), Surface::Sphere(b), _) => Some(b.radius - a.radius),
        (Surface::Cone(a), Surface::Cone(b), _) => Some(b.half_angle - a.half_angle),
        (Surface::Torus(a), Surface::Torus(b), "major_radius") => Some(b.major_radius - a.major_radius),
        (Surface::Torus(a), Surface::Torus(b), _) => Some(b.minor_radius - a.minor_radius),
        _ => None,
    }
}

fn tolerances(mesh: &Mesh, noise: &Noise) -> Tolerances {
    let measured = Measured {
        largest_coordinate: mesh.largest_coordinate(),
        diagonal: mesh.diagonal(),
        spacing: 1.0,
        noise: noise.white,
        normal_noise: noise.white,
        // A spot so small that what is not known of it is nothing beside the noise.
        edge_rounding: 1e-3,
    };
    Tolerances::new(measured, None)
}

/// A random field of normal values with the covariance `s^2 exp(-(d / length)^2)`: a sum of waves whose directions and
/// lengths are drawn from its spectrum (M. Shinozuka, C.-M. Jan, "Digital simulation of random processes and its
/// applications", Journal of Sound and Vibration 25 (1972), 111-128).
struct Field {
    waves: Vec<(Vec3, f64)>,
    amplitude: f64,
}

impl Field {
    fn new(noise: &Noise, rng: &mut Rng) -> Self {
        /// Waves: the field is normal to within what 500 draws can show.
        const N: usize = 60;
        let per_length = std::f64::consts::SQRT_2 / noise.length;
        let mut wave = || {
            let direction = Vec3::new(rng.normal(), rng.normal(), rng.normal());
            (direction * per_length, TAU * rng.uniform())
        };
        let waves = if noise.correlated > 0.0 { (0..N).map(|_| wave()).collect() } else { Vec::new() };
        Self { waves, amplitude: noise.correlated * (2.0 / N as f64).sqrt() }
    }

    fn at(&self, point: &Point3) -> f64 {
        self.amplitude * self.waves.iter().map(|(k, phase)| (k.dot(&point.coords) + phase).cos()).sum::<f64>()
    }
}
