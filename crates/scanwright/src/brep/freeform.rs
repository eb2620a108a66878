//! Bicubic B-spline surfaces for patches that no analytic surface describes.
//!
//! A patch is seen in the parameter plane of a chart: the surface that was found for it, or the plane across its mean
//! normal. A spline is fitted to the chart, then moved to the patch's mesh vertices and, with a larger weight, to its
//! border curves, by least squares with a small penalty on second differences of the poles' moves.
//! P. Dierckx, "Curve and Surface Fitting with Splines", Oxford University Press 1993, chapter 5; here with uniform
//! knots, half as many again while the border is not met. Cost O(poles^2) per patch. Fails where the patch folds over
//! a plane; patches are cut before that (`split`).

use super::assemble::{placement, same_sense};
use super::banded::Banded;
use super::domain::{Domain, Uv};
use super::solid::Geometry;
use super::split::Patch;
use crate::math::{Frame, Point3, UnitVec3, Vec3, any_perpendicular, try_unit};
use crate::mesh::Mesh;
use crate::surface::bspline::{DEGREE, SplineSurface, basis, find_span, uniform_knots};
use crate::surface::{Plane, Surface};

/// Fewest and most poles along one side.
const POLES: (usize, usize) = (6, 48);
/// Spacings per knot span at the start.
const SPAN: f64 = 5.0;
/// Weight of a border sample against a mesh vertex: the border has to close, the inside only to be near.
const BORDER_WEIGHT: f64 = 2000.0;
/// Penalty on second differences of poles against one mesh vertex: only fills where no data is.
const SMOOTHING: f64 = 0.1;
/// Share of the side left free around the patch, so that its border is inside the surface.
const MARGIN: f64 = 0.05;

/// Share of the area that may be steeper than a height over a plane.
pub(super) const MAX_FOLDED: f64 = 0.02;

/// A spline and how far the border samples lie off it.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub surface: SplineSurface,
    pub border_gap: f64,
    /// The border sample that lies farthest off; `None` without a border.
    pub worst: Option<Point3>,
    /// Whether its natural normal points out of the material.
    pub outward: bool,
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
    let (geometry, frame) = chart(mesh, patch);
    let mut vertices: Vec<u32> = patch.triangles.iter().flat_map(|t| mesh.triangles[*t as usize]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let inner: Vec<Point3> = vertices.iter().map(|v| mesh.vertices[*v as usize]).collect();
    let domain = Domain::around(&geometry, frame, || inner.clone());
    let placed = |points: &[Point3]| points.iter().map(|p| (domain.uv(p), *p)).collect::<Vec<_>>();
    let (inner, outer) = (placed(&inner), placed(border));
    let first = inner.first()?.0;
    let (mut low, mut high) = (first, first);
    for (uv, _) in inner.iter().chain(&outer) {
        for i in 0..2 {
            low[i] = low[i].min(uv[i]);
            high[i] = high[i].max(uv[i]);
        }
    }
    for i in 0..2 {
        let margin = (high[i] - low[i]) * MARGIN + spacing;
        (low[i], high[i]) = (low[i] - margin, high[i] + margin);
    }
    let outward = same_sense(&geometry, mesh, patch);
    let mut counts = [0, 1].map(|i| ((high[i] - low[i]) / (SPAN * spacing)) as usize + POLES.0);
    // Spans below the spacing would only bend between the points.
    let most = [0, 1].map(|i| (((high[i] - low[i]) / spacing) as usize).clamp(POLES.0, POLES.1));
    let mut best: Option<Fitted> = None;
    loop {
        counts = [0, 1].map(|i| counts[i].clamp(POLES.0, most[i]));
        let grid = Grid { low, high, counts, knots: counts.map(uniform_knots) };
        let (surface, border_gap, worst) = grid.fit(&domain, &inner, &outer)?;
        let fitted = Fitted { surface, border_gap, worst, outward };
        let done = fitted.border_gap <= tolerance || counts == most;
        if best.as_ref().is_none_or(|b| fitted.border_gap < b.border_gap) {
            best = Some(fitted);
        }
        if done {
            return best;
        }
        counts = counts.map(|n| n * 3 / 2);
    }
}

/// The surface whose parameters the spline takes over, and its placement: a plane where that will do, for it has no
/// poles and no seams.
fn chart(mesh: &Mesh, patch: &Patch) -> (Geometry, Frame) {
    let plane = base_frame(mesh, &patch.triangles);
    let folds = folded_share(mesh, &patch.triangles, &plane) > MAX_FOLDED;
    if let Some(surface) = patch.chart.filter(|s| folds && !matches!(s, Surface::Plane(_))) {
        let geometry = Geometry::Analytic(surface);
        let frame = placement(&geometry, mesh, patch);
        return (geometry, frame);
    }
    let frame = turned(&plane, mesh, &patch.triangles);
    (Geometry::Analytic(Surface::Plane(Plane { point: frame.origin, normal: frame.z })), frame)
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

/// A rectangle of a parameter plane with the knots of a spline over it.
struct Grid {
    low: Uv,
    high: Uv,
    counts: [usize; 2],
    knots: [Vec<f64>; 2],
}

/// The poles that share in a point, and their shares.
type Row = [(usize, f64); (DEGREE + 1) * (DEGREE + 1)];

impl Grid {
    fn row(&self, uv: &Uv) -> Row {
        let at = [0, 1].map(|i| ((uv[i] - self.low[i]) / (self.high[i] - self.low[i])).clamp(0.0, 1.0));
        let spans = [0, 1].map(|i| find_span(&self.knots[i], at[i]));
        let values = [0, 1].map(|i| basis(&self.knots[i], spans[i], at[i]));
        let mut row = [(0, 0.0); (DEGREE + 1) * (DEGREE + 1)];
        for i in 0..=DEGREE {
            for j in 0..=DEGREE {
                let pole = (spans[0] - DEGREE + i) * self.counts[1] + spans[1] - DEGREE + j;
                row[i * (DEGREE + 1) + j] = (pole, values[0][i] * values[1][j]);
            }
        }
        row
    }

    fn point(poles: &[Vec3], row: &Row) -> Vec3 {
        row.iter().fold(Vec3::zeros(), |sum, (k, b)| sum + poles[*k] * *b)
    }

    /// The spline nearest to the chart itself, then moved to the points.
    fn fit(
        &self,
        domain: &Domain,
        inner: &[(Uv, Point3)],
        outer: &[(Uv, Point3)],
    ) -> Option<(SplineSurface, f64, Option<Point3>)> {
        /// Samples of the chart per knot span.
        const DENSITY: usize = 2;
        let n = self.counts[0] * self.counts[1];
        let steps = self.counts.map(|c| DENSITY * (c - DEGREE) + 1);
        let mut of_chart = Vec::new();
        for i in 0..=steps[0] {
            for j in 0..=steps[1] {
                let at = |axis: usize, k: usize| {
                    self.low[axis] + (self.high[axis] - self.low[axis]) * k as f64 / steps[axis] as f64
                };
                let uv = [at(0, i), at(1, j)];
                of_chart.push((self.row(&uv), domain.point(uv).coords, 1.0));
            }
        }
        /// Weight of smoothness that keeps the system regular and no more: this only starts the fit, and the chart is
        /// smooth itself.
        const HARDLY: f64 = 1e-9;
        let start = self.solve(&of_chart, HARDLY)?;
        let moved = |(uv, p): &(Uv, Point3), weight: f64| {
            let row = self.row(uv);
            (row, p.coords - Self::point(&start, &row), weight)
        };
        let mut rows: Vec<(Row, Vec3, f64)> = inner.iter().map(|p| moved(p, 1.0)).collect();
        rows.extend(outer.iter().map(|p| moved(p, BORDER_WEIGHT)));
        let moves = self.solve(&rows, SMOOTHING * (inner.len() as f64 / n as f64).max(1.0))?;
        let poles: Vec<Vec3> = start.iter().zip(&moves).map(|(p, d)| p + d).collect();
        let gap = |(uv, p): &(Uv, Point3)| (Self::point(&poles, &self.row(uv)) - p.coords).norm();
        let worst = outer.iter().max_by(|a, b| gap(a).total_cmp(&gap(b)));
        let (border_gap, worst) = worst.map_or((0.0, None), |sample| (gap(sample), Some(sample.1)));
        let [knots_u, knots_v] = self.knots.clone();
        let poles = poles.into_iter().map(Point3::from).collect();
        Some((SplineSurface { knots_u, knots_v, poles }, border_gap, worst))
    }

    /// Poles by least squares with a penalty on their second differences.
    fn solve(&self, rows: &[(Row, Vec3, f64)], penalty: f64) -> Option<Vec<Vec3>> {
        let n = self.counts[0] * self.counts[1];
        let mut matrix = Banded::zeros(n, DEGREE * self.counts[1] + DEGREE);
        let mut right = vec![[0.0; 3]; n];
        for (row, value, weight) in rows {
            for (i, a) in row {
                for k in 0..3 {
                    right[*i][k] += weight * a * value[k];
                }
                for (j, b) in row {
                    matrix.add(*i, *j, weight * a * b);
                }
            }
        }
        let mut straight = |poles: [usize; 3]| {
            for (i, a) in poles.iter().zip([1.0, -2.0, 1.0]) {
                for (j, b) in poles.iter().zip([1.0, -2.0, 1.0]) {
                    matrix.add(*i, *j, penalty * a * b);
                }
            }
        };
        let at = |i: usize, j: usize| i * self.counts[1] + j;
        for i in 0..self.counts[0] {
            for j in 0..self.counts[1] {
                if i + 2 < self.counts[0] {
                    straight([at(i, j), at(i + 1, j), at(i + 2, j)]);
                }
                if j + 2 < self.counts[1] {
                    straight([at(i, j), at(i, j + 1), at(i, j + 2)]);
                }
            }
        }
        Some(matrix.solve(right)?.into_iter().map(Vec3::from).collect())
    }
}
