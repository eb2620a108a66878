//! Merging vertices that are one point of the scan.
//!
//! A hash grid of cells four tolerances wide finds, for each vertex in order, the lowest earlier vertex within the
//! tolerance; a vertex that finds none represents itself. Representatives are farther than the tolerance from each
//! other, so merging never chains along a row of close vertices.
//!
//! Cost O(n): a cell holds at most about a hundred representatives whatever the input.

use crate::math::Point3;
use crate::mesh::{Mesh, VertId};
use crate::tolerance::Tolerances;

/// Two coordinates rounded on their own lie up to two half roundings apart, on three axes.
const ROUNDINGS: f64 = 2.0;
/// Text files with seven digits differ by this share of the diagonal; method.md 1 asks for the same.
const PER_DIAGONAL: f64 = 1e-6;
/// Detail is never welded away: a hundredth of an edge is below anything that a triangle can show.
const PER_MEDIAN_EDGE: f64 = 0.01;
/// Cells per tolerance: wide enough that most vertices look into few cells, narrow enough to hold few vertices.
const TOLERANCES_PER_CELL: f64 = 4.0;
/// Triangles looked at for the median edge; its relative error from so many is about one percent.
const MEDIAN_SAMPLE: usize = 30_000;

const NONE: u32 = u32::MAX;

/// Which vertices are one.
#[derive(Debug)]
pub(super) struct Welding {
    /// Per vertex, the vertex that it becomes: itself or a lower one.
    pub representative: Vec<VertId>,
    /// Distance within which vertices were merged.
    pub tolerance: f64,
}

/// Finds the vertices of `mesh` to merge.
pub(super) fn weld(mesh: &Mesh) -> Welding {
    let tolerance = tolerance(mesh);
    let mut grid = Grid::new(mesh.vertices.len(), tolerance);
    let vertices = mesh.vertices.iter().enumerate();
    let representative = vertices.map(|(v, point)| grid.find_or_insert(v as VertId, point)).collect();
    Welding { representative, tolerance }
}

fn tolerance(mesh: &Mesh) -> f64 {
    let largest = mesh.largest_coordinate();
    let wanted = (ROUNDINGS * Tolerances::REL_ROUNDING * largest).max(PER_DIAGONAL * mesh.diagonal());
    let allowed = median_edge(mesh).map_or(0.0, |edge| PER_MEDIAN_EDGE * edge);
    // What f64 cannot tell apart is one whatever the edges.
    wanted.min(allowed).max(f64::EPSILON * largest).max(f64::MIN_POSITIVE)
}

/// Median length of the edges that have one, from an even sample of the triangles.
pub(super) fn median_edge(mesh: &Mesh) -> Option<f64> {
    let step = mesh.triangles.len().div_ceil(MEDIAN_SAMPLE).max(1);
    let mut lengths_sq: Vec<f64> = (0..mesh.triangles.len())
        .step_by(step)
        .flat_map(|t| {
            let [a, b, c] = mesh.corners(t);
            [(b - a).norm_squared(), (c - b).norm_squared(), (a - c).norm_squared()]
        })
        .filter(|length_sq| 0.0 < *length_sq)
        .collect();
    if lengths_sq.is_empty() {
        return None;
    }
    let middle = lengths_sq.len() / 2;
    let (_, median, _) = lengths_sq.select_nth_unstable_by(middle, f64::total_cmp);
    Some(median.sqrt())
}

/// Chained hash table of representatives by cell.
struct Grid {
    tolerance: f64,
    cells_per_length: f64,
    /// First representative of each slot.
    heads: Vec<u32>,
    /// Representatives in the order found, that is by ascending vertex.
    representatives: Vec<Representative>,
}

struct Representative {
    point: Point3,
    vertex: VertId,
    /// Next representative of the same slot.
    next: u32,
}

impl Grid {
    fn new(n_vertices: usize, tolerance: f64) -> Self {
        let heads = vec![NONE; n_vertices.next_power_of_two()];
        let cells_per_length = 1.0 / (TOLERANCES_PER_CELL * tolerance);
        Self { tolerance, cells_per_length, heads, representatives: Vec::new() }
    }

    fn find_or_insert(&mut self, vertex: VertId, point: &Point3) -> VertId {
        let scaled = point.coords * self.cells_per_length;
        let home: [i64; 3] = std::array::from_fn(|axis| scaled[axis].floor() as i64);
        let slot = self.slot(home);
        // Soups repeat a vertex exactly: a copy of a representative needs no look at the neighbours.
        if let Some(same) = self.chain(slot).find(|r| r.point == *point) {
            return same.vertex;
        }
        let mut lowest = self.lowest_within(slot, point);
        let border = 1.0 / TOLERANCES_PER_CELL;
        let sides: [i64; 3] = std::array::from_fn(|axis| {
            let inside = scaled[axis] - scaled[axis].floor();
            i64::from(1.0 - border <= inside) - i64::from(inside <= border)
        });
        for mask in 1..8_u8 {
            let crossed = |axis: usize| mask >> axis & 1 == 1;
            if (0..3).all(|axis| !crossed(axis) || sides[axis] != 0) {
                let step = |axis: usize| if crossed(axis) { sides[axis] } else { 0 };
                let cell = std::array::from_fn(|axis| home[axis].saturating_add(step(axis)));
                lowest = lowest.min(self.lowest_within(self.slot(cell), point));
            }
        }
        if lowest != NONE {
            return lowest;
        }
        let next = std::mem::replace(&mut self.heads[slot], self.representatives.len() as u32);
        self.representatives.push(Representative { point: *point, vertex, next });
        vertex
    }

    fn lowest_within(&self, slot: usize, point: &Point3) -> u32 {
        let tolerance_sq = self.tolerance * self.tolerance;
        let near = self.chain(slot).filter(|r| (r.point - point).norm_squared() <= tolerance_sq);
        near.fold(NONE, |lowest, r| lowest.min(r.vertex))
    }

    fn chain(&self, slot: usize) -> impl Iterator<Item = &Representative> {
        std::iter::successors(self.get(self.heads[slot]), |r| self.get(r.next))
    }

    fn get(&self, index: u32) -> Option<&Representative> {
        self.representatives.get(index as usize)
    }

    fn slot(&self, cell: [i64; 3]) -> usize {
        // Odd multipliers spread the cells, the shift takes the well mixed high bits.
        const MULTIPLIERS: [u64; 3] = [0x9E37_79B9_7F4A_7C15, 0xC2B2_AE3D_27D4_EB4F, 0x1656_67B1_9E37_79F9];
        let mixed = cell.iter().zip(MULTIPLIERS).fold(0_u64, |h, (&c, m)| (h ^ c as u64).wrapping_mul(m));
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(MULTIPLIERS[0]);
        (mixed >> 20) as usize & (self.heads.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of unit triangles, so that the median edge is about one.
    fn strip(extra: &[Point3]) -> Mesh {
        let mut vertices: Vec<Point3> =
            (0..20).map(|i| Point3::new(f64::from(i / 2), f64::from(i % 2), 0.0)).collect();
        let triangles = (0..18).map(|i| [i, i + 1, i + 2]).collect();
        vertices.extend_from_slice(extra);
        Mesh { vertices, triangles }
    }

    #[test]
    fn copies_and_near_copies_become_one_and_others_stay() {
        let tolerance = tolerance(&strip(&[]));
        let near = Point3::new(0.9 * tolerance, 0.0, 0.0);
        let far = Point3::new(0.0, 0.0, 1.1 * tolerance);
        let mesh = strip(&[Point3::origin(), near, far]);
        let welding = weld(&mesh);
        assert_eq!(&welding.representative[20..], &[0, 0, 22]);
        assert_eq!(&welding.representative[..20], &(0..20).collect::<Vec<_>>()[..]);
    }

    #[test]
    fn near_copies_are_found_across_every_cell_border() {
        let tolerance = tolerance(&strip(&[]));
        let cell = TOLERANCES_PER_CELL * tolerance;
        for mask in 0..8_u32 {
            let side = |axis: u32| if mask >> axis & 1 == 1 { 1.0 } else { -1.0 };
            // Corner of cells in the midst of the strip's box; the two points lie on opposite sides of it.
            let corner = Point3::new((3.5 / cell).round() * cell, (0.5 / cell).round() * cell, 0.0);
            let offset = Point3::new(side(0), side(1), side(2)).coords * (0.25 * tolerance);
            let welding = weld(&strip(&[corner + offset, corner - offset]));
            assert_eq!(welding.representative[21], 20, "{mask}");
        }
    }

    #[test]
    fn a_row_of_close_vertices_does_not_collapse() {
        let tolerance = tolerance(&strip(&[]));
        let row: Vec<Point3> =
            (0..100).map(|i| Point3::new(5.5, 0.5, 0.6 * tolerance * f64::from(i))).collect();
        let welding = weld(&strip(&row));
        for (v, &r) in welding.representative.iter().enumerate().skip(20) {
            let moved = 0.6 * tolerance * (v as f64 - f64::from(r));
            assert!(moved <= tolerance, "vertex {v} moved by {moved}");
        }
    }
}
