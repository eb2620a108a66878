//! Outliers among the normals of one segment.
//!
//! Each normal is compared with the median of those nearest to it on the sphere, a running median; those that are
//! shifted from it by more than a threshold are outliers. The others are not changed.
//! Known of the thesis: the running median over a point cloud, here the normals on the sphere, that a threshold comes out
//! of it, and that what remains is not modified. Reconstructed: number of neighbours, coordinates as what the median is
//! taken of, mean and two deviations as threshold (`Threshold::MeanAndDeviation`).
//! Ours (`Threshold::MedianAndMad`): a threshold that the outliers themselves do not raise, votes by area, and that an
//! outlier must also disagree with the triangles beside it; a floor by how far normals are apart from triangle to
//! triangle, without which the rim of any curved segment would be cut off.
//!
//! The neighbours are a number, not a radius: normals of spheres and tori lie unevenly. Cost O(n log n). It fails where
//! the segment itself fills the sphere, for then every direction has neighbours, and where outliers lie together in
//! numbers of half the neighbours.

use crate::math::{Vec3, stats};
use crate::mesh::{Adjacency, Csr, Mesh, TriId};
use crate::par;

use super::GaussImage;
use super::nearest::Tree;
use super::rules::weighted_quantile;

/// Options of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlierSearch {
    /// How the threshold comes about. Default: by median and MAD.
    pub threshold: Threshold,
    /// Normals, itself among them, whose median a normal is compared with. Default 20.
    pub neighbors: usize,
    /// Share, 0 to 1, of the area (`MeanAndDeviation`: of the normals) above which nothing is an outlier, for the segment
    /// is not one primitive. Default 0.15.
    pub max_share: f64,
}

/// How far from the median is too far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Threshold {
    /// Mean and two standard deviations of the shifts: near to the thesis.
    MeanAndDeviation,
    /// Median and three robust standard deviations (1.4826 median absolute deviations) of the shifts, by area, of the
    /// normal against its neighbours on the sphere and also against those on the mesh.
    #[default]
    MedianAndMad,
}

impl Default for OutlierSearch {
    fn default() -> Self {
        Self { threshold: Threshold::default(), neighbors: 20, max_share: 0.15 }
    }
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct Outliers {
    /// One per normal. None is when the segment is not one primitive.
    pub is_outlier: Vec<bool>,
    /// Shift on the sphere, as length of a difference of unit normals, above which a normal may be an outlier.
    pub threshold: f64,
    /// Share of the area (`MeanAndDeviation`: of the normals) that is shifted by more.
    pub share: f64,
    /// Whether that is little enough for a segment of one primitive.
    pub is_one_primitive: bool,
}

/// Least threshold: differences of unit normals by rounding alone, as on a plane without noise.
const FLOOR: f64 = 1e-6;
/// Least threshold against the neighbours on the mesh, in median differences of normals from triangle to triangle: at the
/// rim of a curved segment the neighbours lie to one side, and their median a step or so away. On the sphere so high a
/// threshold would keep outliers that have a few others near them.
const FLOOR_STEPS: f64 = 2.0;

impl GaussImage {
    /// The image of a whole mesh without its outliers, and what they were: one per triangle with an area.
    pub fn without_outliers(mesh: &Mesh, adjacency: &Adjacency, search: &OutlierSearch) -> (Self, Outliers) {
        let image = Self::of_mesh(mesh);
        let all: Vec<TriId> = (0..mesh.triangles.len() as TriId).collect();
        let outliers = search.run(&image, &rings(mesh, adjacency, &all));
        (image.kept(&outliers), outliers)
    }

    /// Those normals that are no outliers.
    #[must_use]
    pub fn kept(&self, outliers: &Outliers) -> Self {
        let mut kept = Self::default();
        for ((normal, area), is_outlier) in self.normals.iter().zip(&self.areas).zip(&outliers.is_outlier) {
            if !is_outlier {
                kept.normals.push(*normal);
                kept.areas.push(*area);
            }
        }
        kept
    }
}

/// Per normal of the image of `triangles`, which ascend, the normals of those that share a vertex with its own.
pub fn rings(mesh: &Mesh, adjacency: &Adjacency, triangles: &[TriId]) -> Csr {
    // The same test as the image's.
    let has_area = |t: &TriId| mesh.cross(*t as usize).try_normalize(0.0).is_some();
    let with_area: Vec<TriId> = triangles.iter().copied().filter(has_area).collect();
    let ring = |&t: &TriId| {
        let corners = mesh.triangles[t as usize];
        let around = corners.iter().flat_map(|&v| adjacency.vertex_triangles.row(v as usize));
        let others = around.filter(|u| **u != t);
        let mut ring: Vec<u32> =
            others.filter_map(|u| with_area.binary_search(u).ok()).map(|number| number as u32).collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    };
    let rows = par::map(&with_area, ring);
    let pairs = rows.iter().enumerate().flat_map(|(i, row)| row.iter().map(move |u| (i as u32, *u)));
    Csr::from_pairs(rows.len(), pairs)
}

impl OutlierSearch {
    /// Searches an image. `rings`: per normal its neighbours on the mesh, see [`rings`]; only `MedianAndMad` asks them.
    pub fn run(&self, image: &GaussImage, rings: &Csr) -> Outliers {
        let normals = &image.normals;
        let tree = Tree::new(normals);
        let on_sphere = shifts(normals, |i| tree.nearest(&normals[i], self.neighbors.max(1)));
        let (threshold, is_shifted, weights) = match self.threshold {
            Threshold::MeanAndDeviation => {
                let threshold = mean_and_deviation(&on_sphere).max(FLOOR);
                let is_shifted = on_sphere.iter().map(|d| *d > threshold).collect();
                (threshold, is_shifted, vec![1.0; normals.len()])
            }
            Threshold::MedianAndMad => {
                let on_mesh = shifts(normals, |i| rings.row(i).to_vec());
                let threshold = median_and_mad(&on_sphere, &image.areas).max(FLOOR);
                let floor = FLOOR.max(FLOOR_STEPS * median_step(normals, rings));
                let on_mesh_threshold = median_and_mad(&on_mesh, &image.areas).max(floor);
                let both = on_sphere.iter().zip(&on_mesh);
                let is_shifted: Vec<bool> =
                    both.map(|(s, m)| *s > threshold && *m > on_mesh_threshold).collect();
                (threshold, is_shifted, image.areas.clone())
            }
        };
        let of_shifted = weights.iter().zip(&is_shifted).filter(|(_, is)| **is).map(|(w, _)| w);
        let share = of_shifted.sum::<f64>() / weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let is_one_primitive = share <= self.max_share;
        let is_outlier = if is_one_primitive { is_shifted } else { vec![false; normals.len()] };
        Outliers { is_outlier, threshold, share, is_one_primitive }
    }
}

/// Distance of every normal to the median of its neighbours; zero without any.
fn shifts(normals: &[Vec3], neighbors: impl Fn(usize) -> Vec<u32> + Sync + Send) -> Vec<f64> {
    par::map_indices(normals.len(), |i| {
        median_normal(normals, &neighbors(i)).map_or(0.0, |median| (normals[i] - median).norm())
    })
}

/// Median of each coordinate, as a direction.
fn median_normal(normals: &[Vec3], of: &[u32]) -> Option<Vec3> {
    let mut median = Vec3::zeros();
    for axis in 0..3 {
        let mut values: Vec<f64> = of.iter().map(|&i| normals[i as usize][axis]).collect();
        median[axis] = stats::median(&mut values)?;
    }
    median.try_normalize(0.0)
}

/// Median difference of a normal to one beside it on the mesh.
fn median_step(normals: &[Vec3], rings: &Csr) -> f64 {
    let differences = |i: usize| rings.row(i).iter().map(move |&u| (normals[i] - normals[u as usize]).norm());
    let mut steps: Vec<f64> = (0..rings.len().min(normals.len())).flat_map(differences).collect();
    stats::median(&mut steps).unwrap_or(0.0)
}

fn mean_and_deviation(shifts: &[f64]) -> f64 {
    let n = shifts.len().max(1) as f64;
    let mean = shifts.iter().sum::<f64>() / n;
    let variance = shifts.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / n;
    mean + 2.0 * variance.sqrt()
}

fn median_and_mad(shifts: &[f64], areas: &[f64]) -> f64 {
    let total = areas.iter().sum();
    let median_of = |values: Vec<f64>| {
        weighted_quantile(values.into_iter().zip(areas.iter().copied()).collect(), total, 0.5)
    };
    let median = median_of(shifts.to_vec());
    let mad = median_of(shifts.iter().map(|d| (d - median).abs()).collect());
    median + 3.0 * stats::MAD_TO_SIGMA * mad
}
