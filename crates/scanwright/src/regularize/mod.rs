//! Relations between primitives: directions that the scan cannot tell from parallel or perpendicular are made so, and
//! axes that it cannot tell from coaxial.
//!
//! A narrow face shows its direction badly and a large one well; where both mean the same direction, the narrow one
//! takes it from the large. `evidence` says how well each primitive's own points show its direction and position,
//! `directions` gathers parallel ones, `lines` those of their axes and of centres that lie on one line, both by `gather`;
//! `relations` finds perpendicular gatherings and adjusts all of them together, `enforce` turns and moves each primitive
//! and lets its other parameters follow.
//!
//! A relation is accepted when the scan does not contradict it and when it would rarely be met by accident. The steps
//! are those of F. Langbein, A. Marshall, R. Martin, "Choosing consistent constraints for beautification of reverse
//! engineered geometric models", Computer-Aided Design 36 (2004), 261-278; the tests are ours: every deviation is
//! measured in its own standard uncertainty. No points are fitted again: a primitive is represented by its estimate
//! and its covariance. Cost O(vertices) for the evidence and O(directions^2) for the relations.

mod custom;
mod directions;
mod enforce;
mod evidence;
mod gather;
mod lines;
mod relations;

use crate::mesh::{Adjacency, Mesh};
use crate::par;
use crate::segment::Segmentation;
use crate::tolerance::Tolerances;

use directions::{Cluster, Direction};
use enforce::Target;
use evidence::{Evidence, Position};
use lines::Line;

/// Standard deviations within which a relation is not contradicted: 1.2 % of true ones are lost.
const MAX_SIGMAS: f64 = 2.5;
/// Largest probability that an accepted relation is an accident.
const MAX_ACCIDENT: f64 = 0.05;

/// The segmentation with parallel and perpendicular directions and coaxial axes made exactly so.
///
/// Labels stay. A primitive that takes part in a relation is turned and moved by less than its uncertainty allows, its
/// other parameters follow, and its covariance is that of the related directions together; all others stay as they are.
/// `mesh` and `adjacency` are those of the segmentation.
#[must_use]
pub fn regularize(
    mesh: &Mesh,
    adjacency: &Adjacency,
    segmentation: &Segmentation,
    tolerances: &Tolerances,
) -> Segmentation {
    let inside = evidence::inner_vertices(mesh, adjacency, segmentation);
    let evidence: Vec<Option<Evidence>> = par::map_indices(segmentation.primitives.len(), |k| {
        Evidence::new(mesh, &segmentation.primitives[k], &inside[k], tolerances)
    });
    let mut directions: Vec<Option<Direction>> =
        evidence.iter().map(|e| e.as_ref()?.direction(tolerances.form_angle())).collect();
    let mut positions: Vec<Option<Position>> = evidence
        .iter()
        .zip(&segmentation.primitives)
        .map(|(e, primitive)| e.as_ref()?.position(primitive.surface.as_ref()?))
        .collect();
    let mut regularized = segmentation.clone();
    // A primitive whose points refuse its relation no longer speaks for it: the others are related without it.
    loop {
        let mut clusters = directions::parallel(&directions);
        let lines = lines::coaxial(&mut clusters, &positions, tolerances.form_angle(), &mesh.vertices);
        let clusters = relations::related(&clusters);
        let targets = targets(segmentation.primitives.len(), &clusters, &lines);
        let refused = apply(&targets, &evidence, segmentation, tolerances, &mut regularized);
        if refused.is_empty() {
            return regularized;
        }
        for k in refused {
            // It first leaves its line, and only then its direction.
            if targets[k].is_some_and(|target| target.line.is_some()) {
                positions[k] = None;
            } else {
                directions[k] = None;
            }
        }
    }
}

/// What relations ask of each of `n` primitives; `None` of those that take part in none.
fn targets(n: usize, clusters: &[Cluster], lines: &[Line]) -> Vec<Option<Target>> {
    let mut targets = vec![None; n];
    for cluster in clusters.iter().filter(|c| c.is_related()) {
        for &k in &cluster.members {
            targets[k] = Some(Target { direction: cluster.direction, line: None });
        }
    }
    for line in lines {
        let direction = clusters[line.cluster()].direction;
        let placed = line.placed(&direction.unit);
        for &k in &line.members {
            targets[k] = Some(Target { direction, line: Some(placed) });
        }
    }
    targets
}

/// Primitives after their relations have moved them; returns those that refuse.
fn apply(
    targets: &[Option<Target>],
    evidence: &[Option<Evidence>],
    segmentation: &Segmentation,
    tolerances: &Tolerances,
    regularized: &mut Segmentation,
) -> Vec<usize> {
    regularized.primitives.clone_from(&segmentation.primitives);
    let mut refused = Vec::new();
    for (k, target) in targets.iter().enumerate() {
        let Some(target) = target else { continue };
        let evidence = evidence[k].as_ref().expect("what is related has been seen");
        match enforce::related(&segmentation.primitives[k], evidence, target, tolerances) {
            Some(primitive) => regularized.primitives[k] = primitive,
            None => refused.push(k),
        }
    }
    refused
}
