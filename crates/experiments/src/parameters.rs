//! Parameters of known types: PGP2X, LSGE, Attene and ours.

use scanwright::fit::{FitMethod, Samples, fit_known};
use scanwright::gprimdb::{Class, Model, Triangulation};
use scanwright::math::stats;
use scanwright::par;
use scanwright::surface::Surface;

use crate::Context;
use crate::models::{all, faithful, of_class, with_noise};
use crate::table::Table;

/// Noise along the normal, edge lengths.
const LEVELS: [f64; 5] = [0.0, 0.1, 0.25, 0.4, 0.8];
/// Shapes per cell of the table.
const N_SHAPES: u32 = 60;

/// Figures 3.25 to 3.29 and table 3.2: error of the size of each type (radius; half-angle of cones; tube of tori), in
/// percent, in the median; shapes without an answer in brackets.
pub fn sizes(context: &Context) -> anyhow::Result<Table> {
    let methods = FitMethod::ALL.map(FitMethod::name);
    let mut headings = vec!["models", "noise"];
    headings.extend(methods);
    let mut table = Table::new(&headings);
    for (partial, name) in [(false, "complete"), (true, "partial")] {
        for class in [Class::Cylinder, Class::Cone, Class::Sphere, Class::Torus] {
            for level in LEVELS {
                let manifest = of_class(&faithful(partial, Triangulation::Isotropic, 32), class, N_SHAPES);
                let models = all(&with_noise(&manifest, level));
                let mut row = vec![format!("{name} {}", class.name()), format!("{level}")];
                row.extend(FitMethod::ALL.map(|method| cell(&models, level, method)));
                table.row(row);
            }
        }
    }
    table.write(&context.output, "sizes")?;
    Ok(table)
}

fn cell(models: &[Model], level: f64, method: FitMethod) -> String {
    let errors = par::map(models, |model| error(model, level, method));
    let n_none = errors.iter().filter(|e| e.is_none()).count();
    let mut found: Vec<f64> = errors.into_iter().flatten().map(|e| 100.0 * e).collect();
    match stats::median(&mut found) {
        None => "-".to_owned(),
        Some(median) if n_none > 0 => format!("{median:.3} ({n_none})"),
        Some(median) => format!("{median:.3}"),
    }
}

/// Relative error of the size.
fn error(model: &Model, level: f64, method: FitMethod) -> Option<f64> {
    let samples = Samples { points: model.mesh.vertices.clone(), normals: model.mesh.vertex_normals() };
    let found = fit_known(model.truth.class.kind()?, &samples, level * model.truth.edge, method)?;
    let (name, size) = match found {
        Surface::Plane(_) => return None,
        Surface::Cylinder(s) => ("radius", s.radius),
        Surface::Sphere(s) => ("radius", s.radius),
        Surface::Cone(s) => ("half_angle", s.half_angle),
        Surface::Torus(s) => ("minor_radius", s.minor_radius),
    };
    let truth = model.truth.parameter(name)?;
    Some((size / truth - 1.0).abs())
}
