//! Whether residuals alternate in bands: the mark of a smooth surface laid across a crease.
//!
//! A torus through a chamfer, an annulus and a chamfer misses each of them by less than the noise of one point, but
//! always to the same side. Residuals are averaged over bands of each natural coordinate; for the right surface the
//! means scatter like the noise, whose wavy part makes one independent sample per patch of `VERTICES_PER_SAMPLE`
//! vertices.

use std::f64::consts::PI;

use crate::fit::Fit;
use crate::math::{Frame, Point3};
use crate::surface::Surface;

/// Vertices per independent sample of the residuals, white and wavy noise together.
const VERTICES_PER_SAMPLE: f64 = 25.0;
/// Bands per coordinate, at most.
const MAX_BANDS: usize = 12;
/// Vertices per band, at least.
const MIN_PER_BAND: usize = 40;

/// Root mean square, over the bands of the worse coordinate, of the bands' mean residual in units of its expected
/// deviation. About one for the right surface. `sigma`: deviation of one residual, length.
pub fn lack_of_fit(fit: &Fit, points: &[Point3], sigma: f64) -> f64 {
    let Some(coordinates) = natural_coordinates(&fit.surface, points) else { return 0.0 };
    let residuals: Vec<f64> = points.iter().map(|p| fit.surface.signed_distance(p)).collect();
    let along = |k: usize| banded(coordinates.iter().map(|c| c[k]), &residuals, sigma);
    along(0).max(along(1))
}

fn banded(coordinate: impl Iterator<Item = f64>, residuals: &[f64], sigma: f64) -> f64 {
    let n_bands = (residuals.len() / MIN_PER_BAND).min(MAX_BANDS);
    if n_bands < 3 {
        return 0.0;
    }
    let mut order: Vec<(f64, f64)> = coordinate.zip(residuals.iter().copied()).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let overall = residuals.iter().sum::<f64>() / residuals.len() as f64;
    let mut sum = 0.0;
    for band in 0..n_bands {
        let members = &order[band * order.len() / n_bands..(band + 1) * order.len() / n_bands];
        let n = members.len() as f64;
        let mean = members.iter().map(|m| m.1).sum::<f64>() / n - overall;
        let deviation = sigma * (VERTICES_PER_SAMPLE / n).min(1.0).sqrt();
        sum += (mean / deviation).powi(2);
    }
    (sum / n_bands as f64).sqrt()
}

/// Two coordinates along which a wrong surface shows bands; none for a plane or sphere, which have no profile.
fn natural_coordinates(surface: &Surface, points: &[Point3]) -> Option<Vec<[f64; 2]>> {
    let axis = surface.axis()?;
    let frame = Frame::from_z(axis.origin, axis.direction);
    let locals: Vec<_> = points.iter().map(|p| frame.local(p)).collect();
    // Angles are measured from the mean direction, so that no arc of less than a full turn is cut.
    let (x, y) = locals.iter().fold((0.0, 0.0), |(x, y), l| {
        let r = l.x.hypot(l.y).max(f64::MIN_POSITIVE);
        (x + l.x / r, y + l.y / r)
    });
    let middle = f64::atan2(y, x);
    let turn = |angle: f64| (angle - middle + 3.0 * PI).rem_euclid(2.0 * PI);
    let coordinates = locals.iter().map(|l| {
        let around = turn(l.y.atan2(l.x));
        let profile = match surface {
            Surface::Torus(s) => tube_angle(l.x.hypot(l.y) - s.major_radius, l.z),
            _ => l.z,
        };
        [around, profile]
    });
    let mut coordinates: Vec<[f64; 2]> = coordinates.collect();
    if matches!(surface, Surface::Torus(_)) {
        let (x, y) = coordinates.iter().fold((0.0, 0.0), |(x, y), c| (x + c[1].cos(), y + c[1].sin()));
        let middle = f64::atan2(y, x);
        for c in &mut coordinates {
            c[1] = (c[1] - middle + 3.0 * PI).rem_euclid(2.0 * PI);
        }
    }
    Some(coordinates)
}

fn tube_angle(off: f64, height: f64) -> f64 {
    height.atan2(off)
}
