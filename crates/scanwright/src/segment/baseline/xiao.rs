//! Peaks of the Gauss map, then modes of the mean curvature.
//!
//! D. Xiao, H. Lin, C. Xian, S. Gao, "CAD mesh model segmentation by clustering", Computers & Graphics 35 (2011), 685-691.
//! Known of it, by its abstract: agglomerative clustering parts triangles into sparse and dense ones; the sparse are segmented by
//! the Gauss map and a Hough transform into planar, cylindrical and conical regions, the dense by mean shift of their mean
//! curvature. By the thesis it is weak where densities mix.
//!
//! Reconstructed, as the paper was not at hand: all thresholds; two means of the areas' logarithms for the parting; planes as spots
//! of the Gauss map that stand alone; cylinders and cones together as circles on it, found by a randomized Hough transform, which
//! the paper cites (L. Xu, E. Oja, P. Kultanen, "A new curve detection method: randomized Hough transform", Pattern Recognition
//! Letters 11 (1990), 331-338); mean shift with a flat kernel in one dimension (D. Comaniciu, P. Meer, "Mean shift: a robust
//! approach toward feature space analysis", IEEE Transactions on Pattern Analysis and Machine Intelligence 24 (2002), 603-619).
//! Ours: patches for triangles; a spot takes in what a filter smeared beside it; what is on no spot and no circle goes to the mean
//! shift, as scans have one density, all sparse. The number of regions is found, not asked for.
//!
//! Cost: a look at all patches per peak, of which there are [`MOST_PEAKS`] at most.

use crate::math::{Point3, UnitVec3, Vec3, centroid, principal_axes, try_unit};
use crate::mesh::Csr;
use crate::random::Rng;
use crate::recognize::gauss::Cells;
use crate::segment::spectral::cluster::k_means;
use crate::segment::spectral::patches::{Patch, Patches};
use crate::segment::spectral::regions::best_described;
use crate::segment::{Scan, Segmentation};

/// Most patches.
const MOST_PATCHES: usize = 15_000;
/// Mean area of sparse triangles over that of dense ones, below which all have one density.
const DENSITIES: f64 = 4.0;
/// Angle within which normals are those of one spot or circle, radians, beside their noise: 4 degrees.
const ANGLE: f64 = 0.07;
/// How much farther from a spot those may be that touch it: a filter smears edges.
const SMEARED: f64 = 3.0;
/// Turn of the normal across a patch above which it is not flat, radians, beside the noise.
const FLAT: f64 = 0.15;
/// Cells of the Gauss map for spots, and of axes for circles: about 4 and 6 degrees wide.
const SPOT_CELLS: usize = 2_000;
const AXIS_CELLS: usize = 1_000;
/// Steps of a circle's offset between 0 and 1.
const OFFSET_CELLS: usize = 16;
/// Votes for circles per patch.
const VOTES: usize = 12;
/// Least share of all area in a peak.
const LEAST_SHARE: f64 = 0.003;
/// Most spots, and most circles.
const MOST_PEAKS: usize = 100;
/// Width of the mean shift's kernel: turn of the mean normal across a patch of median size, radians.
const KERNEL: f64 = 0.1;

/// Segments a scan. `seed`: of the patches and the votes.
pub(in crate::segment) fn run(scan: &Scan, seed: u64) -> Segmentation {
    let patches = Patches::of(scan, MOST_PATCHES, seed);
    let mut map = GaussMap::of(&patches, scan.normal_noise);
    map.find_spots();
    map.find_circles(seed);
    let mut group_of = map.group_of;
    let first = group_of.iter().flatten().max().map_or(0, |last| last + 1);
    let rest: Vec<usize> = (0..group_of.len()).filter(|&k| group_of[k].is_none()).collect();
    for (&k, mode) in rest.iter().zip(modes(&mean_turns(&patches.all, &rest), KERNEL)) {
        group_of[k] = Some(first + mode);
    }
    let groups: Vec<u32> = group_of.into_iter().flatten().collect();
    // One number of groups, that which was found.
    best_described(scan, &[groups.len()], |_| patches.of_triangles(&groups))
}

/// Whether each patch is of sparse triangles.
fn sparse(patches: &[Patch]) -> Vec<bool> {
    let logs: Vec<Vec<f64>> = patches
        .iter()
        .map(|p| vec![(p.area / p.n_triangles.max(1) as f64).max(f64::MIN_POSITIVE).ln()])
        .collect();
    let areas: Vec<f64> = patches.iter().map(|p| p.area).collect();
    let class = k_means(&logs, &areas, 2, 1);
    let mean = |wanted: u32| {
        let of_class = logs.iter().zip(&class).filter(|(_, c)| **c == wanted).map(|(log, _)| log[0]);
        let (sum, n) = of_class.fold((0.0, 0.0), |(sum, n), log| (sum + log, n + 1.0));
        sum / f64::max(n, 1.0)
    };
    let means = [mean(0), mean(1)];
    let is_one = (means[0] - means[1]).abs() < DENSITIES.ln() || class.iter().all(|c| *c == class[0]);
    class.iter().map(|&c| is_one || means[c as usize] == means[0].max(means[1])).collect()
}

/// The normals of the patches of sparse triangles, and the peaks they were given to.
struct GaussMap<'a> {
    patches: &'a [Patch],
    beside: Csr,
    /// One per patch.
    group_of: Vec<Option<u32>>,
    is_sparse: Vec<bool>,
    /// Angle within which normals are of one peak, radians.
    angle: f64,
    least_area: f64,
    n_groups: u32,
}

impl<'a> GaussMap<'a> {
    fn of(patches: &'a Patches, normal_noise: f64) -> Self {
        let n = patches.all.len();
        let both_ways =
            patches.borders.iter().flat_map(|b| [(b.between[0], b.between[1]), (b.between[1], b.between[0])]);
        let total: f64 = patches.all.iter().map(|p| p.area).sum();
        let triangles = patches.patch_of.len() as f64 / n.max(1) as f64;
        Self {
            patches: &patches.all,
            beside: Csr::from_pairs(n, both_ways),
            group_of: vec![None; n],
            is_sparse: sparse(&patches.all),
            angle: ANGLE.max(3.0 * normal_noise / triangles.max(1.0).sqrt()),
            least_area: LEAST_SHARE * total,
            n_groups: 0,
        }
    }

    fn normal(&self, k: usize) -> Vec3 {
        self.patches[k].frame.z.into_inner()
    }

    /// Patches that have no peak yet.
    fn open(&self) -> Vec<usize> {
        (0..self.patches.len()).filter(|&k| self.is_sparse[k] && self.group_of[k].is_none()).collect()
    }

    fn area(&self, members: &[usize]) -> f64 {
        members.iter().map(|&k| self.patches[k].area).sum()
    }

    /// Gives the patches a group of their own.
    fn take(&mut self, members: &[usize]) {
        for &k in members {
            self.group_of[k] = Some(self.n_groups);
        }
        self.n_groups += 1;
    }

    /// Planes: spots that flat patches make, largest first.
    fn find_spots(&mut self) {
        let cells = Cells::new(SPOT_CELLS);
        let mut barred = vec![false; cells.len()];
        for _ in 0..MOST_PEAKS {
            let open: Vec<usize> = self.open().into_iter().filter(|&k| self.is_flat(k)).collect();
            let mut votes = vec![0.0; cells.len()];
            for &k in &open {
                votes[cells.of(&self.normal(k))] += self.patches[k].area;
            }
            let Some(cell) = highest(&votes, &barred) else { break };
            barred[cell] = true;
            let mut members: Vec<usize> =
                open.iter().copied().filter(|&k| cells.of(&self.normal(k)) == cell).collect();
            for _ in 0..3 {
                let Some(center) =
                    try_unit(members.iter().map(|&k| self.normal(k) * self.patches[k].area).sum())
                else {
                    break;
                };
                members.clear();
                members.extend(open.iter().copied().filter(|&k| self.is_near(k, &center, self.angle)));
            }
            if self.area(&members) < self.least_area {
                continue;
            }
            if self.stands_alone(&open, &members) {
                self.take(&members);
                self.widen(&members);
            }
        }
    }

    /// Adds to the spot of `members` what touches it and turns from it by no more than a filter smears an edge.
    fn widen(&mut self, members: &[usize]) {
        let group = self.group_of[members[0]];
        let Some(center) = try_unit(members.iter().map(|&k| self.normal(k) * self.patches[k].area).sum())
        else {
            return;
        };
        let mut front = members.to_vec();
        while let Some(at) = front.pop() {
            for &next in self.beside.row(at) {
                let next = next as usize;
                if self.is_sparse[next]
                    && self.group_of[next].is_none()
                    && self.is_near(next, &center, SMEARED * self.angle)
                {
                    self.group_of[next] = group;
                    front.push(next);
                }
            }
        }
    }

    fn is_flat(&self, k: usize) -> bool {
        let patch = &self.patches[k];
        let bend = patch.curvatures.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
        bend * patch.area.sqrt() < FLAT.max(2.0 * self.angle)
    }

    fn is_near(&self, k: usize, center: &UnitVec3, angle: f64) -> bool {
        (self.normal(k) - center.into_inner()).norm() < angle
    }

    /// Whether a spot is no piece of a circle: there the ring around it, twice as wide, holds twice as much.
    fn stands_alone(&self, open: &[usize], members: &[usize]) -> bool {
        let sum = members.iter().map(|&k| self.normal(k) * self.patches[k].area).sum();
        let Some(center) = try_unit(sum) else { return false };
        let wide: Vec<usize> =
            open.iter().copied().filter(|&k| self.is_near(k, &center, 3.0 * self.angle)).collect();
        self.area(&wide) < 2.0 * self.area(members)
    }

    /// Cylinders and cones: circles that the other patches make, largest first.
    fn find_circles(&mut self, seed: u64) {
        let cells = Cells::new(AXIS_CELLS);
        for round in 0..MOST_PEAKS as u64 {
            let open = self.open();
            let mut rng = Rng::for_task(seed, "circles", round);
            let mut votes = vec![0.0; cells.len() * OFFSET_CELLS];
            let mut axes = vec![Vec3::zeros(); votes.len()];
            for _ in 0..VOTES * open.len() {
                let Some((axis, offset)) = self.circle_through_three(open[rng.below(open.len())], &mut rng)
                else {
                    continue;
                };
                let step = ((offset * OFFSET_CELLS as f64) as usize).min(OFFSET_CELLS - 1);
                let slot = cells.of(&axis) * OFFSET_CELLS + step;
                votes[slot] += 1.0;
                axes[slot] += axis.into_inner();
            }
            let Some(slot) = highest(&votes, &vec![false; votes.len()]) else { break };
            let Some(axis) = try_unit(axes[slot]) else { break };
            let offset = ((slot % OFFSET_CELLS) as f64 + 0.5) / OFFSET_CELLS as f64;
            let members = self.on_circle(&open, axis, offset);
            if members.is_empty() || self.area(&members) < self.least_area {
                break;
            }
            self.take(&members);
        }
    }

    /// The axis of the circle through the normals of a patch and of two that are a few steps away, and how high the circle
    /// lies along it, not below 0; none where they are nearly one direction.
    fn circle_through_three(&self, start: usize, rng: &mut Rng) -> Option<(UnitVec3, f64)> {
        /// Steps over neighbours from one to the next.
        const STEPS: usize = 4;
        let mut at = start;
        let normals = [0; 3].map(|_| {
            let normal = self.normal(at);
            for _ in 0..STEPS {
                let beside = self.beside.row(at);
                if beside.is_empty() {
                    break;
                }
                let next = beside[rng.below(beside.len())] as usize;
                if self.is_sparse[next] && self.group_of[next].is_none() {
                    at = next;
                }
            }
            normal
        });
        let across = (normals[1] - normals[0]).cross(&(normals[2] - normals[0]));
        // Twice the area of their triangle, with sides that noise alone does not make.
        let axis = try_unit(across).filter(|_| across.norm() > self.angle * self.angle)?;
        let offset = axis.dot(&normals[0]);
        // The two axes of a great circle are one: that with the first coordinate positive.
        let great = offset.abs() < 1.0 / OFFSET_CELLS as f64;
        let flips =
            if great { axis.iter().find(|x| x.abs() > 0.1).is_some_and(|x| *x < 0.0) } else { offset < 0.0 };
        Some(if flips { (-axis, offset.abs()) } else { (axis, offset.abs()) })
    }

    /// The open patches whose normals lie on a circle near the one given, after it was fitted to them.
    fn on_circle(&self, open: &[usize], mut axis: UnitVec3, mut offset: f64) -> Vec<usize> {
        let mut within = 2.0 * self.angle;
        let mut members = Vec::new();
        for _ in 0..4 {
            members = open
                .iter()
                .copied()
                .filter(|&k| (self.normal(k).dot(&axis) - offset).abs() < within)
                .collect();
            let tips: Vec<Point3> = members.iter().map(|&k| Point3::from(self.normal(k))).collect();
            let middle = centroid(&tips);
            axis = principal_axes(&tips, middle)[0].1;
            offset = axis.dot(&middle.coords);
            within = self.angle;
        }
        members
    }
}

/// The place of the most votes, the first of equal ones; none when there are no votes. Places that are `barred` have none.
fn highest(votes: &[f64], barred: &[bool]) -> Option<usize> {
    let open = (0..votes.len()).filter(|&k| !barred[k] && votes[k] > 0.0);
    open.max_by(|&a, &b| votes[a].total_cmp(&votes[b]).then(b.cmp(&a)))
}

/// Mean curvature of the patches `of`, as the turn of the mean normal across a patch of median size, radians.
fn mean_turns(patches: &[Patch], of: &[usize]) -> Vec<f64> {
    let mut sizes: Vec<f64> = of.iter().map(|&k| patches[k].area.sqrt()).collect();
    let size = crate::math::stats::median(&mut sizes).unwrap_or(0.0);
    of.iter().map(|&k| 0.5 * (patches[k].curvatures[0] + patches[k].curvatures[1]) * size).collect()
}

/// The mode that mean shift with a flat kernel of half width `kernel` leads each value to, numbered upwards.
fn modes(values: &[f64], kernel: f64) -> Vec<u32> {
    const MAX_ROUNDS: usize = 100;
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mut sums = vec![0.0];
    for value in &sorted {
        sums.push(sums[sums.len() - 1] + value);
    }
    let shifted = |value: f64| {
        let from = sorted.partition_point(|x| *x < value - kernel);
        let to = sorted.partition_point(|x| *x <= value + kernel);
        (sums[to] - sums[from]) / (to - from).max(1) as f64
    };
    let end = |mut value: f64| {
        for _ in 0..MAX_ROUNDS {
            let next = shifted(value);
            if (next - value).abs() < 1e-3 * kernel {
                break;
            }
            value = next;
        }
        value
    };
    let ends: Vec<f64> = values.iter().map(|value| end(*value)).collect();
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| ends[a].total_cmp(&ends[b]).then(a.cmp(&b)));
    let mut mode_of = vec![0; values.len()];
    let mut mode = 0;
    for pair in order.windows(2) {
        // Ends of one mode differ by where their rounds stopped.
        if ends[pair[1]] - ends[pair[0]] > 0.5 * kernel {
            mode += 1;
        }
        mode_of[pair[1]] = mode;
    }
    mode_of
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_shift_finds_two_crowds_and_no_third() {
        let mut rng = Rng::for_task(1, "crowds", 0);
        let values: Vec<f64> = (0..200).map(|i| f64::from(i % 2) + 0.02 * rng.normal()).collect();
        let modes = modes(&values, 0.1);
        assert!(modes.iter().enumerate().all(|(i, mode)| *mode == i as u32 % 2), "{modes:?}");
    }
}
