//! Mouths: loops that wind once round a cylinder or cone, where it goes on unseen.

use super::chart::turns;
use super::shell::{Hole, Shell};
use crate::math::{Axis, Frame, Point3, UnitVec3, angle_between, try_unit};
use crate::surface::{Cylinder, Plane, Surface};
use std::f64::consts::PI;

/// Where a cylinder or cone goes on unseen.
#[derive(Debug, Clone)]
pub(super) struct Mouth {
    /// The region that goes on.
    pub label: u32,
    /// Along its axis, into the unseen.
    pub direction: UnitVec3,
    /// A point of the axis.
    pub origin: Point3,
    /// Height of the rim's farthest vertex over `origin` along `direction`.
    pub depth: f64,
    /// Mean height of the rim.
    pub mean: f64,
}

/// A surface with fewer of a loop's edges does not lead it.
const LEADING: f64 = 0.4;
/// Largest angle between axis and table normal at which a bore is extended down to the table, radians.
const UPRIGHT: f64 = 0.35;

/// The mouth that `hole` is, if its leading surface is a cylinder or cone that it winds round.
pub(super) fn mouth(shell: &Shell, hole: &Hole) -> Option<Mouth> {
    let (label, share) = hole.main_label();
    if share < LEADING {
        return None;
    }
    mouth_of(shell, hole, label)
}

/// The mouth of the cylinder or cone `label` that `hole` is, if it winds round it.
fn mouth_of(shell: &Shell, hole: &Hole, label: u32) -> Option<Mouth> {
    let surface = shell.surface(label)?;
    if !matches!(surface, Surface::Cylinder(_) | Surface::Cone(_)) {
        return None;
    }
    let axis = surface.axis()?;
    let points = shell.points(&hole.rim);
    let frame = Frame::from_z(axis.origin, axis.direction);
    let locals: Vec<_> = points.iter().map(|p| frame.local(p)).collect();
    let angles: Vec<f64> = locals.iter().map(|q| q.y.atan2(q.x)).collect();
    // Seen from outside, the hole is on the left: above the rim when it runs with growing angle on a shaft.
    let sense = turns(&angles) * if shell.primitives[label as usize].outward { 1 } else { -1 };
    if sense.abs() != 1 {
        return None;
    }
    let sign = f64::from(sense);
    let direction = if sense > 0 { axis.direction } else { -axis.direction };
    let depth = locals.iter().map(|q| q.z * sign).fold(f64::MIN, f64::max);
    let mean = locals.iter().map(|q| q.z * sign).sum::<f64>() / locals.len() as f64;
    Some(Mouth { label, direction, origin: axis.origin, depth, mean })
}

impl Mouth {
    /// Whether the extension of the mouth's surface arrives at `table` (normal towards the part), and no face that was
    /// seen is in its way.
    pub fn arrives_at(&self, shell: &Shell, table: &Plane) -> bool {
        self.reaches(shell, table) && !self.is_crossed(shell, table)
    }

    /// Whether faces that were seen cross the extension most of the way round before it arrives at `table`.
    fn is_crossed(&self, shell: &Shell, table: &Plane) -> bool {
        const N_SECTORS: usize = 36;
        /// Half of them: a wall that only touches the extension is not in its way.
        const MOST: usize = N_SECTORS / 2;
        /// Spacings off the extension within which a vertex crosses it, and by which it keeps off its ends.
        const NEAR: f64 = 1.0;
        const END: f64 = 3.0;
        let Some(surface) = shell.surface(self.label) else { return false };
        let frame = Frame::from_z(self.origin, self.direction);
        let mut sectors = [false; N_SECTORS];
        for point in &shell.mesh.vertices {
            let is_between = self.height(point) > self.depth + END * shell.spacing
                && table.signed_distance(point) > END * shell.spacing;
            if is_between && surface.signed_distance(point).abs() < NEAR * shell.spacing {
                sectors[frame.sector(point, N_SECTORS)] = true;
            }
        }
        sectors.iter().filter(|s| **s).count() > MOST
    }

    /// Whether the extension of the mouth's surface crosses `table` (normal towards the part) on its way.
    fn reaches(&self, shell: &Shell, table: &Plane) -> bool {
        if angle_between(&self.direction, &-table.normal.into_inner()) > UPRIGHT {
            return false;
        }
        match shell.surface(self.label) {
            // A cone that narrows must not end above the table.
            Some(Surface::Cone(cone)) if cone.axis.direction.dot(&self.direction) < 0.0 => {
                table.signed_distance(&cone.apex()) < 0.0
            }
            _ => true,
        }
    }

    /// Height of `point` over this mouth's origin, into the unseen.
    pub fn height(&self, point: &Point3) -> f64 {
        (point - self.origin).dot(&self.direction)
    }
}

/// The two mouths of one surface that face each other with the least distance; relabels one region as the other when
/// they were found as two.
pub(super) fn facing_pair(shell: &mut Shell, holes: &[Hole]) -> Option<(usize, usize, u32)> {
    let mut mouths: Vec<Option<Mouth>> = holes.iter().map(|hole| mouth(shell, hole)).collect();
    let seen: Vec<u32> = mouths.iter().flatten().map(|m| m.label).collect();
    for (found, hole) in mouths.iter_mut().zip(holes).filter(|(found, _)| found.is_none()) {
        // A mouth that other surfaces cut into is one when its counterpart is seen.
        let mut labels = hole.distinct_labels().into_iter().filter(|label| seen.contains(label));
        *found = labels.find_map(|label| mouth_of(shell, hole, label));
    }
    let mut best: Option<(f64, usize, usize)> = None;
    for i in 0..holes.len() {
        for j in i + 1..holes.len() {
            let Some((a, b)) = mouths[i].as_ref().zip(mouths[j].as_ref()) else { continue };
            if !same_surface(shell, a.label, b.label) || a.direction.dot(&b.direction) > 0.0 {
                continue;
            }
            let there = b.origin + b.direction.into_inner() * b.mean;
            let gap = a.height(&there) - a.mean;
            if gap > 0.0 && best.is_none_or(|(least, ..)| gap < least) {
                best = Some((gap, i, j));
            }
        }
    }
    let (_, i, j) = best?;
    let (a, b) = (mouths[i].as_ref()?.label, mouths[j].as_ref()?.label);
    if a != b {
        shell.primitives[a as usize].surface = joint_cylinder(shell, a, b).map(Surface::Cylinder);
        shell.merge_regions(a, b);
    }
    Some((i, j, a))
}

/// Radii of the two ends of one bore differ by less than this, in spacings.
const SAME_RADIUS: f64 = 0.5;
/// Axes of the two ends of one bore pass each other's middle within this, in spacings, or lean off the line between
/// the middles by less than `LEAN`.
const SAME_AXIS: f64 = 0.5;
/// The direction of an end that is seen a few spacings deep is known to one or two degrees; radians.
const LEAN: f64 = 0.04;
/// Ends farther apart than this, in radii, know their common axis better from their middles than from either.
const FAR: f64 = 2.0;

fn same_surface(shell: &Shell, a: u32, b: u32) -> bool {
    if a == b {
        return true;
    }
    let outward = |label: u32| shell.primitives[label as usize].outward;
    let (Some(Surface::Cylinder(s)), Some(Surface::Cylinder(t))) = (shell.surface(a), shell.surface(b))
    else {
        return false;
    };
    let between = middle(shell, b, &t.axis) - middle(shell, a, &s.axis);
    let agrees = |axis: &Axis, other: &Axis| {
        let leans = angle_between(&axis.direction, &between);
        axis.radial(&other.origin).norm() < SAME_AXIS * shell.spacing || leans.min(PI - leans) < LEAN
    };
    outward(a) == outward(b)
        && (s.radius - t.radius).abs() < SAME_RADIUS * shell.spacing
        && s.axis.direction.cross(&t.axis.direction).norm() < 2.0 * LEAN
        && agrees(&s.axis, &t.axis)
        && agrees(&t.axis, &s.axis)
}

/// One cylinder for two ends of a bore: through both middles when they are far apart, else that of the larger end.
fn joint_cylinder(shell: &Shell, a: u32, b: u32) -> Option<Cylinder> {
    let (Surface::Cylinder(s), Surface::Cylinder(t)) = (*shell.surface(a)?, *shell.surface(b)?) else {
        return None;
    };
    let count = |label: u32| shell.labels.iter().filter(|l| **l == label).count() as f64;
    let (n, m) = (count(a), count(b));
    let radius = (n * s.radius + m * t.radius) / (n + m).max(1.0);
    let (p, q) = (middle(shell, a, &s.axis), middle(shell, b, &t.axis));
    let larger = if n < m { t.axis } else { s.axis };
    let direction = try_unit(q - p).filter(|_| (q - p).norm() > FAR * radius);
    let axis = direction.map_or(larger, |direction| {
        let sense = if direction.dot(&s.axis.direction) < 0.0 { -direction } else { direction };
        Axis { origin: nalgebra::center(&p, &q), direction: sense }
    });
    Some(Cylinder { axis, radius })
}

/// The point of the axis at the mean height of the region's triangles.
fn middle(shell: &Shell, label: u32, axis: &Axis) -> Point3 {
    let mine = (0..shell.labels.len()).filter(|&t| shell.labels[t] == label);
    let (sum, n) = mine.fold((0.0, 0.0), |(sum, n): (f64, f64), t| {
        (sum + axis.height(&shell.mesh.triangle_center(t)), n + 1.0)
    });
    axis.origin + axis.direction.into_inner() * (sum / n.max(1.0))
}
