//! Pictures: charts and spheres side by side in one SVG file, the same bytes every time.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use scanwright::math::Vec3;

/// Colors that people with any color vision tell apart: M. Okabe, K. Ito, "Color universal design" (2008).
pub const COLORS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
/// From few to many.
pub const HEAT: [&str; 6] = ["#7fb8da", "#2f7fbc", "#3b3f9c", "#8e2a8b", "#d0325a", "#f0641e"];

/// Panels in rows, under one legend.
pub struct Figure {
    /// Panels, row by row.
    pub panels: Vec<Panel>,
    /// Panels per row.
    pub columns: usize,
    /// Width and height of a panel, pixels.
    pub size: [f64; 2],
    /// Names with their colors, for spheres; charts name their own series.
    pub legend: Vec<(String, &'static str)>,
}

/// One of a figure.
pub enum Panel {
    /// Series over two axes.
    Chart(Chart),
    /// Points on the unit sphere.
    Sphere(Sphere),
    /// Nothing, so that what follows stands in its column.
    Blank,
}

/// Series over two axes.
pub struct Chart {
    /// Above it.
    pub title: String,
    /// Horizontal.
    pub x: Axis,
    /// Vertical.
    pub y: Axis,
    /// In the order of drawing.
    pub series: Vec<Series>,
    /// Texts above places.
    pub notes: Vec<([f64; 2], String)>,
}

/// An axis with its ticks.
#[derive(Clone)]
pub struct Axis {
    label: String,
    range: [f64; 2],
    is_log: bool,
    /// Values with their texts, whose lines end in `\n`.
    ticks: Vec<(f64, String)>,
    has_grid: bool,
}

/// How a series is drawn.
#[derive(Clone, Copy, PartialEq)]
pub enum Mark {
    /// A line.
    Line,
    /// A thin line, where there are many.
    Hair,
    /// A dashed line, for limits.
    Dashes,
    /// A line with a dot at every point.
    DottedLine,
    /// Dots alone.
    Dots,
    /// Bars from the axis up, so wide.
    Bars(f64),
}

/// Points with a name; those without stay out of the legend.
pub struct Series {
    /// In the legend.
    pub name: String,
    /// One of [`COLORS`].
    pub color: usize,
    /// How it is drawn.
    pub mark: Mark,
    /// In units of the axes.
    pub points: Vec<[f64; 2]>,
}

/// Points on the unit sphere, seen along -z.
pub struct Sphere {
    /// Above it.
    pub title: String,
    /// Direction, and which color of [`HEAT`].
    pub points: Vec<(Vec3, usize)>,
    /// The pole of the equator that is drawn.
    pub pole: Vec3,
}

const LEFT: f64 = 56.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 46.0;
const LEGEND: f64 = 34.0;
const LINE: f64 = 13.0;
const INK: &str = "#333333";

impl Axis {
    /// An axis with about six round ticks.
    pub fn linear(label: &str, range: [f64; 2]) -> Self {
        let step = round_step((range[1] - range[0]) / 6.0);
        /// Of a step: a tick at the very end is not lost to rounding.
        const ROUNDING: f64 = 1e-9;
        let first = (range[0] / step - ROUNDING).ceil() as i64;
        let last = (range[1] / step + ROUNDING).floor() as i64;
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let tick = |k: i64| (k as f64 * step, format!("{:.decimals$}", k as f64 * step));
        Self::with_ticks(label, range, (first..=last).map(tick).collect())
    }

    /// An axis of logarithms with ticks where they are asked for.
    pub fn log(label: &str, range: [f64; 2], ticks: &[f64]) -> Self {
        let ticks = ticks.iter().map(|t| (*t, format!("{t}"))).collect();
        Self { is_log: true, ..Self::with_ticks(label, range, ticks) }
    }

    /// Names at 0, 1, 2 and so on.
    pub fn names(label: &str, names: &[String]) -> Self {
        let ticks = names.iter().enumerate().map(|(k, name)| (k as f64, name.clone())).collect();
        let range = [-0.6, names.len() as f64 - 0.4];
        Self { has_grid: false, ..Self::with_ticks(label, range, ticks) }
    }

    fn with_ticks(label: &str, range: [f64; 2], ticks: Vec<(f64, String)>) -> Self {
        Self { label: label.to_owned(), range, is_log: false, ticks, has_grid: true }
    }

    /// Share of the axis at which a value lies.
    fn share(&self, value: f64) -> f64 {
        let at = |v: f64| if self.is_log { v.ln() } else { v };
        (at(value) - at(self.range[0])) / (at(self.range[1]) - at(self.range[0]))
    }

    fn n_lines(&self) -> usize {
        self.ticks.iter().map(|tick| tick.1.split('\n').count()).max().unwrap_or(1)
    }
}

/// One, two or five times a power of ten, not below `step`.
fn round_step(step: f64) -> f64 {
    let power = 10.0_f64.powf(step.log10().floor());
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|f| f * power >= 0.999 * step);
    factor.unwrap_or(10.0) * power
}

impl Chart {
    /// A chart of groups of bars, one per name of the axis and series.
    pub fn bars(title: &str, groups: &[String], y: Axis, series: &[(&str, Vec<f64>)]) -> Self {
        let width = 0.84 / series.len().max(1) as f64;
        let mut chart = Self {
            title: title.to_owned(),
            x: Axis::names("", groups),
            y,
            series: Vec::new(),
            notes: Vec::new(),
        };
        for (k, (name, values)) in series.iter().enumerate() {
            let offset = width * (k as f64 - 0.5 * (series.len() - 1) as f64);
            let points: Vec<[f64; 2]> =
                values.iter().enumerate().map(|(group, value)| [group as f64 + offset, *value]).collect();
            let words = |value: f64| format!("{value:.1}").trim_end_matches(".0").to_owned();
            chart.notes.extend(points.iter().map(|point| (*point, words(point[1]))));
            let mark = Mark::Bars(0.92 * width);
            chart.series.push(Series { name: (*name).to_owned(), color: k, mark, points });
        }
        chart
    }
}

impl Figure {
    /// Charts of one size.
    pub fn of_charts(columns: usize, size: [f64; 2], charts: Vec<Chart>) -> Self {
        Self { panels: charts.into_iter().map(Panel::Chart).collect(), columns, size, legend: Vec::new() }
    }

    /// Writes `name.svg` into a folder.
    pub fn write(&self, folder: &Path, name: &str) -> anyhow::Result<()> {
        fs::create_dir_all(folder)?;
        fs::write(folder.join(name).with_extension("svg"), self.svg())?;
        Ok(())
    }

    /// The picture as text.
    pub fn svg(&self) -> String {
        let [width, height] = self.size;
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let rows = self.panels.len().div_ceil(columns);
        let legend = self.legend();
        let above = if legend.is_empty() { 4.0 } else { LEGEND };
        let (w, h) = (width * columns as f64, height * rows as f64 + above);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w:.0}\" height=\"{h:.0}\" viewBox=\"0 0 {w:.0} {h:.0}\" \
             font-family=\"Helvetica, Arial, sans-serif\" font-size=\"11\" fill=\"{INK}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        );
        draw_legend(&mut svg, &legend, w);
        for (k, panel) in self.panels.iter().enumerate() {
            let (x, y) = ((k % columns) as f64 * width, (k / columns) as f64 * height + above);
            let _ = writeln!(svg, "<g transform=\"translate({x:.0} {y:.0})\">");
            match panel {
                Panel::Chart(chart) => chart.draw(&mut svg, self.size),
                Panel::Sphere(sphere) => sphere.draw(&mut svg, self.size),
                Panel::Blank => {}
            }
            svg.push_str("</g>\n");
        }
        svg.push_str("</svg>\n");
        svg
    }

    /// Names, colors and marks, each name once.
    fn legend(&self) -> Vec<(String, &'static str, Mark)> {
        let mut found: Vec<(String, &'static str, Mark)> =
            self.legend.iter().map(|(name, color)| (name.clone(), *color, Mark::Dots)).collect();
        for panel in &self.panels {
            let Panel::Chart(chart) = panel else { continue };
            for series in chart.series.iter().filter(|s| !s.name.is_empty()) {
                if !found.iter().any(|known| known.0 == series.name) {
                    found.push((series.name.clone(), COLORS[series.color % COLORS.len()], series.mark));
                }
            }
        }
        found
    }
}

/// Entries in a row, centered in the width.
fn draw_legend(svg: &mut String, legend: &[(String, &'static str, Mark)], width: f64) {
    // Width of a letter on average.
    let length = |name: &str| 40.0 + 6.3 * name.chars().count() as f64;
    let total: f64 = legend.iter().map(|entry| length(&entry.0)).sum();
    let mut x = (0.5 * (width - total)).max(6.0);
    for (name, color, mark) in legend {
        let y = 0.5 * LEGEND;
        let _ = match mark {
            Mark::Dots => {
                writeln!(svg, "<circle cx=\"{:.1}\" cy=\"{y}\" r=\"4\" fill=\"{color}\"/>", x + 10.0)
            }
            Mark::Bars(_) => {
                writeln!(
                    svg,
                    "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"16\" height=\"10\" fill=\"{color}\"/>",
                    y - 5.0
                )
            }
            mark => {
                let dashes = if *mark == Mark::Dashes { " stroke-dasharray=\"5 3\"" } else { "" };
                writeln!(svg, "<path d=\"M{x:.1} {y}h18\" stroke=\"{color}\" stroke-width=\"2\"{dashes}/>")
            }
        };
        text(svg, [x + 23.0, y + 4.0], "start", name);
        x += length(name);
    }
}

fn text(svg: &mut String, [x, y]: [f64; 2], anchor: &str, words: &str) {
    let words = words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>");
}

fn title(svg: &mut String, words: &str, center: f64) {
    let _ = write!(svg, "<g font-size=\"12\" font-weight=\"bold\">");
    text(svg, [center, 18.0], "middle", words);
    svg.push_str("</g>\n");
}

impl Chart {
    fn draw(&self, svg: &mut String, [width, height]: [f64; 2]) {
        let bottom = BOTTOM + LINE * (self.x.n_lines() as f64 - 1.0)
            - if self.x.label.is_empty() { 16.0 } else { 0.0 };
        let (w, h) = (width - LEFT - RIGHT, height - TOP - bottom);
        let place = |[x, y]: [f64; 2]| [LEFT + w * self.x.share(x), TOP + h * (1.0 - self.y.share(y))];
        title(svg, &self.title, LEFT + 0.5 * w);
        self.draw_axes(svg, [w, h]);
        for (k, series) in self.series.iter().enumerate() {
            // The first are the widest, so that they are seen beneath later ones that coincide with them.
            let wider =
                if series.mark == Mark::DottedLine { (self.series.len() - 1 - k) as f64 } else { 0.0 };
            series.draw(svg, place, TOP + h, wider);
        }
        let _ = writeln!(svg, "<g font-size=\"9\">");
        for (at, words) in &self.notes {
            let [x, y] = place(*at);
            text(svg, [x, y - 4.0], "middle", words);
        }
        svg.push_str("</g>\n");
    }

    fn draw_axes(&self, svg: &mut String, [w, h]: [f64; 2]) {
        let floor = TOP + h;
        let mut grid = String::new();
        for (value, words) in &self.x.ticks {
            let x = LEFT + w * self.x.share(*value);
            if self.x.has_grid {
                let _ = write!(grid, "M{x:.1} {TOP}v{h:.1}");
            }
            for (line, words) in words.split('\n').enumerate() {
                text(svg, [x, floor + 15.0 + LINE * line as f64], "middle", words);
            }
        }
        for (value, words) in &self.y.ticks {
            let y = floor - h * self.y.share(*value);
            let _ = write!(grid, "M{LEFT} {y:.1}h{w:.1}");
            text(svg, [LEFT - 6.0, y + 4.0], "end", words);
        }
        let _ = writeln!(svg, "<path d=\"{grid}\" stroke=\"#e4e4e4\"/>");
        let _ = writeln!(svg, "<path d=\"M{LEFT} {TOP}v{h:.1}h{w:.1}\" fill=\"none\" stroke=\"{INK}\"/>");
        let below = floor + 17.0 + LINE * self.x.n_lines() as f64;
        text(svg, [LEFT + 0.5 * w, below], "middle", &self.x.label);
        let (x, y) = (14.0, TOP + 0.5 * h);
        let _ = writeln!(svg, "<g transform=\"rotate(-90 {x} {y:.1})\">");
        text(svg, [x, y], "middle", &self.y.label);
        svg.push_str("</g>\n");
    }
}

impl Series {
    /// `place` gives pixels, `floor` is where bars stand, `wider` are pixels more than usual.
    fn draw(&self, svg: &mut String, place: impl Fn([f64; 2]) -> [f64; 2], floor: f64, wider: f64) {
        let color = COLORS[self.color % COLORS.len()];
        let seen = self.points.iter().filter(|p| place(**p).iter().all(|at| at.is_finite()));
        let at: Vec<[f64; 2]> = seen.map(|p| place(*p)).collect();
        if let Mark::Bars(width) = self.mark {
            let half = 0.5 * (place([width, 1.0])[0] - place([0.0, 1.0])[0]);
            let bars = at
                .iter()
                .map(|[x, y]| format!("M{:.1} {floor:.1}V{y:.1}h{:.1}V{floor:.1}z", x - half, 2.0 * half));
            let _ = writeln!(svg, "<path d=\"{}\" fill=\"{color}\"/>", bars.collect::<String>());
            return;
        }
        if self.mark != Mark::Dots {
            let (width, more) = match self.mark {
                Mark::Hair => (1.0, " stroke-opacity=\"0.7\""),
                Mark::Dashes => (1.5, " stroke-dasharray=\"5 3\""),
                Mark::DottedLine => (1.6 + wider, ""),
                _ => (2.0, ""),
            };
            let line: Vec<String> = at.iter().map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
            let _ = writeln!(
                svg,
                "<path d=\"M{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{more}/>",
                line.join("L")
            );
        }
        if matches!(self.mark, Mark::Dots | Mark::DottedLine) {
            let dots = dots(&at);
            let _ = writeln!(
                svg,
                "<path d=\"{dots}\" stroke=\"{color}\" stroke-width=\"{}\" stroke-linecap=\"round\" stroke-opacity=\"0.85\"/>",
                5.5 + wider
            );
        }
    }
}

/// A line without length, with round ends, is a dot in few letters.
fn dots(places: &[[f64; 2]]) -> String {
    places.iter().map(|[x, y]| format!("M{x:.1} {y:.1}h0")).collect::<Vec<_>>().concat()
}

impl Sphere {
    fn draw(&self, svg: &mut String, [width, height]: [f64; 2]) {
        title(svg, &self.title, 0.5 * width);
        let radius = 0.5 * (width.min(height - TOP) - 16.0);
        let center = [0.5 * width, TOP + 0.5 * (height - TOP - 8.0)];
        let place = |v: &Vec3| [center[0] + radius * v.x, center[1] - radius * v.y];
        let [x, y] = center;
        let _ = writeln!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"#fafafa\" stroke=\"#999999\"/>"
        );
        self.draw_equator(svg, place);
        for is_front in [false, true] {
            let opacity = if is_front { 0.95 } else { 0.22 };
            let size = if is_front { 4.4 } else { 3.6 };
            for (k, color) in HEAT.iter().enumerate() {
                let seen = self.points.iter().filter(|(v, heat)| *heat == k && (v.z >= 0.0) == is_front);
                // Of a plane's normals, which all fall on one spot, one is enough.
                let mut places: Vec<[i64; 2]> =
                    seen.map(|(v, _)| place(v).map(|at| (10.0 * at).round() as i64)).collect();
                places.sort_unstable();
                places.dedup();
                if places.is_empty() {
                    continue;
                }
                let places: Vec<[f64; 2]> = places.iter().map(|at| at.map(|at| at as f64 / 10.0)).collect();
                let dots = dots(&places);
                let _ = writeln!(
                    svg,
                    "<path d=\"{dots}\" stroke=\"{color}\" stroke-width=\"{size}\" stroke-linecap=\"round\" \
                     stroke-opacity=\"{opacity}\"/>"
                );
            }
        }
    }

    /// The great circle about the pole: its front, and its back in dashes.
    fn draw_equator(&self, svg: &mut String, place: impl Fn(&Vec3) -> [f64; 2]) {
        const N: usize = 72;
        // The view is along z: where the circle crosses its outline, and a quarter of the turn to the front.
        let side = Vec3::z().cross(&self.pole).try_normalize(0.0).unwrap_or_else(Vec3::x);
        let front = self.pole.cross(&side);
        let toward = if front.z < 0.0 { -front } else { front };
        for (sign, dashes) in [(1.0, ""), (-1.0, " stroke-dasharray=\"3 3\"")] {
            let points = (0..=N).map(|k| {
                let (sin, cos) = (0.5 * TAU * k as f64 / N as f64).sin_cos();
                let [x, y] = place(&(side * cos + toward * (sign * sin)));
                format!("{x:.1} {y:.1}")
            });
            let line = points.collect::<Vec<_>>().join("L");
            let _ = writeln!(svg, "<path d=\"M{line}\" fill=\"none\" stroke=\"#bbbbbb\"{dashes}/>");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        let of = |low, high| Axis::linear("", [low, high]).ticks.into_iter().map(|t| t.1).collect::<Vec<_>>();
        assert_eq!(of(0.0, 100.0), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(of(-0.1, 0.45), ["-0.1", "0.0", "0.1", "0.2", "0.3", "0.4"]);
        assert_eq!(of(-2.0, 9.0), ["-2", "0", "2", "4", "6", "8"]);
    }

    #[test]
    fn words_are_escaped_and_the_bytes_are_the_same() {
        let figure = || {
            let y = Axis::linear("a < b", [0.0, 1.0]);
            Figure::of_charts(
                1,
                [300.0, 200.0],
                vec![Chart::bars("x & y", &["one".into()], y, &[("s", vec![0.5])])],
            )
        };
        let svg = figure().svg();
        assert!(svg.contains("a &lt; b") && svg.contains("x &amp; y"), "{svg}");
        assert_eq!(svg, figure().svg(), "deterministic");
    }
}
