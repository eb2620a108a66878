//! Part-to-CAD, the thesis's path: the table taken away, regions by a spectral method, each named by its normals on the
//! Gaussian sphere without outliers, its sizes by PGP2X, and each drawn by itself as a CAD surface.
//!
//! Source: doctoral thesis "Extracting Structured Models From Raw Scans of Manufactured Objects" (2015). Known from it:
//! the steps and their order. Reconstructed: how each is done, as said where it is. Nothing is joined, closed or made
//! regular here; `run` is the path that makes solids.

use super::{
    Code, Error, Model, Options, Reconstruction, Regions, Warning, model, reconstruction, regions, stages,
};
use crate::brep::{self, Solid};
use crate::condition;
use crate::denoise::{self, DenoiseMethod, Sun2007};
use crate::deviation;
use crate::fit::{Fit, FitMethod, Samples, fit_known};
use crate::math::Point3;
use crate::mesh::{Adjacency, Mesh};
use crate::progress::{Progress, Stage};
use crate::recognize::Primitive;
use crate::recognize::gauss::{Classifier, GaussImage, OutlierSearch, Rules, rings};
use crate::segment::{RegionId, SegmentMethod, Segmentation, Spectral};
use crate::tolerance::Tolerances;

/// Root mean square distance, in deviations of the noise, beyond which a named surface does not describe its region.
const MISFIT: f64 = 5.0;

/// Draws the primitives of `mesh` as the thesis's Part-to-CAD does. `options.method` may be any; the fit-driven default
/// stands for 3D-NCuts. The one solid holds an open shell per primitive, in the order of the regions.
pub fn run_thesis(
    mesh: &Mesh,
    options: &Options,
    classifier: &Classifier,
    progress: &Progress,
) -> Result<Reconstruction, Error> {
    let method = match options.method {
        SegmentMethod::FitDriven => {
            SegmentMethod::NCuts(Spectral { seed: options.seed, ..Spectral::default() })
        }
        other => other,
    };
    let Regions { scan, support, part, segmentation } =
        regions(mesh, &Options { method, ..options.clone() }, progress)?;
    let segmentation = recognized(&part, &segmentation, &scan.tolerances, classifier);
    progress.report(Stage::Regularize, 1.0)?;

    let (model, undrawn) = drawn(&part.mesh, &segmentation);
    let deviation = deviation::measure(&part.mesh.vertices, &model.mesh);
    progress.report(Stage::Build, 1.0)?;

    let stages::Stated { segmentation, noise, .. } = stages::stated(&part, &segmentation, &scan.tolerances);
    Ok(reconstruction(Regions { scan, support, part, segmentation }, noise, model, deviation, undrawn))
}

/// The same regions with their types by normals and their sizes by PGP2X.
fn recognized(
    part: &stages::Part,
    segmentation: &Segmentation,
    tolerances: &Tolerances,
    classifier: &Classifier,
) -> Segmentation {
    let method = DenoiseMethod::Sun2007(Sun2007::default());
    let denoised = denoise::denoise(&part.mesh, &part.adjacency, tolerances, &method);
    let normals = denoise::vertex_normals(&part.mesh, &denoised);
    let filtered = Mesh { vertices: denoised.vertices, triangles: part.mesh.triangles.clone() };
    let normal_noise = condition::measure(&filtered, &part.adjacency).normal_noise;
    let rules = Rules { normal_noise, ..Rules::default() };
    let triangles = triangles_of(segmentation);
    let depths = depths(&part.mesh, &part.adjacency, &segmentation.labels);
    let primitives = crate::par::map(&triangles, |triangles| {
        let inside = inside(&part.mesh, triangles, &depths);
        let image = GaussImage::of_triangles(&filtered, inside.iter().map(|&t| t as usize));
        let outliers = OutlierSearch::default().run(&image, &rings(&filtered, &part.adjacency, &inside));
        let image = image.kept(&outliers);
        let vertices = vertices_of(&part.mesh, &inside);
        let samples = Samples {
            points: vertices.iter().map(|&v| part.mesh.vertices[v as usize]).collect(),
            normals: vertices.iter().map(|&v| normals[v as usize]).collect(),
        };
        primitive(&rules, classifier, &image, &samples, tolerances.noise())
    });
    Segmentation { labels: segmentation.labels.clone(), primitives }
}

/// What a region is; freeform when its normals have no image or PGP2X finds no surface.
fn primitive(
    rules: &Rules,
    classifier: &Classifier,
    image: &GaussImage,
    samples: &Samples,
    noise: f64,
) -> Primitive {
    let named = classifier.recognize(rules, image);
    let fitted = named.and_then(|(kind, _)| fit_known(kind, samples, noise, FitMethod::Pgp2x));
    let Some((surface, (kind, doubt))) = fitted.zip(named) else { return Primitive::freeform() };
    let facing: f64 =
        samples.points.iter().zip(&samples.normals).map(|(p, n)| surface.normal(p).dot(n)).sum();
    let fit = Fit { surface, outward: facing > 0.0 };
    let mut primitive = Primitive::with_evidence(fit, samples, samples.points.len());
    primitive.ambiguous = if primitive.residual.rms > MISFIT * noise.max(f64::MIN_POSITIVE) {
        let times = primitive.residual.rms / noise.max(f64::MIN_POSITIVE);
        Some(format!(
            "its normals are those of a {}, but it lies {times:.0} times the noise off one",
            kind.name()
        ))
    } else {
        doubt.map(|p| format!("normals alone do not tell; the classifier gives {:.0} %", 100.0 * p))
    };
    primitive
}

/// Rings from a border within which the scanner's rounding and the region's own mistakes turn normals.
const BORDER_RINGS: u8 = 3;

/// One per vertex: rings to a triangle of another region, at most [`BORDER_RINGS`].
fn depths(mesh: &Mesh, adjacency: &Adjacency, labels: &[Option<RegionId>]) -> Vec<u8> {
    let is_border = |v: usize| {
        let mut around = adjacency.vertex_triangles.row(v).iter().map(|&t| labels[t as usize]);
        around.next().is_some_and(|first| around.any(|other| other != first))
    };
    let mut front: Vec<u32> = (0..mesh.vertices.len()).filter(|&v| is_border(v)).map(|v| v as u32).collect();
    let mut depths = vec![BORDER_RINGS; mesh.vertices.len()];
    for &v in &front {
        depths[v as usize] = 0;
    }
    for depth in 1..BORDER_RINGS {
        let mut next = Vec::new();
        for &v in &front {
            for &u in adjacency.vertex_vertices.row(v as usize) {
                if depths[u as usize] > depth {
                    depths[u as usize] = depth;
                    next.push(u);
                }
            }
        }
        front = next;
    }
    depths
}

/// The triangles of a region that are clear of its border, by fewer rings where less than a third would remain.
fn inside(mesh: &Mesh, triangles: &[u32], depths: &[u8]) -> Vec<u32> {
    let depth = |t: u32| mesh.triangles[t as usize].iter().map(|&v| depths[v as usize]).min().unwrap_or(0);
    (1..=BORDER_RINGS)
        .rev()
        .map(|least| triangles.iter().copied().filter(|&t| depth(t) >= least).collect::<Vec<u32>>())
        .find(|inside| 3 * inside.len() >= triangles.len())
        .unwrap_or_else(|| triangles.to_vec())
}

fn triangles_of(segmentation: &Segmentation) -> Vec<Vec<u32>> {
    let mut triangles = vec![Vec::new(); segmentation.primitives.len()];
    for (t, label) in segmentation.labels.iter().enumerate() {
        if let Some(RegionId(k)) = label {
            triangles[*k as usize].push(t as u32);
        }
    }
    triangles
}

fn vertices_of(mesh: &Mesh, triangles: &[u32]) -> Vec<u32> {
    let mut vertices: Vec<u32> = triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// Every primitive drawn by itself, and what could not be.
fn drawn(mesh: &Mesh, segmentation: &Segmentation) -> (Model, Vec<Warning>) {
    let triangles = triangles_of(segmentation);
    let solids = crate::par::map_indices(triangles.len(), |k| {
        let fit = segmentation.primitives[k].fit()?;
        let points: Vec<Point3> =
            vertices_of(mesh, &triangles[k]).iter().map(|&v| mesh.vertices[v as usize]).collect();
        brep::draw(&fit, &points, RegionId(k as u32))
    });
    let mut model = Model { primitives: segmentation.primitives.clone(), ..Model::default() };
    let (mut all, mut undrawn) = (Solid::default(), Vec::new());
    for (k, solid) in solids.into_iter().enumerate() {
        if let Some(solid) = solid {
            all.append(solid);
        } else {
            let text = "spans no part of a surface that could be drawn";
            undrawn.push(Warning::about(Code::FaceDropped, RegionId(k as u32), text));
        }
    }
    if all.faces.is_empty() {
        undrawn.push(Warning::new(Code::NoSolid, "no primitive was drawn"));
        return (model, undrawn);
    }
    model::add_triangles(&mut model, &all);
    model.facts.push(model::facts(&all, 0.0, Vec::new()));
    model.solids.push(all);
    (model, undrawn)
}
