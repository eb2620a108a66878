//! Recognition where it gets hard: few triangles, slender cones, short arcs.

use scanwright::gprimdb::{Class, Manifest, Model, Triangulation};
use scanwright::math::stats;

use crate::Context;
use crate::models::{all, faithful, of_class};
use crate::recognizers::{Right, count_right, trained};
use crate::table::{Table, percent};

/// Another than that of the models the classifier learns from, so that all shapes are new to it.
const TEST_SEED: u64 = 2016;
/// Columns of both tables.
const WAYS: [&str; 4] =
    ["rules alone", "Gsh+s with SVM alone", "rules, then SVM", "ours, by fitted surfaces"];

fn shares(right: Right) -> [String; 4] {
    [right.rules, right.classifier, right.both, right.surfaces].map(|n| percent(n, right.n))
}

/// Recognition of decimated models: by number of triangles and triangulation. The classifier knows isotropic triangles,
/// 32 edges along the square root of the area, alone.
pub fn decimation(context: &Context) -> anyhow::Result<Table> {
    const PER_CLASS: u32 = 60;
    const RESOLUTIONS: [u32; 5] = [8, 12, 16, 32, 64];
    let mut table = Table::new(&[&["models", "edges", "triangles"], &WAYS[..]].concat());
    let classifier = trained(&faithful(false, Triangulation::Isotropic, 32))?;
    for (partial, name) in [(false, "complete"), (true, "partial")] {
        let kinds =
            [Triangulation::Grid, Triangulation::Isotropic, Triangulation::Irregular, Triangulation::Cad];
        for triangulation in kinds {
            for resolution in RESOLUTIONS {
                let manifest = Manifest { seed: TEST_SEED, ..faithful(partial, triangulation, resolution) };
                let of_class = |class| all(&of_class(&manifest, class, PER_CLASS));
                let models: Vec<Model> = Class::PRIMITIVES.map(of_class).concat();
                let mut sizes: Vec<f64> = models.iter().map(|m| m.mesh.triangles.len() as f64).collect();
                let mut row = vec![
                    format!("{name}, {}", format!("{triangulation:?}").to_lowercase()),
                    resolution.to_string(),
                    format!("{:.0}", stats::median(&mut sizes).unwrap_or(0.0)),
                ];
                row.extend(shares(count_right(&models, &classifier)));
                table.row(row);
            }
        }
    }
    table.write(&context.output, "decimation")?;
    Ok(table)
}

/// Recognition of slender cones and of short arcs, by their angle in degrees.
pub fn half_angle(context: &Context) -> anyhow::Result<Table> {
    const HALF_ANGLES: [f64; 10] = [2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0];
    const ARCS: [f64; 9] = [20.0, 30.0, 45.0, 60.0, 90.0, 120.0, 180.0, 270.0, 330.0];
    let mut table = Table::new(&[&["models", "degrees"], &WAYS[..]].concat());
    let mut known = faithful(false, Triangulation::Isotropic, 32);
    known.ranges.half_angle_deg = [HALF_ANGLES[0], 80.0];
    known.ranges.sweep_deg = [ARCS[0], 360.0];
    let classifier = trained(&known)?;
    let mut row = |what: &str, degrees: f64, models: &[Model]| {
        let mut cells = vec![what.to_owned(), format!("{degrees}")];
        cells.extend(shares(count_right(models, &classifier)));
        table.row(cells);
    };
    let complete = Manifest { seed: TEST_SEED, ..faithful(false, Triangulation::Isotropic, 32) };
    row("cylinder, complete: half-angle", 0.0, &first(&complete, Class::Cylinder));
    for half_angle in HALF_ANGLES {
        let mut manifest = complete.clone();
        manifest.ranges.half_angle_deg = [half_angle; 2];
        row("cone, complete: half-angle", half_angle, &first(&manifest, Class::Cone));
    }
    for class in [Class::Cylinder, Class::Cone] {
        for arc in ARCS {
            let mut manifest = Manifest { partial: 1.0, ..complete.clone() };
            manifest.ranges.sweep_deg = [arc; 2];
            row(&format!("{}, partial: arc", class.name()), arc, &first(&manifest, class));
        }
    }
    table.write(&context.output, "half-angle")?;
    Ok(table)
}

/// The first hundred of a class; of partial ones, those that are a part of the turn, not cut obliquely.
fn first(manifest: &Manifest, class: Class) -> Vec<Model> {
    const N: usize = 100;
    // Half of the partial cylinders are cut obliquely.
    let drawn = all(&of_class(manifest, class, 3 * N as u32)).into_iter();
    drawn.filter(|m| !m.truth.partial || m.truth.coverage < 1.0).take(N).collect()
}
