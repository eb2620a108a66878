//! Narrow faces of turned parts, all at once.
//!
//! Chamfer, collar, groove and countersink lie side by side, each a few vertices wide and rounded by the spot as a
//! whole; one by one they are read as a cone or torus over several of them. Averaged along the turn they are a curve
//! with hardly any noise (`profile`), and between the wide faces at its two ends that curve is a chain of straight
//! lines and arcs whose corners may be rounded (`chain`). Chains of more and more lines are fitted with the spot in the
//! model (`search`); the one that describes the curve best for its number of parameters replaces the faces that were
//! there, if it describes it clearly better than they do (`run`).

mod chain;
mod generatrix;
mod pieces;
mod profile;
mod run;
mod search;

use std::cmp::Reverse;

use super::field::Field;
use super::finish::Regions;
use crate::fit::Fit;
use crate::math::{Axis, Frame, Point3, UnitVec3};
use crate::par;
use crate::surface::{Cone, Cylinder, Plane, Surface, SurfaceKind};
pub(super) use pieces::unite;
pub(super) use run::Resolved;
use run::{N_SECTORS, Run};

/// Regions of fewer vertices show no axis that others could turn about.
const MIN_AXIS_VERTICES: usize = 100;

/// Replaces runs of narrow turned faces by those that their common profile shows.
pub(super) fn resolve(field: &Field, regions: &mut Regions) {
    let mut settled = Vec::new();
    for (_, axis) in axes(field, regions, &regions.members(), |_| true) {
        let members = regions.members();
        let runs = run::runs(field, regions, &members, &axis, &settled);
        let found = par::map(&runs, |run: &Run| run.resolved(field, regions, &members));
        for (run, faces) in runs.iter().zip(found) {
            if let Some(faces) = faces {
                settled.extend(regions.replace(&run.regions, faces));
            }
        }
    }
    regions.compact();
}

/// The sectors of the turn about an axis that a region is in; `None` when it does not turn about it: its normals do not
/// point to the axis.
fn level_sectors(field: &Field, axis: &Axis, members: &[u32]) -> Option<[bool; N_SECTORS]> {
    const N_TEST: usize = 300;
    /// Component of a normal along the turn, and share of normals with less.
    const LEVEL: f64 = 0.3;
    const SHARE: f64 = 0.9;
    let frame = Frame::from_z(axis.origin, axis.direction);
    let (mut n, mut n_level, mut sectors) = (0_usize, 0_usize, [false; N_SECTORS]);
    for &v in members.iter().step_by(members.len().div_ceil(N_TEST).max(1)) {
        let radial = axis.radial(&field.points[v as usize]);
        if radial.norm() < 2.0 * field.spacing {
            continue;
        }
        let along = axis.direction.cross(&radial) / radial.norm();
        n += 1;
        n_level += usize::from(field.normals[v as usize].dot(&along).abs() < LEVEL);
        sectors[frame.sector(&field.points[v as usize], N_SECTORS)] = true;
    }
    (n > 0 && n_level as f64 > SHARE * n as f64).then_some(sectors)
}

/// The surface that a straight line leaves as it turns about an axis: through `point`, with the outward `normal` there. It
/// is a cylinder or a plane where it runs along or across the axis within `aligned` radians.
pub(super) fn turned_line(axis: &Axis, point: &Point3, normal: &UnitVec3, aligned: f64) -> Fit {
    let axis = Axis { origin: axis.foot(point), ..*axis };
    let radial = axis.radial(point);
    let outward = normal.dot(&radial) > 0.0;
    // The natural normal points away from the axis and against the growing radius.
    let sin = if outward { -normal.dot(&axis.direction) } else { normal.dot(&axis.direction) };
    let radius = radial.norm();
    let half_angle = sin.abs().atan2(normal.dot(&radial).abs() / radius.max(f64::MIN_POSITIVE));
    let surface = if half_angle < aligned {
        Surface::Cylinder(Cylinder { axis, radius })
    } else if half_angle > std::f64::consts::FRAC_PI_2 - aligned {
        return Fit { surface: Surface::Plane(Plane { point: *point, normal: *normal }), outward: true };
    } else {
        let direction = if sin < 0.0 { -axis.direction } else { axis.direction };
        Surface::Cone(Cone { axis: Axis { direction, ..axis }, radius, half_angle })
    };
    Fit { surface, outward }
}

/// The axes that regions of the wanted kinds turn about, best seen first, each once, with their regions.
pub(super) fn axes(
    field: &Field,
    regions: &Regions,
    members: &[Vec<u32>],
    is_wanted: impl Fn(SurfaceKind) -> bool,
) -> Vec<(usize, Axis)> {
    /// Sine below which two axes are parallel.
    const PARALLEL: f64 = 0.02;
    let mut turned: Vec<usize> = (0..members.len())
        .filter(|&k| members[k].len() >= MIN_AXIS_VERTICES)
        .filter(|&k| {
            regions.fits[k].is_some_and(|f| f.surface.axis().is_some() && is_wanted(f.surface.kind()))
        })
        .collect();
    turned.sort_by_key(|&k| (regions.fits[k].map(|f| f.surface.kind()), Reverse(members[k].len()), k));
    let mut axes: Vec<(usize, Axis)> = Vec::new();
    for k in turned {
        let Some(axis) = regions.fits[k].and_then(|f| f.surface.axis()) else { continue };
        let is_known = axes.iter().any(|(_, known)| {
            known.direction.cross(&axis.direction).norm() < PARALLEL
                && known.radial(&axis.origin).norm() < field.spacing
        });
        if !is_known {
            axes.push((k, axis));
        }
    }
    axes
}
