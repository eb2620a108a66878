//! What the removal of outlying normals does to recognition.

use scanwright::condition::measure;
use scanwright::gprimdb::{Class, Manifest, Model, Noise, Triangulation};
use scanwright::math::Vec3;
use scanwright::mesh::{Adjacency, TriId};
use scanwright::par;
use scanwright::random::Rng;
use scanwright::recognize::gauss::{GaussImage, OutlierSearch, Outliers, Rules, Threshold, rings};
use scanwright::surface::SurfaceKind;

use crate::Context;
use crate::models::{all, faithful, of_class};
use crate::table::{Table, percent};

/// Models per class and row.
const N_SHAPES: u32 = 30;
/// Shares of the normals that are turned anywhere.
const PLANTED: [f64; 4] = [0.0, 0.02, 0.05, 0.1];

/// Share of complete models whose type the rules name: with all normals, without outliers by the threshold like the
/// thesis's, and by ours; and what ours found. Outliers are normals turned anywhere, or those beside vertices that lie 3 to
/// 10 edge lengths off.
pub fn outliers(context: &Context) -> anyhow::Result<Table> {
    let mut table = Table::new(&[
        "noise",
        "outliers",
        "all normals",
        "mean and deviation",
        "median and MAD",
        "outliers found",
        "others lost",
        "not one primitive",
    ]);
    let complete = faithful(false, Triangulation::Isotropic, 32);
    for level in [0.0, 0.1, 0.25] {
        let noise = if level > 0.0 { Noise::Normal { level } } else { Noise::None };
        let models = of_noise(&complete, noise);
        for share in PLANTED {
            let of = |model: &Model| answers(model, share);
            table.row(row(
                &level.to_string(),
                &format!("{:.0} % of the normals", 100.0 * share),
                &models,
                of,
            ));
        }
    }
    for share in [0.005, 0.01, 0.02] {
        let models = of_noise(&complete, Noise::Outliers { level: 0.1, share });
        let of = |model: &Model| answers(model, 0.0);
        table.row(row("0.1", &format!("{} % of the vertices", 100.0 * share), &models, of));
    }
    table.write(&context.output, "outliers")?;
    Ok(table)
}

fn of_noise(manifest: &Manifest, noise: Noise) -> Vec<Model> {
    let manifest = Manifest { noises: vec![noise], ..manifest.clone() };
    Class::PRIMITIVES.map(|class| all(&of_class(&manifest, class, N_SHAPES))).concat()
}

/// What the rules say of one model.
struct Answers {
    /// With all normals, by the threshold like the thesis's, by ours.
    is_right: [bool; 3],
    /// Outliers, and those of them that ours found; other normals, and those of them that it lost.
    counts: [usize; 4],
    is_one_primitive: bool,
}

fn answers(model: &Model, share: f64) -> Answers {
    let adjacency = Adjacency::new(&model.mesh);
    let triangles: Vec<TriId> = (0..model.mesh.triangles.len() as TriId).collect();
    let mut image = GaussImage::of_mesh(&model.mesh);
    let mut is_planted = plant(&mut image, share, u64::from(model.truth.group));
    if let Noise::Outliers { .. } = model.truth.noise {
        is_planted = beside_wild_vertices(model);
    }
    let rings = rings(&model.mesh, &adjacency, &triangles);
    let rules = Rules { normal_noise: measure(&model.mesh, &adjacency).normal_noise, ..Rules::default() };
    let kind = |image: &GaussImage| rules.recognize(image).map(|v| v.kind);
    let truth: Option<SurfaceKind> = model.truth.class.kind();
    let by = |threshold| OutlierSearch { threshold, ..OutlierSearch::default() }.run(&image, &rings);
    let (like_thesis, ours) = (by(Threshold::MeanAndDeviation), by(Threshold::MedianAndMad));
    let of = |outliers: &Outliers| kind(&image.kept(outliers)) == truth;
    let count = |planted: bool, found: bool| {
        let both = is_planted.iter().zip(&ours.is_outlier);
        both.filter(|(p, f)| **p == planted && (**f || !found)).count()
    };
    Answers {
        is_right: [kind(&image) == truth, of(&like_thesis), of(&ours)],
        counts: [count(true, false), count(true, true), count(false, false), count(false, true)],
        is_one_primitive: ours.is_one_primitive,
    }
}

/// Turns a share of the normals anywhere; says which.
fn plant(image: &mut GaussImage, share: f64, group: u64) -> Vec<bool> {
    let mut rng = Rng::for_task(1, "outliers", group);
    let turn = |normal: &mut Vec3| {
        let is_planted = rng.uniform() < share;
        if is_planted {
            *normal = Vec3::new(rng.normal(), rng.normal(), rng.normal()).normalize();
        }
        is_planted
    };
    image.normals.iter_mut().map(turn).collect()
}

/// Which triangles, of those with an area, have a vertex more than two edge lengths off.
fn beside_wild_vertices(model: &Model) -> Vec<bool> {
    let is_wild = |v: &u32| {
        let v = *v as usize;
        (model.mesh.vertices[v] - model.clean[v]).norm() > 2.0 * model.truth.edge
    };
    let with_area =
        (0..model.mesh.triangles.len()).filter(|&t| model.mesh.cross(t).try_normalize(0.0).is_some());
    with_area.map(|t| model.mesh.triangles[t].iter().any(is_wild)).collect()
}

fn row(
    noise: &str,
    outliers: &str,
    models: &[Model],
    of: impl Fn(&Model) -> Answers + Sync + Send,
) -> Vec<String> {
    let answers = par::map(models, of);
    let n_right = |k: usize| answers.iter().filter(|a| a.is_right[k]).count();
    let sum = |k: usize| answers.iter().map(|a| a.counts[k]).sum::<usize>();
    let n_not_one = answers.iter().filter(|a| !a.is_one_primitive).count();
    let mut cells = vec![noise.to_owned(), outliers.to_owned()];
    cells.extend((0..3).map(|k| percent(n_right(k), models.len())));
    cells.push(if sum(0) > 0 { percent(sum(1), sum(0)) } else { "-".to_owned() });
    cells.extend([percent(sum(3), sum(2)), percent(n_not_one, models.len())]);
    cells
}
