//! Cells of equal area on the unit sphere.
//!
//! Two polar caps and collars between them, every collar cut in equal sectors; the zones' borders lie where the areas come
//! out equal. P. Leopardi, "A partition of the unit sphere into regions of equal area and small diameter", Electronic
//! Transactions on Numerical Analysis 25 (2006), 309-327, section 3.

use std::f64::consts::{PI, TAU};

use crate::math::Vec3;

/// A partition of the unit sphere in cells of equal area, numbered from the pole +z in rings.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// Lower border of each zone as a height, descending; the last is -1.
    floors: Vec<f64>,
    /// One per zone: number of sectors.
    sectors: Vec<usize>,
    /// One per zone: its first cell.
    first: Vec<usize>,
    n: usize,
}

impl Cells {
    /// A partition in `n` cells, at least one.
    pub fn new(n: usize) -> Self {
        let n = n.max(1);
        let sectors = sectors_of_zones(n);
        let mut first = Vec::with_capacity(sectors.len());
        let mut floors = Vec::with_capacity(sectors.len());
        let mut before = 0;
        for count in &sectors {
            first.push(before);
            before += count;
            // A zone's area is proportional to its height.
            floors.push(1.0 - 2.0 * before as f64 / n as f64);
        }
        Self { floors, sectors, first, n }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.n
    }

    /// Never: there is at least one cell.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The cell that a direction points into.
    pub fn of(&self, direction: &Vec3) -> usize {
        let zone = self.floors.partition_point(|floor| direction.z < *floor).min(self.floors.len() - 1);
        let turn = (direction.y.atan2(direction.x) / TAU).rem_euclid(1.0);
        let sector = (turn * self.sectors[zone] as f64) as usize;
        self.first[zone] + sector.min(self.sectors[zone] - 1)
    }
}

/// Number of sectors of every zone, from pole to pole.
fn sectors_of_zones(n: usize) -> Vec<usize> {
    if n <= 2 {
        return vec![1; n];
    }
    // The cap's colatitude, and as many collars as make their cells about square.
    let cap = 2.0 * (1.0 / (n as f64).sqrt()).asin();
    let side = (2.0 * TAU / n as f64).sqrt();
    let n_collars = (((PI - 2.0 * cap) / side).round() as usize).clamp(1, n - 2);
    let width = (PI - 2.0 * cap) / n_collars as f64;
    let mut sectors = vec![1];
    let mut rest = 0.0;
    for k in 0..n_collars {
        let (low, high) = (cap + k as f64 * width, cap + (k + 1) as f64 * width);
        let ideal = 0.5 * n as f64 * (low.cos() - high.cos()) + rest;
        let count = ideal.round().max(1.0);
        rest = ideal - count;
        sectors.push(count as usize);
    }
    sectors.push(1);
    sectors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;

    #[test]
    fn every_cell_has_the_same_area_whatever_their_number() {
        for n in [1, 2, 3, 5, 52, 102, 202, 402, 1000] {
            let cells = Cells::new(n);
            assert_eq!(cells.sectors.iter().sum::<usize>(), n, "cells of {n}");
            let mut top = 1.0;
            for (floor, sectors) in cells.floors.iter().zip(&cells.sectors) {
                let area = TAU * (top - floor) / *sectors as f64;
                assert!((area - 2.0 * TAU / n as f64).abs() < 1e-12, "a cell of {n}: {area}");
                top = *floor;
            }
        }
    }

    #[test]
    fn random_directions_fall_into_all_cells_alike() {
        let (cells, per_cell) = (Cells::new(202), 200);
        let mut counts = vec![0.0; cells.len()];
        let mut rng = Rng::for_task(1, "directions", 0);
        for _ in 0..per_cell * cells.len() {
            let direction = Vec3::new(rng.normal(), rng.normal(), rng.normal()).normalize();
            counts[cells.of(&direction)] += 1.0;
        }
        let chi_sq: f64 = counts.iter().map(|c: &f64| (c - 200.0).powi(2) / 200.0).sum();
        // Chi-square of 201 degrees of freedom: mean 201, deviation 20.
        assert!((chi_sq - 201.0).abs() < 5.0 * 20.0, "chi-square {chi_sq}");
    }

    #[test]
    fn poles_are_in_the_caps() {
        let cells = Cells::new(202);
        assert_eq!((cells.of(&Vec3::z()), cells.of(&-Vec3::z())), (0, 201));
    }
}
