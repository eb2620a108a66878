//! The chain that describes a profile best.
//!
//! The profile is cut into none, one, two ... lines between its ends by dynamic programming; each cut is fitted with the
//! spot in the model, arcs are tried in place of neighbouring lines and at corners, and lines nearly along or across the
//! axis are made so. Cost: some hundred fits of a few parameters to a few dozen means.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector2;

use super::chain::{Arc, BEYOND, Chain, Element, Fitted, Line, PRICE, Piece, Scale};
use super::profile::{Mean, has_material_right};
use crate::math::nearest_circle;

/// Lines between the ends, at most.
const MOST_LINES: usize = 5;
/// Shortest line, spacings.
const SHORTEST: f64 = 1.0;

/// The chain that describes the profile best, between the pieces known at one or both of its ends.
pub(super) fn best_chain(ends: &[Piece], means: &[Mean], scale: &Scale) -> Option<Fitted> {
    let material_right = has_material_right(means);
    let mut best: Option<Fitted> = None;
    for cut in cuts(ends, means) {
        let chain = Chain {
            radii: vec![0.0; cut.starts.len()],
            hints: cut.starts.iter().map(|&i| means[i.min(means.len() - 1)].at).collect(),
            pieces: cut.pieces,
            material_right,
            known: [true, ends.len() > 1],
        };
        let Some(fitted) = chain.fitted(means, scale, &[]).and_then(|f| refined(f, means, scale)) else {
            continue;
        };
        if best.as_ref().is_none_or(|b| fitted.misfit.cost < b.misfit.cost) {
            best = Some(fitted);
        }
    }
    best
}

/// First lines: the best cuts of the profile into none, one, two ... lines between its ends.
fn cuts(ends: &[Piece], means: &[Mean]) -> Vec<Cut> {
    let n = means.len();
    let sums = Sums::of(means);
    let first = ends[0];
    let last = ends.get(1).copied();
    let off = |piece: &Piece, m: &Mean| m.weight * piece.distance(&m.at).powi(2);
    let mut on_first = vec![0.0];
    for m in means {
        on_first.push(on_first[on_first.len() - 1] + off(&first, m));
    }
    let mut on_last = vec![0.0; n + 1];
    for i in (0..n).rev() {
        on_last[i] = on_last[i + 1] + last.map_or(f64::INFINITY, |piece| off(&piece, &means[i]));
    }
    // best[k][to]: the first end and k lines up to `to`, and where the last of them begins.
    let mut best: Vec<Vec<(f64, usize)>> = vec![on_first.iter().map(|c| (*c, 0)).collect()];
    let mut found = Vec::new();
    for k in 0..=MOST_LINES {
        if k > 0 {
            let before = &best[k - 1];
            let next = (0..=n)
                .map(|to| {
                    (k..to)
                        .map(|from| (before[from].0 + sums.residual(from, to), from))
                        .min_by(|a, b| a.0.total_cmp(&b.0))
                        .unwrap_or((f64::INFINITY, 0))
                })
                .collect();
            best.push(next);
        }
        let end =
            (1..=n).min_by(|&a, &b| (best[k][a].0 + on_last[a]).total_cmp(&(best[k][b].0 + on_last[b])));
        let Some(mut to) = (if last.is_some() { end } else { Some(n) }) else { continue };
        if last.is_none() && k == 0 {
            continue;
        }
        let mut cut = Cut { pieces: last.into_iter().collect(), starts: Vec::new() };
        if last.is_some() {
            cut.starts.push(to);
        }
        for level in (1..=k).rev() {
            let from = best[level][to].1;
            cut.pieces.push(Piece::Line(sums.line(from, to, means)));
            cut.starts.push(from);
            to = from;
        }
        cut.pieces.push(first);
        cut.pieces.reverse();
        cut.starts.reverse();
        found.push(cut);
    }
    found
}

/// A profile cut into pieces.
struct Cut {
    pieces: Vec<Piece>,
    /// Where each piece but the first begins.
    starts: Vec<usize>,
}

/// The chain with corners rounded where that pays, and lines along or across the axis where they may be; `None` where a
/// line is too short to be one.
fn refined(mut best: Fitted, means: &[Mean], scale: &Scale) -> Option<Fitted> {
    while let Some(better) = with_arc(&best, means, scale) {
        best = better;
    }
    while let Some(better) = without_one(&best, means, scale) {
        best = better;
    }
    best = rounded(best, means, scale);
    best = squared(best, means, scale);
    let outline = best.chain.outline(means, scale.spacing)?;
    let long = |e: Element| outline.length(e) >= SHORTEST * scale.spacing;
    outline.elements().into_iter().all(long).then_some(best)
}

/// The best chain with one arc in place of neighbouring pieces, if it is better.
fn with_arc(best: &Fitted, means: &[Mean], scale: &Scale) -> Option<Fitted> {
    let chain = &best.chain;
    let outline = chain.outline(means, scale.spacing)?;
    let element = |m: &Mean| match outline.nearest(&m.at, |_| false) {
        Element::Piece(k) | Element::Corner(k) => k,
    };
    let pieces: Vec<usize> = means.iter().map(element).collect();
    let n = chain.pieces.len();
    let (low, high) = (usize::from(chain.known[0]), n - usize::from(chain.known[1]));
    let mut found: Option<Fitted> = None;
    for from in low..high {
        for to in from + 2..=high {
            let range: Vec<&Mean> =
                means.iter().zip(&pieces).filter(|(_, k)| (from..to).contains(k)).map(|(m, _)| m).collect();
            let circle = nearest_circle(range.iter().map(|m| (m.weight, m.at.x, m.at.y)));
            let Some(([x, y], radius)) = circle else { continue };
            let center = Vector2::new(x, y);
            let facing: f64 = range.iter().map(|m| m.normal.dot(&(m.at - center)) * m.weight).sum();
            let arc = Piece::Arc(Arc { center, radius, convex: facing > 0.0 });
            let mut next = chain.clone();
            next.pieces.splice(from..to, [arc]);
            // Corners between the pieces that are gone.
            next.hints.drain(from..to - 1);
            next.radii.drain(from..to - 1);
            for k in [from.checked_sub(1), Some(from)].into_iter().flatten() {
                if let Some(radius) = next.radii.get_mut(k) {
                    *radius = 0.0;
                }
            }
            let Some(fitted) = next.fitted(means, scale, &[]) else { continue };
            if fitted.misfit.cost < found.as_ref().map_or(best.misfit.cost, |f| f.misfit.cost) {
                found = Some(fitted);
            }
        }
    }
    found
}

/// The best chain without one of its pieces, if it is better: lines that an arc has taken from others may be left over.
fn without_one(best: &Fitted, means: &[Mean], scale: &Scale) -> Option<Fitted> {
    let chain = &best.chain;
    let (low, high) = (usize::from(chain.known[0]), chain.pieces.len() - usize::from(chain.known[1]));
    let without = |k: usize| {
        let mut next = chain.clone();
        next.pieces.remove(k);
        // Of the two corners at a piece one goes; the other is where its neighbours meet.
        let gone = k.min(next.hints.len() - 1);
        next.hints.remove(gone);
        next.radii.remove(gone);
        if k > 0 && k < chain.hints.len() {
            next.hints[k - 1] = (chain.hints[k - 1] + chain.hints[k]) * 0.5;
            next.radii[k - 1] = 0.0;
        }
        next.fitted(means, scale, &[])
    };
    let found = (low..high).filter(|_| chain.pieces.len() > 2).filter_map(without);
    let better = found.filter(|f| f.misfit.cost < best.misfit.cost);
    better.min_by(|a, b| a.misfit.cost.total_cmp(&b.misfit.cost))
}

/// The chain with corners between lines rounded where that pays.
fn rounded(mut best: Fitted, means: &[Mean], scale: &Scale) -> Fitted {
    /// First radii, spacings.
    const RADII: [f64; 2] = [1.6, 3.2];
    for k in 0..best.chain.radii.len() {
        if !best.chain.pieces[k..k + 2].iter().all(|p| matches!(p, Piece::Line(_))) {
            continue;
        }
        for radius in RADII {
            let mut chain = best.chain.clone();
            chain.radii[k] = radius * scale.spacing;
            if let Some(rounded) = chain.fitted(means, scale, &[])
                && rounded.misfit.cost < best.misfit.cost - PRICE
                && rounded.chain.radii[k] > RADII[0] * scale.spacing
            {
                best = rounded;
            }
        }
    }
    best
}

/// Lines nearly along or across the axis made so, where they depart from it by less than a scan shows, or where that
/// costs no more than their angle does.
fn squared(mut best: Fitted, means: &[Mean], scale: &Scale) -> Fitted {
    /// Angle from which a line is a cone's whatever it costs, radians.
    const FAR: f64 = 0.2;
    /// Departure over the length of a line that says nothing, noise.
    const UNSEEN: f64 = 2.0;
    let mut fixed = Vec::new();
    for k in 0..best.chain.pieces.len() {
        let is_known =
            k == 0 && best.chain.known[0] || k + 1 == best.chain.pieces.len() && best.chain.known[1];
        let Piece::Line(line) = best.chain.pieces[k] else { continue };
        let square = (line.angle / FRAC_PI_2).round() * FRAC_PI_2;
        let tilt = (line.angle - square).abs();
        let Some(outline) = best.chain.outline(means, scale.spacing) else { continue };
        if is_known || tilt > FAR {
            continue;
        }
        // The last line goes on beyond what was seen of it.
        let is_last = k + 1 == best.chain.pieces.len();
        let length = outline.length(Element::Piece(k)) - if is_last { BEYOND * scale.spacing } else { 0.0 };
        let departure = length * tilt;
        let mut chain = best.chain.clone();
        chain.pieces[k] = Piece::Line(line.turned_to(square, means));
        fixed.push(k);
        let is_unseen = departure < UNSEEN * scale.sigma;
        match chain.fitted(means, scale, &fixed) {
            Some(other) if is_unseen || other.misfit.cost <= best.misfit.cost => best = other,
            None if is_unseen => best.chain = chain,
            _ => {
                fixed.pop();
            }
        }
    }
    best
}

/// Sums of weights and moments of all means before each.
struct Sums(Vec<[f64; 6]>);

impl Sums {
    fn of(means: &[Mean]) -> Self {
        let mut sums = vec![[0.0; 6]];
        for m in means {
            let mut next = sums[sums.len() - 1];
            let (w, x, y) = (m.weight, m.at.x, m.at.y);
            for (sum, term) in next.iter_mut().zip([w, w * x, w * y, w * x * x, w * x * y, w * y * y]) {
                *sum += term;
            }
            sums.push(next);
        }
        Self(sums)
    }

    /// Weight, centre, and second moments about it.
    fn moments(&self, from: usize, to: usize) -> (f64, Vector2<f64>, [f64; 3]) {
        let (a, b) = (&self.0[from], &self.0[to]);
        let d: Vec<f64> = b.iter().zip(a).map(|(b, a)| b - a).collect();
        let w = d[0].max(f64::MIN_POSITIVE);
        let center = Vector2::new(d[1] / w, d[2] / w);
        let second =
            [d[3] - w * center.x * center.x, d[4] - w * center.x * center.y, d[5] - w * center.y * center.y];
        (d[0], center, second)
    }

    /// Sum of squared distances to the line that fits best.
    fn residual(&self, from: usize, to: usize) -> f64 {
        if to < from + 2 {
            return 0.0;
        }
        let (_, _, [xx, xy, yy]) = self.moments(from, to);
        (0.5 * (xx + yy) - (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt()).max(0.0)
    }

    /// The line that fits best; through a single mean across its normal.
    fn line(&self, from: usize, to: usize, means: &[Mean]) -> Line {
        let range = &means[from.min(means.len() - 1)..to.clamp(from + 1, means.len())];
        let facing: Vector2<f64> = range.iter().map(|m| m.normal * m.weight).sum();
        let (_, center, [xx, xy, yy]) = self.moments(from, to);
        let normal = if range.len() < 2 {
            facing
        } else {
            let along = 0.5 * (2.0 * xy).atan2(xx - yy);
            let normal = Vector2::new(-along.sin(), along.cos());
            if normal.dot(&facing) < 0.0 { -normal } else { normal }
        };
        let normal = normal / normal.norm().max(f64::MIN_POSITIVE);
        Line { angle: normal.y.atan2(normal.x), offset: normal.dot(&center) }
    }
}
