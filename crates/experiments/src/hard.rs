//! Recognition on the tier that is meant to be hard: every resolution, triangulation and noise.

use scanwright::gprimdb::{Manifest, Model, Noise, Tier};
use scanwright::par;
use scanwright::pipeline;
use scanwright::recognize::Primitive;
use scanwright::recognize::gauss::{Cells, Classifier, Example, GaussImage, N_CELLS};
use scanwright::surface::SurfaceKind;

use crate::Context;
use crate::models::{all, example};
use crate::recognizers::by_rules;
use crate::table::{Table, percent};

/// Shapes of each of the five types in the test, each in one copy: a twenty-fifth of the tier.
const N_TEST: u32 = 160;
/// Those of the training.
const N_TRAIN: u32 = 120;
/// Another seed than that of the tier, so that the classifier has seen none of the test's shapes.
const TRAIN_SEED: u64 = 1;

/// What is said of one model.
struct Answer {
    truth: SurfaceKind,
    /// Rules where they are certain, the classifier elsewhere.
    normals: Option<SurfaceKind>,
    /// The product's, and whether it calls it certain.
    surfaces: Option<SurfaceKind>,
    certain: bool,
    group: String,
}

/// Confusion of the types, then by noise and by number of edges: named right by normals (rules, then Gsh+s with SVM),
/// by fitted surfaces, of those that are not called ambiguous, and wrong ones that are.
pub fn hard(context: &Context) -> anyhow::Result<Table> {
    let test = with_count(&Manifest::of_tier(Tier::Hard), N_TEST);
    let train = Manifest { seed: TRAIN_SEED, ..with_count(&test, N_TRAIN) };
    let cells = Cells::new(N_CELLS);
    let examples: Vec<Example> = all(&train).iter().filter_map(|m| example(m, &cells, true)).collect();
    let classifier = Classifier::train(&examples, N_CELLS, "experiments")?;
    let answers: Vec<Answer> =
        par::map(&all(&test), |model| answer(model, &classifier)).into_iter().flatten().collect();
    confusion(&answers).write(&context.output, "hard-confusion")?;
    let mut table = Table::new(&[
        "models",
        "n",
        "rules, then SVM",
        "ours",
        "called ambiguous",
        "ours, where certain",
        "wrong ones called ambiguous",
    ]);
    let mut groups: Vec<String> = answers.iter().map(|a| a.group.clone()).collect();
    groups.sort_unstable();
    groups.dedup();
    table.row(row("all", &answers.iter().collect::<Vec<_>>()));
    for kind in SurfaceKind::ALL {
        table.row(row(kind.name(), &answers.iter().filter(|a| a.truth == kind).collect::<Vec<_>>()));
    }
    for group in groups {
        table.row(row(&group, &answers.iter().filter(|a| a.group == group).collect::<Vec<_>>()));
    }
    table.write(&context.output, "hard")?;
    Ok(table)
}

/// The tier with one copy of fewer shapes, of the five types alone.
fn with_count(manifest: &Manifest, count: u32) -> Manifest {
    let mut manifest = Manifest { copies: 1, ..manifest.clone() };
    manifest.shapes.retain(|s| s.class.kind().is_some());
    for shapes in &mut manifest.shapes {
        shapes.count = count;
    }
    manifest
}

fn answer(model: &Model, classifier: &Classifier) -> Option<Answer> {
    let truth = model.truth.class.kind()?;
    let (rules, certain) = by_rules(model);
    let likeliest = classifier.classify(&GaussImage::of_mesh(&model.mesh)).first().map(|pair| pair.0);
    let found = pipeline::recognize(&model.mesh).ok();
    Some(Answer {
        truth,
        normals: if certain { rules } else { likeliest },
        surfaces: found.as_ref().and_then(Primitive::kind),
        certain: found.as_ref().is_some_and(|p| p.surface.is_some() && p.ambiguous.is_none()),
        group: group(model),
    })
}

/// Noise, and whether there are enough triangles for it to average out.
fn group(model: &Model) -> String {
    /// Edges along the root of the area: below, a model has a few hundred triangles.
    const FEW: u32 = 16;
    let noise = match model.truth.noise {
        Noise::None => "without noise".to_owned(),
        Noise::Normal { level } => format!("along the normal, {level}"),
        Noise::Isotropic { level } => format!("isotropic, {level}"),
        Noise::Correlated { level, length } => format!("correlated, {level} over {length}"),
        Noise::Outliers { share, .. } => format!("outliers, {:.0} %", 100.0 * share),
    };
    let size = if model.truth.resolution <= FEW { "few triangles" } else { "many triangles" };
    format!("{size}: {noise}")
}

fn row(name: &str, answers: &[&Answer]) -> Vec<String> {
    let count = |is: &dyn Fn(&Answer) -> bool| answers.iter().filter(|a| is(a)).count();
    let right = |a: &Answer| a.surfaces == Some(a.truth);
    let n_certain = count(&|a| a.certain);
    let n_wrong = count(&|a| !right(a));
    vec![
        name.to_owned(),
        answers.len().to_string(),
        percent(count(&|a| a.normals == Some(a.truth)), answers.len()),
        percent(count(&right), answers.len()),
        percent(answers.len() - n_certain, answers.len()),
        percent(count(&|a| a.certain && right(a)), n_certain),
        if n_wrong == 0 { "-".to_owned() } else { percent(count(&|a| !a.certain && !right(a)), n_wrong) },
    ]
}

/// Rows: the truth; columns: what is said, by normals and by fitted surfaces.
fn confusion(answers: &[Answer]) -> Table {
    let names = SurfaceKind::ALL.map(SurfaceKind::name);
    let by = |way: &str| names.map(|name| format!("{way}: {name}"));
    let columns = [
        vec!["truth".to_owned()],
        by("normals").to_vec(),
        by("ours").to_vec(),
        vec!["ours: none".to_owned()],
    ]
    .concat();
    let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    for truth in SurfaceKind::ALL {
        let of = |is: &dyn Fn(&Answer) -> bool| {
            answers.iter().filter(|a| a.truth == truth && is(a)).count().to_string()
        };
        let mut row = vec![truth.name().to_owned()];
        row.extend(SurfaceKind::ALL.map(|kind| of(&|a| a.normals == Some(kind))));
        row.extend(SurfaceKind::ALL.map(|kind| of(&|a| a.surfaces == Some(kind))));
        row.push(of(&|a| a.surfaces.is_none()));
        table.row(row);
    }
    table
}
