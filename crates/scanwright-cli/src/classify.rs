//! `scanwright classify`.

use std::fs;

use scanwright::condition;
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::pipeline;
use scanwright::recognize::gauss::{Classifier, GaussImage, OutlierSearch, Rules};
use scanwright::surface::SurfaceKind;

use crate::args::{ClassifyArgs, OutliersFlag};
use crate::exit::{Code, Failure};
use crate::scan;

/// The classifier that comes with the program: trained on the `faithful` tier.
const SHIPPED: &str = include_str!("../models/faithful.svm");

/// Names the type of a segment: by its normals, as the thesis does, and by fitted surfaces, as `convert` does.
pub fn run(args: &ClassifyArgs) -> Result<Code, Failure> {
    let classifier = match &args.model {
        Some(path) => {
            let text = fs::read_to_string(path).map_err(|error| Failure::input(path, error))?;
            Classifier::from_text(&text).map_err(|error| Failure::input(path, error))?
        }
        None => shipped()?,
    };
    let file = scan::read(&args.segment)?;
    let mesh = condition::condition(&file.mesh).mesh;
    let adjacency = Adjacency::new(&mesh);
    let image = match args.outliers {
        OutliersFlag::Keep => GaussImage::of_mesh(&mesh),
        OutliersFlag::Remove => without_outliers(&mesh, &adjacency),
    };
    let normal_noise = condition::measure(&mesh, &adjacency).normal_noise;
    let rules = Rules { normal_noise, ..Rules::default() };
    let Some(verdict) = rules.recognize(&image) else {
        return Err(Failure::input(&args.segment, "no triangle has an area"));
    };
    let probabilities = classifier.classify(&image);
    let by_rules = if verdict.certain { "certain" } else { "not certain" };
    println!("rules        {}, {by_rules}", verdict.kind.name());
    let listed: Vec<String> =
        probabilities.iter().map(|(kind, p)| format!("{} {:.0} %", kind.name(), 100.0 * p)).collect();
    println!("classifier   {}  ({})", listed.join(", "), classifier.provenance);
    let likeliest = probabilities.first().map_or(verdict.kind, |best| best.0);
    println!("type         {}", if verdict.certain { verdict.kind } else { likeliest }.name());
    let found =
        pipeline::recognize(&mesh).map_err(|error| Failure::input(&args.segment, error.to_string()))?;
    println!("surfaces     {}", found.kind().map_or("none of the five", SurfaceKind::name));
    if let Some(doubt) = found.ambiguous {
        println!("ambiguous    {doubt}");
    }
    Ok(Code::Done)
}

/// The classifier that comes with the program.
pub fn shipped() -> Result<Classifier, Failure> {
    Classifier::from_text(SHIPPED).map_err(|error| Failure::Internal(error.to_string()))
}

/// The image without its outliers; says how much was removed.
fn without_outliers(mesh: &Mesh, adjacency: &Adjacency) -> GaussImage {
    let (image, outliers) = GaussImage::without_outliers(mesh, adjacency, &OutlierSearch::default());
    let percent = 100.0 * outliers.share;
    if outliers.is_one_primitive {
        println!("outliers     {percent:.1} % of the area removed");
    } else {
        println!("outliers     {percent:.1} % of the area: too much for one primitive, all kept");
    }
    image
}
