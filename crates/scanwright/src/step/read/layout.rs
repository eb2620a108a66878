//! The border of a face as polygons in the parameter plane of its surface.
//!
//! Loops are unrolled point by point. One that comes back a whole period further (it goes round a cylinder, a cone, a
//! torus) is joined to its partner, or to the pole it surrounds, along a cut whose two sides share their vertices:
//!
//! ```text
//!       pole or upper loop                o----<----o
//!   ----<-----<-----<----      cut       |         |      one polygon, the period wide;
//!                             ====>      |         |      left and right side are the same
//!   ---->----->----->----                |         |      vertices
//!       lower loop                        o---->----o
//! ```

use super::curve::CLOSED;
use super::patch::{Patch, Uv};
use crate::math::Point3;

/// A corner of a loop: a point shared with the neighbouring faces.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub(super) point: Point3,
    /// Index among the vertices of the shape.
    pub(super) vertex: u32,
}

/// A vertex of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Node {
    /// One of the shape's, on an edge.
    Shared(u32),
    /// One of the face alone.
    Own(u32),
}

/// A closed polygon.
pub(super) type Polygon = Vec<(Uv, Node)>;

/// The border of a face, laid out.
#[derive(Debug, Clone, Default)]
pub(super) struct Layout {
    /// Outer ones counter-clockwise, holes clockwise.
    pub(super) polygons: Vec<Polygon>,
    /// Positions of the face's own vertices.
    pub(super) own: Vec<Point3>,
    /// Steps of the parameters within which chords are fine.
    pub(super) steps: Uv,
}

/// A loop unrolled: it ends `turns` periods from where it begins.
#[derive(Debug, Clone, Default)]
struct Strip {
    points: Polygon,
    turns: [i64; 2],
}

/// Lays out a face. `loops` run counter-clockwise about the normal of the patch's parameters; `at_pole`: distance within
/// which a point is at a pole.
pub(super) fn layout(
    patch: &Patch,
    loops: &[Vec<Corner>],
    tolerance: f64,
    at_pole: f64,
) -> Result<Layout, &'static str> {
    let raw: Vec<Vec<Uv>> = loops.iter().map(|l| parameters(patch, l)).collect();
    let (low, high) = bounds(patch, raw.iter().flatten(), true);
    let mut made = Layout { steps: patch.steps(low, high, tolerance), ..Layout::default() };
    if made.steps.iter().chain(&low).chain(&high).any(|x| !x.is_finite()) {
        return Err("its border is beyond all numbers on its surface");
    }
    let mut strips = Vec::new();
    for (corners, raw) in loops.iter().zip(&raw) {
        let poles: Vec<Option<usize>> = corners.iter().map(|c| pole_at(patch, &c.point, at_pole)).collect();
        // A loop at a pole alone, as of a vertex, bounds nothing.
        if poles.iter().any(Option::is_none) && corners.len() > 1 {
            strips.push(unroll(patch, corners, raw, &poles, &made.steps));
        }
    }
    let (turning, closed): (Vec<Strip>, Vec<Strip>) = strips.into_iter().partition(|s| s.turns != [0, 0]);
    let mut closed: Vec<Polygon> = closed.into_iter().map(|s| s.points).collect();
    for polygon in &mut closed {
        // The face lies on both sides of a seam, whatever sense a file gives to the loop: some turn that of left-handed
        // surfaces round.
        if area(polygon) < 0.0 && has_seam(patch, polygon) {
            polygon.reverse();
        }
    }
    let closes = !turning.is_empty()
        || patch.periods.iter().all(Option::is_some)
        || (patch.periods[0].is_some() && patch.poles.iter().all(Option::is_some));
    let has_outer = closed.iter().any(|p| area(p) > 0.0);
    let sum: i64 = turning.iter().map(|s| s.turns[0]).sum();
    if sum == 0 && (has_outer || !turning.is_empty()) {
        // The face ends before the poles.
        let (low, high) = bounds(patch, raw.iter().flatten(), false);
        made.steps = patch.steps(low, high, tolerance);
    }
    if turning.is_empty() && has_outer {
        let (outer, holes) = closed.into_iter().partition(|p| area(p) > 0.0);
        return place(made, patch, outer, holes);
    }
    if !closes {
        // All clockwise on a surface that does not close by itself: the senses in the file are the other way round.
        for polygon in &mut closed {
            polygon.reverse();
        }
        made.polygons = closed;
        return if made.polygons.is_empty() { Err("it has no border") } else { Ok(made) };
    }
    let outer = bands(patch, &turning, &closed, &mut made)?;
    let (more, holes): (Vec<Polygon>, Vec<Polygon>) = closed.into_iter().partition(|p| area(p) > 0.0);
    place(made, patch, outer.into_iter().chain(more).collect(), holes)
}

/// Whether a vertex is met again a period further.
fn has_seam(patch: &Patch, polygon: &Polygon) -> bool {
    let mut sorted: Vec<(Node, Uv)> = polygon.iter().map(|(uv, node)| (*node, *uv)).collect();
    sorted.sort_by(|a, b| a.0.cmp(&b.0).then(a.1[0].total_cmp(&b.1[0])).then(a.1[1].total_cmp(&b.1[1])));
    sorted.chunk_by(|a, b| a.0 == b.0).any(|same| {
        (0..2).any(|i| {
            let apart = same.iter().map(|(_, uv)| (uv[i] - same[0].1[i]).abs()).fold(0.0, f64::max);
            patch.periods[i].is_some_and(|period| apart > 0.5 * period)
        })
    })
}

fn parameters(patch: &Patch, corners: &[Corner]) -> Vec<Uv> {
    let mut hint = None;
    let mut all = Vec::with_capacity(corners.len());
    for corner in corners {
        let uv = patch.uv(&corner.point, hint);
        hint = Some(uv);
        all.push(uv);
    }
    all
}

fn pole_at(patch: &Patch, p: &Point3, at_pole: f64) -> Option<usize> {
    (0..2).find(|i| patch.poles[*i].is_some_and(|(_, pole)| (p - pole).norm() <= at_pole))
}

/// Range of the parameters of a face: of its border, of whole periods, and `with_poles` up to what closes the surface.
fn bounds<'u>(patch: &Patch, uvs: impl Iterator<Item = &'u Uv>, with_poles: bool) -> (Uv, Uv) {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for uv in uvs {
        for i in 0..2 {
            low[i] = low[i].min(uv[i]);
            high[i] = high[i].max(uv[i]);
        }
    }
    for i in 0..2 {
        if let Some(period) = patch.periods[i] {
            low[i] = low[i].min(0.0);
            high[i] = low[i] + period;
        } else if low[i] > high[i] {
            (low[i], high[i]) = (0.0, 0.0);
        }
    }
    for (v, _) in patch.poles.iter().flatten().filter(|_| with_poles) {
        low[1] = low[1].min(*v);
        high[1] = high[1].max(*v);
    }
    (low, high)
}

fn unroll(patch: &Patch, corners: &[Corner], raw: &[Uv], poles: &[Option<usize>], steps: &Uv) -> Strip {
    let n = corners.len();
    let first = poles.iter().position(Option::is_none).expect("one point is at no pole");
    let mut strip = Strip { points: vec![(raw[first], Node::Shared(corners[first].vertex))], turns: [0; 2] };
    let mut last = raw[first];
    let mut pole: Option<(usize, u32)> = None;
    for k in 1..=n {
        let i = (first + k) % n;
        if let Some(end) = poles[i] {
            pole = Some((end, corners[i].vertex));
            continue;
        }
        let mut uv = raw[i];
        for (a, period) in patch.periods.iter().enumerate() {
            if let Some(period) = period {
                uv[a] += period * ((last[a] - uv[a]) / period).round();
            }
        }
        if let Some((end, vertex)) = pole.take() {
            let turns_back = corners[(i + n - 2) % n].vertex == corners[i].vertex;
            uv[0] = last[0] + turn_at_pole(patch.periods[0], end, uv[0] - last[0], turns_back);
            pole_row(patch, &mut strip.points, [last[0], uv[0]], steps[0], (end, vertex));
        }
        if k < n {
            strip.points.push((uv, Node::Shared(corners[i].vertex)));
        } else {
            for a in 0..2 {
                let turn = patch.periods[a].map_or(0.0, |p| (uv[a] - raw[first][a]) / p);
                strip.turns[a] = turn.round() as i64;
            }
        }
        last = uv;
    }
    strip
}

/// How far the first parameter goes at a pole so that the face lies to the left: forwards at the lower one, backwards at
/// the upper one. `turns_back`: the border leaves along the edge that it came by.
fn turn_at_pole(period: Option<f64>, end: usize, change: f64, turns_back: bool) -> f64 {
    let Some(period) = period else { return change };
    let sense = if end == 0 { 1.0 } else { -1.0 };
    let turn = (sense * change).rem_euclid(period);
    let is_none = turn.min(period - turn) <= CLOSED * period;
    let turn = match (is_none, turns_back) {
        (true, true) => period,
        (true, false) => 0.0,
        _ => turn,
    };
    sense * turn
}

/// A pole as a row of points, all of them the same vertex.
fn pole_row(
    patch: &Patch,
    points: &mut Polygon,
    [from, to]: [f64; 2],
    step: f64,
    (end, vertex): (usize, u32),
) {
    let Some((v, _)) = patch.poles[end] else { return };
    let n = cells(from, to, step);
    points.extend((0..=n).map(|i| ([from + (to - from) * i as f64 / n as f64, v], Node::Shared(vertex))));
}

/// Intervals of at most `step`.
fn cells(from: f64, to: f64, step: f64) -> usize {
    const MOST: f64 = 1000.0;
    ((to - from).abs() / step).ceil().clamp(1.0, MOST) as usize
}

fn area(polygon: &Polygon) -> f64 {
    let Some(([x, y], _)) = polygon.first() else { return 0.0 };
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    sides.map(|((a, _), (b, _))| (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x)).sum::<f64>() * 0.5
}

/// Puts holes into the outer polygons, some periods away if need be.
fn place(
    mut made: Layout,
    patch: &Patch,
    outer: Vec<Polygon>,
    holes: Vec<Polygon>,
) -> Result<Layout, &'static str> {
    const FARTHEST: i32 = 3;
    let shifts = |period: Option<f64>| -> Vec<f64> {
        let mut all: Vec<i32> = if period.is_some() { (-FARTHEST..=FARTHEST).collect() } else { vec![0] };
        all.sort_by_key(|k| (k.abs(), *k));
        all.into_iter().map(|k| f64::from(k) * period.unwrap_or(0.0)).collect()
    };
    let moves: Vec<Uv> = shifts(patch.periods[0])
        .iter()
        .flat_map(|x| shifts(patch.periods[1]).into_iter().map(move |y| [*x, y]))
        .collect();
    made.polygons = outer;
    let n_outer = made.polygons.len();
    for hole in holes {
        // A hole that does not turn is a slit.
        let Some((at, _)) = hole.first().copied() else { continue };
        let fits =
            |d: &&Uv| made.polygons[..n_outer].iter().any(|p| contains(p, [at[0] + d[0], at[1] + d[1]]));
        let found = if moves.len() == 1 { moves.first() } else { moves.iter().find(fits) };
        let Some([x, y]) = found.copied() else { return Err("a hole lies outside its border") };
        made.polygons.push(hole.into_iter().map(|([u, v], node)| ([u + x, v + y], node)).collect());
    }
    Ok(made)
}

pub(super) fn contains(polygon: &Polygon, [x, y]: Uv) -> bool {
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let crossed = sides.filter(|((a, _), (b, _))| {
        (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    });
    crossed.count() % 2 == 1
}

/// The outer polygons of a face whose border goes round its surface, or that has no outer border at all.
fn bands(
    patch: &Patch,
    turning: &[Strip],
    holes: &[Polygon],
    made: &mut Layout,
) -> Result<Vec<Polygon>, &'static str> {
    if turning.iter().any(|s| s.turns[0].abs() + s.turns[1].abs() != 1) {
        return Err("its border goes round its surface in a way that is not supported");
    }
    let axis = usize::from(turning.first().is_some_and(|s| s.turns[1] != 0));
    if turning.iter().any(|s| s.turns[axis] == 0) {
        return Err("its borders go round its surface in two directions");
    }
    let Some(period) = patch.periods[axis] else { return Err("its border does not close it") };
    let plane = Rolled { patch, axis, period, steps: made.steps };
    let holes: Vec<Polygon> = holes.iter().map(|h| plane.rolled(h)).collect();
    let mut rows: Vec<(i64, Polygon)> =
        turning.iter().map(|s| (s.turns[axis], plane.rolled(&s.points))).collect();
    let pairs = match plane.other_period() {
        Some(across) if rows.is_empty() => vec![plane.whole(across, &holes, &mut made.own)],
        Some(across) => partners_around(rows, across)?,
        None => {
            rows.sort_by(|a, b| height(&a.1).total_cmp(&height(&b.1)));
            partners(rows, |end| plane.pole(end, &mut made.own))?
        }
    };
    let mut outer = Vec::new();
    for (lower, upper) in pairs {
        let polygon = plane.join(&lower, &upper, &holes, &mut made.own);
        outer.push(plane.unrolled(&polygon.ok_or("no cut joins its borders without crossing another")?));
    }
    Ok(outer)
}

fn height(row: &Polygon) -> f64 {
    row.iter().map(|(p, _)| p[1]).sum::<f64>() / row.len() as f64
}

/// Each forward row with the backward one above it; poles at the ends where one lacks.
fn partners(
    rows: Vec<(i64, Polygon)>,
    mut pole: impl FnMut(usize) -> Option<Polygon>,
) -> Result<Vec<(Polygon, Polygon)>, &'static str> {
    const OPEN: &str = "its border goes round its surface and nothing closes it";
    let mut pairs = Vec::new();
    let mut lower = None;
    if rows.first().is_none_or(|(turn, _)| *turn < 0) {
        lower = Some(pole(0).ok_or(OPEN)?);
    }
    for (turn, row) in rows {
        lower = match (lower, turn > 0) {
            (None, true) => Some(row),
            (Some(lower), false) => {
                pairs.push((lower, row));
                None
            }
            _ => return Err("its borders go round its surface in senses that do not fit"),
        };
    }
    if let Some(lower) = lower {
        pairs.push((lower, pole(1).ok_or(OPEN)?));
    }
    Ok(pairs)
}

/// The same where the other parameter comes back, too: each forward row with the next backward one.
fn partners_around(rows: Vec<(i64, Polygon)>, across: f64) -> Result<Vec<(Polygon, Polygon)>, &'static str> {
    let (forward, mut backward): (Vec<_>, Vec<_>) = rows.into_iter().partition(|(turn, _)| *turn > 0);
    if forward.len() != backward.len() {
        return Err("its borders go round its surface in senses that do not fit");
    }
    let mut pairs = Vec::new();
    for (_, lower) in forward {
        let rise = |row: &Polygon| match (height(row) - height(&lower)).rem_euclid(across) {
            rise if rise > 0.0 => rise,
            _ => across,
        };
        let nearest =
            (0..backward.len()).min_by(|a, b| rise(&backward[*a].1).total_cmp(&rise(&backward[*b].1)));
        let (_, upper) = backward.swap_remove(nearest.expect("as many backward as forward"));
        let shift = height(&lower) + rise(&upper) - height(&upper);
        let upper = upper.into_iter().map(|([x, y], node)| ([x, y + shift], node)).collect();
        pairs.push((lower, upper));
    }
    Ok(pairs)
}

/// The parameter plane turned so that the first coordinate is the one that the border goes round in.
struct Rolled<'p> {
    patch: &'p Patch,
    axis: usize,
    period: f64,
    steps: Uv,
}

impl Rolled<'_> {
    fn rolled(&self, polygon: &Polygon) -> Polygon {
        let turn = |[u, v]: Uv| if self.axis == 0 { [u, v] } else { [v, -u] };
        polygon.iter().map(|(uv, node)| (turn(*uv), *node)).collect()
    }

    fn uv(&self, [x, y]: Uv) -> Uv {
        if self.axis == 0 { [x, y] } else { [-y, x] }
    }

    fn unrolled(&self, polygon: &Polygon) -> Polygon {
        polygon.iter().map(|(p, node)| (self.uv(*p), *node)).collect()
    }

    fn step(&self, i: usize) -> f64 {
        self.steps[if self.axis == 0 { i } else { 1 - i }]
    }

    fn other_period(&self) -> Option<f64> {
        self.patch.periods[1 - self.axis]
    }

    fn own(&self, p: Uv, own: &mut Vec<Point3>) -> Node {
        own.push(self.patch.point(self.uv(p)));
        Node::Own(own.len() as u32 - 1)
    }

    /// A pole as a row round it, forwards at the lower end and backwards at the upper one.
    fn pole(&self, end: usize, own: &mut Vec<Point3>) -> Option<Polygon> {
        let (v, point) = self.patch.poles[end].filter(|_| self.axis == 0)?;
        own.push(point);
        let node = Node::Own(own.len() as u32 - 1);
        let sense = if end == 0 { 1.0 } else { -1.0 };
        let n = cells(0.0, self.period, self.step(0));
        Some((0..n).map(|i| ([sense * self.period * i as f64 / n as f64, v], node)).collect())
    }

    /// A row round a surface that closes both ways, and the same row one period above: where no hole is if that can be.
    fn whole(&self, across: f64, holes: &[Polygon], own: &mut Vec<Point3>) -> (Polygon, Polygon) {
        let mut heights: Vec<f64> = holes.iter().flatten().map(|(p, _)| p[1].rem_euclid(across)).collect();
        heights.sort_by(f64::total_cmp);
        let next = heights.iter().skip(1).copied().chain(heights.first().map(|h| h + across));
        let gaps = heights.iter().zip(next).map(|(a, b)| (b - a, 0.5 * (a + b)));
        let y = gaps.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |g| g.1);
        let n = cells(0.0, self.period, self.step(0));
        let lower: Polygon =
            (0..n).map(|i| [self.period * i as f64 / n as f64, y]).map(|p| (p, self.own(p, own))).collect();
        let upper = lower.iter().rev().map(|([x, y], node)| ([*x, y + across], *node)).collect();
        (lower, upper)
    }

    /// The polygon between two rows, cut where the cut meets nothing else.
    fn join(
        &self,
        lower: &Polygon,
        upper: &Polygon,
        holes: &[Polygon],
        own: &mut Vec<Point3>,
    ) -> Option<Polygon> {
        let (i, j, shift) = self.cut(lower, upper, holes)?;
        let (start, end) = (lower[i].0, [upper[j].0[0] + shift, upper[j].0[1]]);
        let n =
            cells(0.0, ((end[0] - start[0]) / self.step(0)).hypot((end[1] - start[1]) / self.step(1)), 1.0);
        let between: Polygon = (1..n)
            .map(|k| k as f64 / n as f64)
            .map(|s| [start[0] + (end[0] - start[0]) * s, start[1] + (end[1] - start[1]) * s])
            .map(|p| (p, self.own(p, own)))
            .collect();
        let moved = |(p, node): &(Uv, Node), x: f64| ([p[0] + x, p[1]], *node);
        let period = self.period;
        let mut polygon: Polygon = lower[i..].to_vec();
        polygon.extend(lower[..=i].iter().map(|p| moved(p, period)));
        polygon.extend(between.iter().map(|p| moved(p, period)));
        polygon.extend(upper[j..].iter().map(|p| moved(p, shift + period)));
        polygon.extend(upper[..=j].iter().map(|p| moved(p, shift)));
        polygon.extend(between.iter().rev());
        Some(polygon)
    }

    /// Ends of a cut, as indices, and how far the upper row moves: the straightest that crosses nothing.
    fn cut(&self, lower: &Polygon, upper: &Polygon, holes: &[Polygon]) -> Option<(usize, usize, f64)> {
        /// Ends tried on the lower row.
        const TRIED: usize = 192;
        let stride = lower.len().div_ceil(TRIED);
        let mut tried: Vec<(f64, usize, usize, f64)> = Vec::new();
        for (i, (p, _)) in lower.iter().enumerate().step_by(stride) {
            let aside = |q: &Uv| {
                let shift = ((p[0] - q[0]) / self.period).round() * self.period;
                ((q[0] + shift - p[0]).abs(), shift)
            };
            let near =
                (0..upper.len()).map(|j| (aside(&upper[j].0), j)).min_by(|a, b| a.0.0.total_cmp(&b.0.0));
            let ((aside, shift), j) = near?;
            tried.push((aside, i, j, shift));
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let obstacles = self.obstacles(lower, upper, holes);
        let is_clear = |(_, i, j, shift): &&(f64, usize, usize, f64)| {
            let (a, b) = (lower[*i].0, [upper[*j].0[0] + shift, upper[*j].0[1]]);
            let copies = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| k * self.period);
            !obstacles
                .iter()
                .any(|(p, q)| copies.iter().any(|x| meet([a, b], [[p[0] + x, p[1]], [q[0] + x, q[1]]])))
        };
        tried.iter().find(is_clear).map(|(_, i, j, shift)| (*i, *j, *shift))
    }

    /// Every side of every border.
    fn obstacles(&self, lower: &Polygon, upper: &Polygon, holes: &[Polygon]) -> Vec<(Uv, Uv)> {
        let mut sides = Vec::new();
        for (row, turn) in [(lower, self.period), (upper, -self.period)] {
            sides.extend(row.windows(2).map(|w| (w[0].0, w[1].0)));
            let (first, last) = (row[0].0, row[row.len() - 1].0);
            sides.push((last, [first[0] + turn, first[1]]));
        }
        for hole in holes {
            sides.extend(hole.iter().zip(hole.iter().cycle().skip(1)).map(|(a, b)| (a.0, b.0)));
        }
        sides
    }
}

/// Whether two segments meet anywhere but in a common end.
fn meet([a, b]: [Uv; 2], [p, q]: [Uv; 2]) -> bool {
    /// Relative difference of parameters up to which two corners are one: they were computed from one point.
    const ROUNDING: f64 = 1e-12;
    let same = |x: &Uv, y: &Uv| {
        let scale = x.iter().chain(y).fold(0.0_f64, |m, t| m.max(t.abs()));
        (0..2).all(|i| (x[i] - y[i]).abs() <= ROUNDING * scale)
    };
    if [&p, &q].iter().any(|e| same(e, &a) || same(e, &b)) {
        return false;
    }
    let side = |o: &Uv, d: &Uv, x: &Uv| (d[0] - o[0]) * (x[1] - o[1]) - (d[1] - o[1]) * (x[0] - o[0]);
    let (s, t) = (side(&a, &b, &p), side(&a, &b, &q));
    let (v, w) = (side(&p, &q, &a), side(&p, &q, &b));
    s * t <= 0.0 && v * w <= 0.0 && !(s == 0.0 && t == 0.0)
}
