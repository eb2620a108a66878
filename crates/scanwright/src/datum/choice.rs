//! Datums chosen by how much of a part they are.

use super::{Datum, Mirror, PARALLEL, mirrors};
use crate::math::{Axis, UnitVec3, Vec3};
use crate::surface::{Plane, Surface};

/// A surface that may become a datum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The surface.
    pub datum: Datum,
    /// How much of it was seen.
    pub area: f64,
}

/// Datums that were chosen: places in the list of candidates.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Gives z: the largest plane, or the main axis of a turned part.
    pub level: usize,
    /// Stops the turn about z.
    pub rotate: Option<usize>,
    /// What fixes the origin, in order.
    pub zero: Vec<usize>,
    /// Planes that the part is symmetric about and the origin lies in, instead of on a side.
    pub mirrors: Vec<Mirror>,
    /// Whether the level is an axis.
    pub turned: bool,
}

impl Plan {
    /// All datums, the most important first, none twice.
    pub fn order(&self) -> Vec<usize> {
        let mut order = vec![self.level];
        for k in self.rotate.into_iter().chain(self.zero.iter().copied()) {
            if !order.contains(&k) {
                order.push(k);
            }
        }
        order
    }
}

/// Share of the area about one axis from which a part is a turned one.
const TURNED: f64 = 0.5;

/// Chooses datums among surfaces. `tolerance`: length within which a mirrored surface is another one; without one no
/// symmetry is looked for. `None` when there is neither plane nor axis.
pub fn choose(candidates: &[Candidate], tolerance: Option<f64>) -> Option<Plan> {
    let total: f64 = candidates.iter().map(|c| c.area).sum();
    let largest = |fits: &dyn Fn(&Candidate) -> bool| {
        let all = candidates.iter().enumerate().filter(|(_, c)| fits(c));
        // The first of equals.
        all.rev().max_by(|a, b| a.1.area.total_cmp(&b.1.area)).map(|(k, _)| k)
    };
    let is_plane = |c: &Candidate| matches!(c.datum.surface, Surface::Plane(_));
    let has_axis = |c: &Candidate| c.datum.line().is_some();
    let axis = largest(&has_axis);
    let about = |k: usize| -> f64 {
        let main = candidates[k].datum.line().expect("chosen among those with an axis");
        candidates.iter().filter(|c| is_about(c, &main)).map(|c| c.area).sum()
    };
    let main = (0..candidates.len())
        .filter(|&k| has_axis(&candidates[k]))
        .max_by(|&a, &b| about(a).total_cmp(&about(b)).then(b.cmp(&a)));
    let turned = main.filter(|&k| about(k) > TURNED * total);
    let level = turned.or_else(|| largest(&is_plane)).or(axis)?;
    let z = candidates[level].datum.direction()?;
    let along = |c: &Candidate| c.datum.direction().is_some_and(|d| d.cross(&z).norm() < PARALLEL);
    let across = |c: &Candidate| c.datum.direction().is_some_and(|d| d.dot(&z).abs() < PARALLEL);
    let line = candidates[level].datum.line();
    let off_axis = |c: &Candidate| {
        let center = c.datum.line().filter(|_| along(c)).map(|l| l.origin);
        line.zip(center).is_some_and(|(l, p)| l.radial(&p).norm() > PARALLEL * c.area.sqrt())
    };
    // What stops the turn: a plane that stands upright, else an axis across, else a way to another axis.
    let rotate = largest(&|c| is_plane(c) && across(c))
        .or_else(|| largest(&|c| has_axis(c) && across(c)))
        .or_else(|| largest(&off_axis))
        .or_else(|| largest(&|c| turned.is_none() && has_axis(c) && along(c)));
    let mut zero = vec![level];
    zero.extend(turned.and_then(|_| largest(&|c| is_plane(c) && along(c))));
    zero.extend(rotate);
    let x = rotate.and_then(|k| candidates[k].datum.direction());
    let third = largest(&|c| {
        let apart = |d: UnitVec3| x.is_some_and(|x| z.cross(&x).dot(&d).abs() > 1.0 - PARALLEL);
        is_plane(c) && c.datum.direction().is_some_and(apart)
    });
    // A bore that stands on the level plane fixes both ways in it.
    zero.extend(third.or_else(|| largest(&|c| has_axis(c) && along(c))));
    let mirrors = tolerance.map_or_else(Vec::new, |tolerance| mirrors(candidates, &z, x.as_ref(), tolerance));
    Some(Plan { level, rotate, zero, mirrors, turned: turned.is_some() })
}

/// Whether a surface turns about an axis: its own is the same.
fn is_about(candidate: &Candidate, main: &Axis) -> bool {
    let own = candidate.datum.surface.axis();
    own.is_some_and(|axis| {
        // Within a tenth of its own size.
        let near = main.radial(&axis.origin).norm() < 0.1 * candidate.area.sqrt();
        axis.direction.cross(&main.direction).norm() < PARALLEL && near
    })
}

impl Mirror {
    /// The mirror as a datum that fixes a place.
    pub fn datum(&self) -> Datum {
        let surface = Surface::Plane(Plane { point: self.point, normal: self.normal });
        Datum { surface, outward: true, center: self.point }
    }

    /// Its normal.
    pub fn direction(&self) -> Vec3 {
        self.normal.into_inner()
    }
}
