//! The Gaussian sphere: skewness, sorted histograms, rules and classifier.

use scanwright::gprimdb::{Class, Model, Triangulation};
use scanwright::math::stats;
use scanwright::par;
use scanwright::recognize::gauss::{
    Accumulator, Cells, Example, Fold, GaussImage, N_CELLS, Rules, Voting, cross_validated,
};

use crate::Context;
use crate::models::{all, example, faithful, of_class};
use crate::pictures;
use crate::recognizers::{N_FOLDS, by_fold, by_rules, by_surfaces};
use crate::table::{Table, percent};

/// Figure 2.17: skewness of 100 spheres and 100 tori, by the area and by the number of triangles.
pub fn skewness(context: &Context) -> anyhow::Result<Table> {
    let mut table =
        Table::new(&["models", "triangulation", "votes", "least", "median", "greatest", "above 1.5"]);
    let mut panels: Vec<(String, Vec<f64>, Vec<f64>)> = Vec::new();
    for class in [Class::Sphere, Class::Torus] {
        for triangulation in [Triangulation::Grid, Triangulation::Isotropic] {
            let models = all(&of_class(&faithful(false, triangulation, 32), class, 100));
            let triangulation = format!("{triangulation:?}").to_lowercase();
            for (voting, votes) in [(Voting::Area, "area"), (Voting::Count, "count")] {
                let values: Vec<f64> = models.iter().map(|m| accumulator(m, voting).skewness()).collect();
                let n_above = values.iter().filter(|s| **s > 1.5).count();
                let mut sorted = values.clone();
                let mut at = |q| format!("{:.2}", stats::quantile(&mut sorted, q).unwrap_or(f64::NAN));
                table.row(vec![
                    format!("100 {}", if class == Class::Sphere { "spheres" } else { "tori" }),
                    triangulation.clone(),
                    votes.to_owned(),
                    at(0.0),
                    at(0.5),
                    at(1.0),
                    n_above.to_string(),
                ]);
                let name = format!("{triangulation}, votes by {votes}");
                match panels.iter_mut().find(|panel| panel.0 == name) {
                    Some(panel) => panel.2 = values,
                    None => panels.push((name, values, Vec::new())),
                }
            }
        }
    }
    table.write(&context.output, "skewness")?;
    pictures::skewness(&panels).write(&context.output, "skewness")?;
    Ok(table)
}

fn accumulator(model: &Model, voting: Voting) -> Accumulator {
    Accumulator::new(&GaussImage::of_mesh(&model.mesh), &Cells::new(N_CELLS), voting)
}

/// Figure 2.18: sorted histograms of 10 spheres and 10 tori.
pub fn histograms(context: &Context) -> anyhow::Result<Table> {
    const PLACES: [usize; 7] = [0, 4, 19, 49, 99, 149, 201];
    let headings: Vec<String> = PLACES.iter().map(|p| format!("{}.", p + 1)).collect();
    let mut columns = vec!["model"];
    columns.extend(headings.iter().map(String::as_str));
    let mut table = Table::new(&columns);
    let curves = [Class::Sphere, Class::Torus].map(|class| {
        let models = all(&of_class(&faithful(false, Triangulation::Isotropic, 64), class, 10));
        let histogram = |model: &Model| {
            let histogram = accumulator(model, Voting::Area).descriptor().histogram;
            let mut row = vec![model.truth.name.clone()];
            row.extend(PLACES.iter().map(|p| format!("{:.2}", histogram[*p])));
            table.row(row);
            histogram
        };
        models.iter().map(histogram).collect::<Vec<_>>()
    });
    table.write(&context.output, "histograms")?;
    pictures::histograms(&curves[0], &curves[1]).write(&context.output, "histograms")?;
    Ok(table)
}

/// How models are named, and how many of them right.
pub fn recognition(context: &Context) -> anyhow::Result<Table> {
    let mut table = Table::new(&[
        "models",
        "n",
        "rules alone",
        "Gsh+s with SVM alone",
        "rules, then SVM",
        "rules are certain of",
        "ours, by fitted surfaces",
    ]);
    for (partial, name) in [(false, "complete"), (true, "partial")] {
        for triangulation in [Triangulation::Grid, Triangulation::Isotropic, Triangulation::Cad] {
            let models = all(&faithful(partial, triangulation, 32));
            let cells = Cells::new(N_CELLS);
            let examples: Vec<Example> = models.iter().filter_map(|m| example(m, &cells, true)).collect();
            let by_svm = by_fold(&examples)?;
            let (mut rules_right, mut svm_right, mut both_right, mut n_certain) = (0, 0, 0, 0);
            let ours = par::map(&models, |m| by_surfaces(m, m.normals.clone()));
            let ours_right =
                models.iter().zip(&ours).filter(|(m, kind)| m.truth.class.kind() == **kind).count();
            for (model, svm) in models.iter().zip(by_svm) {
                let truth = model.truth.class.kind();
                let (rules, certain) = by_rules(model);
                rules_right += usize::from(rules == truth);
                svm_right += usize::from(svm == truth);
                both_right += usize::from((if certain { rules } else { svm }) == truth);
                n_certain += usize::from(certain);
            }
            let n = models.len();
            table.row(vec![
                format!("{name}, {}", format!("{triangulation:?}").to_lowercase()),
                n.to_string(),
                percent(rules_right, n),
                percent(svm_right, n),
                percent(both_right, n),
                percent(n_certain, n),
                percent(ours_right, n),
            ]);
        }
    }
    table.write(&context.output, "recognition")?;
    Ok(table)
}

/// Tables 3.3 and 3.5: accuracy with and without the skewness, and by the number of cells.
pub fn cells(context: &Context) -> anyhow::Result<Table> {
    let mut table = Table::new(&["cells", "with skewness", "without"]);
    let of = |partial, class| all(&of_class(&faithful(partial, Triangulation::Isotropic, 32), class, 100));
    let halves = [false, true].map(|partial| Class::PRIMITIVES.map(|class| of(partial, class)).concat());
    let models: Vec<Model> = halves.concat();
    for n in [52, 102, 202, 402] {
        let cells = Cells::new(n);
        let accuracy = |with_skewness| {
            // The complete and the partial model of one number have the same sizes: they share a group.
            let half = models.len() / 2;
            let numbered = models.iter().enumerate().filter_map(|(k, m)| {
                Some(Example { group: (k % half) as u32, ..example(m, &cells, with_skewness)? })
            });
            let examples: Vec<Example> = numbered.collect();
            anyhow::Ok(percent(n_right(&cross_validated(&examples, N_FOLDS)?), examples.len()))
        };
        table.row(vec![n.to_string(), accuracy(true)?, accuracy(false)?]);
    }
    table.write(&context.output, "cells")?;
    Ok(table)
}

fn n_right(folds: &[Fold]) -> usize {
    folds.iter().flat_map(|f| &f.answers).filter(|(truth, answer)| truth == answer).count()
}

/// Table 3.4: the best `C` and `gamma` of each fold.
pub fn folds(context: &Context) -> anyhow::Result<Table> {
    let cells = Cells::new(N_CELLS);
    let models = all(&faithful(false, Triangulation::Isotropic, 32));
    let examples: Vec<Example> = models.iter().filter_map(|m| example(m, &cells, true)).collect();
    let mut table = Table::new(&["fold", "C", "gamma", "accuracy"]);
    for (k, fold) in cross_validated(&examples, N_FOLDS)?.iter().enumerate() {
        table.row(vec![
            (k + 1).to_string(),
            format!("2^{}", fold.parameters.c.log2()),
            format!("2^{}", fold.parameters.gamma.log2()),
            format!("{:.1} %", 100.0 * fold.accuracy),
        ]);
    }
    table.write(&context.output, "folds")?;
    Ok(table)
}

/// Table 3.1, in its shape: least, mean and greatest of what the rules look at, by class.
pub fn statistics(context: &Context) -> anyhow::Result<Table> {
    let mut table = Table::new(&["class", "offset", "flatness", "spread, degrees", "skewness"]);
    for (partial, name) in [(false, "complete"), (true, "partial")] {
        for class in Class::PRIMITIVES {
            let models = all(&of_class(&faithful(partial, Triangulation::Isotropic, 32), class, 100));
            let rules = Rules::default();
            let evidence: Vec<_> =
                models.iter().filter_map(|m| rules.evidence(&GaussImage::of_mesh(&m.mesh))).collect();
            let range = |of: &dyn Fn(usize) -> f64| {
                let values: Vec<f64> = (0..evidence.len()).map(of).collect();
                let least = values.iter().copied().fold(f64::INFINITY, f64::min);
                let greatest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
                format!("{least:.2} / {mean:.2} / {greatest:.2}")
            };
            table.row(vec![
                format!("{name} {}", class.name()),
                range(&|k| evidence[k].offset),
                range(&|k| evidence[k].flatness),
                range(&|k| evidence[k].spread.to_degrees()),
                range(&|k| evidence[k].skewness),
            ]);
        }
    }
    table.write(&context.output, "statistics")?;
    Ok(table)
}
