//! Light and lines on a z-buffer.
//!
//! Ambient light is dimmed by the occlusion of the depth buffer: each sample asks a fixed spiral of neighbours how
//! far they rise above its tangent plane. M. Mittring, "Finding next gen: CryEngine 2", SIGGRAPH courses (2007), in
//! the obscurance form of M. McGuire et al., "The alchemy screen-space ambient obscurance algorithm", High
//! Performance Graphics (2011). Occluders that are hidden themselves cast nothing.

use crate::par;

use super::palette::{self, Color};
use super::raster::{Buffer, NOTHING};

/// Directions of the lights: right, up, towards the eye; not normalized.
const KEY: [f32; 3] = [-0.45, 0.70, 0.65];
const FILL: [f32; 3] = [0.80, 0.10, 0.45];
/// Strengths; together a face that looks at the key light is just below white times its color.
const KEY_STRENGTH: f32 = 0.62;
const FILL_STRENGTH: f32 = 0.14;
const SKY_STRENGTH: f32 = 0.40;
const GROUND_STRENGTH: f32 = 0.20;
/// A faint sheen shows curvature.
const SHEEN_STRENGTH: f32 = 0.10;
const SHEEN_POWER: i32 = 28;
/// Backs of triangles, seen through holes of a scan: darker and warm.
const BACK_TINT: [f32; 3] = [0.62, 0.45, 0.40];

/// Neighbours asked for occlusion, radius as a share of the scene, and strength.
const N_OCCLUDERS: usize = 20;
const OCCLUSION_SHARE: f32 = 0.06;
const OCCLUSION_STRENGTH: f32 = 1.5;
/// Occlusion varies slowly: one value per block of this many samples each way.
const BLOCK: usize = 3;

/// How much of the color remains under a line of each kind.
const OUTLINE_SHADE: f32 = 0.22;
const BORDER_SHADE: f32 = 0.34;
/// A depth step is an outline when it is larger than this share of the scene.
const STEP_SHARE: f32 = 0.012;
/// Half-width of lines, samples; with three samples per pixel a line is about one pixel and a half wide.
const LINE: isize = 2;

/// Linear light of every sample. `colors`: one per triangle; `extent`: size of the scene in samples.
pub(super) fn shade(buffer: &Buffer, colors: &[Color], extent: f32) -> Vec<[f32; 3]> {
    let occlusion = occlusion(buffer, extent);
    let background = palette::BACKGROUND.linear();
    par::map_indices(buffer.triangles.len(), |i| {
        let (x, y) = (i % buffer.width, i / buffer.width);
        let line = line_shade(buffer, x, y, extent);
        let t = buffer.triangles[i];
        if t == NOTHING {
            return background.map(|c| c * line);
        }
        let open = occlusion[(y / BLOCK) * buffer.width.div_ceil(BLOCK) + x / BLOCK];
        let lit = light(colors[t as usize].linear(), buffer.normals[i], open, buffer.backs[i]);
        lit.map(|c| c * line)
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
    let raw = par::map_indices(columns * rows, |i| {
        let x = ((i % columns) * BLOCK + BLOCK / 2).min(buffer.width - 1);
        let y = ((i / columns) * BLOCK + BLOCK / 2).min(buffer.height - 1);
        obscurance(buffer, x, y, radius)
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

fn obscurance(buffer: &Buffer, x: usize, y: usize, radius: f32) -> f32 {
    let i = y * buffer.width + x;
    if buffer.triangles[i] == NOTHING {
        return 1.0;
    }
    const GOLDEN_ANGLE: f32 = 2.399_963;
    let (depth, normal) = (buffer.depths[i], buffer.normals[i]);
    // The spiral starts at a different angle per sample: banding becomes fine grain, which the blur removes.
    let start = ((x * 7 + y * 13) % 16) as f32 * (std::f32::consts::TAU / 16.0);
    let mut sum = 0.0;
    for k in 0..N_OCCLUDERS {
        let distance = radius * ((k as f32 + 0.5) / N_OCCLUDERS as f32);
        let angle = start + GOLDEN_ANGLE * k as f32;
        let (dx, dy) = (distance * angle.cos(), distance * angle.sin());
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

/// The factor that lines put on a sample: 1 where there is none.
fn line_shade(buffer: &Buffer, x: usize, y: usize, extent: f32) -> f32 {
    let i = y * buffer.width + x;
    let step = STEP_SHARE * extent;
    let mut shade = 1.0_f32;
    for dy in -LINE..=LINE {
        for dx in -LINE..=LINE {
            if dx * dx + dy * dy > LINE * LINE {
                continue;
            }
            let (u, v) = (x as isize + dx, y as isize + dy);
            if u < 0 || v < 0 || u >= buffer.width as isize || v >= buffer.height as isize {
                continue;
            }
            let j = v as usize * buffer.width + u as usize;
            let (here, there) = (buffer.triangles[i] == NOTHING, buffer.triangles[j] == NOTHING);
            let adjacent = dx * dx + dy * dy <= 1;
            if here != there {
                // The outline is drawn outside the part, where it hides nothing.
                shade = shade.min(if here || adjacent { OUTLINE_SHADE } else { 1.0 });
            } else if !here && buffer.depths[j] - buffer.depths[i] > step + slope_step(buffer, i, j) {
                shade = shade.min(OUTLINE_SHADE);
            } else if adjacent && buffer.groups[i] != buffer.groups[j] {
                shade = shade.min(BORDER_SHADE);
            }
        }
    }
    shade
}

/// Depth that a slanted surface may gain between neighbouring samples.
fn slope_step(buffer: &Buffer, i: usize, j: usize) -> f32 {
    let slope = |n: [f32; 3]| (n[0].hypot(n[1]) / n[2].abs().max(0.05)).min(12.0);
    let reach = LINE as f32 + 1.0;
    reach * slope(buffer.normals[i]).max(slope(buffer.normals[j]))
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}
