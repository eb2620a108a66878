//! The Gaussian sphere of one complete and one partial model of each type.

use scanwright::gprimdb::{Class, Model, Triangulation};
use scanwright::math::{Frame, Point3, UnitVec3, Vec3};
use scanwright::random::Rng;
use scanwright::recognize::gauss::{Accumulator, Cells, GaussImage, N_CELLS, Rules, Voting};

use crate::Context;
use crate::models::{all, faithful, of_class};
use crate::plot::{Figure, HEAT, Panel, Sphere};
use crate::table::Table;

/// Votes of a cell over their mean up to which its normals have each color but the last.
const HEAT_LIMITS: [f64; 5] = [0.5, 1.0, 2.0, 5.0, 20.0];
/// Normals that are drawn of a model.
const N_DRAWN: usize = 300;
/// How far the axis is tilted to the viewer, degrees.
const TILT_DEG: f64 = 25.0;

/// What the rules see of each model; the picture shows its normals.
pub fn gallery(context: &Context) -> anyhow::Result<Table> {
    let mut table = Table::new(&["model", "offset", "flatness", "spread, degrees", "skewness", "rules say"]);
    let mut panels = Vec::new();
    for partial in [false, true] {
        for class in Class::PRIMITIVES {
            // Planes are complete only.
            if partial && class == Class::Plane {
                panels.push(Panel::Blank);
                continue;
            }
            let manifest = of_class(&faithful(partial, Triangulation::Isotropic, 64), class, 1);
            let model = all(&manifest).swap_remove(0);
            // Planes are complete only: the second shows that another gives the same spot.
            let name =
                format!("{} {}", if model.truth.partial { "partial" } else { "complete" }, class.name());
            if let Some(verdict) = Rules::default().recognize(&GaussImage::of_mesh(&model.mesh)) {
                let seen = verdict.evidence;
                let sure = if verdict.certain { "" } else { ", not certain" };
                table.row(vec![
                    name.clone(),
                    format!("{:.2}", seen.offset),
                    format!("{:.2}", seen.flatness),
                    format!("{:.1}", seen.spread.to_degrees()),
                    format!("{:.2}", seen.skewness),
                    format!("{}{sure}", verdict.kind.name()),
                ]);
            }
            panels.push(Panel::Sphere(sphere(&model, name)));
        }
    }
    table.write(&context.output, "gallery")?;
    let up_to = HEAT_LIMITS.map(|limit| format!("{limit}"));
    let names = up_to.into_iter().chain(["more".to_owned()]).enumerate();
    let names =
        names.map(|(k, name)| if k == 0 { format!("votes over their mean: up to {name}") } else { name });
    let legend = names.zip(HEAT).collect();
    Figure { panels, columns: 5, size: [200.0, 220.0], legend }.write(&context.output, "gallery")?;
    Ok(table)
}

/// Some normals of a model, drawn by area, in the colors of their cells' votes; its axis is up, tilted to the viewer.
fn sphere(model: &Model, title: String) -> Sphere {
    let image = GaussImage::of_mesh(&model.mesh);
    let cells = Cells::new(N_CELLS);
    let votes = Accumulator::new(&image, &cells, Voting::Area).votes;
    let view = View::of(model, &image);
    let mut area = 0.0;
    let area_to: Vec<f64> = image
        .areas
        .iter()
        .map(|a| {
            area += a;
            area
        })
        .collect();
    let mut rng = Rng::for_task(1, "gallery", 0);
    let points = (0..N_DRAWN).map(|_| {
        let at = rng.uniform() * area;
        let normal = image.normals[area_to.partition_point(|a| *a <= at).min(area_to.len() - 1)];
        (view.seen(&normal), HEAT_LIMITS.iter().filter(|limit| votes[cells.of(&normal)] > **limit).count())
    });
    Sphere { title, points: points.collect(), pole: view.seen(&view.up) }
}

/// Where a model is seen from.
struct View {
    up: Vec3,
    right: Vec3,
    toward: Vec3,
}

impl View {
    fn of(model: &Model, image: &GaussImage) -> Self {
        let sum = image.normals.iter().zip(&image.areas).fold(Vec3::zeros(), |sum, (n, a)| sum + n * *a);
        let of_axis = |name: &str| model.truth.parameter(&format!("axis_{name}"));
        let axis = match (of_axis("x"), of_axis("y"), of_axis("z")) {
            (Some(x), Some(y), Some(z)) => Vec3::new(x, y, z),
            _ => Vec3::z(),
        };
        let up = UnitVec3::new_normalize(if axis.dot(&sum) < 0.0 { -axis } else { axis });
        // What there is of a partial model faces the viewer.
        let across = sum - up.into_inner() * sum.dot(&up);
        let is_short = across.norm() < 0.01 * model.truth.area;
        let front =
            if is_short { Frame::from_z(Point3::origin(), up).x.into_inner() } else { across.normalize() };
        Self { up: up.into_inner(), right: up.cross(&front), toward: front }
    }

    /// A direction as the viewer sees it: right, up, and to the viewer.
    fn seen(&self, direction: &Vec3) -> Vec3 {
        let (sin, cos) = TILT_DEG.to_radians().sin_cos();
        let (x, y, z) = (direction.dot(&self.right), direction.dot(&self.up), direction.dot(&self.toward));
        Vec3::new(x, y * cos - z * sin, y * sin + z * cos)
    }
}
