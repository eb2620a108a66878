//! Relations between primitives: directions that the scan cannot tell from parallel or perpendicular are made so, axes that
//! it cannot tell from coaxial, planes from coplanar, sizes from equal.
//!
//! A narrow face shows its direction badly and a large one well; where both mean the same direction, the narrow one
//! takes it from the large. `evidence` says how well each primitive's own points show its direction and position,
//! `directions` gathers parallel ones, `lines` those of their axes and of centres that lie on one line, `sizes` planes and
//! sizes, all by `gather`; `relations` finds perpendicular gatherings and adjusts all of them together, `enforce` turns and
//! moves each primitive and lets its other parameters follow. `certificates` says of each relation how well it held.
//!
//! A relation is accepted when the scan does not contradict it and when it would rarely be met by accident. The steps
//! are those of F. Langbein, A. Marshall, R. Martin, "Choosing consistent constraints for beautification of reverse
//! engineered geometric models", Computer-Aided Design 36 (2004), 261-278; the tests are ours: every deviation is
//! measured in its own standard uncertainty. No points are fitted again: a primitive is represented by its estimate
//! and its covariance. Cost O(vertices) for the evidence and O(directions^2) for the relations.

mod asked;
mod certificates;
mod custom;
mod directions;
mod enforce;
mod evidence;
mod gather;
mod lines;
mod relation;
mod relations;
mod sizes;

pub use relation::{Listed, Manufacture, Relation, RelationKind, Relations};

use std::f64::consts::PI;

use crate::fit::{Noise, parameter_names};
use crate::math::Mat3;
use crate::mesh::Mesh;
use crate::par;
use crate::recognize::{Primitive, arc_seen};
use crate::segment::Segmentation;
use crate::surface::Surface;
use crate::tolerance::Tolerances;
use crate::uncertainty::Interior;

use asked::Asked;
use directions::{Cluster, Direction};
use enforce::{AskedSize, Target, size_of};
use evidence::{Evidence, Position};
use gather::{forced, gathered};
use lines::Line;
use relations::Perpendicular;
use sizes::{PlacedPlane, Size, SizeKind, Sizes};

/// Standard deviations within which a relation is not contradicted: 1.2 % of true ones are lost.
const MAX_SIGMAS: f64 = 2.5;
/// Largest probability that an accepted relation is an accident.
const MAX_ACCIDENT: f64 = 0.05;

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
        Evidence::new(mesh, &segmentation.primitives[k], &interior.vertices[k], noise, tolerances)
    });
    let part = Part { mesh, primitives: &segmentation.primitives, evidence, tolerances };
    let mut voices = Voices::new(&part, &options.manufacture, options.sizes);
    // A primitive whose points refuse its relation no longer speaks for it: the others are related without it.
    loop {
        let found = Found::new(&part, &voices, &options.manufacture, asked.as_ref());
        if let Some(primitives) = found.applied(&part, &mut voices) {
            let relations =
                certificates::of(&part, &found, &voices, &primitives, &options.manufacture, asked.as_ref());
            let segmentation = Segmentation { primitives, labels: segmentation.labels.clone() };
            return Regularized { segmentation, relations };
        }
    }
}

/// Primitives before their relations are made exact.
struct Part<'a> {
    mesh: &'a Mesh,
    primitives: &'a [Primitive],
    /// One per primitive.
    evidence: Vec<Option<Evidence>>,
    tolerances: &'a Tolerances,
}

/// What each primitive still speaks for: one entry per primitive each.
struct Voices {
    directions: Vec<Option<Direction>>,
    positions: Vec<Option<Position>>,
    /// Whether its sizes may be those of others.
    sizes: Vec<bool>,
    /// Who refused what, in order.
    refused: Vec<(usize, Refusal)>,
}

/// What a primitive's points did not allow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Refusal {
    Size,
    Line,
    Direction,
}

impl Voices {
    fn new(part: &Part, manufacture: &Manufacture, sizes: bool) -> Self {
        let directions = part.evidence.iter().map(|e| e.as_ref()?.direction(manufacture.angle)).collect();
        let positions = part
            .evidence
            .iter()
            .zip(part.primitives)
            .map(|(e, primitive)| e.as_ref()?.position(primitive.surface.as_ref()?))
            .collect();
        let sizes = part.evidence.iter().map(|evidence| sizes && evidence.is_some()).collect();
        Self { directions, positions, sizes, refused: Vec::new() }
    }

    /// A primitive first leaves its sizes, then its line, and only then its direction.
    fn refuse(&mut self, k: usize, target: &Target) {
        let refusal = if target.plane.is_some() || target.sizes.iter().any(Option::is_some) {
            self.sizes[k] = false;
            Refusal::Size
        } else if target.line.is_some() {
            self.positions[k] = None;
            Refusal::Line
        } else {
            self.directions[k] = None;
            Refusal::Direction
        };
        self.refused.push((k, refusal));
    }
}

/// The relations that hold.
struct Found {
    clusters: Vec<Cluster>,
    perpendicular: Perpendicular,
    lines: Vec<Line>,
    sizes: Vec<Sizes>,
    /// One per primitive.
    targets: Vec<Target>,
}

impl Found {
    fn new(part: &Part, voices: &Voices, manufacture: &Manufacture, asked: Option<&Asked>) -> Self {
        let mut clusters = directions::parallel(&voices.directions, asked.map(|a| a.parallel.as_slice()));
        let on_lines = asked.map(|a| a.coaxial.as_slice());
        let lines =
            lines::coaxial(&mut clusters, &voices.positions, manufacture, &part.mesh.vertices, on_lines);
        let pairs = asked.map(|a| a.perpendicular_clusters(&clusters));
        let perpendicular = relations::related(&clusters, pairs.as_deref());
        let mut targets = vec![Target::default(); part.primitives.len()];
        let related = &perpendicular.clusters;
        for cluster in related.iter().filter(|c| c.is_related()) {
            for &k in &cluster.members {
                targets[k].direction = Some(cluster.direction);
            }
        }
        for line in &lines {
            let direction = related[line.cluster()].direction;
            let placed = line.placed(&direction.unit);
            for &k in &line.members {
                targets[k].direction = Some(direction);
                targets[k].line = Some(placed);
            }
        }
        let mut found = Self { clusters, perpendicular, lines, sizes: Vec::new(), targets };
        found.sizes = found.equal_sizes(part, voices, manufacture, asked);
        found.ask_for_sizes();
        found
    }

    /// Groups of equal sizes, as they are when directions and lines are made exact.
    fn equal_sizes(
        &self,
        part: &Part,
        voices: &Voices,
        manufacture: &Manufacture,
        asked: Option<&Asked>,
    ) -> Vec<Sizes> {
        let mut all: Vec<Size> = (0..part.primitives.len())
            .filter(|&k| voices.sizes[k])
            .flat_map(|k| self.sizes_of(part, k, manufacture).unwrap_or_default())
            .collect();
        // Best seen first; planes of one cluster and sizes of one kind are compared among themselves alone.
        all.sort_by(|a, b| {
            let by_evidence = a.variance.total_cmp(&b.variance);
            a.kind.cmp(&b.kind).then(by_evidence).then(a.primitive.cmp(&b.primitive))
        });
        let groups: Vec<Sizes> = all
            .chunk_by(|a, b| a.kind == b.kind)
            .flat_map(|of_kind| match asked {
                None => gathered(of_kind),
                Some(asked) => forced(of_kind, asked.sizes(of_kind[0].kind), |size: &Size| size.primitive),
            })
            .collect();
        groups.into_iter().filter(|group| group.members.len() > 1).collect()
    }

    /// Sizes of a primitive; `None` when its points do not show them.
    fn sizes_of(&self, part: &Part, k: usize, manufacture: &Manufacture) -> Option<Vec<Size>> {
        /// Unrelated sizes lie within a factor of twenty: of its own size wide on a linear scale.
        const SPREAD: f64 = 3.0;
        let target = &self.targets[k];
        let (primitive, evidence) = (&part.primitives[k], part.evidence[k].as_ref()?);
        let moved = match enforce::related(primitive, evidence, target, part.tolerances) {
            Some(moved) if !target.is_empty() => moved.surface?,
            _ => primitive.surface?,
        };
        let names = parameter_names(&moved);
        let tilts: Vec<usize> = match (evidence.tilt, target.direction) {
            (Some(tilt), Some(_)) => vec![tilt, tilt + 1],
            _ => Vec::new(),
        };
        let on_line = target.line.is_some() && evidence.tilt.is_some();
        let fixed: Vec<usize> = tilts.into_iter().chain(if on_line { 0..2 } else { 0..0 }).collect();
        // More than half a turn is no fillet.
        let arc = arc_seen(&moved, &evidence.samples.points);
        let free = match &moved {
            Surface::Plane(_) | Surface::Cone(_) => true,
            Surface::Cylinder(_) => arc.is_some_and(|arc| arc > PI),
            Surface::Sphere(_) => arc.is_some_and(|arc| arc > 0.5 * PI),
            Surface::Torus(_) => false,
        };
        let size = |parameter: usize, kind: SizeKind, value: f64, range: f64, form: f64| {
            Some(Size {
                primitive: k,
                kind,
                parameter,
                value,
                variance: evidence.variance_given(parameter, &fixed)?,
                form: form * form,
                range,
                at: evidence.frame.origin,
                direction: Mat3::zeros(),
                free,
            })
        };
        if let Surface::Plane(plane) = &moved {
            let cluster = self.clusters.iter().position(|c| c.members.contains(&k))?;
            let direction = target.direction?;
            let value = direction.unit.dot(&plane.point.coords);
            let range = extent(part.mesh, &direction);
            let offset = size(0, SizeKind::Offset { cluster }, value, range, manufacture.length)?;
            return Some(vec![Size { direction: direction.covariance, ..offset }]);
        }
        let outward = primitive.outward;
        let named = names.iter().enumerate().filter_map(|(i, name)| {
            let value = size_of(&moved, name)?;
            let (kind, form) = match (&moved, *name) {
                (Surface::Cylinder(_), _) => (SizeKind::CylinderRadius { outward }, manufacture.length),
                (Surface::Sphere(_), _) => (SizeKind::SphereRadius { outward }, manufacture.length),
                (Surface::Cone(_), _) => (SizeKind::HalfAngle, manufacture.angle),
                (_, "major_radius") => (SizeKind::MajorRadius, manufacture.length),
                _ => (SizeKind::MinorRadius { outward }, manufacture.length),
            };
            size(i, kind, value, SPREAD * value.abs(), form)
        });
        Some(named.collect())
    }

    fn ask_for_sizes(&mut self) {
        for group in self.sizes.iter().filter(|group| group.is_free()) {
            for size in &group.members {
                let target = &mut self.targets[size.primitive];
                if let (SizeKind::Offset { .. }, Some(direction)) = (size.kind, target.direction) {
                    let (offset, variance) = (group.value, group.stated());
                    target.plane =
                        Some(PlacedPlane { normal: direction.unit, offset, variance, at: group.at });
                } else if let Some(free) = target.sizes.iter_mut().find(|size| size.is_none()) {
                    let (value, variance) = (group.value, group.stated());
                    *free = Some(AskedSize { parameter: size.parameter, value, variance });
                }
            }
        }
    }

    /// Primitives after their relations have moved them; `None` when some refuse, which is noted in `voices`.
    fn applied(&self, part: &Part, voices: &mut Voices) -> Option<Vec<Primitive>> {
        let mut primitives = part.primitives.to_vec();
        let n_refused = voices.refused.len();
        for (k, target) in self.targets.iter().enumerate().filter(|(_, target)| !target.is_empty()) {
            let evidence = part.evidence[k].as_ref().expect("what is related has been seen");
            match enforce::related(&part.primitives[k], evidence, target, part.tolerances) {
                Some(primitive) => primitives[k] = primitive,
                None => voices.refuse(k, target),
            }
        }
        (voices.refused.len() == n_refused).then_some(primitives)
    }
}

/// Size of the part along a direction.
fn extent(mesh: &Mesh, direction: &Direction) -> f64 {
    let heights = mesh.vertices.iter().map(|p| direction.unit.dot(&p.coords));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
    high - low
}
