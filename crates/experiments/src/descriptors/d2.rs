//! D2: the distribution of distances between pairs of random points of a surface.
//!
//! R. Osada, T. Funkhouser, B. Chazelle, D. Dobkin, "Shape distributions", ACM Transactions on Graphics 21 (2002),
//! 807-832. Distances are divided by their mean, one of its normalizations. There a million pairs in 1024 bins; here a
//! hundred thousand in 64, as a classifier learns from a thousand models.

use scanwright::mesh::Mesh;
use scanwright::random::Rng;

use super::{SEED, Sampler};

const N_PAIRS: usize = 100_000;
/// Bins of the histogram.
pub const N_BINS: usize = 64;
/// End of the histogram in means: a slender rod, whose distances have a triangular density, reaches it.
pub const REACH: f64 = 3.0;

/// Share of the pairs in each bin of distance; what is beyond the last is in the last. `None` for a mesh without area.
pub fn d2(mesh: &Mesh) -> Option<Vec<f64>> {
    let sampler = Sampler::new(mesh)?;
    let mut rng = Rng::for_task(SEED, "d2", 0);
    let distances: Vec<f64> =
        (0..N_PAIRS).map(|_| (sampler.draw(&mut rng).1 - sampler.draw(&mut rng).1).norm()).collect();
    let mean = distances.iter().sum::<f64>() / N_PAIRS as f64;
    let mut histogram = vec![0.0; N_BINS];
    for distance in distances {
        let bin = (distance / mean / REACH * N_BINS as f64) as usize;
        histogram[bin.min(N_BINS - 1)] += 1.0 / N_PAIRS as f64;
    }
    Some(histogram)
}
