//! The histogram of deviations, in the colors of its scale.

use std::fmt::Write as _;

use super::number::{count, percent, short};
use crate::deviation::Histogram;
use crate::render::Diverging;

/// Sizes in the units of the drawing.
const WIDTH: f64 = 720.0;
const TOP: f64 = 18.0;
const BARS: f64 = 130.0;
const LEFT: f64 = 46.0;
const END: f64 = 26.0;
const GAP: f64 = 8.0;
const STRIP: f64 = 10.0;
const HEIGHT: f64 = TOP + BARS + 58.0;
/// More bins than can be told apart are not drawn.
const MOST_BINS: usize = 400;

/// Whether there is something to draw.
pub(super) fn can_show(histogram: &Histogram) -> bool {
    let limit = histogram.limit;
    limit.is_finite()
        && limit > 0.0
        && (1..=MOST_BINS).contains(&histogram.counts.len())
        && histogram.total() > 0
}

/// Bars over a strip of the scale's colors, between two bars of what lies beyond.
pub(super) fn histogram(histogram: &Histogram, unit: &str) -> String {
    let scale = Diverging { limit: histogram.limit };
    let most =
        histogram.counts.iter().chain([&histogram.below, &histogram.above]).max().copied().unwrap_or(1);
    let n = histogram.counts.len();
    let (from, to) = (LEFT + END + GAP, WIDTH - END - GAP - 4.0);
    let step = (to - from) / n as f64;
    let floor = TOP + BARS;
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"Histogram of the deviations\" \
         font-size=\"12\" fill=\"currentColor\">"
    );
    let mut bar = |x: f64, width: f64, count: usize, color: &str| {
        let height = BARS * count as f64 / most.max(1) as f64;
        let _ = write!(
            svg,
            "<rect x=\"{x:.2}\" y=\"{:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{color}\" \
             stroke=\"#5a5f66\" stroke-width=\"0.4\"/>",
            floor - height
        );
    };
    for (k, count) in histogram.counts.iter().enumerate() {
        let middle = histogram.limit * ((2 * k + 1) as f64 / n as f64 - 1.0);
        bar(from + step * k as f64, step, *count, &scale.color(middle).hex());
    }
    let [under, over] = Diverging::BEYOND.map(crate::render::Color::hex);
    bar(LEFT, END, histogram.below, &under);
    bar(to + GAP, END, histogram.above, &over);
    axes(&mut svg, histogram, (from, to), most, unit);
    svg.push_str("</svg>");
    svg
}

/// Colors, numbers and lines.
fn axes(svg: &mut String, histogram: &Histogram, (from, to): (f64, f64), most: usize, unit: &str) {
    let floor = TOP + BARS;
    let scale = Diverging { limit: histogram.limit };
    const N_STRIPS: usize = 96;
    let step = (to - from) / N_STRIPS as f64;
    let mut strip = |x: f64, width: f64, color: &str| {
        let _ = write!(
            svg,
            "<rect x=\"{x:.2}\" y=\"{:.2}\" width=\"{width:.2}\" height=\"{STRIP}\" fill=\"{color}\"/>",
            floor + 4.0
        );
    };
    for k in 0..N_STRIPS {
        let value = histogram.limit * ((2 * k + 1) as f64 / N_STRIPS as f64 - 1.0);
        // A little wider, so that no seam shows between two.
        strip(from + step * k as f64, step + 0.4, &scale.color(value).hex());
    }
    let [under, over] = Diverging::BEYOND.map(crate::render::Color::hex);
    strip(LEFT, END, &under);
    strip(to + GAP, END, &over);
    let mut text = |x: f64, y: f64, anchor: &str, text: &str| {
        let text = super::write::escaped(text);
        let _ = write!(svg, "<text x=\"{x:.2}\" y=\"{y:.2}\" text-anchor=\"{anchor}\">{text}</text>");
    };
    for k in -2..=2 {
        let share = f64::from(k) / 2.0;
        let value = share * histogram.limit;
        let label = super::number::trimmed(&short(Some(value)));
        let label = if k > 0 { format!("+{label}") } else { label };
        text(from + (to - from) * (share + 1.0) / 2.0, floor + 30.0, "middle", &label);
    }
    text(LEFT, floor + 50.0, "start", &format!("below: {}", count(histogram.below)));
    text(to + GAP + END, floor + 50.0, "end", &format!("above: {}", count(histogram.above)));
    text(0.5 * (from + to), floor + 50.0, "middle", &format!("signed deviation ({unit}), positive outside"));
    let share = percent(Some(most as f64 / histogram.total().max(1) as f64));
    text(LEFT - 6.0, TOP + 4.0, "end", &format!("{share} %"));
    text(LEFT - 6.0, floor, "end", "0");
    let middle = 0.5 * (from + to);
    let _ = write!(
        svg,
        "<path d=\"M{LEFT} {floor}H{:.2}M{middle:.2} {TOP}V{:.2}\" stroke=\"#5a5f66\" stroke-width=\"0.8\" \
         stroke-dasharray=\"none\" fill=\"none\"/>",
        WIDTH - 4.0,
        floor + 18.0
    );
}
