//! Clusters of points in a few dimensions: k-means from spread starts.
//!
//! S. Lloyd, "Least squares quantization in PCM", IEEE Transactions on Information Theory 28 (1982), 129-137; starts by
//! D. Arthur and S. Vassilvitskii, "k-means++: the advantages of careful seeding", SODA 2007, 1027-1035.
//!
//! Of many points a sample is clustered, and all join the nearest of its centers: where a center lies does not gain from
//! more points, and the rounds would cost minutes for the vertices of a scan.

use crate::par;
use crate::random::Rng;

/// Starts of which the best is kept.
const N_STARTS: u64 = 10;
/// Most rounds per start.
const MAX_ROUNDS: usize = 100;
/// Points that are clustered at most; some hundred per cluster.
const N_SAMPLE: usize = 16_000;

/// The cluster of every point, below `k`. `points`: rows of equal length; `weights`: one per point.
pub(in crate::segment) fn k_means(points: &[Vec<f64>], weights: &[f64], k: usize, seed: u64) -> Vec<u32> {
    let k = k.min(points.len());
    if k <= 1 {
        return vec![0; points.len()];
    }
    if points.len() <= N_SAMPLE {
        return clustered(points, weights, k, seed).1;
    }
    let mut rng = Rng::for_task(seed, "k-means sample", 0);
    let sample: Vec<usize> = (0..N_SAMPLE).map(|_| rng.below(points.len())).collect();
    let sampled: Vec<Vec<f64>> = sample.iter().map(|&i| points[i].clone()).collect();
    let sample_weights: Vec<f64> = sample.iter().map(|&i| weights[i]).collect();
    let (centers, _) = clustered(&sampled, &sample_weights, k, seed);
    par::map(points, |point| nearest(point, &centers).0)
}

/// The centers of the clusters of all points, and the cluster of every point.
fn clustered(points: &[Vec<f64>], weights: &[f64], k: usize, seed: u64) -> (Vec<Vec<f64>>, Vec<u32>) {
    let starts: Vec<u64> = (0..N_STARTS).collect();
    let runs = par::map(&starts, |&start| {
        let mut rng = Rng::for_task(seed, "k-means", start);
        refine(points, weights, spread(points, weights, k, &mut rng))
    });
    let best = runs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let (_, centers, labels) = best.expect("there is a start");
    (centers, labels)
}

/// First centers: each drawn by its squared distance to those before.
fn spread(points: &[Vec<f64>], weights: &[f64], k: usize, rng: &mut Rng) -> Vec<Vec<f64>> {
    let mut centers = vec![points[rng.below(points.len())].clone()];
    let mut nearest_sq: Vec<f64> = points.iter().map(|p| distance_sq(p, &centers[0])).collect();
    while centers.len() < k {
        let total: f64 = nearest_sq.iter().zip(weights).map(|(d, w)| d * w).sum();
        let mut left = rng.uniform() * total;
        let drawn = nearest_sq.iter().zip(weights).position(|(d, w)| {
            left -= d * w;
            left < 0.0
        });
        let center = points[drawn.unwrap_or(points.len() - 1)].clone();
        for (nearest, point) in nearest_sq.iter_mut().zip(points) {
            *nearest = nearest.min(distance_sq(point, &center));
        }
        centers.push(center);
    }
    centers
}

/// Sum of weighted squared distances, the centers and the clusters, after Lloyd's rounds.
fn refine(
    points: &[Vec<f64>],
    weights: &[f64],
    mut centers: Vec<Vec<f64>>,
) -> (f64, Vec<Vec<f64>>, Vec<u32>) {
    let mut labels = vec![u32::MAX; points.len()];
    let mut cost = f64::INFINITY;
    for _ in 0..MAX_ROUNDS {
        let mut changed = false;
        cost = 0.0;
        for (i, point) in points.iter().enumerate() {
            let (label, off) = nearest(point, &centers);
            changed |= labels[i] != label;
            labels[i] = label;
            cost += weights[i] * off;
        }
        if !changed {
            break;
        }
        let mut sums = vec![vec![0.0; points[0].len()]; centers.len()];
        let mut totals = vec![0.0; centers.len()];
        for ((point, label), weight) in points.iter().zip(&labels).zip(weights) {
            totals[*label as usize] += weight;
            for (sum, x) in sums[*label as usize].iter_mut().zip(point) {
                *sum += weight * x;
            }
        }
        for ((center, sum), total) in centers.iter_mut().zip(sums).zip(totals) {
            if total > 0.0 {
                *center = sum.into_iter().map(|x| x / total).collect();
            }
        }
    }
    (cost, centers, labels)
}

fn nearest(point: &[f64], centers: &[Vec<f64>]) -> (u32, f64) {
    let mut best = (0, f64::INFINITY);
    for (k, center) in centers.iter().enumerate() {
        let off = distance_sq(point, center);
        if off < best.1 {
            best = (k as u32, off);
        }
    }
    best
}

fn distance_sq(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separate_blobs_are_separate_clusters() {
        let mut rng = Rng::for_task(1, "blobs", 0);
        let truth: Vec<usize> = (0..300).map(|i| i % 5).collect();
        let points: Vec<Vec<f64>> = truth
            .iter()
            .map(|&k| vec![10.0 * k as f64 + rng.normal(), 7.0 * (k % 2) as f64 + rng.normal()])
            .collect();
        let labels = k_means(&points, &[1.0; 300], 5, 1);
        for i in 0..300 {
            for j in 0..300 {
                assert_eq!(labels[i] == labels[j], truth[i] == truth[j], "points {i} and {j}");
            }
        }
    }
}
