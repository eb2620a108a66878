//! Generated models with their images on the Gaussian sphere.

use scanwright::gprimdb::{Class, Manifest, Model, Noise, Tier, Triangulation};
use scanwright::par;
use scanwright::recognize::gauss::{Accumulator, Cells, Example, GaussImage, Voting};

/// The `faithful` manifest with one triangulation, of one resolution, without noise, complete or partial.
pub fn faithful(partial: bool, triangulation: Triangulation, resolution: u32) -> Manifest {
    Manifest {
        partial: if partial { 1.0 } else { 0.0 },
        triangulations: vec![triangulation],
        resolutions: vec![resolution],
        ..Manifest::of_tier(Tier::Faithful)
    }
}

/// The same, of one class alone.
pub fn of_class(manifest: &Manifest, class: Class, count: u32) -> Manifest {
    let mut manifest = manifest.clone();
    manifest.shapes.retain(|s| s.class == class);
    for shapes in &mut manifest.shapes {
        shapes.count = count;
    }
    manifest
}

/// The same with noise along the normal, in edge lengths.
pub fn with_noise(manifest: &Manifest, level: f64) -> Manifest {
    let noise = if level > 0.0 { Noise::Normal { level } } else { Noise::None };
    Manifest { noises: vec![noise], ..manifest.clone() }
}

/// All models of a manifest.
pub fn all(manifest: &Manifest) -> Vec<Model> {
    par::map_indices(manifest.n_models(), |k| manifest.model(k))
}

/// The descriptor of a model, with its type and group.
pub fn example(model: &Model, cells: &Cells, with_skewness: bool) -> Option<Example> {
    let kind = model.truth.class.kind()?;
    let image = GaussImage::of_mesh(&model.mesh);
    let descriptor = Accumulator::new(&image, cells, Voting::Area).descriptor();
    let values = if with_skewness { descriptor.values() } else { descriptor.histogram };
    Some(Example { values, kind, group: model.truth.group })
}
