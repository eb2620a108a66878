//! `scanwright train`.

use scanwright::gprimdb::{Database, Split};
use scanwright::par;
use scanwright::recognize::gauss::{Classifier, Example, N_CELLS, TooFew, cross_validated};

use crate::args::TrainArgs;
use crate::exit::{Code, Failure};
use crate::{console, outputs};

/// Trains a classifier on the models of a database that are not kept for tests.
pub fn run(args: &TrainArgs) -> Result<Code, Failure> {
    outputs::check(&args.database, &[&args.output], args.force)?;
    console::handle_interrupts();
    par::with_threads(args.threads, || train(args))
}

fn train(args: &TrainArgs) -> Result<Code, Failure> {
    let wrong = |error| Failure::input(&args.database, error);
    let database = Database::open(&args.database).map_err(wrong)?;
    let manifest = database.manifest().map_err(wrong)?;
    let Some(manifest) = manifest else {
        return Err(Failure::input(&args.database, "has no generated models to train on"));
    };
    let n = database.n_models().map_err(wrong)?;
    if n < manifest.n_models() {
        let text = format!("has {n} of {} models: `gprimdb generate` goes on with it", manifest.n_models());
        return Err(Failure::input(&args.database, text));
    }
    let mut examples = Vec::new();
    for split in [Split::Train, Split::Validate] {
        let entries = database.of_split(split).map_err(wrong)?;
        examples.extend(entries.into_iter().filter_map(|entry| {
            let kind = entry.truth.class.kind()?;
            let values = entry.descriptor.into_iter().map(f64::from).collect();
            Some(Example { values, kind, group: entry.truth.group })
        }));
    }
    let too_few = |error: TooFew| Failure::input(&args.database, error);
    let folds = cross_validated(&examples, args.folds).map_err(too_few)?;
    println!("fold      C   gamma   accuracy");
    for (k, fold) in folds.iter().enumerate() {
        let parameters = fold.parameters;
        println!(
            "{:4}  2^{:+03.0}  2^{:+03.0}   {:6.2} %",
            k + 1,
            parameters.c.log2(),
            parameters.gamma.log2(),
            100.0 * fold.accuracy
        );
    }
    let n: usize = folds.iter().map(|fold| fold.answers.len()).sum();
    let n_right =
        folds.iter().flat_map(|fold| &fold.answers).filter(|(truth, answer)| truth == answer).count();
    println!("all                {:6.2} % of {n}", 100.0 * n_right as f64 / n.max(1) as f64);
    let provenance = format!("{} examples of a database of seed {}", examples.len(), manifest.seed);
    let classifier = Classifier::train(&examples, N_CELLS, &provenance).map_err(too_few)?;
    outputs::write(&[(&args.output, classifier.to_text().into_bytes())])?;
    println!("{}: trained on {provenance}", args.output.display());
    Ok(Code::Done)
}
