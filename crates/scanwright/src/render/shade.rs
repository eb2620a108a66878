//! Light and lines on a z-buffer.
//!
//! Ambient light is dimmed by the occlusion of the depth buffer: each sample asks a fixed spiral of neighbours how
//! far they rise above its tangent plane. M. McGuire, B. Osman, M. Bukowski, P. Hennessy, "The alchemy screen-space
//! ambient obscurance algorithm", High Performance Graphics (2011). Occluders that are hidden themselves cast nothing.

use crate::mesh::Mesh;
use crate::par;

use super::Paint;
use super::palette;
use super::raster::{Buffer, NOTHING};

/// Directions of the lights: right, up, towards the eye; not normalized.
const KEY: [f32; 3] = [-0.55, 0.74, 0.48];
const FILL: [f32; 3] = [0.75, -0.25, 0.60];
/// Strengths; together a face that looks at the key light is just below white times its color.
const KEY_STRENGTH: f32 = 0.60;
const FILL_STRENGTH: f32 = 0.20;
const SKY_STRENGTH: f32 = 0.44;
const GROUND_STRENGTH: f32 = 0.30;
/// A faint sheen shows curvature.
const SHEEN_STRENGTH: f32 = 0.10;
const SHEEN_POWER: i32 = 28;
/// Backs of triangles, seen through holes of a scan: darker and warm.
const BACK_TINT: [f32; 3] = [0.62, 0.45, 0.40];

/// Neighbours asked for occlusion, in how many patterns, within which share of the scene, and how strongly they count.
const N_OCCLUDERS: usize = 20;
const N_SPIRALS: usize = 16;
const OCCLUSION_SHARE: f32 = 0.06;
const OCCLUSION_STRENGTH: f32 = 1.5;
/// Occlusion varies slowly: one value per block of this many samples each way.
const BLOCK: usize = 3;

/// How much of the color remains under a line of each kind.
const OUTLINE_SHADE: f32 = 0.22;
const BORDER_SHADE: f32 = 0.34;
/// A depth step is an outline when it is larger than this share of the scene.
const STEP_SHARE: f32 = 0.012;

/// How much of the light's play remains on colors that stand for values: enough to see the shape, little enough to read
/// the color against its scale.
const PLAY_ON_VALUES: f32 = 0.4;

/// Linear light of every sample of `mesh`; `extent`: size of the scene in samples.
pub(super) fn shade(buffer: &Buffer, mesh: &Mesh, paint: &Paint, extent: f32) -> Vec<[f32; 3]> {
    let occlusion = occlusion(buffer, extent);
    let lines = lines(buffer, extent);
    let (colors, play) = match paint {
        Paint::Triangles(colors) => (colors.iter().map(|color| color.linear()).collect(), 1.0),
        Paint::Values { .. } => (Vec::new(), PLAY_ON_VALUES),
    };
    let background = palette::BACKGROUND.linear();
    par::map_indices(buffer.triangles.len(), |i| {
        let (x, y) = (i % buffer.width, i / buffer.width);
        let line = line_shade(&lines, buffer.width, x, y);
        let t = buffer.triangles[i];
        if t == NOTHING {
            return background.map(|c| c * line);
        }
        let open = occlusion[(y / BLOCK) * buffer.width.div_ceil(BLOCK) + x / BLOCK];
        let color = match paint {
            Paint::Triangles(_) => colors[t as usize],
            Paint::Values { values, scale } => {
                let [a, b, c] = mesh.triangles[t as usize].map(|v| values[v as usize]);
                let [wa, wb] = buffer.weights[i].map(f64::from);
                scale.color(wa * a + wb * b + (1.0 - wa - wb) * c).linear()
            }
        };
        let lit = light(color, buffer.normals[i], open, buffer.backs[i]);
        [0, 1, 2].map(|k| (play * lit[k] + (1.0 - play) * color[k]) * line)
    })
}

fn light(color: [f32; 3], normal: [f32; 3], open: f32, back: bool) -> [f32; 3] {
    let (key, fill) = (unit(KEY), unit(FILL));
    let diffuse = |l: [f32; 3]| dot(normal, l).max(0.0);
    // Half of the key light is wrapped round the terminator: surfaces keep their shape in the shade.
    let wrapped = (0.75 * dot(normal, key) + 0.25).max(0.0);
    let up = 0.5 + 0.5 * normal[1];
    let ambient = (SKY_STRENGTH * up + GROUND_STRENGTH * (1.0 - up)) * open;
    let direct = KEY_STRENGTH * wrapped * (0.4 + 0.6 * open) + FILL_STRENGTH * diffuse(fill);
    let half = unit([key[0], key[1], key[2] + 1.0]);
    let sheen = SHEEN_STRENGTH * dot(normal, half).max(0.0).powi(SHEEN_POWER) * open;
    let tint = if back { BACK_TINT } else { [1.0; 3] };
    [0, 1, 2].map(|k| color[k] * tint[k] * (ambient + direct) + if back { 0.0 } else { sheen })
}

/// Share of the sky that each block of samples sees.
fn occlusion(buffer: &Buffer, extent: f32) -> Vec<f32> {
    let (columns, rows) = (buffer.width.div_ceil(BLOCK), buffer.height.div_ceil(BLOCK));
    let radius = (OCCLUSION_SHARE * extent).max(1.0);
    let spirals = spirals(radius);
    let raw = par::map_indices(columns * rows, |i| {
        let x = ((i % columns) * BLOCK + BLOCK / 2).min(buffer.width - 1);
        let y = ((i / columns) * BLOCK + BLOCK / 2).min(buffer.height - 1);
        obscurance(buffer, x, y, &spirals[(x * 7 + y * 13) % N_SPIRALS], radius)
    });
    // A small box blur hides the spiral's pattern.
    par::map_indices(columns * rows, |i| {
        let (x, y) = (i % columns, i / columns);
        let (mut sum, mut n) = (0.0, 0.0_f32);
        for v in y.saturating_sub(2)..(y + 3).min(rows) {
            for u in x.saturating_sub(2)..(x + 3).min(columns) {
                sum += raw[v * columns + u];
                n += 1.0;
            }
        }
        sum / n
    })
}

/// Offsets of the neighbours asked, in golden-angle spirals. A sample takes one of several that start at different
/// angles: banding becomes fine grain, which the blur removes.
fn spirals(radius: f32) -> [[(f32, f32); N_OCCLUDERS]; N_SPIRALS] {
    const GOLDEN_ANGLE: f32 = 2.399_963;
    std::array::from_fn(|spiral| {
        let start = spiral as f32 * (std::f32::consts::TAU / N_SPIRALS as f32);
        std::array::from_fn(|k| {
            let distance = radius * ((k as f32 + 0.5) / N_OCCLUDERS as f32);
            let (sin, cos) = (start + GOLDEN_ANGLE * k as f32).sin_cos();
            (distance * cos, distance * sin)
        })
    })
}

fn obscurance(buffer: &Buffer, x: usize, y: usize, spiral: &[(f32, f32)], radius: f32) -> f32 {
    let i = y * buffer.width + x;
    if buffer.triangles[i] == NOTHING {
        return 1.0;
    }
    let (depth, normal) = (buffer.depths[i], buffer.normals[i]);
    let mut sum = 0.0;
    for &(dx, dy) in spiral {
        let (u, v) = (x as f32 + dx, y as f32 + dy);
        if u < 0.0 || v < 0.0 || u >= buffer.width as f32 || v >= buffer.height as f32 {
            continue;
        }
        let j = v as usize * buffer.width + u as usize;
        if buffer.triangles[j] == NOTHING {
            continue;
        }
        let offset = [dx, -dy, buffer.depths[j] - depth];
        let length_sq = dot(offset, offset);
        // Far occluders fade out, so that a part in front leaves no dark rim.
        let near = (1.0 - length_sq / (4.0 * radius * radius)).max(0.0);
        let rise = (dot(offset, normal) - 0.02 * radius).max(0.0);
        sum += near * rise / (length_sq.sqrt() + 0.05 * radius);
    }
    (1.0 - OCCLUSION_STRENGTH * sum / N_OCCLUDERS as f32).clamp(0.15, 1.0)
}

/// What a line at a sample would be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Line {
    None,
    Border,
    Outline,
}

/// Per sample: the line its four neighbours make of it.
fn lines(buffer: &Buffer, extent: f32) -> Vec<Line> {
    let (w, h) = (buffer.width, buffer.height);
    let step = STEP_SHARE * extent;
    let per_row = par::map_indices(h, |y| {
        let line_at = |x: usize| {
            let i = y * w + x;
            let sides = [(x > 0, -1), (x + 1 < w, 1), (y > 0, -(w as isize)), (y + 1 < h, w as isize)];
            let inside = sides.into_iter().filter(|(inside, _)| *inside);
            inside
                .map(|(_, d)| line_between(buffer, i, i.wrapping_add_signed(d), step))
                .max()
                .unwrap_or(Line::None)
        };
        (0..w).map(line_at).collect::<Vec<_>>()
    });
    per_row.concat()
}

/// The line that sample `i` gets from its neighbour `j`. Outlines lie outside the nearer part, where they hide nothing.
fn line_between(buffer: &Buffer, i: usize, j: usize, step: f32) -> Line {
    let (here, there) = (buffer.groups[i], buffer.groups[j]);
    if here == NOTHING {
        return if there == NOTHING { Line::None } else { Line::Outline };
    }
    if there == NOTHING {
        return Line::None;
    }
    let rise = buffer.depths[j] - buffer.depths[i];
    if rise > step && rise > step + slope(buffer.normals[i]).max(slope(buffer.normals[j])) {
        return Line::Outline;
    }
    if here == there { Line::None } else { Line::Border }
}

/// Depth that a slanted surface gains from one sample to the next.
fn slope(n: [f32; 3]) -> f32 {
    const STEEPEST: f32 = 12.0;
    (n[0].hypot(n[1]) / n[2].abs().max(1.0 / STEEPEST)).min(STEEPEST)
}

/// The factor that the strongest line within a sample's reach puts on it.
fn line_shade(lines: &[Line], width: usize, x: usize, y: usize) -> f32 {
    let height = lines.len() / width;
    let mut strongest = lines[y * width + x];
    let mut look = |inside: bool, i: usize| {
        if inside {
            strongest = strongest.max(lines[i]);
        }
    };
    let i = y * width + x;
    look(x > 0, i.wrapping_sub(1));
    look(x + 1 < width, i + 1);
    look(y > 0, i.wrapping_sub(width));
    look(y + 1 < height, i + width);
    match strongest {
        Line::None => 1.0,
        Line::Border => BORDER_SHADE,
        Line::Outline => OUTLINE_SHADE,
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}
