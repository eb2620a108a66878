//! Pictures, made on the processor: no graphics card, and the same bytes whatever the number of threads.
//!
//! [`picture`] lays views out in a grid, all at one scale; [`panel()`] draws one, with values or a marked place. Each view is rasterized into a z-buffer of `SAMPLES` x
//! `SAMPLES` samples per pixel, shaded with a key light, a sky and the occlusion of the depth buffer, and its region
//! borders and outlines are drawn as thin dark lines.
//!
//! Cost: O(samples + triangles) per view. Transparency, textures and perspective are absent.

mod camera;
mod palette;
mod panel;
mod png;
mod raster;
mod shade;
mod text;

pub use camera::Camera;
pub use palette::{Color, Diverging, of_kind, of_region};
pub use panel::{Drawable, Paint, Panel, panel, visible_samples};

use crate::math::Point3;
use crate::mesh::Mesh;
use crate::par;

/// A picture: rows from the top, three bytes (sRGB red, green, blue) per pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `3 * width * height` bytes.
    pub pixels: Vec<u8>,
}

impl Image {
    /// The bytes of a PNG file.
    pub fn to_png(&self) -> Vec<u8> {
        png::encode(self)
    }
}

/// A mesh seen from one side.
#[derive(Debug, Clone)]
pub struct View<'a> {
    /// What is drawn.
    pub mesh: &'a Mesh,
    /// One per triangle: its color.
    pub colors: &'a [Color],
    /// One per triangle: lines are drawn between triangles of different groups, and shading is smooth within one.
    pub groups: &'a [u32],
    /// Where from.
    pub camera: Camera,
    /// Shown above it.
    pub title: &'a str,
}

/// Everything about a picture but its views.
#[derive(Debug, Clone)]
pub struct Sheet<'a> {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Points that every view must show; the scale follows from them.
    pub frame: &'a [Point3],
    /// Names of colors, shown below.
    pub legend: &'a [(Color, String)],
}

/// Samples per pixel and axis.
const SAMPLES: usize = 3;
/// Height of title and legend as shares of the picture's height.
const TITLE_SHARE: f64 = 0.040;
const LEGEND_SHARE: f64 = 0.055;
/// Share of a panel left free around the frame.
const MARGIN_SHARE: f64 = 0.035;

/// Draws `views` in a grid as near to square as their number allows.
pub fn picture(views: &[View], sheet: &Sheet) -> Image {
    let grid = Grid::new(views, sheet);
    let mut canvas = Canvas::new(sheet.width, sheet.height);
    let scale = views
        .iter()
        .map(|view| view.camera.fitting_scale(sheet.frame, grid.panel, MARGIN_SHARE))
        .fold(f64::INFINITY, f64::min);
    for (i, view) in views.iter().enumerate() {
        let (left, top) = grid.origin(i);
        let panel = draw(view, sheet.frame, grid.panel, scale);
        canvas.paste(&panel, grid.panel, left, top);
        let size = 0.6 * grid.title as f64;
        let center = left as f64 + 0.5 * grid.panel.0 as f64;
        let x = center - 0.5 * text::width(view.title, size);
        text::draw(&mut canvas, view.title, x, top as f64 - 0.28 * grid.title as f64, size);
    }
    draw_legend(&mut canvas, sheet, grid.legend);
    canvas.into_image()
}

/// Places of panels.
struct Grid {
    n_columns: usize,
    panel: (usize, usize),
    title: usize,
    legend: usize,
    /// First row of pixels of the panels of each row.
    tops: Vec<usize>,
}

impl Grid {
    fn new(views: &[View], sheet: &Sheet) -> Self {
        let n_columns = (1..=views.len()).find(|c| c * c >= views.len()).unwrap_or(1);
        let share = |s: f64| (s * sheet.height as f64).round() as usize;
        let title = share(TITLE_SHARE);
        let legend = if sheet.legend.is_empty() { 0 } else { share(LEGEND_SHARE) };
        let rows = views.chunks(n_columns);
        let titles: Vec<usize> =
            rows.map(|row| if row.iter().any(|v| !v.title.is_empty()) { title } else { 0 }).collect();
        let taken = legend + titles.iter().sum::<usize>();
        let panel_height = sheet.height.saturating_sub(taken) / titles.len().max(1);
        let mut tops = Vec::new();
        let mut bottom = 0;
        for title in titles {
            tops.push(bottom + title);
            bottom += title + panel_height;
        }
        Self { n_columns, panel: (sheet.width / n_columns, panel_height), title, legend, tops }
    }

    fn origin(&self, i: usize) -> (usize, usize) {
        ((i % self.n_columns) * self.panel.0, self.tops[i / self.n_columns])
    }
}

/// The pixels of one view, linear light, rows from the top.
fn draw(view: &View, frame: &[Point3], (width, height): (usize, usize), scale: f64) -> Vec<[f32; 3]> {
    let (w, h) = (width * SAMPLES, height * SAMPLES);
    let screen = view.camera.screen(frame, w, h, scale * SAMPLES as f64);
    let normals = raster::corner_normals(view.mesh, view.groups);
    let buffer = raster::rasterize(view.mesh, view.groups, &normals, &screen, (w, h));
    let shaded = shade::shade(&buffer, view.mesh, &Paint::Triangles(view.colors), screen.depth_extent());
    averaged(&shaded, (width, height))
}

/// Pixels from samples.
fn averaged(shaded: &[[f32; 3]], (width, height): (usize, usize)) -> Vec<[f32; 3]> {
    let w = width * SAMPLES;
    let average = |i: usize| {
        let (px, py) = (i % width, i / width);
        let mut sum = [0.0_f32; 3];
        for sy in 0..SAMPLES {
            for sx in 0..SAMPLES {
                let sample = shaded[(py * SAMPLES + sy) * w + px * SAMPLES + sx];
                for k in 0..3 {
                    sum[k] += sample[k];
                }
            }
        }
        sum.map(|s| s / (SAMPLES * SAMPLES) as f32)
    };
    par::map_indices(width * height, average)
}

fn draw_legend(canvas: &mut Canvas, sheet: &Sheet, height: usize) {
    let size = 0.42 * height as f64;
    let (swatch, gap) = (0.9 * size, 1.6 * size);
    let width_of = |name: &str| swatch + 0.5 * size + text::width(name, size);
    let total: f64 = sheet.legend.iter().map(|(_, name)| width_of(name) + gap).sum::<f64>() - gap;
    let mut x = 0.5 * (sheet.width as f64 - total);
    let baseline = sheet.height as f64 - 0.36 * height as f64;
    for (color, name) in sheet.legend {
        canvas.fill(x, baseline - 0.78 * size, swatch, *color);
        text::draw(canvas, name, x + swatch + 0.5 * size, baseline, size);
        x += width_of(name) + gap;
    }
}

/// An image under construction, linear light.
struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<[f32; 3]>,
}

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        let pixels = vec![palette::BACKGROUND.linear(); width * height];
        Self { width, height, pixels }
    }

    fn paste(&mut self, panel: &[[f32; 3]], (width, height): (usize, usize), left: usize, top: usize) {
        for row in 0..height.min(self.height.saturating_sub(top)) {
            let to = (top + row) * self.width + left;
            self.pixels[to..to + width].copy_from_slice(&panel[row * width..(row + 1) * width]);
        }
    }

    /// Mixes `color` into a pixel; outside the picture nothing happens.
    fn blend(&mut self, x: i64, y: i64, color: [f32; 3], cover: f64) {
        if x < 0 || y < 0 || x >= self.width as i64 || y >= self.height as i64 {
            return;
        }
        let pixel = &mut self.pixels[y as usize * self.width + x as usize];
        for k in 0..3 {
            pixel[k] += (color[k] - pixel[k]) * cover as f32;
        }
    }

    /// A filled square with rounded corners.
    fn fill(&mut self, x: f64, y: f64, size: f64, color: Color) {
        let (radius, center) = (0.22 * size, 0.5 * size);
        let color = color.linear();
        for py in y.floor() as i64..=(y + size).ceil() as i64 {
            for px in x.floor() as i64..=(x + size).ceil() as i64 {
                let dx = ((px as f64 + 0.5 - x - center).abs() - center + radius).max(0.0);
                let dy = ((py as f64 + 0.5 - y - center).abs() - center + radius).max(0.0);
                let cover = (radius - dx.hypot(dy) + 0.5).clamp(0.0, 1.0);
                self.blend(px, py, color, cover);
            }
        }
    }

    fn into_image(self) -> Image {
        let pixels = self.pixels.iter().flat_map(|p| p.map(palette::encode)).collect();
        Image { width: self.width, height: self.height, pixels }
    }
}
