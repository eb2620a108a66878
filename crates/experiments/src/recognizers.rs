//! Ways to name the type of a model: rules, classifier, fitted surfaces.

use scanwright::fit::{Samples, Weights};
use scanwright::gprimdb::{Manifest, Model, Triangulation};
use scanwright::math::Vec3;
use scanwright::par;
use scanwright::recognize::gauss::{Cells, Classifier, Example, GaussImage, N_CELLS, Rules, cross_validated};
use scanwright::recognize::{Limits, choose};
use scanwright::surface::SurfaceKind;

use crate::models::{all, example, faithful};

/// Folds of every cross-validation.
pub const N_FOLDS: u32 = 10;

/// What the rules say, and whether they are certain.
pub fn by_rules(model: &Model) -> (Option<SurfaceKind>, bool) {
    let verdict = Rules::default().recognize(&GaussImage::of_mesh(&model.mesh));
    (verdict.map(|v| v.kind), verdict.is_some_and(|v| v.certain))
}

/// What a classifier that has not seen an example's group says, for each.
pub fn by_fold(examples: &[Example]) -> anyhow::Result<Vec<Option<SurfaceKind>>> {
    let folds = cross_validated(examples, N_FOLDS)?;
    let mut next: Vec<_> = folds.iter().map(|fold| fold.answers.iter()).collect();
    Ok(examples.iter().map(|e| next[(e.group % N_FOLDS) as usize].next().map(|answer| answer.1)).collect())
}

/// The product's choice among fitted surfaces, told that the model is a scan with hardly any noise. `normals`: one per
/// vertex.
pub fn by_surfaces(model: &Model, normals: Vec<Vec3>) -> Option<SurfaceKind> {
    const N_SAMPLES: usize = 400;
    let edge = model.truth.edge;
    // The floor of the noise, and the limits that follow from the spacing, are those of `segment::Field`.
    let sigma = 0.08 * edge;
    let weights = Weights { distance_sigma: sigma, normal_sigma: 0.1, normal_weight: 0.5 };
    let limits =
        Limits { min_radius: 1.6 * edge, min_taper: 0.7 * edge, min_departure: 1.5 * sigma, min_tilt: 0.1 };
    let all = Samples { points: model.mesh.vertices.clone(), normals };
    choose(&all.thinned(N_SAMPLES), all.points.len(), &weights, &limits, None).map(|c| c.fit.surface.kind())
}

/// A classifier for models it has not seen: of the manifest's shapes in isotropic triangles, half of them partial.
pub fn trained(manifest: &Manifest) -> anyhow::Result<Classifier> {
    let manifest =
        Manifest { partial: 0.5, ranges: manifest.ranges, ..faithful(false, Triangulation::Isotropic, 32) };
    let cells = Cells::new(N_CELLS);
    let examples: Vec<Example> = all(&manifest).iter().filter_map(|m| example(m, &cells, true)).collect();
    Ok(Classifier::train(&examples, N_CELLS, "experiments")?)
}

/// How many of some models each way names right.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Right {
    /// Number of models.
    pub n: usize,
    /// By the rules alone.
    pub rules: usize,
    /// By the classifier alone.
    pub classifier: usize,
    /// By the rules where they are certain, by the classifier elsewhere.
    pub both: usize,
    /// By fitted surfaces.
    pub surfaces: usize,
}

/// Counts what is named right of `models`, by a classifier that was trained on others. Surfaces are fitted to vertices
/// with the normals of the triangulation, as no scan has better ones.
pub fn count_right(models: &[Model], classifier: &Classifier) -> Right {
    let each = par::map(models, |model| {
        let truth = model.truth.class.kind();
        let (rules, certain) = by_rules(model);
        let likeliest = classifier.classify(&GaussImage::of_mesh(&model.mesh)).first().map(|pair| pair.0);
        let both = if certain { rules } else { likeliest };
        let surfaces = by_surfaces(model, model.mesh.vertex_normals());
        [rules, likeliest, both, surfaces].map(|kind| usize::from(kind == truth))
    });
    let sum = |k: usize| each.iter().map(|right| right[k]).sum();
    Right { n: models.len(), rules: sum(0), classifier: sum(1), both: sum(2), surfaces: sum(3) }
}
