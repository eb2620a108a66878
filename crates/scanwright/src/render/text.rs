//! Letters as strokes: lines and arcs with round ends, so that any size is smooth.
//!
//! Units: the x-height is 1; ascenders reach 1.45, descenders -0.45. Letters that are not here are left out.

use super::{Canvas, palette};

/// Stroke width in x-heights.
const STROKE: f64 = 0.15;
/// Space between letters, and the width of a blank, in x-heights.
const GAP: f64 = 0.30;
const BLANK: f64 = 0.45;
/// x-height as a share of the text's size.
const X_HEIGHT: f64 = 0.52;

/// A stroke of a letter; `y` grows upwards from the baseline.
enum Stroke {
    /// From one point to another.
    Line([f64; 4]),
    /// Center, radii, start angle and sweep in quarter turns, counter-clockwise from the right.
    Arc([f64; 6]),
}

use Stroke::{Arc, Line};

/// Advances by `text` at `size`, pixels.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let advance: f64 = text.chars().map(|c| glyph(c).0 + GAP).sum();
    (advance - GAP).max(0.0) * X_HEIGHT * size
}

/// Draws `text` with its baseline starting at (`x`, `y`), pixels from the top left.
pub(super) fn draw(canvas: &mut Canvas, text: &str, mut x: f64, y: f64, size: f64) {
    let unit = X_HEIGHT * size;
    for c in text.chars() {
        let (advance, strokes) = glyph(c);
        draw_glyph(canvas, &strokes, x, y, unit, advance);
        x += (advance + GAP) * unit;
    }
}

fn draw_glyph(canvas: &mut Canvas, strokes: &[Stroke], x: f64, y: f64, unit: f64, advance: f64) {
    let ink = palette::INK.linear();
    let half = 0.5 * STROKE * unit;
    let (left, right) = ((x - unit * 0.3) as i64, (x + unit * (advance + 0.3)).ceil() as i64);
    let (top, bottom) = ((y - unit * 1.8) as i64, (y + unit * 0.8).ceil() as i64);
    for py in top..=bottom {
        for px in left..=right {
            let u = (px as f64 + 0.5 - x) / unit;
            let v = (y - py as f64 - 0.5) / unit;
            let distance = strokes.iter().map(|s| s.distance(u, v)).fold(f64::INFINITY, f64::min);
            let cover = (half - distance * unit + 0.5).clamp(0.0, 1.0);
            if cover > 0.0 {
                canvas.blend(px, py, ink, cover);
            }
        }
    }
}

impl Stroke {
    fn distance(&self, x: f64, y: f64) -> f64 {
        match *self {
            Line([x0, y0, x1, y1]) => {
                let (dx, dy) = (x1 - x0, y1 - y0);
                let length_sq = dx * dx + dy * dy;
                let t = if length_sq > 0.0 { ((x - x0) * dx + (y - y0) * dy) / length_sq } else { 0.0 };
                let t = t.clamp(0.0, 1.0);
                (x - x0 - t * dx).hypot(y - y0 - t * dy)
            }
            Arc([cx, cy, rx, ry, start, sweep]) => {
                // Short chords: the curve is within a hundredth of a stroke of them.
                const N_CHORDS: usize = 20;
                let at = |i: usize| {
                    let quarter = start + sweep * i as f64 / N_CHORDS as f64;
                    let angle = quarter * std::f64::consts::FRAC_PI_2;
                    (cx + rx * angle.cos(), cy + ry * angle.sin())
                };
                (0..N_CHORDS)
                    .map(|i| {
                        let ((x0, y0), (x1, y1)) = (at(i), at(i + 1));
                        Line([x0, y0, x1, y1]).distance(x, y)
                    })
                    .fold(f64::INFINITY, f64::min)
            }
        }
    }
}

/// Width and strokes of a letter.
#[expect(clippy::too_many_lines, reason = "one table")]
fn glyph(c: char) -> (f64, Vec<Stroke>) {
    /// The round bowl most small letters share.
    fn bowl() -> Stroke {
        Arc([0.48, 0.5, 0.48, 0.5, 0.0, 4.0])
    }
    /// An upright at `x`.
    fn stem(x: f64, bottom: f64, top: f64) -> Stroke {
        Line([x, bottom, x, top])
    }
    /// The shoulder of n, m, h and its right leg.
    fn shoulder(x: f64, width: f64) -> [Stroke; 2] {
        let r = width / 2.0;
        [Arc([x + r, 1.0 - r, r, r, 0.0, 2.0]), Line([x + width, 0.0, x + width, 1.0 - r])]
    }
    let [arch, leg] = shoulder(0.0, 0.8);
    match c {
        'a' => (0.96, vec![bowl(), stem(0.96, 0.0, 1.0)]),
        'b' => (0.96, vec![bowl(), stem(0.0, 0.0, 1.45)]),
        'c' => (0.84, vec![Arc([0.48, 0.5, 0.48, 0.5, 0.5, 3.0])]),
        'd' => (0.96, vec![bowl(), stem(0.96, 0.0, 1.45)]),
        'e' => (0.94, vec![Arc([0.48, 0.5, 0.48, 0.5, 0.0, 3.45]), Line([0.0, 0.5, 0.96, 0.5])]),
        'f' => (
            0.55,
            vec![Arc([0.5, 1.15, 0.3, 0.3, 1.0, 1.0]), stem(0.2, 0.0, 1.15), Line([0.0, 1.0, 0.5, 1.0])],
        ),
        'g' => (0.96, vec![bowl(), stem(0.96, 0.05, 1.0), Arc([0.48, 0.02, 0.48, 0.47, 2.5, 1.5])]),
        'h' => (0.8, vec![stem(0.0, 0.0, 1.45), arch, leg]),
        'i' => (0.06, vec![stem(0.03, 0.0, 1.0), stem(0.03, 1.38, 1.4)]),
        'j' => (
            0.3,
            vec![stem(0.27, -0.15, 1.0), stem(0.27, 1.38, 1.4), Arc([0.0, -0.15, 0.27, 0.3, 3.0, 1.0])],
        ),
        'k' => (0.74, vec![stem(0.0, 0.0, 1.45), Line([0.0, 0.4, 0.68, 1.0]), Line([0.24, 0.6, 0.74, 0.0])]),
        'l' => (0.06, vec![stem(0.03, 0.0, 1.45)]),
        'm' => {
            let [a, b] = shoulder(0.0, 0.64);
            let [p, q] = shoulder(0.64, 0.64);
            (1.28, vec![stem(0.0, 0.0, 1.0), a, b, p, q])
        }
        'n' => (0.8, vec![stem(0.0, 0.0, 1.0), arch, leg]),
        'o' => (0.96, vec![bowl()]),
        'p' => (0.96, vec![bowl(), stem(0.0, -0.45, 1.0)]),
        'q' => (0.96, vec![bowl(), stem(0.96, -0.45, 1.0)]),
        'r' => (0.5, vec![stem(0.0, 0.0, 1.0), Arc([0.42, 0.58, 0.42, 0.42, 0.9, 1.1])]),
        's' => (
            0.68,
            vec![Arc([0.34, 0.75, 0.32, 0.25, 0.35, 2.65]), Arc([0.34, 0.25, 0.34, 0.25, 2.35, 2.65])],
        ),
        't' => (
            0.56,
            vec![stem(0.2, 0.26, 1.35), Arc([0.46, 0.26, 0.26, 0.26, 2.0, 1.1]), Line([0.0, 1.0, 0.52, 1.0])],
        ),
        'u' => (
            0.8,
            vec![stem(0.0, 0.4, 1.0), Arc([0.4, 0.4, 0.4, 0.4, 2.0, 2.0]), stem(0.8, 0.0, 1.0)],
        ),
        'v' => (0.84, vec![Line([0.0, 1.0, 0.42, 0.0]), Line([0.42, 0.0, 0.84, 1.0])]),
        'w' => (
            1.2,
            vec![
                Line([0.0, 1.0, 0.32, 0.0]),
                Line([0.32, 0.0, 0.6, 1.0]),
                Line([0.6, 1.0, 0.88, 0.0]),
                Line([0.88, 0.0, 1.2, 1.0]),
            ],
        ),
        'x' => (0.78, vec![Line([0.0, 0.0, 0.78, 1.0]), Line([0.0, 1.0, 0.78, 0.0])]),
        'y' => (0.84, vec![Line([0.0, 1.0, 0.42, 0.0]), Line([0.84, 1.0, 0.22, -0.45])]),
        'z' => (
            0.72,
            vec![Line([0.0, 1.0, 0.72, 1.0]), Line([0.72, 1.0, 0.0, 0.0]), Line([0.0, 0.0, 0.72, 0.0])],
        ),
        '0' => (0.86, vec![Arc([0.43, 0.7, 0.43, 0.7, 0.0, 4.0])]),
        '1' => (0.4, vec![Line([0.0, 1.15, 0.36, 1.4]), stem(0.36, 0.0, 1.4)]),
        '2' => (
            0.82,
            vec![
                Arc([0.41, 1.0, 0.39, 0.4, -0.4, 2.3]),
                Line([0.73, 0.77, 0.0, 0.0]),
                Line([0.0, 0.0, 0.82, 0.0]),
            ],
        ),
        '3' => (
            0.78,
            vec![Arc([0.37, 1.06, 0.34, 0.34, -1.0, 2.8]), Arc([0.37, 0.37, 0.4, 0.37, 2.2, 2.8])],
        ),
        '4' => (
            0.9,
            vec![Line([0.66, 0.0, 0.66, 1.4]), Line([0.66, 1.4, 0.0, 0.4]), Line([0.0, 0.4, 0.9, 0.4])],
        ),
        '5' => (
            0.8,
            vec![
                Line([0.74, 1.4, 0.16, 1.4]),
                Line([0.16, 1.4, 0.1, 0.76]),
                Arc([0.37, 0.44, 0.43, 0.44, 2.3, 3.1]),
            ],
        ),
        '6' => (0.84, vec![Arc([0.42, 0.44, 0.42, 0.44, 0.0, 4.0]), Line([0.05, 0.6, 0.56, 1.4])]),
        '7' => (0.78, vec![Line([0.0, 1.4, 0.78, 1.4]), Line([0.78, 1.4, 0.26, 0.0])]),
        '8' => (
            0.82,
            vec![Arc([0.41, 1.05, 0.33, 0.35, 0.0, 4.0]), Arc([0.41, 0.36, 0.41, 0.36, 0.0, 4.0])],
        ),
        '9' => (0.84, vec![Arc([0.42, 0.96, 0.42, 0.44, 0.0, 4.0]), Line([0.79, 0.8, 0.28, 0.0])]),
        '.' => (0.08, vec![stem(0.04, 0.0, 0.02)]),
        ',' => (0.12, vec![Line([0.08, 0.02, 0.0, -0.2])]),
        '-' => (0.5, vec![Line([0.0, 0.5, 0.5, 0.5])]),
        _ => (BLANK, Vec::new()),
    }
}
