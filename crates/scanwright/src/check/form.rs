//! Form: how far the points of a face depart from their own surface.
//!
//! The distance between the highest and the lowest of many noisy points grows with their number: noise alone makes it
//! about `2 sigma sqrt(2 ln n)`. So the width is given in three ways, each beside what the scanner's noise alone would
//! make of it: over all points, for the least-squares and the minimum zone surface; for the middle 99.7 % of them; and
//! for means over cells, which noise hardly moves.

use crate::align::Part;
use crate::fit::minimum_zone;
use crate::math::{Axis, Point3, Vec3, stats};
use crate::surface::{Surface, SurfaceKind};

/// Widths of the zone that holds a face's points, length.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Form {
    /// `flatness`, `cylindricity`, `sphericity`, or `form` of a cone or torus.
    pub name: &'static str,
    /// Points; those beyond six deviations left out.
    pub n_points: usize,
    /// About the least-squares surface.
    pub least_squares: f64,
    /// Of the narrowest zone.
    pub minimum_zone: f64,
    /// What noise alone makes of either.
    pub noise_peaks: f64,
    /// Of the middle 99.7 % of the points, about the least-squares surface.
    pub robust: f64,
    /// What noise alone makes of it.
    pub noise_robust: f64,
    /// Of the means over cells of four vertex spacings.
    pub filtered: f64,
    /// What noise alone makes of it.
    pub noise_filtered: f64,
    /// The largest roundness of its sections, by least squares, of the middle 99.7 %; of cylinders and cones.
    pub roundness: Option<f64>,
}

/// Deviations of the points about their surface beyond which they are no part of its form.
const OUTLIER: f64 = 6.0;
/// Points that a minimum zone is found for.
const MOST_POINTS: usize = 20_000;
/// Width of the middle 99.7 % of a normal distribution, standard deviations.
const ROBUST_WIDTH: f64 = 5.936;

pub(super) fn of(
    surface: &Surface,
    points: &[Point3],
    sigma: f64,
    part: &Part,
    vertices_per_sample: f64,
) -> Form {
    let noise = part.tolerances.noise();
    let kept: Vec<Point3> =
        points.iter().filter(|p| surface.signed_distance(p).abs() <= OUTLIER * sigma).copied().collect();
    let distances: Vec<f64> = kept.iter().map(|p| surface.signed_distance(p)).collect();
    let stride = kept.len().div_ceil(MOST_POINTS).max(1);
    let few: Vec<Point3> = kept.iter().step_by(stride).copied().collect();
    let (_, zone) = minimum_zone(surface, &few);
    let peaks = |n: f64| 2.0 * noise * (2.0 * n.max(1.0).ln()).sqrt();
    let (filtered, noise_filtered) =
        filtered(surface, &kept, &distances, part.tolerances.spacing(), noise, vertices_per_sample);
    Form {
        name: match surface.kind() {
            SurfaceKind::Plane => "flatness",
            SurfaceKind::Cylinder => "cylindricity",
            SurfaceKind::Sphere => "sphericity",
            SurfaceKind::Cone | SurfaceKind::Torus => "form",
        },
        n_points: kept.len(),
        least_squares: width(&distances),
        minimum_zone: zone.min(width(&distances)),
        noise_peaks: peaks(kept.len() as f64),
        robust: robust_width(&distances),
        noise_robust: ROBUST_WIDTH * noise,
        filtered,
        noise_filtered,
        roundness: roundness(surface, &kept),
    }
}

fn width(values: &[f64]) -> f64 {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    (high - low).max(0.0)
}

/// Width of the middle 99.7 %.
fn robust_width(values: &[f64]) -> f64 {
    const TAIL: f64 = 0.0015;
    let mut values = values.to_vec();
    let high = stats::quantile(&mut values, 1.0 - TAIL).unwrap_or(0.0);
    high - stats::quantile(&mut values, TAIL).unwrap_or(0.0)
}

/// Width of the means over cells, and what noise alone makes of it.
fn filtered(
    surface: &Surface,
    points: &[Point3],
    distances: &[f64],
    spacing: f64,
    noise: f64,
    vertices_per_sample: f64,
) -> (f64, f64) {
    const CELL: f64 = 4.0;
    const LEAST: usize = 8;
    let cell = |p: &Point3| [p.x, p.y, p.z].map(|x| (x / (CELL * spacing)).floor() as i64);
    // Cells of places on the surface: which cell a point is in says nothing about its distance.
    let places = points.iter().map(|p| cell(&surface.project(p)));
    let mut keyed: Vec<([i64; 3], f64)> = places.zip(distances.iter().copied()).collect();
    keyed.sort_by_key(|a| a.0);
    let cells: Vec<(f64, usize)> = keyed
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|cell| cell.len() >= LEAST)
        .map(|cell| (cell.iter().map(|c| c.1).sum::<f64>() / cell.len() as f64, cell.len()))
        .collect();
    let means: Vec<f64> = cells.iter().map(|c| c.0).collect();
    let typical = cells.iter().map(|c| c.1).sum::<usize>() as f64 / cells.len().max(1) as f64;
    // No cell says more than its points, nor less than one of them.
    let of_mean = noise * (vertices_per_sample / typical.max(1.0)).min(1.0).sqrt();
    let peaks = 2.0 * of_mean * (2.0 * (cells.len().max(1) as f64).ln()).sqrt();
    (if means.is_empty() { 0.0 } else { width(&means) }, peaks)
}

/// The largest roundness of the sections of a wall across its axis.
fn roundness(surface: &Surface, points: &[Point3]) -> Option<f64> {
    const SECTIONS: usize = 8;
    const LEAST: usize = 24;
    let (axis, slope) = match surface {
        Surface::Cylinder(s) => (s.axis, 0.0),
        Surface::Cone(s) => (s.axis, s.half_angle.tan()),
        _ => return None,
    };
    let heights: Vec<f64> = points.iter().map(|p| axis.height(p)).collect();
    let (low, high) =
        heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let mut sections: Vec<Vec<Point3>> = vec![Vec::new(); SECTIONS];
    for (point, height) in points.iter().zip(&heights) {
        let share = (height - low) / (high - low).max(f64::MIN_POSITIVE);
        sections[((share * SECTIONS as f64) as usize).min(SECTIONS - 1)].push(*point);
    }
    let widths = sections.iter().filter(|s| s.len() >= LEAST).map(|section| {
        let middle = section.iter().map(|p| axis.height(p)).sum::<f64>() / section.len() as f64;
        section_width(section, &axis, slope, middle)
    });
    widths.max_by(f64::total_cmp)
}

/// Width of a section about its own circle: radii at `height`, across the wall.
fn section_width(section: &[Point3], axis: &Axis, slope: f64, height: f64) -> f64 {
    let direction = axis.direction;
    let (x, y) = {
        let frame = crate::math::Frame::from_z(axis.origin, direction);
        (frame.x, frame.y)
    };
    let flat: Vec<nalgebra::Vector2<f64>> = section
        .iter()
        .map(|p| {
            let radial: Vec3 = axis.radial(p);
            // Along the wall to the section's height.
            let radius = radial.norm() + (height - axis.height(p)) * slope;
            let unit = radial / radial.norm().max(f64::MIN_POSITIVE) * radius;
            nalgebra::Vector2::new(unit.dot(&x), unit.dot(&y))
        })
        .collect();
    let Some((center, radius)) = crate::math::fitted_circle(&flat) else { return 0.0 };
    let across = 1.0 / slope.hypot(1.0);
    let distances: Vec<f64> = flat.iter().map(|p| ((p - center).norm() - radius) * across).collect();
    robust_width(&distances)
}
