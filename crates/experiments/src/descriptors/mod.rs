//! Descriptors of shape that the thesis compares its own with: D2, the Laplacian spectrum and surflet pairs.
//!
//! Known of the thesis: that D2 and others stand beside Gsh+s in figures 3.19 and 3.20, and D2 on partial models. Sizes of
//! samples and histograms are those of the sources or ours, said in each file. All are numbers for the classifier, not
//! distances as in the sources, so that what is compared is what the descriptors hold.

mod d2;
mod spectrum;
mod surflet;

pub use d2::{N_BINS as D2_BINS, REACH as D2_REACH, d2};
pub use spectrum::spectrum;
pub use surflet::surflets;

use scanwright::math::Point3;
use scanwright::mesh::Mesh;
use scanwright::random::Rng;

/// Seed of all draws: a descriptor is a function of its mesh.
const SEED: u64 = 2015;

/// Draws points evenly from a surface.
struct Sampler<'a> {
    mesh: &'a Mesh,
    /// One per triangle: area up to its end.
    area_to: Vec<f64>,
}

impl<'a> Sampler<'a> {
    /// `None` for a mesh without area.
    fn new(mesh: &'a Mesh) -> Option<Self> {
        let mut area = 0.0;
        let area_to: Vec<f64> = (0..mesh.triangles.len())
            .map(|t| {
                area += mesh.area(t);
                area
            })
            .collect();
        (area > 0.0).then_some(Self { mesh, area_to })
    }

    /// A point, and the triangle it lies on. Within the triangle: Osada and others (2002), equation 1.
    fn draw(&self, rng: &mut Rng) -> (usize, Point3) {
        let last = self.area_to.len() - 1;
        let at = rng.uniform() * self.area_to[last];
        let triangle = self.area_to.partition_point(|area| *area <= at).min(last);
        let [a, b, c] = self.mesh.corners(triangle);
        let (r1, r2) = (rng.uniform().sqrt(), rng.uniform());
        (triangle, a + (b - a) * (r1 * (1.0 - r2)) + (c - a) * (r1 * r2))
    }
}

#[cfg(test)]
mod tests {
    use scanwright::gprimdb::{Class, Triangulation};
    use scanwright::mesh::Mesh;

    use super::*;
    use crate::models::{all, faithful, of_class};

    fn mesh(class: Class) -> Mesh {
        let manifest = of_class(&faithful(false, Triangulation::Isotropic, 32), class, 1);
        all(&manifest).swap_remove(0).mesh
    }

    /// Turned by a quarter, moved, and thrice as large.
    fn moved(mesh: &Mesh) -> Mesh {
        let place = |p: &Point3| Point3::new(7.0 - 3.0 * p.y, 3.0 * p.x, 3.0 * p.z - 1.0);
        Mesh { vertices: mesh.vertices.iter().map(place).collect(), ..mesh.clone() }
    }

    #[test]
    fn descriptors_do_not_change_when_a_model_is_moved_and_scaled() {
        for class in Class::PRIMITIVES {
            let (here, there) = (mesh(class), moved(&mesh(class)));
            for (name, of) in
                [("D2", d2 as fn(&Mesh) -> Option<Vec<f64>>), ("spectrum", spectrum), ("surflets", surflets)]
            {
                let (a, b) = (of(&here).expect("it has an area"), of(&there).expect("it has an area"));
                let largest = a.iter().copied().fold(0.0, f64::max);
                let off = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                // Rounding moves a few of the many draws to the next bin: flat models have surflets at a bin's border.
                assert!(off <= 0.05 * largest, "{name} of a {}: {off} of {largest}", class.name());
            }
        }
    }

    #[test]
    fn distances_on_a_sphere_grow_linearly_up_to_its_diameter() {
        let histogram = d2(&mesh(Class::Sphere)).expect("it has an area");
        // The density of chords is linear up to the diameter, which is 1.5 times their mean: half of the bins.
        let half = histogram.len() / 2;
        for (k, share) in histogram.iter().enumerate().take(half - 1) {
            let expected = (2 * k + 1) as f64 / (half * half) as f64;
            assert!((share - expected).abs() < 3e-3, "bin {k}: {share}, not {expected}");
        }
        assert!(histogram[half + 1..].iter().all(|share| *share == 0.0), "{histogram:?}");
    }

    #[test]
    fn eigenvalues_of_a_sphere_are_those_of_theory() {
        let values = spectrum(&mesh(Class::Sphere)).expect("it has an area");
        let degrees = (1..).flat_map(|l| std::iter::repeat_n(l, 2 * l + 1));
        for (value, l) in values.iter().zip(degrees) {
            let expected = 4.0 * std::f64::consts::PI * (l * (l + 1)) as f64;
            assert!((value / expected - 1.0).abs() < 0.03, "degree {l}: {value}, not {expected}");
        }
    }

    #[test]
    fn all_surflets_of_a_plane_agree_in_their_angles() {
        let histogram = surflets(&mesh(Class::Plane)).expect("it has an area");
        assert!((histogram.iter().sum::<f64>() - 1.0).abs() < 1e-9, "shares of one");
        let n_used = histogram.iter().filter(|share| **share > 0.02).count();
        assert!(n_used <= 5, "only distances differ, not {n_used} bins");
    }
}
