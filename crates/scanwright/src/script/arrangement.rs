//! The plane cut along lines and circles: vertices, sides, cells.
//!
//! Every curve is taken whole within a rectangle and cut where it meets others; cells are traced along sides, each side
//! followed by the next one clockwise about its end (D. E. Muller, F. P. Preparata, "Finding the intersection of two
//! convex polyhedra", Theoretical Computer Science 7 (1978), 217-236). Directions are compared at a distance from the
//! vertex, not by tangents, so that a fillet and the line it touches are told apart. Points nearer than `tolerance` are
//! one: noise parts what was drawn through one point. O(n^2) curves, O(v log v) sides.

use std::collections::{BTreeMap, BTreeSet};

use super::curve::{Curve, cross};
use super::sweep::Point2;

/// A piece of a curve between two vertices.
#[derive(Debug, Clone)]
pub(super) struct Side {
    pub(super) from: usize,
    pub(super) to: usize,
    /// The curve it is drawn with.
    pub(super) curve: usize,
    /// Every curve that runs along it.
    pub(super) curves: Vec<usize>,
    /// Range of the curve's parameter, ascending.
    pub(super) range: (f64, f64),
    /// The cell on its left and on its right; `None` outside the rectangle.
    pub(super) cells: [Option<usize>; 2],
}

/// A connected part of the plane that no curve crosses.
#[derive(Debug, Clone)]
pub(super) struct Cell {
    /// Its border, counter-clockwise: sides and whether they run forward.
    pub(super) border: Vec<(usize, bool)>,
    /// The border with its arcs as chords of a few degrees.
    pub(super) polygon: Vec<Point2>,
    pub(super) area: f64,
}

/// The cut plane.
#[derive(Debug, Clone)]
pub(super) struct Arrangement {
    /// The curves given, then the sides of the rectangle, then lines that tie lonely circles to the rest.
    pub(super) curves: Vec<Curve>,
    pub(super) vertices: Vec<Point2>,
    pub(super) sides: Vec<Side>,
    pub(super) cells: Vec<Cell>,
}

/// Radians of a chord of an arc.
const CHORD: f64 = std::f64::consts::PI / 60.0;

impl Arrangement {
    /// `None` when rounding and noise leave no consistent cells.
    pub(super) fn new(curves: &[Curve], low: Point2, high: Point2, tolerance: f64) -> Option<Self> {
        /// Rounds of tying: each ties every lonely piece to what is beside it.
        const ROUNDS: usize = 3;
        let mut curves = curves.to_vec();
        for (point, direction) in [
            (low, Point2::new(1.0, 0.0)),
            (high, Point2::new(-1.0, 0.0)),
            (low, Point2::new(0.0, 1.0)),
            (high, Point2::new(0.0, -1.0)),
        ] {
            curves.push(Curve::Line { point, direction });
        }
        for _ in 0..ROUNDS {
            let mut made = Self::cut(&curves, low, high, tolerance);
            let lonely = made.lonely_circles();
            if lonely.is_empty() {
                let expected = (high.x - low.x) * (high.y - low.y);
                return made.trace(expected).then_some(made);
            }
            curves.extend(lonely);
        }
        None
    }

    fn cut(curves: &[Curve], low: Point2, high: Point2, tolerance: f64) -> Self {
        let (vertices, on_curve) = vertices(curves, low, high, tolerance);
        let mut made = Self { curves: curves.to_vec(), vertices, sides: Vec::new(), cells: Vec::new() };
        let mut known: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        for (c, (curve, on)) in curves.iter().zip(&on_curve).enumerate() {
            for (from, to, range) in made.pieces(curve, on) {
                let middle = curve.at(0.5 * (range.0 + range.1));
                let is_inside = middle.x > low.x - tolerance
                    && middle.x < high.x + tolerance
                    && middle.y > low.y - tolerance
                    && middle.y < high.y + tolerance;
                if !is_inside {
                    continue;
                }
                let twins = known.entry((from.min(to), from.max(to))).or_default();
                let twin = twins.iter().copied().find(|&s| {
                    let side = &made.sides[s];
                    let other = made.curves[side.curve].at(0.5 * (side.range.0 + side.range.1));
                    (other - middle).norm() <= tolerance
                });
                if let Some(twin) = twin {
                    made.sides[twin].curves.push(c);
                    continue;
                }
                twins.push(made.sides.len());
                made.sides.push(Side { from, to, curve: c, curves: vec![c], range, cells: [None; 2] });
            }
        }
        made
    }

    /// A curve cut at its vertices.
    fn pieces(&mut self, curve: &Curve, on: &BTreeSet<usize>) -> Vec<(usize, usize, (f64, f64))> {
        use std::f64::consts::{PI, TAU};
        let mut places: Vec<(f64, usize)> =
            on.iter().map(|&v| (curve.parameter(&self.vertices[v]), v)).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut pieces: Vec<(usize, usize, (f64, f64))> =
            places.windows(2).map(|w| (w[0].1, w[1].1, (w[0].0, w[1].0))).collect();
        if matches!(curve, Curve::Circle { .. }) {
            if places.len() < 2 {
                // Two ends are needed to have two pieces.
                let start = places.first().map_or(0.0, |p| p.0);
                let mut add = |angle: f64| {
                    self.vertices.push(curve.at(angle));
                    self.vertices.len() - 1
                };
                let first = places.first().map_or_else(|| add(start), |p| p.1);
                let second = add(start + PI);
                return vec![
                    (first, second, (start, start + PI)),
                    (second, first, (start + PI, start + TAU)),
                ];
            }
            let (first, last) = (places[0], places[places.len() - 1]);
            pieces.push((last.1, first.1, (last.0, first.0 + TAU)));
        }
        pieces
    }

    /// A level line through each circle that is not connected to the rectangle.
    fn lonely_circles(&self) -> Vec<Curve> {
        let mut parent: Vec<usize> = (0..self.vertices.len()).collect();
        fn root(parent: &mut [usize], mut v: usize) -> usize {
            while parent[v] != v {
                parent[v] = parent[parent[v]];
                v = parent[v];
            }
            v
        }
        for side in &self.sides {
            let (a, b) = (root(&mut parent, side.from), root(&mut parent, side.to));
            parent[a.max(b)] = a.min(b);
        }
        let Some(first) = self.sides.iter().find(|s| matches!(self.curves[s.curve], Curve::Line { .. }))
        else {
            return Vec::new();
        };
        let main = root(&mut parent, first.from);
        let mut tied = BTreeSet::new();
        let mut lines = Vec::new();
        for side in &self.sides {
            let piece = root(&mut parent, side.from);
            let Curve::Circle { center, .. } = self.curves[side.curve] else { continue };
            if piece != main && tied.insert(piece) {
                lines.push(Curve::Line { point: center, direction: Point2::new(1.0, 0.0) });
            }
        }
        lines
    }

    /// Finds the cells; whether they fill the rectangle, of area `expected`, once.
    fn trace(&mut self, expected: f64) -> bool {
        /// Share of the rectangle that vertices moved within the tolerance may cost.
        const SLACK: f64 = 0.01;
        let next = self.successors();
        let mut seen = vec![false; 2 * self.sides.len()];
        let (mut total, mut n_outer) = (0.0, 0);
        for start in 0..seen.len() {
            if seen[start] {
                continue;
            }
            let mut border = Vec::new();
            let mut half = start;
            while !seen[half] {
                seen[half] = true;
                border.push((half / 2, half.is_multiple_of(2)));
                half = next[half];
            }
            let polygon = self.polygon(&border);
            let area = signed_area(&polygon);
            if area <= 0.0 {
                // Slivers between curves that nearly coincide may be turned inside out; only the outer border is large.
                n_outer += usize::from(area < -SLACK * expected);
                continue;
            }
            total += area;
            let cell = self.cells.len();
            for &(side, forward) in &border {
                self.sides[side].cells[usize::from(!forward)] = Some(cell);
            }
            self.cells.push(Cell { border, polygon, area });
        }
        n_outer == 1 && (total - expected).abs() <= SLACK * expected
    }

    /// The side that follows each side, `2 * side` forward and `2 * side + 1` backward, round the cell on its left.
    fn successors(&self) -> Vec<usize> {
        let mut leaving: Vec<Vec<usize>> = vec![Vec::new(); self.vertices.len()];
        for (s, side) in self.sides.iter().enumerate() {
            leaving[side.from].push(2 * s);
            leaving[side.to].push(2 * s + 1);
        }
        let mut next = vec![0; 2 * self.sides.len()];
        for halves in &leaving {
            let reach = halves.iter().map(|h| 0.5 * self.chord(h / 2)).fold(f64::INFINITY, f64::min);
            let mut turned: Vec<(f64, usize)> =
                halves.iter().map(|&h| (self.direction(h, reach), h)).collect();
            turned.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for i in 0..turned.len() {
                let before = turned[(i + turned.len() - 1) % turned.len()].1;
                // What arrives here is the twin of what leaves.
                next[turned[i].1 ^ 1] = before;
            }
        }
        next
    }

    /// Distance within which a side leaves its ends monotonically.
    fn chord(&self, side: usize) -> f64 {
        let s = &self.sides[side];
        match self.curves[s.curve] {
            Curve::Line { .. } => (self.vertices[s.to] - self.vertices[s.from]).norm(),
            Curve::Circle { radius, .. } => {
                2.0 * radius * (0.5 * (s.range.1 - s.range.0).min(std::f64::consts::PI)).sin()
            }
        }
    }

    /// Angle at which a half leaves its start, seen `reach` away.
    fn direction(&self, half: usize, reach: f64) -> f64 {
        let side = &self.sides[half / 2];
        let is_forward = half.is_multiple_of(2);
        let (start, sign) = if is_forward { (side.range.0, 1.0) } else { (side.range.1, -1.0) };
        let step = match self.curves[side.curve] {
            Curve::Line { .. } => reach,
            Curve::Circle { radius, .. } => 2.0 * (reach / (2.0 * radius)).min(1.0).asin(),
        };
        let curve = &self.curves[side.curve];
        let away = curve.at(start + sign * step) - curve.at(start);
        away.y.atan2(away.x)
    }

    /// The points of a side from its start to before its end; arcs as chords.
    pub(super) fn walk(&self, side: usize, forward: bool) -> Vec<Point2> {
        let s = &self.sides[side];
        let curve = &self.curves[s.curve];
        let (a, b) = if forward { s.range } else { (s.range.1, s.range.0) };
        let n = match curve {
            Curve::Line { .. } => 1,
            Curve::Circle { .. } => ((b - a).abs() / CHORD).ceil().max(2.0) as usize,
        };
        let mut points = vec![self.vertices[if forward { s.from } else { s.to }]];
        points.extend((1..n).map(|i| curve.at(a + (b - a) * i as f64 / n as f64)));
        points
    }

    /// The middle of a side.
    pub(super) fn middle(&self, side: usize) -> Point2 {
        let s = &self.sides[side];
        self.curves[s.curve].at(0.5 * (s.range.0 + s.range.1))
    }

    /// Length of a side.
    pub(super) fn length(&self, side: usize) -> f64 {
        let s = &self.sides[side];
        match self.curves[s.curve] {
            Curve::Line { .. } => s.range.1 - s.range.0,
            Curve::Circle { radius, .. } => radius * (s.range.1 - s.range.0),
        }
    }

    pub(super) fn polygon(&self, border: &[(usize, bool)]) -> Vec<Point2> {
        border.iter().flat_map(|&(side, forward)| self.walk(side, forward)).collect()
    }
}

/// Points where curves meet within the rectangle, and those on each curve.
fn vertices(
    curves: &[Curve],
    low: Point2,
    high: Point2,
    tolerance: f64,
) -> (Vec<Point2>, Vec<BTreeSet<usize>>) {
    let mut vertices: Vec<Point2> = Vec::new();
    let mut on_curve = vec![BTreeSet::new(); curves.len()];
    // Corners of the rectangle first: they shall not move.
    let n = curves.len();
    let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j)));
    let is_frame = |c: usize| matches!(curves[c], Curve::Line { point, .. } if point == low || point == high);
    let (frame, rest): (Vec<_>, Vec<_>) = pairs.partition(|&(i, j)| is_frame(i) && is_frame(j));
    for (i, j) in frame.into_iter().chain(rest) {
        for p in curves[i].meets(&curves[j], tolerance) {
            let is_outside = p.x < low.x - tolerance
                || p.x > high.x + tolerance
                || p.y < low.y - tolerance
                || p.y > high.y + tolerance;
            if is_outside || !p.x.is_finite() || !p.y.is_finite() {
                continue;
            }
            let known = vertices.iter().position(|v| (v - p).norm() <= tolerance);
            let v = known.unwrap_or_else(|| {
                vertices.push(p);
                vertices.len() - 1
            });
            on_curve[i].insert(v);
            on_curve[j].insert(v);
        }
    }
    (vertices, on_curve)
}

/// Area of a polygon, positive when counter-clockwise.
pub(super) fn signed_area(polygon: &[Point2]) -> f64 {
    let Some(base) = polygon.first() else { return 0.0 };
    let next = polygon.iter().cycle().skip(1);
    0.5 * polygon.iter().zip(next).map(|(a, b)| cross(&(a - base), &(b - base))).sum::<f64>()
}

/// Whether a point is inside an odd number of polygons.
pub(super) fn is_inside<'a>(polygons: impl IntoIterator<Item = &'a [Point2]>, p: &Point2) -> bool {
    let mut odd = false;
    for polygon in polygons {
        let mut a = polygon[polygon.len() - 1];
        for b in polygon {
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                odd = !odd;
            }
            a = *b;
        }
    }
    odd
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(x: f64, y: f64, dx: f64, dy: f64) -> Curve {
        Curve::Line { point: Point2::new(x, y), direction: Point2::new(dx, dy).normalize() }
    }

    fn square(curves: &[Curve], tolerance: f64) -> Arrangement {
        Arrangement::new(curves, Point2::new(0.0, 0.0), Point2::new(10.0, 10.0), tolerance).expect("cells")
    }

    #[test]
    fn cells_fill_the_rectangle() {
        let circle = |x: f64, y: f64, radius: f64| Curve::Circle { center: Point2::new(x, y), radius };
        // Lines in three directions, one through a corner, a circle across them, one on its own, one half outside.
        let curves = [
            line(3.0, 0.0, 0.0, 1.0),
            line(0.0, 4.0, 1.0, 0.0),
            line(0.0, 0.0, 1.0, 1.0),
            circle(3.0, 4.0, 2.0),
            circle(8.0, 2.0, 0.5),
            circle(10.0, 8.0, 1.0),
        ];
        let plane = square(&curves, 1e-6);
        let total: f64 = plane.cells.iter().map(|c| c.area).sum();
        assert!((total - 100.0).abs() < 1e-9, "{total}");
        // Euler: one connected piece, the outer face not counted.
        let used: BTreeSet<usize> = plane.sides.iter().flat_map(|s| [s.from, s.to]).collect();
        assert_eq!(used.len() + plane.cells.len() + 1, plane.sides.len() + 2);
        for (c, cell) in plane.cells.iter().enumerate() {
            for &(side, forward) in &cell.border {
                assert_eq!(plane.sides[side].cells[usize::from(!forward)], Some(c));
            }
        }
    }

    #[test]
    fn a_fillet_that_noise_has_moved_still_parts_its_corner() {
        for shift in [-0.02, 0.0, 0.02] {
            let fillet = Curve::Circle { center: Point2::new(2.0 + shift, 2.0 - shift), radius: 2.0 };
            let walls = [line(0.0, 4.0, 1.0, 0.0), line(4.0, 0.0, 0.0, 1.0)];
            let plane = square(&[walls[0], walls[1], fillet], 0.05);
            let corner = (4.0 - std::f64::consts::PI) * 4.0 / 4.0;
            let near = |c: &&Cell| is_inside([c.polygon.as_slice()], &Point2::new(3.85, 3.85));
            let cell = plane.cells.iter().find(near).expect("a cell");
            assert!((cell.area - corner).abs() < 0.1, "area {} instead of {corner}", cell.area);
        }
    }
}
