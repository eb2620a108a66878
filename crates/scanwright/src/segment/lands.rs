//! Lands of one round: the tips of teeth, splines and ribs that were turned before they were cut.
//!
//! A land is a narrow arc of a large circle. Across its width the arc rises by less than the noise, so that each alone
//! is read as a plane, or as a cylinder about a wrong axis. Together they show what they are: strips along one axis of
//! the part, at one distance from it, each facing away from it. Where five or more do so and one cylinder describes
//! each as well as its own surface does, that cylinder is the simpler explanation, one radius in place of as many
//! planes; and where it rises by less than the noise, nothing speaks for flats.

use super::field::Field;
use super::finish::Regions;
use super::primitive;
use super::turned::axes;
use crate::fit::{Fit, Samples, refine};
use crate::math::{Axis, stats, try_unit};
use crate::par;
use crate::recognize::{Primitive, is_as_good, mean_cost};
use crate::surface::{Cylinder, Surface, SurfaceKind};

/// Fewer strips round an axis may be the sides of a square or the ends of ribs.
const MIN_LANDS: usize = 5;
/// Samples per region in a test.
const N_TEST: usize = 200;
/// Times that the cylinder is fitted to the strips that are on it.
const ROUNDS: usize = 3;
/// Steps of each fit.
const STEPS: usize = 20;

/// Lands on one cylinder.
#[derive(Debug, Clone)]
pub(super) struct Round {
    fit: Fit,
    /// Regions on it.
    lands: Vec<u32>,
}

impl Round {
    /// The lands among `strips`, which are about as far from one axis; `None` when they are too few.
    fn of(field: &Field, axis: &Axis, strips: &[&Strip], members: &[Vec<u32>]) -> Option<Self> {
        let mut radii: Vec<f64> = strips.iter().map(|s| s.radius).collect();
        let radius = stats::median(&mut radii)?;
        let outward = strips.first()?.outward;
        let mut fit = Fit { surface: Surface::Cylinder(Cylinder { axis: *axis, radius }), outward };
        let mut lands = strips.to_vec();
        for _ in 0..ROUNDS {
            if lands.len() < MIN_LANDS {
                return None;
            }
            let samples = lands.iter().fold(Samples::default(), |all, s| {
                all.followed_by(&field.samples(&members[s.region as usize], N_TEST))
            });
            fit = refine(&fit, &samples, &field.weights, STEPS)?;
            lands = strips
                .iter()
                .copied()
                .filter(|s| s.is_on(field, &fit, &members[s.region as usize]))
                .collect();
        }
        let rises_unseen = lands.iter().all(|s| s.rise() < field.weights.distance_sigma);
        let lands: Vec<u32> = lands.iter().map(|s| s.region).collect();
        (lands.len() >= MIN_LANDS && rises_unseen).then_some(Self { fit, lands })
    }

    /// The primitive of each land: the cylinder that all of them show together.
    pub fn primitives(&self, field: &Field, members: &[Vec<u32>]) -> Vec<(u32, Primitive)> {
        let mut all: Vec<u32> =
            self.lands.iter().flat_map(|&k| members[k as usize].iter().copied()).collect();
        all.sort_unstable();
        let together = primitive::fitted(field, &self.fit, &all, |_| None);
        self.lands.iter().map(|&k| (k, together.clone())).collect()
    }
}

/// Finds the lands among the regions; their fits become the cylinders that they share.
pub(super) fn find(field: &Field, regions: &mut Regions) -> Vec<Round> {
    let members = regions.members();
    let mut rounds: Vec<Round> = Vec::new();
    for (axis_of, axis) in axes(field, regions, &members, |kind| kind == SurfaceKind::Cylinder) {
        let about_axis = par::map_indices(members.len(), |k| {
            let is_land = rounds.iter().any(|round| round.lands.contains(&(k as u32)));
            let fit = regions.fits[k].filter(|_| k != axis_of && !is_land)?;
            Strip::about(field, &axis, k as u32, &fit, &members[k])
        });
        let mut strips: Vec<Strip> = about_axis.into_iter().flatten().collect();
        strips.sort_by(|a, b| a.radius.total_cmp(&b.radius).then(a.region.cmp(&b.region)));
        for group in strips.chunk_by(|a, b| b.radius - a.radius < field.spacing) {
            for outward in [true, false] {
                let alike: Vec<&Strip> = group.iter().filter(|s| s.outward == outward).collect();
                let Some(round) = Round::of(field, &axis, &alike, &members) else { continue };
                for &k in &round.lands {
                    regions.fits[k as usize] = Some(round.fit);
                }
                rounds.push(round);
            }
        }
    }
    rounds
}

/// A narrow region that faces some axis or away from it.
#[derive(Debug, Clone, Copy)]
struct Strip {
    region: u32,
    /// Median distance from the axis.
    radius: f64,
    /// Width across the axis.
    width: f64,
    outward: bool,
    own_cost: f64,
}

impl Strip {
    /// `None` where the region is no such strip.
    fn about(field: &Field, axis: &Axis, region: u32, fit: &Fit, members: &[u32]) -> Option<Self> {
        /// Cosine below which a strip does not face the axis: noise turns narrow ones by less.
        const MIN_FACING: f64 = 0.97;
        if !matches!(fit.surface.kind(), SurfaceKind::Plane | SurfaceKind::Cylinder) || members.is_empty() {
            return None;
        }
        let mut radii: Vec<f64> =
            members.iter().map(|&v| axis.radial(&field.points[v as usize]).norm()).collect();
        let radius = stats::median(&mut radii)?;
        let middle = field.points[members[members.len() / 2] as usize];
        let radial = try_unit(axis.radial(&middle))?;
        let facing = fit.distance_and_outward_normal(&middle).1.dot(&radial);
        let across = axis.direction.cross(&radial);
        let offsets = members.iter().map(|&v| (field.points[v as usize] - middle).dot(&across));
        let (low, high) = offsets.fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        let own_cost = mean_cost(fit, &field.samples(members, N_TEST), &field.weights);
        let strip = Self { region, radius, width: high - low, outward: facing > 0.0, own_cost };
        (facing.abs() > MIN_FACING && strip.rise() < 2.0 * field.weights.distance_sigma).then_some(strip)
    }

    /// By which the arc departs from a plane, length.
    fn rise(&self) -> f64 {
        self.width.powi(2) / (8.0 * self.radius)
    }

    /// Whether `fit` describes the region as well as its own surface does.
    fn is_on(&self, field: &Field, fit: &Fit, members: &[u32]) -> bool {
        is_as_good(mean_cost(fit, &field.samples(members, N_TEST), &field.weights), self.own_cost)
    }
}
