//! How near estimates of sizes come to the least spread that any unbiased one can have.

use scanwright::fit::{FitMethod, Samples, fit_known, parameter_covariance, parameter_names};
use scanwright::gprimdb::{Class, Model, Triangulation};
use scanwright::math::stats;
use scanwright::par;
use scanwright::random::Rng;
use scanwright::surface::{Surface, SurfaceKind};

use crate::Context;
use crate::models::{all, faithful, of_class};
use crate::table::Table;

/// Noise along the normal, edge lengths.
const LEVELS: [f64; 5] = [0.05, 0.1, 0.25, 0.4, 0.8];
/// Shapes per cell of the table.
const N_SHAPES: u32 = 8;
/// Draws of noise on each: their root mean square is known within 11 %, a cell's median within 5 %.
const N_DRAWS: u64 = 40;
const SEED: u64 = 2015;

/// Error of each size over draws of noise, root mean square, over the Cramer-Rao bound: in the median over shapes.
///
/// The bound is that of all parameters together, for independent normal noise along the normals:
/// `sigma^2 (J^T J)^-1` at the true surface.
pub fn bound(context: &Context) -> anyhow::Result<Table> {
    let mut headings = vec!["models", "noise"];
    headings.extend(FitMethod::ALL.map(FitMethod::name));
    let mut table = Table::new(&headings);
    for (partial, name) in [(false, "complete"), (true, "partial")] {
        for (class, sizes) in [
            (Class::Cylinder, &["radius"][..]),
            (Class::Cone, &["half_angle"]),
            (Class::Sphere, &["radius"]),
            (Class::Torus, &["major_radius", "minor_radius"]),
        ] {
            let models = all(&of_class(&faithful(partial, Triangulation::Isotropic, 32), class, N_SHAPES));
            let of_levels =
                LEVELS.map(|level| FitMethod::ALL.map(|method| ratios(&models, sizes, level, method)));
            for (i, size) in sizes.iter().enumerate() {
                for (level, of_methods) in LEVELS.iter().zip(&of_levels) {
                    let name = format!("{name} {}: {}", class.name(), size.replace('_', " "));
                    let mut row = vec![name, level.to_string()];
                    row.extend(of_methods.iter().map(|of_models| cell(of_models, i)));
                    table.row(row);
                }
            }
        }
    }
    table.write(&context.output, "bound")?;
    Ok(table)
}

/// The median over models of the ratio of one size.
fn cell(of_models: &[Vec<Option<f64>>], size: usize) -> String {
    let mut found: Vec<f64> = of_models.iter().filter_map(|ratios| ratios[size]).collect();
    stats::median(&mut found).map_or_else(|| "-".to_owned(), |median| format!("{median:.2}"))
}

/// For each model and size: error over the bound; `None` where a method finds no surface in one of ten draws or more.
fn ratios(models: &[Model], sizes: &[&str], level: f64, method: FitMethod) -> Vec<Vec<Option<f64>>> {
    par::map_indices(models.len(), |m| {
        let model = &models[m];
        let kind = model.truth.class.kind();
        let exact = Samples { points: model.clean.clone(), normals: model.normals.clone() };
        let truth = kind.and_then(|kind| fit_known(kind, &exact, 0.0, FitMethod::Robust));
        let Some((kind, truth)) = kind.zip(truth) else { return vec![None; sizes.len()] };
        let sigma = level * model.truth.edge;
        let bounds = parameter_covariance(&truth, &exact, sigma, exact.points.len() as f64);
        let errors = errors(model, m as u64, kind, sigma, sizes, method);
        let ratio = |(i, size): (usize, &&str)| {
            let place = parameter_names(&truth).iter().position(|name| name == size)?;
            let bound = bounds.get(place)?[place].sqrt();
            let squares: Vec<f64> = errors.iter().map(|of_draw| of_draw[i].powi(2)).collect();
            let enough = 10 * squares.len() as u64 > 9 * N_DRAWS;
            enough.then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt() / bound)
        };
        sizes.iter().enumerate().map(ratio).collect()
    })
}

/// The errors of the sizes in each draw of noise that a surface was found in.
fn errors(
    model: &Model,
    index: u64,
    kind: SurfaceKind,
    sigma: f64,
    sizes: &[&str],
    method: FitMethod,
) -> Vec<Vec<f64>> {
    let draw = |draw: u64| {
        let mut rng = Rng::for_task(SEED, "bound", index * N_DRAWS + draw);
        let mut mesh = model.mesh.clone();
        mesh.vertices =
            model.clean.iter().zip(&model.normals).map(|(p, n)| p + n * (sigma * rng.normal())).collect();
        let normals = mesh.vertex_normals();
        let found = fit_known(kind, &Samples { points: mesh.vertices, normals }, sigma, method)?;
        sizes.iter().map(|size| Some(size_of(&found, size)? - model.truth.parameter(size)?)).collect()
    };
    (0..N_DRAWS).filter_map(draw).collect()
}

fn size_of(surface: &Surface, name: &str) -> Option<f64> {
    match (surface, name) {
        (Surface::Cylinder(s), "radius") => Some(s.radius),
        (Surface::Sphere(s), "radius") => Some(s.radius),
        (Surface::Cone(s), "half_angle") => Some(s.half_angle),
        (Surface::Torus(s), "major_radius") => Some(s.major_radius),
        (Surface::Torus(s), "minor_radius") => Some(s.minor_radius),
        _ => None,
    }
}
