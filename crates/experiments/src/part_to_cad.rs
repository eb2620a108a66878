//! Part-to-CAD on the example scan, held against the drawing it was made from; our default in the same table.

use std::path::Path;

use scanwright::io;
use scanwright::math::{Axis, Point3, UnitVec3, Vec3, angle_between};
use scanwright::pipeline::{self, Options, Reconstruction};
use scanwright::progress::Progress;
use scanwright::recognize::Primitive;
use scanwright::recognize::gauss::Classifier;
use scanwright::surface::{Cone, Cylinder, Plane, Surface};

use crate::Context;
use crate::table::Table;

/// A face of the drawing.
struct Drawn {
    name: &'static str,
    surface: Surface,
}

/// The faces of `examples/bushing.ply` that are wide enough to be seen, millimetres.
fn bushing() -> Vec<Drawn> {
    let axis = |origin: [f64; 3], direction: Vec3| Axis {
        origin: Point3::from(origin),
        direction: UnitVec3::new_normalize(direction),
    };
    let plane =
        |height: f64| Surface::Plane(Plane { point: Point3::new(0.0, 0.0, height), normal: Vec3::z_axis() });
    let along = axis([0.0; 3], Vec3::z());
    let across = axis([0.0, 0.0, 23.333_836], Vec3::y());
    let cylinder = |axis, radius| Surface::Cylinder(Cylinder { axis, radius });
    let chamfer = Cone {
        axis: axis([0.0, 0.0, 37.9], -Vec3::z()),
        radius: 50.889_814 - 37.9,
        half_angle: std::f64::consts::FRAC_PI_4,
    };
    let face = |name, surface| Drawn { name, surface };
    vec![
        face("foot", plane(0.0)),
        face("flange, top", plane(5.905_433)),
        face("rim", plane(38.889_727)),
        face("body", cylinder(along, 13.900_556)),
        face("flange", cylinder(along, 20.599_326)),
        face("bore", cylinder(along, 8.679_162)),
        face("cross hole", cylinder(across, 2.860_761)),
        face("chamfer", Surface::Cone(chamfer)),
    ]
}

/// What both paths say of every face of the example: type, error of its size, tilt.
pub fn part_to_cad(context: &Context) -> anyhow::Result<Table> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let scan = io::read_mesh_file(&root.join("examples/bushing.ply"))?;
    let text = std::fs::read_to_string(root.join("crates/scanwright-cli/models/faithful.svm"))?;
    let classifier = Classifier::from_text(&text)?;
    let (options, progress) = (Options::default(), Progress::none());
    let thesis = pipeline::run_thesis(&scan.mesh, &options, &classifier, &progress)?;
    let ours = pipeline::run(&scan.mesh, &options, &progress)?;
    let mut table = Table::new(&[
        "face",
        "type",
        "size",
        "Part-to-CAD: type",
        "error of size",
        "tilt",
        "ours: type",
        "error of size",
        "tilt",
    ]);
    for drawn in bushing() {
        let mut row =
            vec![drawn.name.to_owned(), drawn.surface.kind().name().to_owned(), size_text(&drawn.surface)];
        for result in [&thesis, &ours] {
            let found = found(result, &drawn.surface).and_then(|primitive| primitive.surface);
            row.extend(found.map_or(["none".into(), "-".into(), "-".into()], |found| {
                let kind = found.kind().name().to_owned();
                [kind, error_text(&drawn.surface, &found), tilt_text(&drawn.surface, &found)]
            }));
        }
        table.row(row);
    }
    table.write(&context.output, "part-to-cad")?;
    Ok(table)
}

/// The primitive with most triangles on a surface.
fn found<'a>(result: &'a Reconstruction, surface: &Surface) -> Option<&'a Primitive> {
    /// Deviations of the noise, and cosine to its normal, within which a triangle is on a surface.
    const NEAR: f64 = 3.0;
    const ALIGNED: f64 = 0.9;
    let mut counts = vec![0_usize; result.segmentation.primitives.len()];
    for (t, label) in result.segmentation.labels.iter().enumerate() {
        let center = result.mesh.triangle_center(t);
        let is_near = surface.signed_distance(&center).abs() < NEAR * result.measured.noise;
        let normal = result.mesh.cross(t).try_normalize(0.0).unwrap_or_default();
        if let Some(region) = label
            && is_near
            && surface.normal(&center).dot(&normal).abs() > ALIGNED
        {
            counts[region.0 as usize] += 1;
        }
    }
    let best = (0..counts.len()).max_by_key(|&k| (counts[k], std::cmp::Reverse(k)))?;
    (counts[best] > 0).then(|| &result.segmentation.primitives[best])
}

/// Radius, or half-angle of a cone.
fn size(surface: &Surface) -> Option<f64> {
    match surface {
        Surface::Cylinder(s) => Some(s.radius),
        Surface::Cone(s) => Some(s.half_angle),
        Surface::Plane(_) | Surface::Sphere(_) | Surface::Torus(_) => None,
    }
}

fn size_text(surface: &Surface) -> String {
    match surface {
        Surface::Cone(s) => format!("half-angle {:.0} degrees", s.half_angle.to_degrees()),
        other => size(other).map_or_else(String::new, |r| format!("radius {r:.3} mm")),
    }
}

/// Of planes, how far the found one is from the point of the true one.
fn error_text(truth: &Surface, found: &Surface) -> String {
    match (truth, found) {
        (Surface::Plane(t), Surface::Plane(_)) => format!("{:+.3} mm", found.signed_distance(&t.point)),
        (Surface::Cone(t), Surface::Cone(f)) => {
            format!("{:+.2} degrees", (f.half_angle - t.half_angle).to_degrees())
        }
        (Surface::Cylinder(t), Surface::Cylinder(f)) => format!("{:+.3} mm", f.radius - t.radius),
        _ => "-".to_owned(),
    }
}

/// Angle between the axes, or between the normals of planes.
fn tilt_text(truth: &Surface, found: &Surface) -> String {
    let direction = |s: &Surface| match s {
        Surface::Plane(p) => Some(p.normal),
        other => other.axis().map(|axis| axis.direction),
    };
    if truth.kind() != found.kind() {
        return "-".to_owned();
    }
    direction(truth).zip(direction(found)).map_or_else(
        || "-".to_owned(),
        |(a, b)| {
            let angle = angle_between(&a, &b);
            format!("{:.2} degrees", angle.min(std::f64::consts::PI - angle).to_degrees())
        },
    )
}
