//! The relations that a user asks for, as sets of primitives.

use std::f64::consts::{FRAC_PI_2, PI};

use super::angles::Pair;
use super::directions::Cluster;
use super::lines::Line;
use super::relation::{Listed, RelationKind};
use super::sizes::SizeKind;

/// Sets of primitives that are to mean the same.
pub(super) struct Asked {
    /// Of one direction: what is on one line or one plane is parallel too.
    pub parallel: Vec<Vec<usize>>,
    /// On one line.
    pub coaxial: Vec<Vec<usize>>,
    /// Two primitives, and the angle between them, radians.
    angles: Vec<([usize; 2], f64)>,
    coplanar: Vec<Vec<usize>>,
    radii: Vec<Vec<usize>>,
    half_angles: Vec<Vec<usize>>,
    major_radii: Vec<Vec<usize>>,
    minor_radii: Vec<Vec<usize>>,
    meetings: Vec<[usize; 2]>,
    /// Axes that are to be arranged, and how.
    pub patterns: Vec<(RelationKind, Vec<usize>)>,
}

impl Asked {
    /// `n`: number of primitives; others are left out.
    pub fn new(list: &[Listed], n: usize) -> Self {
        let of = |kinds: &[RelationKind]| {
            let sets = list.iter().filter(|listed| kinds.contains(&listed.kind));
            let sets = sets.map(|listed| listed.of.iter().map(|&k| k as usize).filter(|&k| k < n).collect());
            merged(sets.collect())
        };
        use RelationKind as Kind;
        Self {
            parallel: of(&[
                Kind::Parallel,
                Kind::Coaxial,
                Kind::Coplanar,
                Kind::CircularPattern,
                Kind::EqualSpacing,
                Kind::RectangularPattern,
            ]),
            coaxial: of(&[Kind::Coaxial]),
            angles: angles(list, n),
            coplanar: of(&[Kind::Coplanar]),
            radii: of(&[Kind::EqualRadius]),
            half_angles: of(&[Kind::EqualHalfAngle]),
            major_radii: of(&[Kind::EqualMajorRadius]),
            minor_radii: of(&[Kind::EqualMinorRadius]),
            meetings: meetings(list, n),
            patterns: patterns(list, n),
        }
    }

    /// Pairs of clusters that hold primitives which are to have an angle.
    pub fn angles_of_clusters(&self, clusters: &[Cluster]) -> Vec<Pair> {
        let home = |k: usize| clusters.iter().position(|cluster| cluster.members.contains(&k));
        let mut pairs: Vec<Pair> = Vec::new();
        for &([a, b], angle) in &self.angles {
            let Some((a, b)) = home(a).zip(home(b)) else { continue };
            let clusters = (a.min(b), a.max(b));
            if pairs.iter().all(|pair| pair.clusters != clusters) {
                pairs.push(Pair { clusters, angle });
            }
        }
        pairs.sort_by_key(|pair| pair.clusters);
        pairs
    }

    /// Pairs of lines that hold primitives which are to meet.
    pub fn meetings_of_lines(&self, lines: &[Line]) -> Vec<[usize; 2]> {
        let home = |k: usize| lines.iter().position(|line| line.members.contains(&k));
        let pair = |&[a, b]: &[usize; 2]| Some([home(a)?, home(b)?]);
        self.meetings.iter().filter_map(pair).filter(|[a, b]| a != b).collect()
    }

    /// The sets of primitives that are to share a size.
    pub fn sizes(&self, kind: SizeKind) -> &[Vec<usize>] {
        match kind {
            SizeKind::Offset { .. } => &self.coplanar,
            SizeKind::CylinderRadius { .. } | SizeKind::SphereRadius { .. } => &self.radii,
            SizeKind::HalfAngle => &self.half_angles,
            SizeKind::MajorRadius => &self.major_radii,
            SizeKind::MinorRadius { .. } => &self.minor_radii,
        }
    }
}

/// Every two of each relation between directions that are not parallel, with their angle: at most a right one.
fn angles(list: &[Listed], n: usize) -> Vec<([usize; 2], f64)> {
    let mut angles = Vec::new();
    for listed in list {
        let angle = match (listed.kind, listed.degrees) {
            (RelationKind::Perpendicular, _) => FRAC_PI_2,
            (RelationKind::CommonAngle, Some(degrees)) => {
                let angle = degrees.to_radians().rem_euclid(PI);
                angle.min(PI - angle)
            }
            _ => continue,
        };
        angles.extend(every_two(listed, n).into_iter().map(|pair| (pair, angle)));
    }
    angles
}

/// Every two axes that are to meet.
fn meetings(list: &[Listed], n: usize) -> Vec<[usize; 2]> {
    let sets = list.iter().filter(|listed| listed.kind == RelationKind::Intersecting);
    sets.flat_map(|listed| every_two(listed, n)).collect()
}

fn every_two(listed: &Listed, n: usize) -> Vec<[usize; 2]> {
    let of: Vec<usize> = listed.of.iter().map(|&k| k as usize).filter(|&k| k < n).collect();
    of.iter().enumerate().flat_map(|(i, &a)| of[i + 1..].iter().map(move |&b| [a, b])).collect()
}

/// Axes that are to be arranged, and how.
fn patterns(list: &[Listed], n: usize) -> Vec<(RelationKind, Vec<usize>)> {
    use RelationKind::{CircularPattern, EqualSpacing, RectangularPattern};
    list.iter()
        .filter(|listed| matches!(listed.kind, CircularPattern | EqualSpacing | RectangularPattern))
        .map(|listed| (listed.kind, listed.of.iter().map(|&k| k as usize).filter(|&k| k < n).collect()))
        .collect()
}

/// Sets that share a member made one.
fn merged(sets: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    let mut apart: Vec<Vec<usize>> = Vec::new();
    for mut set in sets {
        // All that touch the new one become part of it.
        let (touching, others): (Vec<_>, Vec<_>) =
            apart.into_iter().partition(|other: &Vec<usize>| other.iter().any(|k| set.contains(k)));
        set.extend(touching.into_iter().flatten());
        set.sort_unstable();
        set.dedup();
        apart = others;
        apart.push(set);
    }
    apart
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_that_share_a_member_are_one() {
        let sets = merged(vec![vec![1, 2], vec![5, 6], vec![2, 3], vec![6, 1]]);
        assert_eq!(sets, [vec![1, 2, 3, 5, 6]]);
        assert_eq!(merged(vec![vec![1, 2], vec![3, 4]]), [vec![1, 2], vec![3, 4]]);
    }

    #[test]
    fn what_is_coaxial_is_parallel_and_every_two_of_three_are_perpendicular() {
        let listed = |kind, of: &[u32]| Listed { kind, of: of.to_vec(), degrees: None };
        let list =
            [listed(RelationKind::Coaxial, &[0, 1]), listed(RelationKind::Perpendicular, &[2, 3, 4, 99])];
        let asked = Asked::new(&list, 5);
        assert_eq!(asked.parallel, [vec![0, 1]]);
        assert_eq!(asked.coaxial, [vec![0, 1]]);
        let pairs: Vec<[usize; 2]> = asked.angles.iter().map(|(pair, _)| *pair).collect();
        assert_eq!(pairs, [[2, 3], [2, 4], [3, 4]]);
    }
}
