//! Relations between primitives: directions that the scan cannot tell from parallel or perpendicular are made so, axes that
//! it cannot tell from coaxial, planes from coplanar, sizes from equal.
//!
//! A narrow face shows its direction badly and a large one well; where both mean the same direction, the narrow one
//! takes it from the large. `evidence` says how well each primitive's own points show its direction and position,
//! `directions` gathers parallel ones, `lines` those of their axes and of centres that lie on one line, `sizes` planes and
//! sizes, all by `gather`. `angles` finds gatherings at right and other common angles and adjusts all of them together;
//! `patterns` then arranges lines, `meetings` makes them meet, and `enforce` turns and moves each primitive and lets its
//! other parameters follow. `certificates` says of each relation how well it held.
//!
//! A relation is accepted when the scan does not contradict it and when it would rarely be met by accident. The steps
//! are those of F. Langbein, A. Marshall, R. Martin, "Choosing consistent constraints for beautification of reverse
//! engineered geometric models", Computer-Aided Design 36 (2004), 261-278; the tests are ours: every deviation is
//! measured in its own standard uncertainty. No points are fitted again: a primitive is represented by its estimate
//! and its covariance. Cost O(vertices) for the evidence, O(directions^2) and O(lines^2) for the relations.

mod angles;
mod asked;
mod certificates;
mod custom;
mod directions;
mod enforce;
mod evidence;
mod found;
mod gather;
mod gaussian;
mod lines;
mod meetings;
mod patterns;
mod relation;
mod sizes;

pub use relation::{Listed, Manufacture, Relation, RelationKind, Relations};

use crate::fit::Noise;
use crate::math::stats;
use crate::mesh::Mesh;
use crate::par;
use crate::segment::Segmentation;
use crate::tolerance::Tolerances;
use crate::uncertainty::Interior;

use asked::Asked;
use evidence::Evidence;
use found::{Found, Part, Voices};

/// Standard deviations within which a relation is not contradicted: 1.2 % of true ones are lost.
const MAX_SIGMAS: f64 = 2.5;

/// Chi squared of so many degrees of freedom that is exceeded as rarely as [`MAX_SIGMAS`] is by one deviation.
fn max_chi_squared(freedom: usize) -> f64 {
    /// P(|z| > 2.5), and the standard deviations that a normal number exceeds on one side with that probability.
    const RARE: f64 = 0.0124;
    const ONE_SIDED: f64 = 2.244;
    const { assert!(MAX_SIGMAS == 2.5, "RARE and ONE_SIDED belong to 2.5 sigmas") };
    match freedom {
        1 => MAX_SIGMAS * MAX_SIGMAS,
        2 => -2.0 * RARE.ln(),
        n => n as f64 * stats::chi_squared_ratio(n as f64, ONE_SIDED),
    }
}

/// Largest probability that an accepted relation is an accident.
const MAX_ACCIDENT: f64 = 0.05;
/// Share of a pair's variance below which the relations accepted so far decide it.
const DECIDED: f64 = 0.01;
/// Share of its covariance that a line keeps once an arrangement has put it in its place: later ones leave it there.
const PINNED: f64 = 1e-9;

/// Primitives with their relations made exact, and what these are.
#[derive(Debug, Clone)]
pub struct Regularized {
    /// Labels as before; primitives turned, moved and resized.
    pub segmentation: Segmentation,
    /// What was found or asked for, accepted and refused.
    pub relations: Vec<Relation>,
}

/// What relations are looked for, and in what.
#[derive(Debug, Clone)]
pub struct RegularizeOptions {
    /// Which relations are made exact.
    pub relations: Relations,
    /// What real faces deviate by from their design.
    pub manufacture: Manufacture,
    /// Whether sizes and planes are made equal, beside directions and lines.
    pub sizes: bool,
}

/// The segmentation with its relations made exact.
///
/// Labels stay. A primitive that takes part in a relation is turned, moved and resized by less than its uncertainty allows,
/// its other parameters follow, and its covariance is that of the related directions together; all others stay as they
/// are. `interior` is that of the segmentation of `mesh`.
#[must_use]
pub fn regularize(
    mesh: &Mesh,
    interior: &Interior,
    segmentation: &Segmentation,
    noise: &Noise,
    tolerances: &Tolerances,
    options: &RegularizeOptions,
) -> Regularized {
    let asked = match &options.relations {
        Relations::Off => {
            return Regularized { segmentation: segmentation.clone(), relations: Vec::new() };
        }
        Relations::Auto => None,
        Relations::Listed(list) => Some(Asked::new(list, segmentation.primitives.len())),
    };
    let evidence = par::map_indices(segmentation.primitives.len(), |k| {
        let (primitive, vertices) = (&segmentation.primitives[k], &interior.vertices[k]);
        let rounding = interior.rounding(vertices, tolerances);
        Evidence::new(mesh, primitive, vertices, noise, rounding, tolerances)
    });
    let part = Part { mesh, primitives: &segmentation.primitives, evidence, tolerances };
    let mut voices = Voices::new(&part, &options.manufacture, options.sizes);
    // A primitive whose points refuse its relation no longer speaks for it: the others are related without it.
    loop {
        let found = Found::new(&part, &voices, &options.manufacture, asked.as_ref());
        if let Some(primitives) = found.applied(&part, &mut voices) {
            let relations = certificates::of(&part, &found, &voices, &primitives, &options.manufacture);
            let segmentation = Segmentation { primitives, labels: segmentation.labels.clone() };
            return Regularized { segmentation, relations };
        }
    }
}
