//! Conditioning: from any triangles to an oriented manifold with boundary.
//!
//! Vertices that are one point are merged; triangles without area dissolved and repeated ones dropped; edges of three or more
//! triangles and vertices of several fans split; every component oriented; specks dropped. Holes stay: they say what
//! the scanner did not see. Positions are those of the input, and every triangle knows which input triangle it was.
//!
//! Cost O(n) but for the sort that finds repeated triangles.

use super::caps::swap_caps;
use super::components::{components, specks};
use super::half_edges::{HalfEdges, NONE, next};
use super::orient::orient;
use super::split::{join, split_vertices};
use super::weld::{median_edge, weld};
use crate::mesh::{Csr, Mesh, TriId, VertId};

/// Height of a triangle, in roundings of its coordinates, below which it has no direction.
const FLAT_ROUNDINGS: f64 = 8.0;

/// A mesh that the other stages can rely on: every edge belongs to one or two triangles of consistent orientation,
/// every vertex to one fan, every triangle has an area. It may still be open and in several pieces, and may cross
/// itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Conditioned {
    /// The triangles kept, in the input's order.
    pub mesh: Mesh,
    /// Per triangle of `mesh`, its index in the input.
    pub source_triangle: Vec<TriId>,
    /// What was done.
    pub report: ConditionReport,
}

/// What conditioning found and did.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct ConditionReport {
    /// Triangles given.
    pub n_input_triangles: usize,
    /// Vertices given.
    pub n_input_vertices: usize,
    /// Distance within which vertices were merged, length.
    pub weld_distance: f64,
    /// Vertices merged into another.
    pub n_welded_vertices: usize,
    /// Triangles dropped because two of their corners are one, or all lie on a line and nothing is open without them.
    pub n_zero_area_triangles: usize,
    /// Triangles whose corners lay on a line and which took half of the neighbour across their longest side, lest
    /// dropping them opened the surface.
    pub n_swapped_caps: usize,
    /// Triangles dropped because another has the same corners, in either sense.
    pub n_repeated_triangles: usize,
    /// Edges of three or more triangles, now split.
    pub n_split_edges: usize,
    /// Vertices added to give each fan its own.
    pub n_split_vertices: usize,
    /// Edges cut because the surface has only one side.
    pub n_one_sided_edges: usize,
    /// Triangles turned over.
    pub n_flipped_triangles: usize,
    /// Small pieces dropped.
    pub n_specks: usize,
    /// Triangles of the pieces dropped.
    pub n_speck_triangles: usize,
    /// Pieces kept.
    pub n_components: usize,
    /// Boundary edges of what was kept.
    pub n_boundary_edges: usize,
    /// Boundary loops of what was kept; an open sheet has one.
    pub n_boundary_loops: usize,
}

impl Conditioned {
    /// One value per input triangle from one per conditioned triangle: `missing` for those that were dropped.
    pub fn to_input<T: Clone>(&self, values: &[T], missing: T) -> Vec<T> {
        assert_eq!(values.len(), self.source_triangle.len(), "one value per triangle");
        let mut per_input = vec![missing; self.report.n_input_triangles];
        for (value, &source) in values.iter().zip(&self.source_triangle) {
            per_input[source as usize] = value.clone();
        }
        per_input
    }
}

/// Conditions `mesh`. Idempotent, but for edges of three or more triangles that the first pass had to turn over.
pub fn condition(mesh: &Mesh) -> Conditioned {
    let mut report = ConditionReport {
        n_input_triangles: mesh.triangles.len(),
        n_input_vertices: mesh.vertices.len(),
        ..ConditionReport::default()
    };
    let (mut welded, mut source_triangle) = weld_and_drop(mesh, &mut report);
    let (mut half_edges, n_crowded) = join(&welded);
    report.n_split_edges = n_crowded;

    let orientation = orient(&welded, &mut half_edges);
    report.n_one_sided_edges = orientation.n_cut_edges;
    for (triangle, _) in welded.triangles.iter_mut().zip(&orientation.flip).filter(|(_, flip)| **flip) {
        triangle.swap(1, 2);
    }
    half_edges.renumber_flipped(&orientation.flip);

    let recheck = n_crowded > 0 || orientation.n_cut_edges > 0;
    report.n_split_vertices = split_vertices(&mut welded, &mut half_edges, recheck);

    let (component, n_components) =
        if recheck { components(&half_edges) } else { (orientation.component, orientation.n_components) };
    let speck = specks(&welded, &component, n_components, median_edge(&welded).unwrap_or(0.0));
    let kept = |t: usize| !speck[component[t] as usize];
    report.n_specks = speck.iter().filter(|s| **s).count();
    report.n_components = n_components - report.n_specks;
    report.n_speck_triangles = (0..component.len()).filter(|&t| !kept(t)).count();
    report.n_flipped_triangles = (0..component.len()).filter(|&t| kept(t) && orientation.flip[t]).count();
    (report.n_boundary_edges, report.n_boundary_loops) = count_boundary(&half_edges, kept);

    let mesh = compact(&welded, kept);
    let mut t = 0;
    source_triangle.retain(|_| {
        t += 1;
        kept(t - 1)
    });
    Conditioned { mesh, source_triangle, report }
}

/// Merges vertices, then drops triangles without area and repeated ones. Also returns the triangles' input indices.
fn weld_and_drop(mesh: &Mesh, report: &mut ConditionReport) -> (Mesh, Vec<TriId>) {
    let welding = weld(mesh);
    report.weld_distance = welding.tolerance;
    let is_merged = |(v, r): (usize, &VertId)| v as VertId != *r;
    report.n_welded_vertices = welding.representative.iter().enumerate().filter(|x| is_merged(*x)).count();
    let renamed = mesh.triangles.iter().map(|t| t.map(|v| welding.representative[v as usize])).collect();
    let mut welded = Mesh { vertices: mesh.vertices.clone(), triangles: renamed };
    let mut source: Vec<TriId> = (0..mesh.triangles.len() as TriId).collect();

    let is_needle = |[a, b, c]: &[VertId; 3]| a == b || b == c || c == a;
    let needles: Vec<usize> =
        (0..welded.triangles.len()).filter(|&t| is_needle(&welded.triangles[t])).collect();
    let repeats = repeated(&welded);
    // A needle may repeat another; it is dropped once and counted as a needle.
    report.n_zero_area_triangles = needles.len();
    let n_dropped = drop_triangles(&mut welded, &mut source, &[needles, repeats].concat());
    report.n_repeated_triangles = n_dropped - report.n_zero_area_triangles;

    let rounding = FLAT_ROUNDINGS * f64::EPSILON * mesh.largest_coordinate();
    let (n_swapped, caps) = swap_caps(&mut welded, |mesh, t| is_flat(mesh, t, rounding));
    report.n_swapped_caps = n_swapped;
    report.n_zero_area_triangles += drop_triangles(&mut welded, &mut source, &caps);
    if n_swapped > 0 {
        let repeats = repeated(&welded);
        report.n_repeated_triangles += drop_triangles(&mut welded, &mut source, &repeats);
    }
    (welded, source)
}

/// Drops triangles with their sources; returns how many.
fn drop_triangles(mesh: &mut Mesh, source: &mut Vec<TriId>, dropped: &[usize]) -> usize {
    if dropped.is_empty() {
        return 0;
    }
    let mut kept = vec![true; mesh.triangles.len()];
    for &t in dropped {
        kept[t] = false;
    }
    let mut keep = kept.iter();
    mesh.triangles.retain(|_| *keep.next().expect("one per triangle"));
    let mut keep = kept.iter();
    source.retain(|_| *keep.next().expect("one per triangle"));
    kept.iter().filter(|kept| !**kept).count()
}

/// Whether a triangle's height is lost in the rounding of its coordinates.
fn is_flat(mesh: &Mesh, t: usize, rounding: f64) -> bool {
    let [a, b, c] = mesh.corners(t);
    let longest_sq = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
    // Twice the area is the longest edge times the height above it.
    mesh.cross(t).norm_squared() <= rounding * rounding * longest_sq
}

/// The triangles with the same three vertices as an earlier one.
fn repeated(mesh: &Mesh) -> Vec<usize> {
    let sorted = |t: u32| {
        let mut corners = mesh.triangles[t as usize];
        corners.sort_unstable();
        corners
    };
    let n_triangles = mesh.triangles.len() as u32;
    let by_lowest = Csr::from_pairs(mesh.vertices.len(), (0..n_triangles).map(|t| (sorted(t)[0], t)));
    let mut repeated = Vec::new();
    let mut row = Vec::new();
    for v in 0..by_lowest.len() {
        row.clear();
        row.extend(by_lowest.row(v).iter().map(|&t| (sorted(t), t)));
        row.sort_unstable();
        repeated.extend(row.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1 as usize));
    }
    repeated
}

/// Boundary edges and loops of the kept triangles; these are consistently oriented.
fn count_boundary(half_edges: &HalfEdges, kept: impl Fn(usize) -> bool) -> (usize, usize) {
    let mut visited = vec![false; half_edges.twin.len()];
    let (mut n_edges, mut n_loops) = (0, 0);
    for start in 0..half_edges.twin.len() as u32 {
        if half_edges.twin[start as usize] != NONE || visited[start as usize] || !kept(start as usize / 3) {
            continue;
        }
        n_loops += 1;
        let mut h = start;
        while !visited[h as usize] {
            visited[h as usize] = true;
            n_edges += 1;
            h = next(h);
            while half_edges.twin[h as usize] != NONE {
                h = next(half_edges.twin[h as usize]);
            }
        }
    }
    (n_edges, n_loops)
}

/// The kept triangles without unused vertices; the order of both stays.
fn compact(mesh: &Mesh, kept: impl Fn(usize) -> bool) -> Mesh {
    let n_triangles = mesh.triangles.len();
    let mut new_of_old = vec![VertId::MAX; mesh.vertices.len()];
    for t in (0..n_triangles).filter(|&t| kept(t)) {
        for v in mesh.triangles[t] {
            new_of_old[v as usize] = 0;
        }
    }
    let mut vertices = Vec::new();
    for (new, vertex) in new_of_old.iter_mut().zip(&mesh.vertices).filter(|(new, _)| **new == 0) {
        *new = vertices.len() as VertId;
        vertices.push(*vertex);
    }
    let rename = |t: usize| mesh.triangles[t].map(|v| new_of_old[v as usize]);
    let triangles = (0..n_triangles).filter(|&t| kept(t)).map(rename).collect();
    Mesh { vertices, triangles }
}
