//! One view without title and legend, for pages that set these themselves.

use crate::math::{Point3, Vec3};
use crate::mesh::Mesh;

use super::camera::Screen;
use super::raster::{self, Buffer, NOTHING};
use super::{Camera, Canvas, Color, Diverging, Image, MARGIN_SHARE, SAMPLES, averaged, shade};

/// A mesh ready to be drawn from many sides.
#[derive(Debug, Clone)]
pub struct Drawable<'a> {
    mesh: &'a Mesh,
    groups: &'a [u32],
    normals: Vec<[Vec3; 3]>,
}

impl<'a> Drawable<'a> {
    /// `groups`: one per triangle; lines are drawn between triangles of different groups, and shading is smooth within
    /// one.
    pub fn new(mesh: &'a Mesh, groups: &'a [u32]) -> Self {
        Self { mesh, groups, normals: raster::corner_normals(mesh, groups) }
    }
}

/// What gives a mesh its colors.
#[derive(Debug, Clone, Copy)]
pub enum Paint<'a> {
    /// One color per triangle.
    Triangles(&'a [Color]),
    /// One value per vertex, interpolated.
    Values {
        /// Finite, or NaN where there is none.
        values: &'a [f64],
        /// Their colors.
        scale: Diverging,
    },
}

/// A picture of one view.
#[derive(Debug, Clone)]
pub struct Panel<'a> {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Points that the picture must show.
    pub frame: &'a [Point3],
    /// Where from.
    pub camera: Camera,
    /// One per triangle: whether it is part of a place that shall be found at a glance. The place shines through what
    /// hides it, and is circled when it is small. Empty for none.
    pub marked: &'a [bool],
}

/// How much of the mark's color covers what hides the marked place.
const SHINE: f32 = 0.45;
/// A place that spans less than this share of the picture is circled.
const CIRCLED_SHARE: f64 = 0.30;
/// Room between a place and its circle, and the circle's smallest radius and width, as shares of the picture's height.
const RING_ROOM: f64 = 0.03;
const RING_RADIUS: f64 = 0.05;
const RING_WIDTH: f64 = 0.008;

/// Draws one view.
pub fn panel(drawable: &Drawable, paint: &Paint, panel: &Panel) -> Image {
    let size = (panel.width, panel.height);
    let scale = panel.camera.fitting_scale(panel.frame, size, MARGIN_SHARE);
    let samples = (panel.width * SAMPLES, panel.height * SAMPLES);
    let screen = panel.camera.screen(panel.frame, samples.0, samples.1, scale * SAMPLES as f64);
    let Drawable { mesh, groups, normals } = drawable;
    let buffer = raster::rasterize(mesh, groups, normals, &screen, samples);
    let mut shaded = shade::shade(&buffer, mesh, paint, screen.depth_extent());
    let mut canvas = Canvas::new(panel.width, panel.height);
    if panel.marked.contains(&true) {
        shine_through(&mut shaded, &buffer, drawable, panel.marked, &screen);
    }
    canvas.paste(&averaged(&shaded, size), size, 0, 0);
    circle(&mut canvas, mesh, panel.marked, &screen);
    canvas.into_image()
}

fn shine_through(
    shaded: &mut [[f32; 3]],
    buffer: &Buffer,
    drawable: &Drawable,
    marked: &[bool],
    screen: &Screen,
) {
    let (place, old, _) = drawable.mesh.submesh(|t| marked[t]);
    let normals: Vec<[Vec3; 3]> = old.iter().map(|t| drawable.normals[*t as usize]).collect();
    let groups = vec![0; old.len()];
    let behind = raster::rasterize(&place, &groups, &normals, screen, (buffer.width, buffer.height));
    let color = Color::MARK.linear();
    for (i, sample) in shaded.iter_mut().enumerate() {
        let hidden = behind.triangles[i] != NOTHING
            && buffer.triangles[i] != NOTHING
            && !marked[buffer.triangles[i] as usize];
        if hidden {
            for k in 0..3 {
                sample[k] += SHINE * (color[k] - sample[k]);
            }
        }
    }
}

/// A ring around the marked triangles, unless they are large enough to be found without.
fn circle(canvas: &mut Canvas, mesh: &Mesh, marked: &[bool], screen: &Screen) {
    let triangles = mesh.triangles.iter().zip(marked).filter(|(_, marked)| **marked);
    let points: Vec<[f64; 2]> = triangles
        .flat_map(|(triangle, _)| triangle)
        .map(|v| screen.project(&mesh.vertices[*v as usize]))
        .map(|[x, y, _]| [f64::from(x) / SAMPLES as f64, f64::from(y) / SAMPLES as f64])
        .collect();
    let empty = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let (lo, hi) = points
        .iter()
        .fold(empty, |(lo, hi), p| ([0, 1].map(|k| p[k].min(lo[k])), [0, 1].map(|k| p[k].max(hi[k]))));
    let height = canvas.height as f64;
    let extent = (hi[0] - lo[0]).hypot(hi[1] - lo[1]);
    if points.is_empty() || extent > CIRCLED_SHARE * height {
        return;
    }
    let center = [0, 1].map(|k| 0.5 * (lo[k] + hi[k]));
    let radius = (0.5 * extent + RING_ROOM * height).max(RING_RADIUS * height);
    let half_width = 0.5 * (RING_WIDTH * height).max(1.5);
    let color = Color::MARK.linear();
    let reach = radius + half_width + 1.0;
    for y in (center[1] - reach).floor() as i64..=(center[1] + reach).ceil() as i64 {
        for x in (center[0] - reach).floor() as i64..=(center[0] + reach).ceil() as i64 {
            let distance = (x as f64 + 0.5 - center[0]).hypot(y as f64 + 0.5 - center[1]);
            let cover = (half_width - (distance - radius).abs() + 0.5).clamp(0.0, 1.0);
            canvas.blend(x, y, color, cover);
        }
    }
}

/// Per camera and group below `n_groups`: how many samples of a small picture show the front of one of its triangles.
pub fn visible_samples(
    drawable: &Drawable,
    n_groups: usize,
    cameras: &[Camera],
    frame: &[Point3],
) -> Vec<Vec<usize>> {
    const SIZE: (usize, usize) = (320, 240);
    let count = |camera: &Camera| {
        let scale = camera.fitting_scale(frame, SIZE, MARGIN_SHARE);
        let screen = camera.screen(frame, SIZE.0, SIZE.1, scale);
        let Drawable { mesh, groups, normals } = drawable;
        let buffer = raster::rasterize(mesh, groups, normals, &screen, SIZE);
        let mut counts = vec![0; n_groups];
        for (group, back) in buffer.groups.iter().zip(&buffer.backs) {
            if !back && let Some(count) = counts.get_mut(*group as usize) {
                *count += 1;
            }
        }
        counts
    };
    cameras.iter().map(count).collect()
}
