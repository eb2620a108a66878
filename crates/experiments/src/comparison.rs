//! Descriptors against one another, by the same classifier.

use scanwright::gprimdb::{Class, Model, Triangulation};
use scanwright::mesh::Mesh;
use scanwright::par;
use scanwright::recognize::gauss::{Cells, Example, N_CELLS};
use scanwright::surface::SurfaceKind;

use crate::Context;
use crate::descriptors::{d2, spectrum, surflets};
use crate::models::{all, example, faithful, of_class};
use crate::pictures;
use crate::recognizers::{by_fold, by_rules, by_surfaces};
use crate::table::{Table, percent};

/// A name, and what it makes of a model.
type Descriptor = (&'static str, fn(&Model) -> Option<Example>);

const DESCRIPTORS: [Descriptor; 5] = [
    ("Gsh", |m| example(m, &Cells::new(N_CELLS), false)),
    ("Gsh+s", |m| example(m, &Cells::new(N_CELLS), true)),
    ("D2", |m| with_values(m, d2)),
    ("spectrum", |m| with_values(m, spectrum)),
    ("surflets", |m| with_values(m, surflets)),
];

fn with_values(model: &Model, descriptor: fn(&Mesh) -> Option<Vec<f64>>) -> Option<Example> {
    let (values, kind) = (descriptor(&model.mesh)?, model.truth.class.kind()?);
    Some(Example { values, kind, group: model.truth.group })
}

/// Figures 3.19 and 3.20, in their shape: share named right in a cross-validation, by descriptor and type.
pub fn descriptors(context: &Context) -> anyhow::Result<Table> {
    let mut headings = vec!["models", "descriptor", "all"];
    headings.extend(SurfaceKind::ALL.map(SurfaceKind::name));
    let mut table = Table::new(&headings);
    for (partial, name) in [(false, "complete"), (true, "partial")] {
        let models = all(&faithful(partial, Triangulation::Isotropic, 32));
        let truth: Vec<Option<SurfaceKind>> = models.iter().map(|m| m.truth.class.kind()).collect();
        let mut row = |what: &str, answers: &[Option<SurfaceKind>]| {
            let share = |of: Option<SurfaceKind>| {
                let pairs = truth.iter().zip(answers).filter(|(truth, _)| of.is_none() || **truth == of);
                let (right, n) =
                    pairs.fold((0, 0), |(right, n), (t, a)| (right + usize::from(t == a), n + 1));
                percent(right, n)
            };
            let mut cells = vec![name.to_owned(), what.to_owned(), share(None)];
            cells.extend(SurfaceKind::ALL.map(|kind| share(Some(kind))));
            table.row(cells);
        };
        for (what, descriptor) in DESCRIPTORS {
            let answers = answers(&models, descriptor)?;
            row(what, &answers);
            if what == "Gsh+s" {
                let by_both = models.iter().zip(&answers).map(|(model, svm)| match by_rules(model) {
                    (kind, true) => kind,
                    _ => *svm,
                });
                row("rules, then Gsh+s", &by_both.collect::<Vec<_>>());
            }
        }
        row("ours, by fitted surfaces", &par::map(&models, |m| by_surfaces(m, m.normals.clone())));
    }
    table.write(&context.output, "descriptors")?;
    Ok(table)
}

/// What a classifier that has not seen a model's shape says by a descriptor, for each.
fn answers(
    models: &[Model],
    descriptor: fn(&Model) -> Option<Example>,
) -> anyhow::Result<Vec<Option<SurfaceKind>>> {
    let examples = par::map(models, descriptor);
    let mut found = by_fold(&examples.iter().flatten().cloned().collect::<Vec<_>>())?.into_iter();
    Ok(examples.iter().map(|e| e.as_ref().and_then(|_| found.next().flatten())).collect())
}

/// D2 on partial models, as the thesis shows it: what is named right of each type, and as what partial models are named.
/// The picture shows distributions of some of them.
pub fn d2_partial(context: &Context) -> anyhow::Result<Table> {
    let named = SurfaceKind::ALL.map(|kind| format!("partial named {}", kind.name()));
    let mut headings = vec!["type", "complete named right", "partial named right"];
    headings.extend(named.iter().map(String::as_str));
    let mut table = Table::new(&headings);
    let of = |partial| all(&faithful(partial, Triangulation::Isotropic, 32));
    let (complete, partial) = (of(false), of(true));
    let by_d2 = |models: &[Model]| answers(models, |m| with_values(m, d2));
    let (of_complete, of_partial) = (by_d2(&complete)?, by_d2(&partial)?);
    for kind in SurfaceKind::ALL {
        let share = |models: &[Model], answers: &[Option<SurfaceKind>], named: SurfaceKind| {
            let of_kind = || models.iter().zip(answers).filter(|(m, _)| m.truth.class.kind() == Some(kind));
            percent(of_kind().filter(|(_, answer)| **answer == Some(named)).count(), of_kind().count())
        };
        let mut row = vec![kind.name().to_owned()];
        row.push(share(&complete, &of_complete, kind));
        row.push(share(&partial, &of_partial, kind));
        row.extend(SurfaceKind::ALL.map(|named| share(&partial, &of_partial, named)));
        table.row(row);
    }
    table.write(&context.output, "d2-partial")?;
    let curves = Class::PRIMITIVES.map(|class| {
        let some = |partial, n| {
            let models = all(&of_class(&faithful(partial, Triangulation::Isotropic, 32), class, n));
            models.iter().filter_map(|m| d2(&m.mesh)).collect::<Vec<_>>()
        };
        (class.name(), some(false, 5), if class == Class::Plane { Vec::new() } else { some(true, 5) })
    });
    pictures::distances(&curves).write(&context.output, "d2-partial")?;
    Ok(table)
}
