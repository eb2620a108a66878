//! A profile as a chain of straight lines and arcs, its corners sharp or rounded, and what a scanner's spot makes of it.
//!
//! The spot blurs the signed distance; on a straight piece that changes nothing, near a corner the distance is averaged
//! over the spot. The chain is fitted to the means of a profile by damped Gauss-Newton steps with that model, so that a
//! line two spacings wide, all of it rounded, still has its place and direction.

use nalgebra::{DMatrix, DVector, Vector2};

use super::profile::{Mean, foot};
use crate::math::blur::{SPOT_REACH, averaged_distance};

/// A straight line: points with `normal . x = offset`, the normal out of the material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// Direction of the normal, radians, from the radial direction towards that of the axis.
    pub angle: f64,
    pub offset: f64,
}

impl Line {
    pub fn normal(&self) -> Vector2<f64> {
        Vector2::new(self.angle.cos(), self.angle.sin())
    }

    /// The line with its normal at `angle`, through the mean that is nearest to it.
    pub fn turned_to(&self, angle: f64, means: &[Mean]) -> Self {
        let off = |m: &Mean| (self.normal().dot(&m.at) - self.offset).abs() - m.normal.dot(&self.normal());
        let nearest = means.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        let turned = Self { angle, offset: 0.0 };
        Self { offset: nearest.map_or(self.offset, |m| turned.normal().dot(&m.at)), ..turned }
    }

    fn meets(&self, other: &Self) -> Option<Vector2<f64>> {
        /// Sine of the angle below which lines have no corner.
        const LEAST: f64 = 0.05;
        let (a, b) = (self.normal(), other.normal());
        let sine = a.perp(&b);
        (sine.abs() > LEAST).then(|| {
            Vector2::new(self.offset * b.y - other.offset * a.y, other.offset * a.x - self.offset * b.x)
                / sine
        })
    }
}

/// A circular arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    pub center: Vector2<f64>,
    pub radius: f64,
    /// Whether the material is on the side of the centre.
    pub convex: bool,
}

/// One piece of a profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Piece {
    Line(Line),
    Arc(Arc),
}

impl Piece {
    /// Normal out of the material at a place beside the piece.
    pub fn normal(&self, at: &Vector2<f64>) -> Vector2<f64> {
        match self {
            Self::Line(line) => line.normal(),
            Self::Arc(arc) => {
                let from = at - arc.center;
                from * (if arc.convex { 1.0 } else { -1.0 } / from.norm().max(f64::MIN_POSITIVE))
            }
        }
    }

    /// Signed distance, positive outside the material.
    pub fn distance(&self, at: &Vector2<f64>) -> f64 {
        match self {
            Self::Line(line) => line.normal().dot(at) - line.offset,
            Self::Arc(arc) => ((at - arc.center).norm() - arc.radius) * if arc.convex { 1.0 } else { -1.0 },
        }
    }

    fn n_parameters(&self) -> usize {
        match self {
            Self::Line(_) => 2,
            Self::Arc(_) => 3,
        }
    }

    /// Where two pieces meet, near `hint`; where they only just miss each other, between them.
    fn meets(&self, other: &Self, hint: &Vector2<f64>) -> Option<Vector2<f64>> {
        /// Of the radius: nearer centres have no direction between them, for rounding makes it.
        const CONCENTRIC: f64 = 1e-9;
        match (self, other) {
            (Self::Line(a), Self::Line(b)) => a.meets(b),
            (Self::Line(line), Self::Arc(arc)) | (Self::Arc(arc), Self::Line(line)) => {
                let normal = line.normal();
                let height = normal.dot(&arc.center) - line.offset;
                let foot = arc.center - normal * height;
                let half = arc.radius * arc.radius - height * height;
                nearest_of(
                    foot,
                    Vector2::new(-normal.y, normal.x),
                    half,
                    hint,
                    height.abs() - arc.radius,
                    arc,
                )
            }
            (Self::Arc(a), Self::Arc(b)) => {
                let apart = b.center - a.center;
                let length = apart.norm();
                if length < CONCENTRIC * a.radius {
                    return None;
                }
                let along = (length * length + a.radius * a.radius - b.radius * b.radius) / (2.0 * length);
                let foot = a.center + apart * (along / length);
                let half = a.radius * a.radius - along * along;
                let across = Vector2::new(-apart.y, apart.x) / length;
                nearest_of(foot, across, half, hint, along.abs() - a.radius, a)
            }
        }
    }
}

/// `foot` moved by the root of `half_sq` to the side of `hint`; where that is negative, the foot itself if the arc is
/// missed by little.
fn nearest_of(
    foot: Vector2<f64>,
    across: Vector2<f64>,
    half_sq: f64,
    hint: &Vector2<f64>,
    missed: f64,
    arc: &Arc,
) -> Option<Vector2<f64>> {
    /// Of the radius.
    const LITTLE: f64 = 0.3;
    if half_sq <= 0.0 {
        return (missed < LITTLE * arc.radius).then(|| {
            let from = foot - arc.center;
            arc.center + from * (arc.radius / from.norm().max(f64::MIN_POSITIVE))
        });
    }
    let side = if (hint - foot).dot(&across) < 0.0 { -1.0 } else { 1.0 };
    Some(foot + across * (side * half_sq.sqrt()))
}

/// Pieces in the order of the profile, and the radius at each corner between two lines, zero where it is sharp.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chain {
    pub pieces: Vec<Piece>,
    /// One per corner: about where it is.
    pub hints: Vec<Vector2<f64>>,
    pub radii: Vec<f64>,
    /// Whether the profile has the material on its right.
    pub material_right: bool,
    /// Whether the first and the last piece are known and stay.
    pub known: [bool; 2],
}

/// A part of the chain: which piece, or which rounded corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Element {
    Piece(usize),
    Corner(usize),
}

/// The chain as straight segments.
#[derive(Debug, Clone)]
pub(super) struct Outline {
    /// Ends of the segments.
    points: Vec<Vector2<f64>>,
    /// One per segment.
    elements: Vec<Element>,
    normals: Vec<Vector2<f64>>,
}

/// Deviations of a chain.
#[derive(Debug, Clone, Copy)]
pub(super) struct Misfit {
    /// Squared deviations of the means in units of their noise, and the price of the parameters.
    pub cost: f64,
    /// Root mean square deviation in units of one vertex's noise.
    pub systematic: f64,
}

impl Misfit {
    /// That of no description at all.
    pub const NOTHING: Self = Self { cost: f64::INFINITY, systematic: f64::INFINITY };
}

/// A chain with its deviations.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub chain: Chain,
    pub misfit: Misfit,
}

/// Noise of one vertex, the spot, the vertex spacing.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    pub sigma: f64,
    pub blur: f64,
    pub spacing: f64,
}

/// Spacings by which the first and the last line go on beyond the profile.
pub(super) const BEYOND: f64 = 8.0;
/// Price of a parameter: the Bayesian criterion's for some fifty samples.
pub(super) const PRICE: f64 = 4.0;
/// Deviations beyond this many sigmas are outliers.
const CLIP: f64 = 5.0;

impl Chain {
    /// Corner `k`, between pieces `k` and `k + 1`.
    pub fn corner(&self, k: usize) -> Option<Vector2<f64>> {
        self.pieces[k].meets(&self.pieces[k + 1], &self.hints[k])
    }

    /// Along the profile where its normal is `normal`.
    fn along(&self, normal: Vector2<f64>) -> Vector2<f64> {
        if self.material_right {
            Vector2::new(normal.y, -normal.x)
        } else {
            Vector2::new(-normal.y, normal.x)
        }
    }

    fn normals_at(&self, k: usize, corner: &Vector2<f64>) -> [Vector2<f64>; 2] {
        [self.pieces[k].normal(corner), self.pieces[k + 1].normal(corner)]
    }

    /// Whether corner `k` stands out of the material.
    pub fn is_convex(&self, k: usize, corner: &Vector2<f64>) -> bool {
        let [a, b] = self.normals_at(k, corner);
        let turn = a.perp(&b);
        if self.material_right { turn < 0.0 } else { turn > 0.0 }
    }

    /// The arc that rounds corner `k`.
    pub fn rounding(&self, k: usize) -> Option<Arc> {
        let corner = self.corner(k)?;
        let convex = self.is_convex(k, &corner);
        let [a, b] = self.normals_at(k, &corner);
        let bisector = a + b;
        let inward = if convex { -1.0 } else { 1.0 };
        let center = corner + bisector / bisector.norm_squared() * (2.0 * inward * self.radii[k]);
        Some(Arc { center, radius: self.radii[k], convex })
    }

    /// The chain between the extents of `means`; `None` where it folds.
    pub fn outline(&self, means: &[Mean], spacing: f64) -> Option<Outline> {
        let n = self.pieces.len();
        let end = |k: usize, mean: &Mean, sign: f64| {
            let piece = &self.pieces[k];
            let normal = piece.normal(&mean.at);
            let foot = mean.at - normal * piece.distance(&mean.at);
            match piece {
                Piece::Line(_) => foot + self.along(normal) * (sign * BEYOND * spacing),
                Piece::Arc(_) => foot,
            }
        };
        let mut outline =
            Outline { points: vec![end(0, means.first()?, -1.0)], elements: Vec::new(), normals: Vec::new() };
        for k in 0..n {
            let next = if k + 1 < n { self.corner(k)? } else { end(k, means.last()?, 1.0) };
            let rounded = (k + 1 < n && self.radii[k] > 0.0).then(|| self.rounding(k)).flatten();
            let next = match rounded {
                // The contact with this piece; both pieces beside a rounded corner are lines.
                Some(arc) => {
                    let normal = self.pieces[k].normal(&next);
                    arc.center + normal * if arc.convex { arc.radius } else { -arc.radius }
                }
                None => next,
            };
            match self.pieces[k] {
                Piece::Line(line) => {
                    if (next - outline.points.last()?).dot(&self.along(line.normal())) <= 0.0 {
                        return None;
                    }
                    outline.points.push(next);
                    outline.elements.push(Element::Piece(k));
                    outline.normals.push(line.normal());
                }
                Piece::Arc(arc) => self.go_round(&mut outline, &arc, next, Element::Piece(k))?,
            }
            if let Some(arc) = rounded {
                let normal = self.pieces[k + 1].normal(&next);
                let contact = arc.center + normal * if arc.convex { arc.radius } else { -arc.radius };
                self.go_round(&mut outline, &arc, contact, Element::Corner(k))?;
            }
        }
        Some(outline)
    }

    /// Adds chords of `arc` from where the outline is to `to`.
    fn go_round(&self, outline: &mut Outline, arc: &Arc, to: Vector2<f64>, element: Element) -> Option<()> {
        /// Largest turn of a chord, and of an arc, radians.
        const CHORD: f64 = 0.25;
        const MOST: f64 = 5.0;
        let angle = |p: &Vector2<f64>| (p.y - arc.center.y).atan2(p.x - arc.center.x);
        let from = angle(outline.points.last()?);
        let sign = if self.material_right == arc.convex { -1.0 } else { 1.0 };
        let sweep = (sign * (angle(&to) - from)).rem_euclid(std::f64::consts::TAU);
        if sweep > MOST {
            return None;
        }
        let n = (sweep / CHORD).ceil().max(1.0) as usize;
        let side = if arc.convex { 1.0 } else { -1.0 };
        let radial = |share: f64| {
            let (sin, cos) = (from + sign * sweep * share).sin_cos();
            Vector2::new(cos, sin)
        };
        for chord in 1..=n {
            let share = chord as f64 / n as f64;
            outline.points.push(arc.center + radial(share) * arc.radius);
            outline.elements.push(element);
            outline.normals.push(radial(share - 0.5 / n as f64) * side);
        }
        Some(())
    }

    /// Places of the free pieces.
    fn free(&self) -> Vec<usize> {
        let last = self.pieces.len() - 1;
        (0..=last).filter(|&k| !(k == 0 && self.known[0] || k == last && self.known[1])).collect()
    }

    fn parameters(&self) -> DVector<f64> {
        let mut x = Vec::new();
        for k in self.free() {
            match self.pieces[k] {
                Piece::Line(line) => x.extend([line.angle, line.offset]),
                Piece::Arc(arc) => x.extend([arc.center.x, arc.center.y, arc.radius]),
            }
        }
        x.extend(self.radii.iter().copied().filter(|r| *r > 0.0));
        DVector::from_vec(x)
    }

    fn with_parameters(&self, parameters: &DVector<f64>) -> Self {
        let mut chain = self.clone();
        let mut next = parameters.iter().copied();
        let mut take = || next.next().unwrap_or_default();
        for k in self.free() {
            match &mut chain.pieces[k] {
                Piece::Line(line) => (line.angle, line.offset) = (take(), take()),
                Piece::Arc(arc) => {
                    arc.center = Vector2::new(take(), take());
                    arc.radius = take().max(0.1 * arc.radius);
                }
            }
        }
        for radius in chain.radii.iter_mut().filter(|r| **r > 0.0) {
            *radius = take().max(0.1 * *radius);
        }
        for k in 0..chain.hints.len() {
            if let Some(corner) = chain.corner(k) {
                chain.hints[k] = corner;
            }
        }
        chain
    }

    /// Fits the free pieces and radii to the means. `fixed_angles`: lines whose direction stays.
    pub fn fitted(&self, means: &[Mean], scale: &Scale, fixed_angles: &[usize]) -> Option<Fitted> {
        const STEPS: usize = 12;
        /// First damping, as a share of the information, and the gain in cost from which a step is the last.
        const DAMPING: f64 = 1e-2;
        const DONE: f64 = 1e-3;
        /// Information on parameters that the means do not show, so that these stay; costs are of the order of one.
        const UNSHOWN: f64 = 1e-9;
        let mut frozen = Vec::new();
        let mut place = 0;
        for k in self.free() {
            if fixed_angles.contains(&k) {
                frozen.push(place);
            }
            place += self.pieces[k].n_parameters();
        }
        let mut x = self.parameters();
        let mut residuals = self.residuals(means, scale)?;
        let mut damping = DAMPING;
        for _ in 0..STEPS {
            if x.is_empty() {
                break;
            }
            let jacobian = self.jacobian(&x, &residuals, &frozen, means, scale);
            let normal = jacobian.transpose() * &jacobian;
            let gradient = jacobian.transpose() * &residuals;
            let mut damped = normal.clone();
            for i in 0..x.len() {
                damped[(i, i)] += damping * normal[(i, i)].max(UNSHOWN) + UNSHOWN;
            }
            let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else { break };
            let next = &x - step;
            match self.with_parameters(&next).residuals(means, scale) {
                Some(r) if r.norm_squared() < residuals.norm_squared() => {
                    let gain = residuals.norm_squared() - r.norm_squared();
                    (x, residuals, damping) = (next, r, damping * 0.3);
                    if gain < DONE {
                        break;
                    }
                }
                _ => damping *= 8.0,
            }
        }
        let chain = self.with_parameters(&x);
        // Lines are much more frequent than arcs, and an edge is rounded no more often than it is chamfered.
        let n_arcs = self.free().into_iter().filter(|&k| matches!(self.pieces[k], Piece::Arc(_))).count();
        let is_rounded_edge =
            |k: &usize| self.radii[*k] > 0.0 && self.corner(*k).is_some_and(|at| self.is_convex(*k, &at));
        let n_rounded = (0..self.radii.len()).filter(is_rounded_edge).count();
        let n_free = x.len() - frozen.len() + n_arcs + n_rounded;
        let outline = chain.outline(means, scale.spacing)?;
        let misfit = outline.held_against(means, scale, n_free);
        Some(Fitted { chain, misfit })
    }

    /// Which parameters are angles.
    fn angles(&self) -> Vec<usize> {
        let mut angles = Vec::new();
        let mut place = 0;
        for k in self.free() {
            if matches!(self.pieces[k], Piece::Line(_)) {
                angles.push(place);
            }
            place += self.pieces[k].n_parameters();
        }
        angles
    }

    fn residuals(&self, means: &[Mean], scale: &Scale) -> Option<DVector<f64>> {
        let outline = self.outline(means, scale.spacing)?;
        let of = |m: &Mean| {
            (outline.blurred(&m.at, scale.blur) / scale.sigma).clamp(-CLIP, CLIP) * m.weight.sqrt()
        };
        Some(DVector::from_iterator(means.len(), means.iter().map(of)))
    }

    fn jacobian(
        &self,
        x: &DVector<f64>,
        residuals: &DVector<f64>,
        frozen: &[usize],
        means: &[Mean],
        scale: &Scale,
    ) -> DMatrix<f64> {
        /// Of the spacing, and of a radian: differences far above rounding, far below what the spot resolves.
        const STEP: f64 = 1e-3;
        let angles = self.angles();
        let mut jacobian = DMatrix::zeros(means.len(), x.len());
        for i in (0..x.len()).filter(|i| !frozen.contains(i)) {
            let step = if angles.contains(&i) { STEP } else { STEP * scale.spacing };
            let mut moved = x.clone();
            moved[i] += step;
            if let Some(r) = self.with_parameters(&moved).residuals(means, scale) {
                jacobian.set_column(i, &((r - residuals) / step));
            }
        }
        jacobian
    }
}

impl Outline {
    /// A line through the points of a profile, each on what is taken for its surface.
    pub fn through(points: Vec<Vector2<f64>>, normals: &[Vector2<f64>]) -> Self {
        let normals = points
            .windows(2)
            .zip(normals)
            .map(|(p, n)| {
                let along = p[1] - p[0];
                let across = Vector2::new(-along.y, along.x);
                let sign = if across.dot(n) < 0.0 { -1.0 } else { 1.0 };
                across * (sign / across.norm().max(f64::MIN_POSITIVE))
            })
            .collect();
        let elements = vec![Element::Piece(0); points.len().saturating_sub(1)];
        Self { points, elements, normals }
    }

    /// The element nearest to a point, of those that are not `skipped`.
    pub fn nearest(&self, at: &Vector2<f64>, skipped: impl Fn(Element) -> bool) -> Element {
        let segments = self.points.windows(2).zip(&self.elements).filter(|(_, e)| !skipped(**e));
        let off = |p: &[Vector2<f64>]| (foot([p[0], p[1]], at).0 - at).norm_squared();
        let nearest = segments.min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
        nearest.map_or(Element::Piece(0), |(_, e)| *e)
    }

    /// Length of an element.
    pub fn length(&self, element: Element) -> f64 {
        let own = self.points.windows(2).zip(&self.elements).filter(|(_, e)| **e == element);
        own.map(|(p, _)| (p[1] - p[0]).norm()).sum()
    }

    pub fn elements(&self) -> Vec<Element> {
        let mut elements = self.elements.clone();
        elements.dedup();
        elements
    }

    /// The nearest segment, and the point's foot on it.
    fn nearest_segment(&self, at: &Vector2<f64>) -> (usize, f64, f64) {
        let mut best = (0, f64::INFINITY, 0.0);
        for (k, p) in self.points.windows(2).enumerate() {
            let (foot, t) = foot([p[0], p[1]], at);
            let distance_sq = (foot - at).norm_squared();
            if distance_sq < best.1 {
                best = (k, distance_sq, t);
            }
        }
        best
    }

    /// Signed distance, positive outside the material, and its gradient.
    fn field(&self, at: &Vector2<f64>) -> (f64, Vector2<f64>) {
        let (k, distance_sq, t) = self.nearest_segment(at);
        let normal = if t <= 0.0 && k > 0 {
            self.normals[k] + self.normals[k - 1]
        } else if t >= 1.0 && k + 1 < self.normals.len() {
            self.normals[k] + self.normals[k + 1]
        } else {
            return ((at - self.points[k]).dot(&self.normals[k]), self.normals[k]);
        };
        let foot = if t <= 0.0 { self.points[k] } else { self.points[k + 1] };
        let from = at - foot;
        let distance = distance_sq.sqrt();
        let sign = if from.dot(&normal) < 0.0 { -1.0 } else { 1.0 };
        (sign * distance, from * (sign / distance.max(f64::MIN_POSITIVE)))
    }

    /// Distance to the chain as a scanner with this spot sees it.
    fn blurred(&self, at: &Vector2<f64>, blur: f64) -> f64 {
        /// Chords hide kinks between their ends: a little farther than the spot.
        const NEAR: f64 = 1.2 * SPOT_REACH;
        let inner = &self.points[1..self.points.len().max(2) - 1];
        let is_near = inner.iter().any(|p| (p - at).norm_squared() < (NEAR * blur).powi(2));
        if blur > 0.0 && is_near { averaged_distance(at, blur, |p| self.field(p)) } else { self.field(at).0 }
    }

    /// How the outline of a chain with `n_free` parameters deviates from the means.
    pub fn held_against(&self, means: &[Mean], scale: &Scale, n_free: usize) -> Misfit {
        let (mut misfit, mut sum_sq, mut n) = (0.0, 0.0, 0.0);
        for mean in means {
            let square = (self.blurred(&mean.at, scale.blur) / scale.sigma).clamp(-CLIP, CLIP).powi(2);
            misfit += square * mean.weight;
            sum_sq += square * mean.count;
            n += mean.count;
        }
        let cost = misfit + PRICE * n_free as f64;
        Misfit { cost, systematic: (sum_sq / f64::max(n, 1.0)).sqrt() }
    }
}
