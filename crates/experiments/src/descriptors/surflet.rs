//! Surflet pairs: how oriented points of a surface lie to one another, as a histogram of four numbers per pair.
//!
//! E. Wahl, U. Hillenbrand, G. Hirzinger, "Surflet-pair-relation histograms: a statistical 3D-shape representation for
//! rapid classification", 3-D Digital Imaging and Modeling (2003), 474-481. Four features, five bins each as there.
//! Distances are divided by the largest. Normals are those of the triangles; turned inside out, a model has other
//! surflets, unlike the other descriptors.

use std::f64::consts::PI;

use scanwright::math::{Point3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::random::Rng;

use super::{SEED, Sampler};

/// Surflets that are drawn; all their pairs are taken.
const N_SURFLETS: usize = 500;
/// Bins of each feature.
const N_BINS: usize = 5;

/// Share of the pairs in each of the 625 bins. `None` for a mesh without area.
pub fn surflets(mesh: &Mesh) -> Option<Vec<f64>> {
    let sampler = Sampler::new(mesh)?;
    let normals = mesh.triangle_normals();
    let mut rng = Rng::for_task(SEED, "surflets", 0);
    let drawn: Vec<(Point3, Vec3)> = (0..N_SURFLETS)
        .map(|_| {
            let (triangle, point) = sampler.draw(&mut rng);
            (point, normals[triangle])
        })
        .collect();
    let pairs = (0..N_SURFLETS).flat_map(|i| (0..i).map(move |j| (i, j)));
    let relations: Vec<[f64; 4]> = pairs.filter_map(|(i, j)| relation(drawn[i], drawn[j])).collect();
    let longest = relations.iter().map(|r| r[3]).fold(0.0, f64::max);
    let mut histogram = vec![0.0; N_BINS.pow(4)];
    for [alpha, beta, gamma, delta] in &relations {
        let shares = [0.5 * (alpha / PI + 1.0), 0.5 * (beta + 1.0), 0.5 * (gamma + 1.0), delta / longest];
        let bin = |share: &f64| ((share * N_BINS as f64) as usize).min(N_BINS - 1);
        let place = shares.iter().fold(0, |place, share| place * N_BINS + bin(share));
        histogram[place] += 1.0 / relations.len() as f64;
    }
    Some(histogram)
}

/// In the frame of the first surflet, its normal `u`, `v` across it and the line between both, and `w`: the turn of the
/// second normal about `v`, its cosine with `v`, the line's cosine with `u`, and the distance. The first is the surflet
/// whose normal is more across the line. `None` where the points are the same or the line is along the normal.
fn relation(one: (Point3, Vec3), other: (Point3, Vec3)) -> Option<[f64; 4]> {
    let across = |from: (Point3, Vec3), to: (Point3, Vec3)| from.1.dot(&(to.0 - from.0)).abs();
    let (first, second) = if across(one, other) <= across(other, one) { (one, other) } else { (other, one) };
    let line = second.0 - first.0;
    let distance = line.norm();
    let u = first.1;
    let v = line.cross(&u).try_normalize(0.0)?;
    let w = u.cross(&v);
    let alpha = w.dot(&second.1).atan2(u.dot(&second.1));
    Some([alpha, v.dot(&second.1), u.dot(&line) / distance, distance])
}
