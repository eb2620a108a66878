//! The rules: spot, great circle, small circle, and the accumulator for what fills the sphere.

use super::{Accumulator, Cells, GaussImage, N_CELLS, Voting};
use crate::math::{Frame, Mat3, Point3, UnitVec3, Vec3, symmetric_eigen};
use crate::surface::SurfaceKind;

/// Where the plane through the normals is centred.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Center {
    /// Mean of the normals.
    Mean,
    /// Geometric median: outlying normals do not pull it, and it turns with the normals, as the median of each coordinate
    /// does not.
    #[default]
    Median,
}

/// Options of the rules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Standard deviation of the normals, radians; thresholds follow it. Default 0.
    pub normal_noise: f64,
    /// Where the plane through the normals is centred. Default: median.
    pub center: Center,
    /// Cells of the accumulator. Default 202.
    pub n_cells: usize,
    /// How triangles vote. Default: by area.
    pub voting: Voting,
}

impl Default for Rules {
    fn default() -> Self {
        Self { normal_noise: 0.0, center: Center::default(), n_cells: N_CELLS, voting: Voting::Area }
    }
}

/// What the rules look at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Angle about the centre that holds 95 % of the area's normals, radians.
    pub spread: f64,
    /// Root mean square distance of the normals to the plane through them.
    pub flatness: f64,
    /// Distance of that plane to the sphere's centre: zero for a great circle, the sine of a cone's half-angle.
    pub offset: f64,
    /// Normal of that plane: the axis of a cylinder or cone.
    pub axis: UnitVec3,
    /// Share of the turn about that axis that the normals show.
    pub turn: f64,
    /// Skewness of the votes.
    pub skewness: f64,
    /// Deviation of the votes over their mean, without that of chance.
    pub dispersion: f64,
    /// Second moments of the normals about the sphere's centre, ascending: their sum is one.
    pub moments: [f64; 3],
    /// Length of the mean normal: zero for complete spheres and tori.
    pub mean: f64,
}

/// A type with what speaks for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// The type.
    pub kind: SurfaceKind,
    /// Whether normals alone can tell: not so for short arcs, and for caps of spheres and tori.
    pub certain: bool,
    /// The statistics that decided.
    pub evidence: Evidence,
}

/// Spread of a plane's normals, radians, beside their noise.
const SPOT: f64 = 0.07;
/// Flatness of a circle's normals, beside their noise.
const CIRCLE: f64 = 0.03;
/// What noise may make of them at most, before a cone's or a sphere's normals pass for a spot or a circle: complete tori
/// have a flatness of 0.5.
const NOISIEST_SPOT: f64 = 0.5;
const NOISIEST_CIRCLE: f64 = 0.3;
/// Length of the centre below which normals have no common direction: those of a box have none at all.
const COMMON: f64 = 0.5;
/// Offset from which a circle is a small one: the sine of 2.9 degrees.
const SMALL_CIRCLE: f64 = 0.05;
/// Skewness from which votes gather at the ends of an axis. Complete spheres have 0.1, complete tori 5.6, with 10 degrees
/// of noise still 2.8.
const GATHERED: f64 = 1.5;
/// Second moments of the normals of a complete sphere, and of a complete torus whatever its radii, ascending.
const SPHERE_MOMENTS: [f64; 3] = [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0];
const TORUS_MOMENTS: [f64; 3] = [0.25, 0.25, 0.5];
/// Difference to those moments, and length of the mean normal, that triangles of a complete model leave.
const COMPLETE: f64 = 0.05;
/// Share of the turn from which an arc shows whether its circle is great or small.
const LONG_ARC: f64 = 0.2;
/// Sectors by which the turn is measured.
const N_SECTORS: usize = 72;

impl Rules {
    /// The type of a region from its image; `None` when it has no area.
    pub fn recognize(&self, image: &GaussImage) -> Option<Verdict> {
        let evidence = self.evidence(image)?;
        let spot = SPOT.max(3.0 * self.normal_noise).min(NOISIEST_SPOT);
        let circle = CIRCLE.max(2.5 * self.normal_noise).min(NOISIEST_CIRCLE);
        let is_too_noisy = spot >= NOISIEST_SPOT || circle >= NOISIEST_CIRCLE;
        let (kind, certain) = if evidence.spread < spot {
            (SurfaceKind::Plane, true)
        } else if evidence.flatness < circle {
            let kind = if evidence.offset < SMALL_CIRCLE { SurfaceKind::Cylinder } else { SurfaceKind::Cone };
            let is_clear = (evidence.offset - SMALL_CIRCLE).abs() > 0.5 * SMALL_CIRCLE;
            (kind, is_clear && evidence.turn > LONG_ARC)
        } else {
            let (kind, moments) = if evidence.skewness < GATHERED {
                (SurfaceKind::Sphere, SPHERE_MOMENTS)
            } else {
                (SurfaceKind::Torus, TORUS_MOMENTS)
            };
            let off = evidence.moments.iter().zip(moments).map(|(a, b)| (a - b).abs());
            (kind, off.chain([evidence.mean]).fold(0.0, f64::max) < COMPLETE)
        };
        Some(Verdict { kind, certain: certain && !is_too_noisy, evidence })
    }

    /// What the rules look at; `None` when the image is empty.
    pub fn evidence(&self, image: &GaussImage) -> Option<Evidence> {
        let total: f64 = image.areas.iter().sum();
        if total <= 0.0 {
            return None;
        }
        let center = match self.center {
            Center::Mean => mean(image, total),
            Center::Median => median(image, total),
        };
        let (mut scatter, mut second) = (Mat3::zeros(), Mat3::zeros());
        for (normal, area) in image.normals.iter().zip(&image.areas) {
            let off = normal - center;
            scatter += off * off.transpose() * (area / total);
            second += normal * normal.transpose() * (area / total);
        }
        let [(variance, axis), ..] = symmetric_eigen(&scatter);
        let angle = |n: &Vec3| n.cross(&center).norm().atan2(n.dot(&center));
        let angles = image.normals.iter().map(angle).zip(image.areas.iter().copied()).collect();
        let has_direction = center.norm() > COMMON;
        let accumulator = Accumulator::new(image, &Cells::new(self.n_cells), self.voting);
        Some(Evidence {
            spread: if has_direction { weighted_quantile(angles, total, 0.95) } else { std::f64::consts::PI },
            flatness: variance.max(0.0).sqrt(),
            offset: center.dot(&axis).abs(),
            axis,
            turn: turn(image, axis),
            skewness: accumulator.skewness(),
            dispersion: accumulator.dispersion(),
            moments: symmetric_eigen(&second).map(|pair| pair.0),
            mean: mean(image, total).norm(),
        })
    }
}

fn mean(image: &GaussImage, total: f64) -> Vec3 {
    let sum = image.normals.iter().zip(&image.areas).fold(Vec3::zeros(), |sum, (n, area)| sum + n * *area);
    sum / total
}

/// The point with the least sum of distances to the normals, by area: E. Weiszfeld, Tohoku Mathematical Journal 43 (1937),
/// 355-386.
fn median(image: &GaussImage, total: f64) -> Vec3 {
    const MAX_STEPS: usize = 100;
    // Far below what thresholds of the rules can tell apart, in radians.
    const STILL: f64 = 1e-6;
    // Normals closer to the median than this no longer pull it to themselves.
    const NEAR: f64 = 1e-6;
    let mut center = mean(image, total);
    for _ in 0..MAX_STEPS {
        let (mut sum, mut weight_sum) = (Vec3::zeros(), 0.0);
        for (normal, area) in image.normals.iter().zip(&image.areas) {
            let weight = area / (normal - center).norm().max(NEAR);
            sum += normal * weight;
            weight_sum += weight;
        }
        let next = sum / weight_sum;
        let moved = (next - center).norm();
        center = next;
        if moved < STILL {
            break;
        }
    }
    center
}

/// Share of the turn about `axis` that normals which are not along it show.
fn turn(image: &GaussImage, axis: UnitVec3) -> f64 {
    let frame = Frame::from_z(Point3::origin(), axis);
    let mut seen = [false; N_SECTORS];
    for normal in &image.normals {
        if normal.cross(&axis).norm() > SMALL_CIRCLE {
            seen[frame.sector(&Point3::from(*normal), N_SECTORS)] = true;
        }
    }
    // Coarse triangles leave sectors between them empty: up to an eighth of the turn is a gap that they bridge.
    let longest_gap = N_SECTORS / 8;
    let n = (0..N_SECTORS).filter(|&k| {
        let reach = |step: fn(usize, usize) -> usize| (0..longest_gap).find(|&d| seen[step(k, d) % N_SECTORS]);
        seen[k]
            || matches!((reach(|k, d| k + d), reach(|k, d| k + N_SECTORS - d)), (Some(a), Some(b)) if a + b <= longest_gap)
    });
    n.count() as f64 / N_SECTORS as f64
}

/// The value up to which a share `q` of the weight lies: (value, weight) each.
pub(super) fn weighted_quantile(mut values: Vec<(f64, f64)>, total: f64, q: f64) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut sum = 0.0;
    let at = values.iter().find(|(_, weight)| {
        sum += weight;
        sum >= q * total
    });
    at.or(values.last()).map_or(0.0, |v| v.0)
}
