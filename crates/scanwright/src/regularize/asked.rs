//! The relations that a user asks for, as sets of primitives.

use super::directions::Cluster;
use super::relation::{Listed, RelationKind};
use super::sizes::SizeKind;

/// Sets of primitives that are to mean the same.
pub(super) struct Asked {
    /// Of one direction: what is on one line or one plane is parallel too.
    pub parallel: Vec<Vec<usize>>,
    /// On one line.
    pub coaxial: Vec<Vec<usize>>,
    perpendicular: Vec<Vec<usize>>,
    coplanar: Vec<Vec<usize>>,
    radii: Vec<Vec<usize>>,
    half_angles: Vec<Vec<usize>>,
    major_radii: Vec<Vec<usize>>,
    minor_radii: Vec<Vec<usize>>,
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
            parallel: of(&[Kind::Parallel, Kind::Coaxial, Kind::Coplanar]),
            coaxial: of(&[Kind::Coaxial]),
            perpendicular: pairs(list, n),
            coplanar: of(&[Kind::Coplanar]),
            radii: of(&[Kind::EqualRadius]),
            half_angles: of(&[Kind::EqualHalfAngle]),
            major_radii: of(&[Kind::EqualMajorRadius]),
            minor_radii: of(&[Kind::EqualMinorRadius]),
        }
    }

    /// Pairs of clusters that hold primitives which are to be perpendicular.
    pub fn perpendicular_clusters(&self, clusters: &[Cluster]) -> Vec<(usize, usize)> {
        let home = |k: usize| clusters.iter().position(|cluster| cluster.members.contains(&k));
        let pair = |set: &Vec<usize>| Some((home(*set.first()?)?, home(*set.get(1)?)?));
        let mut pairs: Vec<(usize, usize)> =
            self.perpendicular.iter().filter_map(pair).map(|(a, b)| (a.min(b), a.max(b))).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
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

/// Every two of each perpendicular relation.
fn pairs(list: &[Listed], n: usize) -> Vec<Vec<usize>> {
    let sets = list.iter().filter(|listed| listed.kind == RelationKind::Perpendicular);
    let pairs_of = |of: &[u32]| -> Vec<Vec<usize>> {
        let of: Vec<usize> = of.iter().map(|&k| k as usize).filter(|&k| k < n).collect();
        (0..of.len())
            .flat_map(|i| (i + 1..of.len()).map(move |j| (i, j)))
            .map(|(i, j)| vec![of[i], of[j]])
            .collect()
    };
    sets.flat_map(|listed| pairs_of(&listed.of)).collect()
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
        let listed = |kind, of: &[u32]| Listed { kind, of: of.to_vec() };
        let list =
            [listed(RelationKind::Coaxial, &[0, 1]), listed(RelationKind::Perpendicular, &[2, 3, 4, 99])];
        let asked = Asked::new(&list, 5);
        assert_eq!(asked.parallel, [vec![0, 1]]);
        assert_eq!(asked.coaxial, [vec![0, 1]]);
        assert_eq!(asked.perpendicular, [vec![2, 3], vec![2, 4], vec![3, 4]]);
    }
}
