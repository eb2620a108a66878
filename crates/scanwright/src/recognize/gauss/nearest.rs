//! The nearest of many directions: a k-d tree.
//!
//! J. L. Bentley, "Multidimensional binary search trees used for associative searching", Communications of the ACM 18
//! (1975), 509-517. A grid on the sphere would hold all normals of a plane in one cell; the tree halves them however
//! they lie, equal ones by their number. Built in O(n log n), asked in O(log n).

use crate::math::Vec3;

/// Directions of a leaf: so few are compared faster than sorted further.
const LEAF: usize = 16;

/// A tree of directions.
pub(super) struct Tree<'a> {
    normals: &'a [Vec3],
    /// Numbers of the normals. The middle of every range divides it: no larger before, no smaller behind.
    order: Vec<u32>,
    /// One per place in `order`: the coordinate by which it divides its range.
    axes: Vec<u8>,
}

impl<'a> Tree<'a> {
    /// A tree of `normals`.
    pub fn new(normals: &'a [Vec3]) -> Self {
        let order = (0..normals.len() as u32).collect();
        let mut tree = Self { normals, order, axes: vec![0; normals.len()] };
        let mut ranges = vec![(0, normals.len())];
        while let Some((from, to)) = ranges.pop() {
            if to - from > LEAF {
                let middle = tree.divide(from, to);
                ranges.extend([(from, middle), (middle + 1, to)]);
            }
        }
        tree
    }

    /// Puts the middle of a range in place, by its longest coordinate.
    fn divide(&mut self, from: usize, to: usize) -> usize {
        let normals = self.normals;
        let range = &mut self.order[from..to];
        let first = normals[range[0] as usize];
        let (low, high) = range
            .iter()
            .map(|&i| normals[i as usize])
            .fold((first, first), |(low, high), n| (low.inf(&n), high.sup(&n)));
        let axis = (high - low).imax();
        let half = range.len() / 2;
        range.select_nth_unstable_by(half, |&a, &b| {
            normals[a as usize][axis].total_cmp(&normals[b as usize][axis]).then(a.cmp(&b))
        });
        self.axes[from + half] = axis as u8;
        from + half
    }

    /// Numbers of the `k` normals nearest to `at` (all, if there are fewer), nearest first.
    pub fn nearest(&self, at: &Vec3, k: usize) -> Vec<u32> {
        let mut found = Vec::with_capacity(k + 1);
        self.search(at, k, 0, self.order.len(), &mut found);
        found.into_iter().map(|(_, i)| i).collect()
    }

    fn search(&self, at: &Vec3, k: usize, from: usize, to: usize, found: &mut Vec<(f64, u32)>) {
        if to - from <= LEAF {
            for &i in &self.order[from..to] {
                self.offer(at, k, i, found);
            }
            return;
        }
        let middle = from + (to - from) / 2;
        let divider = self.order[middle];
        let axis = usize::from(self.axes[middle]);
        let beyond = at[axis] - self.normals[divider as usize][axis];
        let (near, far) = ((from, middle), (middle + 1, to));
        let (near, far) = if beyond < 0.0 { (near, far) } else { (far, near) };
        self.search(at, k, near.0, near.1, found);
        self.offer(at, k, divider, found);
        // Not closer is not needed: of many equal normals any `k` will do.
        if found.len() < k || found.last().is_some_and(|worst| beyond * beyond < worst.0) {
            self.search(at, k, far.0, far.1, found);
        }
    }

    fn offer(&self, at: &Vec3, k: usize, i: u32, found: &mut Vec<(f64, u32)>) {
        let distance_sq = (self.normals[i as usize] - at).norm_squared();
        if found.len() == k && found.last().is_none_or(|worst| distance_sq >= worst.0) {
            return;
        }
        let place = found.partition_point(|other| other.0 <= distance_sq);
        found.insert(place, (distance_sq, i));
        found.truncate(k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;

    #[test]
    fn the_nearest_are_those_of_a_search_through_all() {
        let mut rng = Rng::for_task(1, "nearest", 0);
        let mut direction = || Vec3::new(rng.normal(), rng.normal(), rng.normal()).normalize();
        let mut normals: Vec<Vec3> = (0..500).map(|_| direction()).collect();
        normals.extend(vec![Vec3::z(); 100]);
        let tree = Tree::new(&normals);
        for at in (0..50).map(|_| direction()).chain([Vec3::z()]) {
            let distances = |found: &[u32]| -> Vec<f64> {
                found.iter().map(|&i| (normals[i as usize] - at).norm_squared()).collect()
            };
            let mut all: Vec<f64> = distances(&(0..600).collect::<Vec<u32>>());
            all.sort_by(f64::total_cmp);
            assert_eq!(distances(&tree.nearest(&at, 20)), all[..20]);
        }
        assert_eq!(Tree::new(&normals[..3]).nearest(&Vec3::x(), 20).len(), 3);
        assert!(Tree::new(&[]).nearest(&Vec3::x(), 20).is_empty());
    }
}
