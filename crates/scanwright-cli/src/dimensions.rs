//! Relations and dimensions in the summary.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use scanwright::dimension::{Dimension, DimensionKind, Quantity};
use scanwright::pipeline::{Options, Reconstruction};
use scanwright::regularize::RelationKind;

/// Diameters that are written out; the JSON has all dimensions.
const MOST_DIAMETERS: usize = 5;
/// Standard uncertainties of a 95 % interval.
const WIDE: f64 = 2.0;

/// How many relations of each kind were made exact, and how many refused; `None` when there are none.
pub fn relations_line(result: &Reconstruction) -> Option<String> {
    let mut counts: BTreeMap<RelationKind, usize> = BTreeMap::new();
    for relation in result.relations.iter().filter(|relation| relation.accepted) {
        *counts.entry(relation.kind).or_default() += 1;
    }
    let n_refused = result.relations.iter().filter(|relation| !relation.accepted).count();
    let named = |(kind, n): (&RelationKind, &usize)| format!("{n} {}", relation_name(*kind));
    let mut parts: Vec<String> = counts.iter().map(named).collect();
    if n_refused > 0 {
        parts.push(format!("{n_refused} refused"));
    }
    (!parts.is_empty()).then(|| parts.join(", "))
}

fn relation_name(kind: RelationKind) -> &'static str {
    match kind {
        RelationKind::Parallel => "parallel",
        RelationKind::Perpendicular => "perpendicular",
        RelationKind::CommonAngle => "at a common angle",
        RelationKind::Coaxial => "coaxial",
        RelationKind::Coplanar => "coplanar",
        RelationKind::EqualRadius => "of equal radius",
        RelationKind::EqualHalfAngle => "of equal half-angle",
        RelationKind::EqualMajorRadius => "of equal major radius",
        RelationKind::EqualMinorRadius => "of equal minor radius",
        RelationKind::Intersecting => "meeting in a point",
        RelationKind::CircularPattern => "around a circle",
        RelationKind::EqualSpacing => "equally spaced",
        RelationKind::RectangularPattern => "in a rectangle",
    }
}

/// How many dimensions there are and what they are worth, then the largest diameters.
pub fn dimension_lines(result: &Reconstruction, options: &Options, unit: &str) -> Vec<String> {
    let all = &result.dimensions;
    if all.is_empty() {
        return Vec::new();
    }
    let count = |f: &dyn Fn(&Dimension) -> bool| all.iter().filter(|d| f(d)).count();
    let near = count(&|d| d.nominal.is_some());
    let guesses = count(&|d| d.guess.is_some());
    let applied = count(&|d| d.nominal.as_ref().is_some_and(|nominal| nominal.applied));
    let round = if options.snap {
        format!("{near} near a round value, {applied} of these applied")
    } else {
        format!("{near} near a round value (offered, --snap applies them)")
    };
    let mut lines = vec![format!("{}: {round}, {guesses} guesses", all.len())];
    let mut diameters: Vec<&Dimension> =
        all.iter().filter(|d| d.kind == DimensionKind::Diameter && d.guess.is_none()).collect();
    diameters.sort_by(|a, b| b.value.total_cmp(&a.value).then(a.id.cmp(&b.id)));
    lines.extend(diameters.into_iter().take(MOST_DIAMETERS).map(|d| described(d, unit)));
    lines
}

fn described(dimension: &Dimension, unit: &str) -> String {
    debug_assert_eq!(dimension.quantity, Quantity::Length, "diameters are lengths");
    let half = WIDE * dimension.uncertainty;
    let decimals = decimals(half);
    let arc = dimension.evidence.arc.map_or(0.0, f64::to_degrees);
    let mut text = format!(
        "diameter {:.decimals$} +- {half:.decimals$} {unit} of primitive {} ({arc:.0} degrees seen)",
        dimension.value, dimension.of[0],
    );
    if let Some(nominal) = &dimension.nominal {
        let word = if nominal.applied { "made" } else { "near" };
        let _ = write!(text, ", {word} {} ({})", trimmed(nominal.value), nominal.grid);
    }
    text
}

/// Decimals that show two digits of `uncertainty`.
fn decimals(uncertainty: f64) -> usize {
    const MOST: f64 = 9.0;
    if uncertainty > 0.0 { (1.0 - uncertainty.log10().floor()).clamp(0.0, MOST) as usize } else { 3 }
}

/// A round number as people write it.
fn trimmed(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
