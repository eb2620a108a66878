//! Which relations hold among the primitives of a part, and the primitives that they make.

use std::f64::consts::PI;

use super::angles::{self, Angles};
use super::asked::Asked;
use super::directions::{self, Cluster, Direction};
use super::enforce::{self, AskedSize, Target, size_of};
use super::evidence::{Evidence, Position};
use super::gather::{forced, gathered};
use super::lines::{self, Line, PlacedLine};
use super::meetings::{self, Meeting};
use super::patterns::{self, Pattern};
use super::relation::Manufacture;

use super::sizes::{PlacedPlane, Size, SizeKind, Sizes};
use crate::fit::parameter_names;
use crate::math::Mat3;
use crate::mesh::Mesh;
use crate::recognize::{Primitive, arc_seen};
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// Primitives before their relations are made exact.
pub(super) struct Part<'a> {
    pub mesh: &'a Mesh,
    pub primitives: &'a [Primitive],
    /// One per primitive.
    pub evidence: Vec<Option<Evidence>>,
    pub tolerances: &'a Tolerances,
}

/// What each primitive still speaks for: one entry per primitive each.
pub(super) struct Voices {
    directions: Vec<Option<Direction>>,
    positions: Vec<Option<Position>>,
    /// Whether its sizes may be those of others.
    sizes: Vec<bool>,
    /// Whether axes may be arranged and made to meet.
    arranges: bool,
    /// Who refused what, in order.
    pub refused: Vec<(usize, Refusal)>,
}

/// What a primitive's points did not allow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refusal {
    Size,
    Line,
    Direction,
}

impl Voices {
    pub fn new(part: &Part, manufacture: &Manufacture, sizes: bool) -> Self {
        let directions = part.evidence.iter().map(|e| e.as_ref()?.direction(manufacture.angle)).collect();
        let positions = part
            .evidence
            .iter()
            .zip(part.primitives)
            .map(|(e, primitive)| e.as_ref()?.position(primitive.surface.as_ref()?))
            .collect();
        let own = part.evidence.iter().map(|evidence| sizes && evidence.is_some()).collect();
        Self { directions, positions, sizes: own, arranges: sizes, refused: Vec::new() }
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
pub(super) struct Found {
    clusters: Vec<Cluster>,
    pub angles: Angles,
    pub lines: Vec<Line>,
    pub patterns: Vec<Pattern>,
    pub meetings: Vec<Meeting>,
    pub sizes: Vec<Sizes>,
    /// One per primitive.
    targets: Vec<Target>,
}

impl Found {
    pub fn new(part: &Part, voices: &Voices, manufacture: &Manufacture, asked: Option<&Asked>) -> Self {
        let mut clusters = directions::parallel(&voices.directions, asked.map(|a| a.parallel.as_slice()));
        let on_lines = asked.map(|a| a.coaxial.as_slice());
        let lines = lines::coaxial(
            &mut clusters,
            &voices.directions,
            &voices.positions,
            manufacture,
            &part.mesh.vertices,
            on_lines,
        );
        let pairs = asked.map(|a| a.angles_of_clusters(&clusters));
        let angles = angles::related(&clusters, pairs.as_deref());
        let mut targets = vec![Target::default(); part.primitives.len()];
        let related = &angles.clusters;
        for cluster in related.iter().filter(|c| c.is_related()) {
            for &k in &cluster.members {
                targets[k].direction = Some(cluster.direction);
            }
        }
        let directions: Vec<Direction> = related.iter().map(|cluster| cluster.direction).collect();
        let mut placed: Vec<PlacedLine> =
            lines.iter().map(|line| line.placed(&directions[line.cluster()].unit)).collect();
        let arrangements = asked.map(|a| a.patterns.as_slice());
        let patterns = if voices.arranges {
            patterns::arranged(&lines, &directions, &mut placed, part.primitives, manufacture, arrangements)
        } else {
            Vec::new()
        };
        let is_arranged: Vec<bool> =
            (0..lines.len()).map(|l| patterns.iter().any(|pattern| pattern.lines.contains(&l))).collect();
        let pairs = asked.map(|a| a.meetings_of_lines(&lines));
        let meetings = if voices.arranges {
            let extent = part.mesh.diagonal();
            meetings::meetings(&lines, &directions, &mut placed, &is_arranged, extent, pairs.as_deref())
        } else {
            Vec::new()
        };
        for (l, line) in lines.iter().enumerate() {
            let meets = meetings.iter().any(|meeting| meeting.lines.contains(&l));
            if line.is_shared() || is_arranged[l] || meets {
                for &k in &line.members {
                    targets[k].direction = Some(directions[line.cluster()]);
                    targets[k].line = Some(placed[l]);
                }
            }
        }
        let mut found = Self { clusters, angles, lines, patterns, meetings, sizes: Vec::new(), targets };
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
    pub fn applied(&self, part: &Part, voices: &mut Voices) -> Option<Vec<Primitive>> {
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
