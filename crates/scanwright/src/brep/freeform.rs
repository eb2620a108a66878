//! Bicubic B-spline surfaces for patches that no analytic surface describes.
//!
//! A patch is seen as a height over the plane across its mean normal; heights of its mesh vertices and, with a larger
//! weight, of its border curves are fitted by least squares with a small penalty on second differences of the poles.
//! P. Dierckx, "Curve and Surface Fitting with Splines", Oxford University Press 1993, chapter 5; here with uniform
//! knots that are doubled while the border is not met. Poles lie on the grid of knot averages, so the two in-plane
//! coordinates are reproduced exactly. Cost O(poles^3) per patch. Fails where the patch folds over its plane; patches
//! are cut before that (`split`).

use nalgebra::{DMatrix, DVector};

use super::split::Patch;
use crate::math::{Frame, Point3, UnitVec3, Vec3, any_perpendicular, try_unit};
use crate::mesh::Mesh;
use crate::surface::bspline::{DEGREE, SplineSurface, basis, find_span, uniform_knots};

/// Fewest and most poles along one side.
const POLES: (usize, usize) = (6, 26);
/// Spacings per knot span at the start.
const SPAN: f64 = 5.0;
/// Weight of a border sample against a mesh vertex: the border has to close, the inside only to be near.
const BORDER_WEIGHT: f64 = 50.0;
/// Penalty on second differences of poles against one mesh vertex: only fills where no data is.
const SMOOTHING: f64 = 1e-3;
/// Share of the side left free around the patch, so that its border is inside the surface.
const MARGIN: f64 = 0.05;

/// A spline and how far the border samples lie off it.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub surface: SplineSurface,
    pub border_gap: f64,
}

/// Frame over which a patch is a height: its third direction is the mean outward normal.
pub(super) fn base_frame(mesh: &Mesh, triangles: &[u32]) -> Frame {
    let (mut normal, mut center, mut area) = (Vec3::zeros(), Vec3::zeros(), 0.0);
    for t in triangles {
        let a = mesh.area(*t as usize);
        normal += mesh.cross(*t as usize);
        center += mesh.triangle_center(*t as usize).coords * a;
        area += a;
    }
    let z = try_unit(normal).unwrap_or_else(Vec3::z_axis);
    Frame::from_z(Point3::from(center / area.max(f64::MIN_POSITIVE)), z)
}

/// Share of a patch's area whose normal points away from the frame's third direction or nearly so.
pub(super) fn folded_share(mesh: &Mesh, triangles: &[u32], frame: &Frame) -> f64 {
    /// Cosine of the steepest slope that still counts as a height.
    const STEEPEST: f64 = 0.25;
    let (mut folded, mut all) = (0.0, 0.0);
    for t in triangles {
        let cross = mesh.cross(*t as usize);
        let area = cross.norm();
        all += area;
        if cross.dot(&frame.z) < STEEPEST * area {
            folded += area;
        }
    }
    if all > 0.0 { folded / all } else { 0.0 }
}

/// The spline of a patch, through `border` within `tolerance` where that can be had.
pub(super) fn fit(
    mesh: &Mesh,
    patch: &Patch,
    border: &[Point3],
    spacing: f64,
    tolerance: f64,
) -> Option<Fitted> {
    let frame = turned(&base_frame(mesh, &patch.triangles), mesh, &patch.triangles);
    let mut vertices: Vec<u32> = patch.triangles.iter().flat_map(|t| mesh.triangles[*t as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let inner: Vec<Vec3> = vertices.iter().map(|v| frame.local(&mesh.vertices[*v as usize])).collect();
    let outer: Vec<Vec3> = border.iter().map(|p| frame.local(p)).collect();
    let first = *inner.first()?;
    let (low, high) = inner.iter().chain(&outer).fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
    let margin = (high - low) * MARGIN + Vec3::repeat(spacing);
    let (low, high) = (low - margin, high + margin);
    let mut counts = [0, 1].map(|i| ((high[i] - low[i]) / (SPAN * spacing)) as usize + POLES.0);
    let mut best: Option<Fitted> = None;
    loop {
        counts = counts.map(|n| n.clamp(POLES.0, POLES.1));
        let fitted = fit_grid(&frame, [low.x, low.y], [high.x, high.y], counts, &inner, &outer)?;
        let done = fitted.border_gap <= tolerance || counts == [POLES.1; 2];
        if best.as_ref().is_none_or(|b| fitted.border_gap < b.border_gap) {
            best = Some(fitted);
        }
        if done {
            return best;
        }
        counts = counts.map(|n| n * 3 / 2);
    }
}

/// Turns a frame about its third direction so that its first follows the longest extent.
fn turned(frame: &Frame, mesh: &Mesh, triangles: &[u32]) -> Frame {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for t in triangles {
        let p = frame.local(&mesh.triangle_center(*t as usize));
        xx += p.x * p.x;
        xy += p.x * p.y;
        yy += p.y * p.y;
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let x = frame.x.into_inner() * angle.cos() + frame.y.into_inner() * angle.sin();
    let x = try_unit(x).unwrap_or_else(|| any_perpendicular(&frame.z));
    Frame { origin: frame.origin, x, y: UnitVec3::new_normalize(frame.z.cross(&x)), z: frame.z }
}

fn fit_grid(
    frame: &Frame,
    low: [f64; 2],
    high: [f64; 2],
    counts: [usize; 2],
    inner: &[Vec3],
    outer: &[Vec3],
) -> Option<Fitted> {
    let knots = counts.map(uniform_knots);
    let n = counts[0] * counts[1];
    let (mut matrix, mut right) = (DMatrix::<f64>::zeros(n, n), DVector::<f64>::zeros(n));
    let place = |p: &Vec3| [0, 1].map(|i| ((p[i] - low[i]) / (high[i] - low[i])).clamp(0.0, 1.0));
    let row = |p: &Vec3| {
        let at = place(p);
        let spans = [0, 1].map(|i| find_span(&knots[i], at[i]));
        let values = [0, 1].map(|i| basis(&knots[i], spans[i], at[i]));
        let mut row = [(0, 0.0); (DEGREE + 1) * (DEGREE + 1)];
        for i in 0..=DEGREE {
            for j in 0..=DEGREE {
                let pole = (spans[0] - DEGREE + i) * counts[1] + spans[1] - DEGREE + j;
                row[i * (DEGREE + 1) + j] = (pole, values[0][i] * values[1][j]);
            }
        }
        row
    };
    let mut add = |row: &[(usize, f64)], value: f64, weight: f64| {
        for (i, a) in row {
            right[*i] += weight * a * value;
            for (j, b) in row {
                matrix[(*i, *j)] += weight * a * b;
            }
        }
    };
    for p in inner {
        add(&row(p), p.z, 1.0);
    }
    for p in outer {
        add(&row(p), p.z, BORDER_WEIGHT);
    }
    let penalty = SMOOTHING * (inner.len() as f64 / n as f64).max(1.0);
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            let at = |i: usize, j: usize| i * counts[1] + j;
            if i + 2 < counts[0] {
                add(&[(at(i, j), 1.0), (at(i + 1, j), -2.0), (at(i + 2, j), 1.0)], 0.0, penalty);
            }
            if j + 2 < counts[1] {
                add(&[(at(i, j), 1.0), (at(i, j + 1), -2.0), (at(i, j + 2), 1.0)], 0.0, penalty);
            }
        }
    }
    let heights = matrix.cholesky()?.solve(&right);
    let average = |axis: usize, k: usize| {
        let share = knots[axis][k + 1..=k + DEGREE].iter().sum::<f64>() / DEGREE as f64;
        low[axis] + (high[axis] - low[axis]) * share
    };
    let poles = (0..n)
        .map(|k| {
            let (i, j) = (k / counts[1], k % counts[1]);
            frame.global(&Vec3::new(average(0, i), average(1, j), heights[k]))
        })
        .collect();
    let border_gap = outer
        .iter()
        .map(|p| (row(p).iter().map(|(k, b)| heights[*k] * b).sum::<f64>() - p.z).abs())
        .fold(0.0, f64::max);
    let [knots_u, knots_v] = knots;
    Some(Fitted { surface: SplineSurface { knots_u, knots_v, poles }, border_gap })
}
