//! Simpler surfaces in place of one complex surface.
//!
//! A torus, sphere or cone may have been laid over several facets of a turned part: chamfer, ring, chamfer. In the
//! half-plane through the axis each of those facets is a straight line, and the mean over the whole turn hardly has
//! any noise left. The profile is cut into the best one, two, three ... lines (dynamic programming). If lines with
//! corners as round as the scanner makes them describe it better than an arc, every line becomes a hypothesis;
//! whether they replace the whole is decided in `select`.

use std::f64::consts::PI;

use super::edge;
use super::field::{Field, Hypothesis, Scratch};
use super::grow::{BORDER_RINGS, MIN_INTERIOR, settle_as};
use crate::fit::Fit;
use crate::math::{Frame, nearest_circle};
use crate::recognize::{COST_CAP, fit_kind};
use crate::surface::{Surface, SurfaceKind};

/// Samples of a fit while typing a part.
const N_SAMPLES: usize = 60;
/// Lines of a profile, at most.
const MOST_LINES: usize = 7;
/// Cells of a profile, at most.
const MOST_CELLS: usize = 64;
/// Narrowest part that is tried, in spacings.
const MIN_WIDTH: f64 = 2.0;
/// Saving in squared sigmas that one more line must bring.
const LINE_PRICE: f64 = 100.0;
/// Price of one parameter of a profile in squared sigmas of its cells.
const PRICE_PER_FREEDOM: f64 = 2.0;
/// Vertices per independent sample of the noise, which is wavy over some six spacings. Means of cells show nothing but
/// the noise; `recognize` counts fewer samples, for single vertices also carry what fits leave over.
pub(super) const VERTICES_PER_SAMPLE: f64 = 40.0;
/// Vertices of a part, at least.
const MIN_PART: usize = 30;

/// Hypotheses for the parts of a complex one.
pub(super) fn parts(field: &Field, hypothesis: &Hypothesis, scratch: &mut Scratch) -> Vec<Hypothesis> {
    let support: Vec<u32> = hypothesis.support.iter().map(|s| s.0).collect();
    let Some(profile) = Profile::new(field, &hypothesis.fit, &support, scratch) else { return Vec::new() };
    profile
        .lines(field.weights.distance_sigma, field.blur)
        .into_iter()
        .filter_map(|(from, to)| {
            let part = profile.vertices(from, to, field.spacing);
            if part.len() < MIN_PART || profile.width(from, to) < MIN_WIDTH * field.spacing {
                return None;
            }
            let fit = simplest(field, &part)?;
            settle_as(field, &fit, &part, scratch)
        })
        .collect()
}

/// Sums over the points of one or more cells: count, and moments of radius and height.
#[derive(Debug, Clone, Copy, Default)]
struct Moments([f64; 6]);

impl Moments {
    fn add(&mut self, r: f64, z: f64) {
        for (sum, term) in self.0.iter_mut().zip([1.0, r, z, r * r, r * z, z * z]) {
            *sum += term;
        }
    }

    fn plus(mut self, other: Self, sign: f64) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += sign * b;
        }
        self
    }

    /// Sum of squared distances to the line that fits best.
    fn line_residual(&self) -> f64 {
        let [n, r, z, rr, rz, zz] = self.0;
        if n < 2.0 {
            return 0.0;
        }
        let (rr, rz, zz) = (rr - r * r / n, rz - r * z / n, zz - z * z / n);
        (0.5 * (rr + zz) - (0.25 * (rr - zz) * (rr - zz) + rz * rz).sqrt()).max(0.0)
    }
}

/// The vertices of a surface of revolution in cells along its profile.
struct Profile {
    /// One per cell.
    members: Vec<Vec<u32>>,
    /// One per cell boundary: sums over all cells before it.
    before: Vec<Moments>,
    /// Length of a cell along the profile.
    cell: f64,
}

impl Profile {
    /// The profile about the axis of `fit`; `None` when it has none.
    fn new(field: &Field, fit: &Fit, support: &[u32], scratch: &mut Scratch) -> Option<Self> {
        let surface = match fit.surface {
            // A sphere's profile needs an axis: that of the torus nearest to it.
            Surface::Sphere(_) => {
                let interior = field.eroded(support, BORDER_RINGS, MIN_INTERIOR, scratch);
                let samples = field.samples(&interior, 2 * N_SAMPLES);
                fit_kind(SurfaceKind::Torus, &samples, &field.weights, &field.limits, None)?.fit.surface
            }
            other => other,
        };
        let axis = surface.axis()?;
        let frame = Frame::from_z(axis.origin, axis.direction);
        let planar: Vec<(f64, f64)> = support
            .iter()
            .map(|&v| {
                let local = frame.local(&field.points[v as usize]);
                (local.x.hypot(local.y), local.z)
            })
            .collect();
        let keys = arc_lengths(&surface, &planar)?;
        let low = keys.iter().copied().fold(f64::MAX, f64::min);
        let length = keys.iter().copied().fold(f64::MIN, f64::max) - low;
        let n_cells = ((2.0 * length / field.spacing) as usize).clamp(1, MOST_CELLS);
        let cell = length / n_cells as f64;
        let mut members = vec![Vec::new(); n_cells];
        let mut moments = vec![Moments::default(); n_cells];
        for ((key, &(r, z)), &v) in keys.iter().zip(&planar).zip(support) {
            let at = (((key - low) / cell) as usize).min(n_cells - 1);
            members[at].push(v);
            moments[at].add(r, z);
        }
        let mut before = vec![Moments::default()];
        for m in moments {
            before.push(before[before.len() - 1].plus(m, 1.0));
        }
        Some(Self { members, before, cell })
    }

    fn width(&self, from: usize, to: usize) -> f64 {
        (to - from) as f64 * self.cell
    }

    /// Vertices of the cells, without the rounded rims where there is room.
    fn vertices(&self, from: usize, to: usize, spacing: f64) -> Vec<u32> {
        let rim = ((spacing / self.cell).round() as usize).min((to - from).saturating_sub(1) / 3);
        self.members[from + rim..to - rim].concat()
    }

    fn residual(&self, from: usize, to: usize) -> f64 {
        self.before[to].plus(self.before[from], -1.0).line_residual()
    }

    /// Ranges of cells that are lines of the best cuts into one, two, three ... lines, each once; none when an arc
    /// describes the profile as well.
    fn lines(&self, sigma: f64, blur: f64) -> Vec<(usize, usize)> {
        let n = self.members.len();
        let cost = |from, to| self.residual(from, to) / (sigma * sigma);
        // best[k][to]: cheapest cut of the first `to` cells into k + 1 lines, and where the last of them begins.
        let mut best: Vec<Vec<(f64, usize)>> = vec![(0..=n).map(|to| (cost(0, to), 0)).collect()];
        let mut found = vec![(0, n)];
        let mut lowest = self.cost_of_lines(&found, sigma, blur);
        for k in 1..MOST_LINES.min(n) {
            let last = &best[k - 1];
            let next: Vec<(f64, usize)> = (0..=n)
                .map(|to| {
                    (k..to)
                        .map(|from| (last[from].0 + cost(from, to), from))
                        .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
                        .unwrap_or((f64::MAX, 0))
                })
                .collect();
            if last[n].0 - next[n].0 < LINE_PRICE {
                break;
            }
            best.push(next);
            let mut lines = Vec::new();
            let mut to = n;
            for level in best.iter().rev() {
                lines.push((level[to].1, to));
                to = level[to].1;
            }
            lines.reverse();
            lowest = lowest.min(self.cost_of_lines(&lines, sigma, blur));
            found.extend(lines);
        }
        if self.cost_of_arc(sigma) <= lowest {
            return Vec::new();
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Squared deviations of the cells' means from a polyline with blurred corners, in units of their noise, and the
    /// price of its lines.
    fn cost_of_lines(&self, ranges: &[(usize, usize)], sigma: f64, blur: f64) -> f64 {
        let lines: Vec<Line> = ranges.iter().map(|&(from, to)| self.line(from, to)).collect();
        let mut sum = PRICE_PER_FREEDOM * 2.0 * lines.len() as f64;
        for (k, &(from, to)) in ranges.iter().enumerate() {
            for cell in from..to {
                let Some((weight, r, z)) = self.mean(cell) else { continue };
                // The nearer of the two corners rounds the line here.
                let other = if 2 * cell < from + to { k.checked_sub(1) } else { Some(k + 1) };
                let other = other.and_then(|k| lines.get(k));
                let distance = lines[k].distance(r, z);
                let deviation = other.map_or(distance, |other| lines[k].blurred(other, blur, r, z));
                sum += weight * (deviation / sigma).powi(2);
            }
        }
        sum
    }

    /// The same for the nearest circular arc.
    fn cost_of_arc(&self, sigma: f64) -> f64 {
        let cells: Vec<(f64, f64, f64)> = (0..self.members.len()).filter_map(|c| self.mean(c)).collect();
        let Some(([r0, z0], radius)) = nearest_circle(cells.iter().copied()) else { return f64::MAX };
        let deviations =
            cells.iter().map(|&(w, r, z)| w * (((r - r0).hypot(z - z0) - radius) / sigma).powi(2));
        deviations.sum::<f64>() + PRICE_PER_FREEDOM * 3.0
    }

    /// Number of independent samples in a cell, and its mean radius and height.
    fn mean(&self, cell: usize) -> Option<(f64, f64, f64)> {
        let [n, r, z, ..] = self.before[cell + 1].plus(self.before[cell], -1.0).0;
        (n > 0.0).then(|| (n / VERTICES_PER_SAMPLE, r / n, z / n))
    }

    /// Whether the profile runs with (1) or against (-1) a direction from one cell to a later one.
    fn heading(&self, first: usize, last: usize, along: f64) -> f64 {
        let (Some((_, r0, z0)), Some((_, r1, z1))) = (self.mean(first), self.mean(last)) else { return 1.0 };
        ((r1 - r0) * along.cos() + (z1 - z0) * along.sin()).signum()
    }

    /// The line of a range of cells, its rounded rims left out where there is room.
    fn line(&self, from: usize, to: usize) -> Line {
        let rim = (to - from) / 4;
        let [n, r, z, rr, rz, zz] = self.before[to - rim].plus(self.before[from + rim], -1.0).0;
        let n = n.max(1.0);
        let (rr, rz, zz) = (rr - r * r / n, rz - r * z / n, zz - z * z / n);
        let along = 0.5 * (2.0 * rz).atan2(rr - zz);
        // Directions follow the profile, so that all normals point to one side of it.
        let sign = self.heading(from + rim, to - rim - 1, along);
        Line { r: r / n, z: z / n, normal: [-sign * along.sin(), sign * along.cos()] }
    }
}

/// A straight line in the half-plane.
struct Line {
    r: f64,
    z: f64,
    normal: [f64; 2],
}

impl Line {
    fn distance(&self, r: f64, z: f64) -> f64 {
        self.normal[0] * (r - self.r) + self.normal[1] * (z - self.z)
    }

    /// Distance to this line and another with their corner rounded by a spot: see `edge`. The corner is convex on the
    /// side away from the lines' middles.
    fn blurred(&self, other: &Self, blur: f64, r: f64, z: f64) -> f64 {
        let apart = (self.normal[0] - other.normal[0]).hypot(self.normal[1] - other.normal[1]);
        let side = -other.distance(self.r, self.z).signum();
        let (a, b) = (self.distance(r, z), other.distance(r, z));
        edge::blurred_maximum(side * a, side * b, blur * apart) * side
    }
}

/// Position of each point of the half-plane along the profile of a surface, length.
fn arc_lengths(surface: &Surface, planar: &[(f64, f64)]) -> Option<Vec<f64>> {
    match surface {
        Surface::Torus(s) => {
            let angles: Vec<f64> = planar.iter().map(|(r, z)| z.atan2(r - s.major_radius)).collect();
            let (x, y) = angles.iter().fold((0.0, 0.0), |(x, y), a| (x + a.cos(), y + a.sin()));
            let middle = f64::atan2(y, x);
            Some(
                angles
                    .iter()
                    .map(|a| (a - middle + 3.0 * PI).rem_euclid(2.0 * PI) * s.minor_radius)
                    .collect(),
            )
        }
        Surface::Cone(s) => {
            let (sin, cos) = s.half_angle.sin_cos();
            Some(planar.iter().map(|(r, z)| r * sin + z * cos).collect())
        }
        _ => None,
    }
}

/// The simplest type that describes a part about as well as any.
fn simplest(field: &Field, part: &[u32]) -> Option<Fit> {
    /// Share by which a more complex type must be better.
    const CLEARLY: f64 = 0.7;
    let samples = field.samples(part, N_SAMPLES);
    let mut best: Option<(Fit, f64)> = None;
    for kind in [SurfaceKind::Plane, SurfaceKind::Cylinder, SurfaceKind::Cone] {
        let Some(choice) = fit_kind(kind, &samples, &field.weights, &field.limits, None) else { continue };
        if best.is_none_or(|(_, cost)| choice.mean_cost < CLEARLY * cost) {
            best = Some((choice.fit, choice.mean_cost.min(COST_CAP)));
        }
    }
    best.map(|(fit, _)| fit)
}
