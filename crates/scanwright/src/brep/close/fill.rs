//! Fills what loops bound on one surface, by constrained Delaunay triangulation in the surface's picture.
//!
//! The part of the picture with winding number one about the loops is the hole; a loop set with any other winding
//! bounds nothing on this surface alone and is refused, which is how a lone mouth of a bore is told from a window in
//! its wall. Loops of noisy scans cross themselves in the picture; as only the connectivity is taken from it, they are
//! smoothed there until they do not.
//!
//! Constrained Delaunay triangulation: L. P. Chew, "Constrained Delaunay triangulations", Algorithmica 4 (1989).
//! Cost: O(n m + n log n) for m loop edges and n points of the filling.

use super::chart::{Chart, Flat};
use super::shell::Shell;
use crate::math::Point3;
use crate::par;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

/// Smoothings tried before a self-crossing loop is given up; each moves a vertex by up to a spacing.
pub(super) const SMOOTHINGS: [usize; 5] = [0, 2, 6, 20, 60];
/// Points are kept this far from the loops, in spacings: nearer ones make slivers.
const CLEARANCE: f64 = 0.6;

/// Fills the part of the surface of `label` that `loops` bound; false, changing nothing, when there is none.
pub(super) fn fill_on_surface(shell: &mut Shell, loops: &[&[u32]], label: u32) -> bool {
    let rims: Vec<Vec<Point3>> = loops.iter().map(|rim| shell.points(rim)).collect();
    let all: Vec<Point3> = rims.iter().flatten().copied().collect();
    let Some(chart) = Chart::new(&shell.primitives[label as usize], &all) else { return false };
    for n_smoothings in SMOOTHINGS {
        let Some(flats) =
            rims.iter().map(|rim| chart.flat_loop(rim, n_smoothings)).collect::<Option<Vec<_>>>()
        else {
            return false;
        };
        let endless = chart.is_endless_at_origin() && winding([0.0, 0.0], &flats) != 0;
        if n_smoothings == 0 && (endless || !bounds_hole(&flats)) {
            return false;
        }
        let inside = interior_points(&chart, &flats, &all, shell.spacing);
        let extra: Vec<Flat> = inside.iter().map(|p| p.1).collect();
        let Some(triangles) = triangulate(&flats, &extra) else { continue };
        let mut vertices: Vec<u32> = loops.iter().flat_map(|rim| rim.iter().copied()).collect();
        vertices.extend(inside.iter().map(|p| shell.add_vertex(p.0)));
        for triangle in triangles {
            shell.add_triangle(triangle.map(|i| vertices[i]), label);
        }
        return true;
    }
    false
}

/// Whether some point has winding number one about the loops and none has less than zero: judged by areas and
/// nesting, as self-crossings of a noisy loop always have small spots of other windings.
fn bounds_hole(flats: &[Vec<Flat>]) -> bool {
    let areas: Vec<f64> = flats.iter().map(|l| signed_area(l)).collect();
    let outer = areas.iter().any(|a| *a > 0.0);
    // Every clockwise loop must lie inside a counter-clockwise one.
    let nested = (0..flats.len()).filter(|&i| areas[i] <= 0.0).all(|i| {
        (0..flats.len())
            .any(|j| areas[j] > 0.0 && areas[j] > -areas[i] && winding_of_loop(flats[i][0], &flats[j]) > 0)
    });
    outer && nested
}

/// Signed area of a polygon.
pub(super) fn signed_area(polygon: &[Flat]) -> f64 {
    let n = polygon.len();
    let cross = |i: usize| {
        let ([x, y], [u, v]) = (polygon[i], polygon[(i + 1) % n]);
        x * v - y * u
    };
    0.5 * (0..n).map(cross).sum::<f64>()
}

/// Winding number of a closed polygon about a point.
pub(super) fn winding_of_loop([x, y]: Flat, polygon: &[Flat]) -> i32 {
    let n = polygon.len();
    let mut winding = 0;
    for i in 0..n {
        let ([x0, y0], [x1, y1]) = (polygon[i], polygon[(i + 1) % n]);
        if (y0 <= y) == (y1 <= y) {
            continue;
        }
        let left = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0);
        if y0 <= y && left > 0.0 {
            winding += 1;
        } else if y0 > y && left < 0.0 {
            winding -= 1;
        }
    }
    winding
}

fn winding(point: Flat, loops: &[Vec<Flat>]) -> i32 {
    loops.iter().map(|polygon| winding_of_loop(point, polygon)).sum()
}

/// Points of a regular grid on the surface that lie in the hole, clear of the loops.
pub(super) fn interior_points(
    chart: &Chart,
    flats: &[Vec<Flat>],
    rim: &[Point3],
    step: f64,
) -> Vec<(Point3, Flat)> {
    let clearance_sq = (CLEARANCE * step).powi(2);
    let grid = chart.grid(rim, step);
    let keep = par::map(&grid, |(point, flat)| {
        winding(*flat, flats) == 1 && rim.iter().all(|r| (r - point).norm_squared() > clearance_sq)
    });
    grid.into_iter().zip(keep).filter(|(_, keep)| *keep).map(|(found, _)| found).collect()
}

/// Triangles (indices into the points of `loops`, then `extra`) that fill what the loops bound; `None` unless their
/// border is exactly the loops.
pub(super) fn triangulate(loops: &[Vec<Flat>], extra: &[Flat]) -> Option<Vec<[usize; 3]>> {
    let mut plane = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let points: Vec<Flat> = loops.iter().flatten().chain(extra).copied().collect();
    let mut index_of = Vec::with_capacity(points.len());
    let mut handles = Vec::with_capacity(points.len());
    for (i, &[x, y]) in points.iter().enumerate() {
        let handle = plane.insert(Point2::new(x, y)).ok()?;
        if handle.index() < index_of.len() {
            return None;
        }
        index_of.push(i);
        handles.push(handle);
    }
    let mut borders = Vec::new();
    let mut start = 0;
    for polygon in loops {
        let n = polygon.len();
        for i in 0..n {
            let (a, b) = (start + i, start + (i + 1) % n);
            if !plane.can_add_constraint(handles[a], handles[b]) {
                return None;
            }
            plane.add_constraint(handles[a], handles[b]);
            borders.push((a, b));
        }
        start += n;
    }
    let mut triangles = Vec::new();
    for face in plane.inner_faces() {
        let corners = face.vertices().map(|v| index_of[v.index()]);
        let middle = [0, 1].map(|k| corners.iter().map(|&c| points[c][k]).sum::<f64>() / 3.0);
        if winding(middle, loops) == 1 {
            triangles.push(corners);
        }
    }
    has_border(&triangles, borders).then_some(triangles)
}

/// Whether the border of `triangles` is `expected`, a set of directed edges.
fn has_border(triangles: &[[usize; 3]], mut expected: Vec<(usize, usize)>) -> bool {
    let mut edges: Vec<(usize, usize)> =
        triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3]))).collect();
    edges.sort_unstable();
    if edges.windows(2).any(|pair| pair[0] == pair[1]) {
        return false;
    }
    let mut border: Vec<(usize, usize)> =
        edges.iter().filter(|e| edges.binary_search(&(e.1, e.0)).is_err()).copied().collect();
    border.sort_unstable();
    expected.sort_unstable();
    border == expected
}
