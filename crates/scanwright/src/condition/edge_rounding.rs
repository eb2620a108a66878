//! The scanner's spot, read from how round it left sharp edges.
//!
//! A spot of standard deviation b blurs the distance field. Near a straight edge of turning angle 2a the field is
//! `max(l1, l2)` of the distances to both sides, and with `t` across the edge and `z` along the bisector its blur is
//! `z cos a + sin a E|t + b x|`, x standard normal: the surface is the wedge `z = -tan a |t|` smoothed by a Gaussian
//! of width b. The area lost under the wedge is `tan a b^2`, whatever the shape of the blur, for E|t + b x| - |t|
//! integrates to its variance. (Outside a convex edge the true field is rounded instead of `max`; that changes the
//! area of a square edge by about 4 %.)
//! At each sampled crease both sides are fitted by planes well away from it, the area between wedge and scan is
//! summed in bins across the edge, and b is read from the crowd of sites: a fillet of radius r looks like
//! b = 0.46 r at a square edge, so fillets can only raise a site's value and the low end of the sites is taken.
//! Sites whose profile is nearer to an arc than to a blurred wedge are left out.
//!
//! Cost: a bounded number of sites. Where noise hides the shape of the profile it cannot tell the spot from fillets
//! when every edge has the same fillet; edges rounder than [`MAX_ROUNDING`] spacings are not put down to the scanner.

use crate::math::blur::blurred_magnitude;
use crate::math::{Point3, Vec3, centroid, principal_axes, try_unit};
use crate::mesh::{Adjacency, Mesh};
use crate::par;

use super::noise::Patch;
use super::patch::rings;

/// Sites looked at: enough for a steady quantile, few enough to be quick.
const MAX_SITES: usize = 3_000;
/// Least number of usable sites for an answer.
const MIN_SITES: usize = 15;
/// Bend over one spacing from which a patch may lie on a blurred sharp edge: one spacing of blur leaves a square edge
/// with a bend of 0.8 per spacing, noise of a fifth of a spacing makes bends of about 0.1.
const MIN_BEND: f64 = 0.2;
/// Radius of a site, in spacings.
const SITE_RADIUS: f64 = 8.0;
/// Rings that surely reach [`SITE_RADIUS`]: slivers make some rings short.
const SITE_RINGS: usize = 16;
/// Distance from the edge, in spacings, beyond which a side is taken for flat: a spot of 1.2 spacings has no
/// influence beyond two of its deviations.
const SIDE_FROM: f64 = 2.75;
/// Farthest distance from the edge, in spacings, that a side's plane is fitted to.
const SIDE_TO: f64 = 7.0;
/// Half length of a site along the edge, in spacings: short, so that round edges are nearly straight over it.
const HALF_LENGTH: f64 = 3.5;
/// Least number of vertices on a side.
const MIN_SIDE: usize = 15;
/// Half turning angles, as cosine, that count: 27 to 63 degrees. Blunter edges lose too little area to measure,
/// sharper ones are thin walls.
const TURN_COSINE: [f64; 2] = [0.45, 0.89];
/// Bins across the edge, out to [`SIDE_FROM`] on both sides.
const N_BINS: usize = 11;
/// Largest residual of a side in standard deviations of the noise, beside [`FLAT_SHARE`].
const FLAT_SIGMAS: f64 = 2.0;
/// Residual of a side, in spacings, that wavy noise and curvature may cause.
const FLAT_SHARE: f64 = 0.12;
/// Roundings beyond this many spacings are not the scanner's.
const MAX_ROUNDING: f64 = 2.0;
/// Highest over lowest squared rounding of one crowd: sites of sharp edges scatter by some 10 % in width.
const CROWD_RATIO: f64 = 1.5;
/// Size of the lowest crowd as a share of the largest one: parts with mostly broken edges show few sharp ones, but sides
/// that curve make stragglers below the sharp edges. Of 67 simulated scans of known spot one (nist_ctc_01-clean) has enough
/// of them for 0.08, and was taken to have a third of its spot; all others are measured the same with 0.08 and 0.2.
const CROWD_SHARE: f64 = 0.2;
/// What meshing adds to the squared rounding, in squared spacings: triangles cut across an edge, and the field they
/// were drawn from is interpolated between its samples. Measured on simulated scans of known spot: 0.09 to 0.17.
const MESHING_SHARE: f64 = 0.12;
/// Smallest rounding, in spacings, that is told from none: the spread of [`MESHING_SHARE`] allows no less.
const SHARPEST: f64 = 0.1;

/// Standard deviation of the scanner's spot; zero when too few edges show it, [`SHARPEST`] when edges are sharp.
pub(super) fn edge_rounding(
    mesh: &Mesh,
    adjacency: &Adjacency,
    normals: &[Vec3],
    patches: &[Patch],
    spacing: f64,
    noise: f64,
) -> f64 {
    let squares = site_squares(mesh, adjacency, normals, patches, spacing, noise);
    let meshing = MESHING_SHARE * spacing * spacing;
    let n_sharp = squares.iter().filter(|s| **s <= meshing).count();
    // Edges as sharp as meshing leaves them show that there is no spot; no edge at all shows nothing.
    let sharpest = if n_sharp >= MIN_SITES { SHARPEST * spacing } else { 0.0 };
    let Some(square) = lowest_crowd(squares) else { return sharpest };
    let rounding = (square - meshing).max(0.0).sqrt().max(sharpest);
    if rounding <= MAX_ROUNDING * spacing { rounding } else { 0.0 }
}

/// Median of the crowd at the low end of the sites' squared roundings: fillets and chamfers make crowds of their own
/// above it, noise makes stragglers below.
fn lowest_crowd(mut squares: Vec<f64>) -> Option<f64> {
    squares.retain(|s| *s > 0.0);
    squares.sort_unstable_by(f64::total_cmp);
    let end = |i: usize| squares.partition_point(|s| *s <= CROWD_RATIO * squares[i]);
    let sizes: Vec<usize> = (0..squares.len()).map(|i| end(i) - i).collect();
    let least = (CROWD_SHARE * *sizes.iter().max()? as f64).max(MIN_SITES as f64);
    let mut start = sizes.iter().position(|n| *n as f64 >= least)?;
    // Climbs from the first sites that are crowded at all to the densest place near them.
    loop {
        let densest = (start..end(start)).rev().max_by_key(|i| sizes[*i])?;
        if sizes[densest] <= sizes[start] {
            break;
        }
        start = densest;
    }
    Some(squares[start.midpoint(end(start))])
}

fn site_squares(
    mesh: &Mesh,
    adjacency: &Adjacency,
    normals: &[Vec3],
    patches: &[Patch],
    spacing: f64,
    noise: f64,
) -> Vec<f64> {
    let bent: Vec<&Patch> =
        patches.iter().filter(|p| p.quadric.strongest_bend().0.abs() * spacing > MIN_BEND).collect();
    let n_sites = bent.len().min(MAX_SITES);
    let squares = par::map_indices(n_sites, |i| {
        let site = Site { mesh, adjacency, normals, spacing, noise };
        site.rounding_sq(bent[i * bent.len() / n_sites])
    });
    squares.into_iter().flatten().collect()
}

/// What every site needs.
struct Site<'a> {
    mesh: &'a Mesh,
    adjacency: &'a Adjacency,
    normals: &'a [Vec3],
    spacing: f64,
    noise: f64,
}

/// The sharp edge that two sides would meet in, as seen across: `across` along t, `up` along the bisector.
struct Wedge {
    apex: Point3,
    across: Vec3,
    along: Vec3,
    up: Vec3,
    /// Tangent of half the turning angle.
    slope: f64,
}

/// Sums over the vertices of one bin across the edge.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    t: f64,
    lost: f64,
    n: f64,
}

impl Site<'_> {
    /// Squared rounding seen about the middle of `patch`, `None` when it is no clean sharp edge.
    fn rounding_sq(&self, patch: &Patch) -> Option<f64> {
        let (bend, across) = patch.quadric.strongest_bend();
        // With the bisector pointing to the sharp side, convex and concave edges look alike.
        let sign = -bend.signum();
        let middle = self.mesh.vertices[patch.vertex as usize];
        let reach_sq = (SITE_RADIUS * self.spacing).powi(2);
        let near = rings(self.adjacency, patch.vertex, SITE_RINGS, |v| {
            (self.mesh.vertices[v as usize] - middle).norm_squared() < reach_sq
        });
        let up = patch.quadric.frame.z.into_inner() * sign;
        let mut wedge = Wedge { apex: middle, across, along: up.cross(&across), up, slope: 1.0 };
        // The first directions come from a noisy bend; the sides improve them.
        for _ in 0..3 {
            wedge = self.refit(&near, &wedge, sign)?;
        }
        let profile = self.lost_profile(&near, &wedge);
        let area: f64 = profile.windows(2).map(|w| 0.5 * (w[0].lost + w[1].lost) * (w[1].t - w[0].t)).sum();
        let square = area / wedge.slope;
        is_blurred_wedge(&profile, wedge.slope, square).then_some(square)
    }

    fn refit(&self, near: &[u32], wedge: &Wedge, sign: f64) -> Option<Wedge> {
        let (left, left_normal) = self.side(near, wedge, -1.0, sign)?;
        let (right, right_normal) = self.side(near, wedge, 1.0, sign)?;
        let up = try_unit(left_normal + right_normal)?.into_inner();
        let along = try_unit(right_normal.cross(&left_normal))?.into_inner();
        let across = along.cross(&up);
        let cosine = up.dot(&left_normal);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        if !(TURN_COSINE[0]..TURN_COSINE[1]).contains(&cosine) {
            return None;
        }
        // Both side planes seen in the (across, up) plane through the old apex.
        let (l, r) = (left_normal.dot(&(left - wedge.apex)), right_normal.dot(&(right - wedge.apex)));
        let right_is_positive = right_normal.dot(&across).signum();
        let apex = wedge.apex
            + up * ((l + r) / (2.0 * cosine))
            + across * ((r - l) / (2.0 * sine) * right_is_positive);
        Some(Wedge { apex, across, along, up, slope: sine / cosine })
    }

    /// Centroid and normal of the plane of one side.
    fn side(&self, near: &[u32], wedge: &Wedge, which: f64, sign: f64) -> Option<(Point3, Vec3)> {
        let mut normal_sum = Vec3::zeros();
        let mut points = Vec::with_capacity(near.len() / 2);
        // Distances from the edge are measured on the side, not on its shadow.
        let per_shadow = (1.0 + wedge.slope * wedge.slope).sqrt() / self.spacing;
        for &v in near {
            let offset = self.mesh.vertices[v as usize] - wedge.apex;
            let distance = which * offset.dot(&wedge.across) * per_shadow;
            let along = offset.dot(&wedge.along) / self.spacing;
            if distance > SIDE_FROM && distance < SIDE_TO && along.abs() < HALF_LENGTH {
                points.push(self.mesh.vertices[v as usize]);
                normal_sum += self.normals[v as usize];
            }
        }
        if points.len() < MIN_SIDE {
            return None;
        }
        let center = centroid(&points);
        let [(variance, normal), (width, _), _] = principal_axes(&points, center);
        let flat = FLAT_SIGMAS * self.noise + FLAT_SHARE * self.spacing;
        if variance > flat * flat || width < self.spacing * self.spacing {
            return None;
        }
        let outward = normal.dot(&normal_sum).signum() * sign;
        Some((center, normal.into_inner() * outward))
    }

    /// Mean height lost under the wedge in each bin across the edge that holds a vertex.
    fn lost_profile(&self, near: &[u32], wedge: &Wedge) -> Vec<Bin> {
        let reach = SIDE_FROM * self.spacing / (1.0 + wedge.slope * wedge.slope).sqrt();
        let width = 2.0 * reach / N_BINS as f64;
        let mut bins = [Bin::default(); N_BINS];
        for &v in near {
            let offset = self.mesh.vertices[v as usize] - wedge.apex;
            let (t, z) = (offset.dot(&wedge.across), offset.dot(&wedge.up));
            let bin = ((t + reach) / width).floor();
            if offset.dot(&wedge.along).abs() > HALF_LENGTH * self.spacing
                || bin < 0.0
                || bin >= N_BINS as f64
            {
                continue;
            }
            let bin = &mut bins[bin as usize];
            bin.t += t;
            bin.lost -= z + wedge.slope * t.abs();
            bin.n += 1.0;
        }
        let filled = bins.iter().filter(|b| b.n > 0.0);
        filled.map(|b| Bin { t: b.t / b.n, lost: b.lost / b.n, n: b.n }).collect()
    }
}

/// Whether a wedge smoothed by a spot of this squared deviation is nearer to the profile than a fillet that loses the
/// same area.
fn is_blurred_wedge(profile: &[Bin], slope: f64, square: f64) -> bool {
    if square <= 0.0 {
        return false;
    }
    let half_turn = slope.atan();
    let deviation = square.sqrt();
    // The fillet of radius r loses (tan a - a) r^2 under the wedge.
    let radius = deviation * (slope / (slope - half_turn)).sqrt();
    let by_spot = |t: f64| slope * (blurred_magnitude(t, deviation).0 - t.abs());
    let by_fillet = |t: f64| {
        let within = t.abs() < radius * half_turn.sin();
        if within {
            radius / half_turn.cos() - (radius * radius - t * t).sqrt() - slope * t.abs()
        } else {
            0.0
        }
    };
    let misfit = |model: &dyn Fn(f64) -> f64| -> f64 {
        profile.iter().map(|bin| bin.n * (bin.lost - model(bin.t)).powi(2)).sum()
    };
    misfit(&by_spot) < misfit(&by_fillet)
}
