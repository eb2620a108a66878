//! A classifier for what the rules leave: support vectors on the descriptor `Gsh+s`.
//!
//! C. Cortes, V. Vapnik, "Support-vector networks", Machine Learning 20 (1995), 273-297, with the kernel
//! `exp(-gamma |x - y|^2)`, one class against one. Known of the thesis: supervised, `C` and `gamma` the best of each fold.
//! Here features are scaled to [0, 1] by the training part alone, folds are made of whole groups, so that no copy of a
//! training shape is tested, and classes weigh alike however many examples they have.

use libsvm_rs::io::{load_model_from_reader, save_model_to_writer};
use libsvm_rs::predict::{predict, predict_probability, predict_values};
use libsvm_rs::probability::sigmoid_train;
use libsvm_rs::train::svm_train;
use libsvm_rs::{KernelType, SvmModel, SvmNode, SvmParameter, SvmParameterBuilder, SvmProblem, SvmType};

use crate::par;
use crate::surface::SurfaceKind;

use super::{Accumulator, Cells, GaussImage, Rules, Voting};

/// A descriptor whose type is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// See [`super::Descriptor::values`].
    pub values: Vec<f64>,
    /// Its type.
    pub kind: SurfaceKind,
    /// Copies of one shape share a group.
    pub group: u32,
}

/// `C` and `gamma`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Price of an example on the wrong side.
    pub c: f64,
    /// Inverse square of the kernel's width.
    pub gamma: f64,
}

/// One fold of a cross-validation.
#[derive(Debug, Clone, PartialEq)]
pub struct Fold {
    /// The best on the fold's own training part.
    pub parameters: Parameters,
    /// Share of its test part that is named right.
    pub accuracy: f64,
    /// Pairs of truth and answer.
    pub answers: Vec<(SurfaceKind, SurfaceKind)>,
}

/// A trained classifier.
#[derive(Debug, Clone)]
pub struct Classifier {
    scale: Scale,
    model: SvmModel,
    n_cells: usize,
    /// What it was trained on: name and seed of the manifest.
    pub provenance: String,
}

/// Why a classifier cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("is no classifier of this program: {0}")]
pub struct ReadClassifierError(String);

/// Why nothing can be trained.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("two types with {LEAST_GROUPS} shapes each are needed, there are {0}")]
pub struct TooFew(usize);

/// Shapes of a type below which it cannot be trained and tested.
const LEAST_GROUPS: usize = 10;
/// First and last exponents of two that are tried, and the step between them.
const C_EXPONENTS: (i32, i32, usize) = (-5, 15, 2);
const GAMMA_EXPONENTS: (i32, i32, usize) = (-15, 3, 2);
/// First line of the text of a classifier.
const HEADER: &str = "scanwright classifier 1";
/// Decimals of scaled features: far finer than the votes of a thousand triangles.
const STEPS: f64 = 1e5;

impl Classifier {
    /// Trains on all examples, with the parameters that name one in five of their groups best.
    ///
    /// Probabilities are Platt's sigmoids (J. Platt, "Probabilistic outputs for support vector machines", 1999), fitted to
    /// folds of whole groups, not by the library, whose folds depend on what was trained before.
    pub fn train(examples: &[Example], n_cells: usize, provenance: &str) -> Result<Self, TooFew> {
        check(examples)?;
        libsvm_rs::set_quiet(true);
        let parameters = best_parameters(examples);
        let scale = Scale::of(examples);
        let mut model = svm_train(&scale.problem(examples), &settings(parameters, examples));
        let kinds: Vec<SurfaceKind> = model.label.iter().map(|l| SurfaceKind::ALL[*l as usize]).collect();
        let pairs: Vec<(SurfaceKind, SurfaceKind)> = (0..kinds.len())
            .flat_map(|i| (i + 1..kinds.len()).map(move |j| (i, j)))
            .map(|(i, j)| (kinds[i], kinds[j]))
            .collect();
        let sigmoids = par::map(&pairs, |pair| sigmoid(examples, *pair, &scale, parameters));
        (model.prob_a, model.prob_b) = sigmoids.into_iter().unzip();
        Ok(Self { scale, model, n_cells, provenance: provenance.to_owned() })
    }

    /// Types by probability, likeliest first.
    pub fn classify(&self, image: &GaussImage) -> Vec<(SurfaceKind, f64)> {
        let accumulator = Accumulator::new(image, &Cells::new(self.n_cells), Voting::Area);
        self.probabilities(&accumulator.descriptor().values())
    }

    /// The type by the rules where they are certain, else the likeliest, with its probability; `None` without an image.
    pub fn recognize(&self, rules: &Rules, image: &GaussImage) -> Option<(SurfaceKind, Option<f64>)> {
        let verdict = rules.recognize(image)?;
        if verdict.certain {
            return Some((verdict.kind, None));
        }
        let likeliest = self.classify(image).first().copied();
        Some(likeliest.map_or((verdict.kind, None), |(kind, probability)| (kind, Some(probability))))
    }

    fn probabilities(&self, values: &[f64]) -> Vec<(SurfaceKind, f64)> {
        let nodes = self.scale.nodes(values);
        let Some((_, probabilities)) = predict_probability(&self.model, &nodes) else { return Vec::new() };
        let kinds = self.model.label.iter().map(|label| SurfaceKind::ALL[*label as usize]);
        let mut found: Vec<(SurfaceKind, f64)> = kinds.zip(probabilities).collect();
        found.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        found
    }

    /// The classifier as text: what the features are divided by, then the model as LIBSVM writes it.
    pub fn to_text(&self) -> String {
        let row = |values: &[f64]| values.iter().map(|v| format!("{v:?}")).collect::<Vec<_>>().join(" ");
        let mut bytes = Vec::new();
        save_model_to_writer(&mut bytes, &self.model).expect("memory takes all");
        let model = String::from_utf8_lossy(&bytes);
        let (low, high) = (row(&self.scale.low), row(&self.scale.high));
        format!("{HEADER}\n{}\n{}\n{low}\n{high}\n{model}", self.provenance, self.n_cells)
    }

    /// Reads what [`Self::to_text`] wrote.
    pub fn from_text(text: &str) -> Result<Self, ReadClassifierError> {
        let broken = |what: &str| ReadClassifierError(what.to_owned());
        let mut lines = text.splitn(6, '\n');
        let mut line = |what: &str| lines.next().ok_or_else(|| ReadClassifierError(format!("no {what}")));
        if line("header")? != HEADER {
            return Err(broken("its first line is another"));
        }
        let provenance = line("provenance")?.to_owned();
        let n_cells = line("number of cells")?.parse().map_err(|_| broken("its number of cells is none"))?;
        let mut row = |what: &str| -> Result<Vec<f64>, ReadClassifierError> {
            let numbers: Result<Vec<f64>, _> = line(what)?.split(' ').map(str::parse).collect();
            numbers.map_err(|_| ReadClassifierError(format!("its {what} are no numbers")))
        };
        let (low, high) = (row("lowest features")?, row("highest features")?);
        let model = load_model_from_reader(line("model")?.as_bytes());
        let model = model.map_err(|error| ReadClassifierError(error.to_string()))?;
        let known = |label: &i32| (0..SurfaceKind::ALL.len() as i32).contains(label);
        let fits = |row: &[f64]| row.len().checked_sub(1) == Some(n_cells);
        if !fits(&low) || !fits(&high) || !model.label.iter().all(known) {
            return Err(broken("its parts do not fit together"));
        }
        Ok(Self { scale: Scale { low, high }, model, n_cells, provenance })
    }
}

/// `n_folds` folds, each trained with the parameters that are best within its own training part.
pub fn cross_validated(examples: &[Example], n_folds: u32) -> Result<Vec<Fold>, TooFew> {
    check(examples)?;
    libsvm_rs::set_quiet(true);
    let folds: Vec<u32> = (0..n_folds).collect();
    let fold = |&k: &u32| {
        let (test, train): (Vec<Example>, Vec<Example>) =
            examples.iter().cloned().partition(|e| place(e.group, n_folds) == k);
        let parameters = best_parameters(&train);
        let answers = answers(&train, &test, parameters);
        let n_right = answers.iter().filter(|(truth, answer)| truth == answer).count();
        Fold { parameters, accuracy: n_right as f64 / test.len().max(1) as f64, answers }
    };
    Ok(folds.iter().map(fold).collect())
}

/// Whether two types at least have as many groups as it takes.
fn check(examples: &[Example]) -> Result<(), TooFew> {
    let has_enough = |kind: &SurfaceKind| {
        let mut groups: Vec<u32> = examples.iter().filter(|e| e.kind == *kind).map(|e| e.group).collect();
        groups.sort_unstable();
        groups.dedup();
        groups.len() >= LEAST_GROUPS
    };
    let n = SurfaceKind::ALL.iter().filter(|kind| has_enough(kind)).count();
    if n < 2 { Err(TooFew(n)) } else { Ok(()) }
}

/// The sigmoid `1 / (1 + exp(a f + b))` of the decision values `f` between two types: those that examples have under
/// models trained without their groups.
fn sigmoid(
    examples: &[Example],
    (first, second): (SurfaceKind, SurfaceKind),
    scale: &Scale,
    parameters: Parameters,
) -> (f64, f64) {
    const N_FOLDS: u32 = 5;
    let of_pair: Vec<Example> =
        examples.iter().filter(|e| e.kind == first || e.kind == second).cloned().collect();
    let (mut decisions, mut sides) = (Vec::new(), Vec::new());
    for k in 0..N_FOLDS {
        let (test, train): (Vec<Example>, Vec<Example>) =
            of_pair.iter().cloned().partition(|e| place(e.group, N_FOLDS) == k);
        let has = |kind| train.iter().any(|e: &Example| e.kind == kind);
        if !has(first) || !has(second) {
            continue;
        }
        let model = svm_train(&scale.problem(&train), &settings(parameters, &train));
        // A model's decisions are positive for the class it met first.
        let towards = if model.label[0] as usize == label(first) { 1.0 } else { -1.0 };
        for example in &test {
            let mut decision = [0.0];
            predict_values(&model, &scale.nodes(&example.values), &mut decision);
            decisions.push(towards * decision[0]);
            sides.push(if example.kind == first { 1.0 } else { -1.0 });
        }
    }
    sigmoid_train(&decisions, &sides)
}

/// The fold of a group: groups of one class follow one another, and are dealt out in turn.
fn place(group: u32, n_folds: u32) -> u32 {
    group % n_folds.max(1)
}

/// The parameters that name most of one in five groups right, trained on the others: the smallest `C`, then `gamma`, of
/// equally good ones.
fn best_parameters(examples: &[Example]) -> Parameters {
    const N_FOLDS: u32 = 5;
    // Not the groups of one outer fold alone: those left out are dealt anew.
    let mut groups: Vec<u32> = examples.iter().map(|e| e.group).collect();
    groups.sort_unstable();
    groups.dedup();
    let (test, train): (Vec<Example>, Vec<Example>) = examples.iter().cloned().partition(|e| {
        let dealt = groups.binary_search(&e.group).unwrap_or(0) as u32;
        dealt.is_multiple_of(N_FOLDS)
    });
    let powers =
        |(first, last, step): (i32, i32, usize)| (first..=last).step_by(step).map(|k| 2.0_f64.powi(k));
    let grid: Vec<Parameters> = powers(C_EXPONENTS)
        .flat_map(|c| powers(GAMMA_EXPONENTS).map(move |gamma| Parameters { c, gamma }))
        .collect();
    let right = par::map(&grid, |parameters| {
        answers(&train, &test, *parameters).iter().filter(|(truth, answer)| truth == answer).count()
    });
    let best = (0..grid.len()).max_by_key(|&k| (right[k], std::cmp::Reverse(k)));
    best.map_or(Parameters { c: 1.0, gamma: 1.0 }, |k| grid[k])
}

/// Truth and answer for every example of `test`.
fn answers(train: &[Example], test: &[Example], parameters: Parameters) -> Vec<(SurfaceKind, SurfaceKind)> {
    let scale = Scale::of(train);
    let model = svm_train(&scale.problem(train), &settings(parameters, train));
    test.iter()
        .map(|e| (e.kind, SurfaceKind::ALL[predict(&model, &scale.nodes(&e.values)) as usize]))
        .collect()
}

fn settings(parameters: Parameters, examples: &[Example]) -> SvmParameter {
    let settings = SvmParameterBuilder::new()
        .svm_type(SvmType::CSvc)
        .kernel_type(KernelType::Rbf)
        .c(parameters.c)
        .gamma(parameters.gamma)
        .build()
        .expect("C and gamma are positive");
    SvmParameter { weight: weights(examples), ..settings }
}

/// One per class: its share of the price, so that all classes weigh alike.
fn weights(examples: &[Example]) -> Vec<(i32, f64)> {
    let count = |kind: SurfaceKind| examples.iter().filter(|e| e.kind == kind).count();
    let present: Vec<SurfaceKind> = SurfaceKind::ALL.into_iter().filter(|k| count(*k) > 0).collect();
    let mean = examples.len() as f64 / present.len().max(1) as f64;
    present.iter().map(|&kind| (label(kind) as i32, mean / count(kind) as f64)).collect()
}

fn label(kind: SurfaceKind) -> usize {
    SurfaceKind::ALL.iter().position(|k| *k == kind).expect("all kinds are there")
}

/// The range of every feature.
#[derive(Debug, Clone, PartialEq)]
struct Scale {
    low: Vec<f64>,
    high: Vec<f64>,
}

impl Scale {
    fn of(examples: &[Example]) -> Self {
        let n = examples.first().map_or(0, |e| e.values.len());
        let over = |k: usize, start: f64, pick: fn(f64, f64) -> f64| {
            examples.iter().map(|e| e.values[k]).fold(start, pick)
        };
        Self {
            low: (0..n).map(|k| over(k, f64::INFINITY, f64::min)).collect(),
            high: (0..n).map(|k| over(k, f64::NEG_INFINITY, f64::max)).collect(),
        }
    }

    /// Scaled features but those that are zero, numbered from one.
    fn nodes(&self, values: &[f64]) -> Vec<SvmNode> {
        let scaled = |k: usize| {
            let range = self.high[k] - self.low[k];
            let share = if range > 0.0 { (values[k] - self.low[k]) / range } else { 0.0 };
            (share * STEPS).round() / STEPS
        };
        let n = values.len().min(self.low.len());
        (0..n)
            .map(|k| SvmNode { index: k as i32 + 1, value: scaled(k) })
            .filter(|node| node.value != 0.0)
            .collect()
    }

    fn problem(&self, examples: &[Example]) -> SvmProblem {
        SvmProblem {
            labels: examples.iter().map(|e| label(e.kind) as f64).collect(),
            instances: examples.iter().map(|e| self.nodes(&e.values)).collect(),
        }
    }
}
