//! What each relation rests on: how far its members were from it, and what making it exact cost their points.

use super::angles::Deviation;
use super::evidence::{Evidence, turn_to};
use super::found::{Found, Part, Refusal, Voices};
use super::meetings::Meeting;
use super::patterns::Pattern;
use super::relation::{Manufacture, Relation, RelationKind};
use super::sizes::{SizeKind, Sizes};
use crate::math::{Mat3, UnitVec3, angle_between};
use crate::recognize::Primitive;
use crate::surface::Surface;

/// The relations that hold, then those that were refused. `primitives`: as they became.
pub(super) fn of(
    part: &Part,
    found: &Found,
    voices: &Voices,
    primitives: &[Primitive],
    manufacture: &Manufacture,
) -> Vec<Relation> {
    let certify = Certify { part, primitives, manufacture };
    let clusters = &found.angles.clusters;
    let parallel = clusters.iter().filter(|c| c.members.len() > 1);
    let mut relations: Vec<Relation> =
        parallel.map(|c| certify.parallel(&c.members, &c.direction.unit)).collect();
    let best = |deviation: &Deviation| {
        let (a, b) = deviation.pair.clusters;
        (clusters[a].members[0], clusters[b].members[0])
    };
    relations.extend(found.angles.made.iter().map(|made| certify.angle(made, best(made))));
    for line in found.lines.iter().filter(|line| line.is_shared()) {
        let direction = &clusters[line.cluster()].direction;
        relations.push(certify.coaxial(&line.members, &direction.unit));
    }
    relations.extend(found.patterns.iter().map(|pattern| {
        // Each line by the best seen of its members.
        let members: Vec<usize> = pattern.lines.iter().map(|&l| found.lines[l].members[0]).collect();
        let Pattern { kind, z, z_statistical, shift, .. } = *pattern;
        Relation { z, z_statistical, shift, ..certify.cost(kind, &members) }
    }));
    relations.extend(found.meetings.iter().map(|meeting| {
        let members = meeting.lines.map(|l| found.lines[l].members[0]);
        let Meeting { z, shift, .. } = *meeting;
        Relation { z, z_statistical: z, shift, ..certify.cost(RelationKind::Intersecting, &members) }
    }));
    relations.extend(found.sizes.iter().map(|group| certify.sizes(group)));
    relations.extend(found.angles.left.iter().map(|(left, why)| Relation {
        accepted: false,
        reason: Some(why.clone()),
        ..certify.angle(left, best(left))
    }));
    relations.extend(voices.refused.iter().map(|&(k, refusal)| certify.refused(k, refusal)));
    relations
}

struct Certify<'a> {
    part: &'a Part<'a>,
    primitives: &'a [Primitive],
    manufacture: &'a Manufacture,
}

impl Certify<'_> {
    fn evidence(&self, k: usize) -> &Evidence {
        self.part.evidence[k].as_ref().expect("what is related has been seen")
    }

    /// A relation of `members` with what it cost their points, before its deviations are known.
    fn cost(&self, kind: RelationKind, members: &[usize]) -> Relation {
        let rms = |of: &[Primitive]| {
            let of_member = |&k: &usize| of[k].surface.as_ref().map(|surface| self.evidence(k).rms(surface));
            members.iter().filter_map(of_member).fold(0.0, f64::max)
        };
        let mut turn: f64 = 0.0;
        for &k in members {
            let (old, new) = (&self.part.primitives[k].surface, &self.primitives[k].surface);
            if let (Some(old), Some(new)) =
                (old.as_ref().and_then(direction), new.as_ref().and_then(direction))
            {
                turn = turn.max(between(&old, &new));
            }
        }
        Relation {
            kind,
            of: members.iter().map(|&k| k as u32).collect(),
            z: 0.0,
            z_statistical: 0.0,
            turn,
            shift: 0.0,
            angle: None,
            before: rms(self.part.primitives),
            after: rms(self.primitives),
            accepted: true,
            reason: None,
        }
    }

    /// How far the own direction of a primitive is from `unit` in its standard uncertainties, with what manufacture may
    /// deviate by and without.
    fn deviation_of_direction(&self, k: usize, unit: &UnitVec3) -> [f64; 2] {
        [self.manufacture.angle, 0.0].map(|form| {
            let Some(own) = self.evidence(k).direction(form) else { return 0.0 };
            let turn = turn_to(&own.unit, unit);
            let moved = turn.cross(&own.unit);
            let size = moved.norm();
            if size == 0.0 {
                return 0.0;
            }
            let along = moved / size;
            size / along.dot(&(own.covariance * along)).sqrt()
        })
    }

    fn parallel(&self, members: &[usize], unit: &UnitVec3) -> Relation {
        let mut relation = self.cost(RelationKind::Parallel, members);
        for &k in members {
            let [z, statistical] = self.deviation_of_direction(k, unit);
            relation.z = relation.z.max(z);
            relation.z_statistical = relation.z_statistical.max(statistical);
        }
        relation
    }

    fn angle(&self, deviation: &Deviation, (a, b): (usize, usize)) -> Relation {
        let Deviation { pair, size, variance } = deviation;
        let kind = if pair.is_right() { RelationKind::Perpendicular } else { RelationKind::CommonAngle };
        let relation = self.cost(kind, &[a, b]);
        let angle = (!pair.is_right()).then_some(pair.angle);
        let own = [a, b].map(|k| self.evidence(k).direction(0.0));
        let statistical = match own {
            [Some(a), Some(b)] => {
                let (u, v) = (a.unit.into_inner(), b.unit.into_inner());
                (v.dot(&(a.covariance * v)) + u.dot(&(b.covariance * u))) / pair.angle.sin().powi(2)
            }
            _ => *variance,
        };
        Relation { z: size / variance.sqrt(), z_statistical: size / statistical.sqrt(), angle, ..relation }
    }

    /// Where axes and centres are from where they became, at the middle of their points.
    fn coaxial(&self, members: &[usize], unit: &UnitVec3) -> Relation {
        let mut relation = self.cost(RelationKind::Coaxial, members);
        for &k in members {
            let (old, new) = (&self.part.primitives[k].surface, &self.primitives[k].surface);
            let Some((old, new)) = old.as_ref().zip(new.as_ref()) else { continue };
            let Some(position) = self.evidence(k).position(old) else { continue };
            let (point, _) = position.given(unit);
            let moved = place(new, &self.evidence(k).frame.origin) - point;
            let across = moved - unit.into_inner() * unit.dot(&moved);
            let size = across.norm();
            relation.shift = relation.shift.max(size);
            if size == 0.0 {
                continue;
            }
            let along = across / size;
            let form = self.manufacture.angle * position.reach;
            let variance = |covariance: &Mat3| along.dot(&(covariance * along));
            let statistical = variance(&position.covariance);
            relation.z = relation.z.max(size / (statistical + form * form).sqrt());
            relation.z_statistical = relation.z_statistical.max(size / statistical.sqrt());
        }
        relation
    }

    fn sizes(&self, group: &Sizes) -> Relation {
        let kind = match group.members[0].kind {
            SizeKind::Offset { .. } => RelationKind::Coplanar,
            SizeKind::CylinderRadius { .. } | SizeKind::SphereRadius { .. } => RelationKind::EqualRadius,
            SizeKind::HalfAngle => RelationKind::EqualHalfAngle,
            SizeKind::MajorRadius => RelationKind::EqualMajorRadius,
            SizeKind::MinorRadius { .. } => RelationKind::EqualMinorRadius,
        };
        let members: Vec<usize> = group.members.iter().map(|size| size.primitive).collect();
        let mut relation = self.cost(kind, &members);
        for size in &group.members {
            let (z, statistical) = group.deviations(size);
            relation.z = relation.z.max(z);
            relation.z_statistical = relation.z_statistical.max(statistical);
            relation.shift = relation.shift.max((size.value - group.value).abs());
        }
        if !group.is_free() {
            relation.accepted = false;
            relation.reason = Some("equal, and left: faces beside them may be tangent to them".to_owned());
        }
        relation
    }

    /// A primitive whose points did not follow.
    fn refused(&self, k: usize, refusal: Refusal) -> Relation {
        let (kind, what) = match refusal {
            Refusal::Size => (RelationKind::EqualRadius, "its size or plane"),
            Refusal::Line => (RelationKind::Coaxial, "its line"),
            Refusal::Direction => (RelationKind::Parallel, "its direction"),
        };
        let kind = match (&self.part.primitives[k].surface, refusal) {
            (Some(Surface::Plane(_)), Refusal::Size) => RelationKind::Coplanar,
            (Some(Surface::Cone(_)), Refusal::Size) => RelationKind::EqualHalfAngle,
            (Some(Surface::Torus(_)), Refusal::Size) => RelationKind::EqualMinorRadius,
            _ => kind,
        };
        let reason = format!("its points would lie farther off {what} than noise explains");
        Relation { accepted: false, reason: Some(reason), ..self.cost(kind, &[k]) }
    }
}

fn direction(surface: &Surface) -> Option<UnitVec3> {
    super::evidence::direction_of(surface)
}

/// Angle between two lines, radians.
fn between(a: &UnitVec3, b: &UnitVec3) -> f64 {
    angle_between(a, b).min(angle_between(a, &-b.into_inner()))
}

/// The centre of a sphere, or the point of the axis beside `middle`.
fn place(surface: &Surface, middle: &crate::math::Point3) -> crate::math::Point3 {
    match surface {
        Surface::Sphere(sphere) => sphere.center,
        _ => surface.axis().map_or(*middle, |axis| axis.foot(middle)),
    }
}
