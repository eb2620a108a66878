//! One face seen in several pieces is one region.
//!
//! A bore seen from both mouths, a wall cut by a shadow: pieces of one surface that face each other across a hole of
//! the scan. Two regions become one when their borders that face each other are borders of the scan, not edges to
//! other faces, when one surface describes both as well as their own do, and when that surface continues between them
//! where material may end: not through the air of a bore that crosses it. Planes must also touch the same border
//! loop: coplanar pads are separate faces.

use super::field::{Field, Scratch};
use super::grow::{BORDER_RINGS, MIN_INTERIOR};
use crate::fit::{Fit, Samples, refine};
use crate::math::stats;
use crate::mesh::{Mesh, winding_number};
use crate::par;
use crate::recognize::{COST_CAP, is_as_good, mean_cost};
use crate::surface::{Surface, SurfaceKind};

/// Share of a piece's border that the scan must have left open: less is a scratch, not an end.
const MIN_OPEN_SHARE: f64 = 0.25;
/// Samples per piece in a test.
const N_TEST: usize = 200;
/// Border vertices per piece that are asked what they face.
const N_FACING: usize = 400;
/// Share of the borders facing each other that the scan must have left open.
const MIN_OPEN: f64 = 0.6;

/// The region that each region belongs to (itself, or the lowest of its union), and that region's surface.
pub(super) fn unions(
    mesh: &Mesh,
    field: &Field,
    of_vertex: &[Option<u32>],
    fits: &[Option<Fit>],
    members: &[Vec<u32>],
) -> (Vec<usize>, Vec<Option<Fit>>) {
    let loops = border_loops(field);
    let pieces: Vec<Piece> =
        par::map_indices(fits.len(), |k| Piece::new(field, fits[k], &members[k], &loops));
    let mut root: Vec<usize> = (0..fits.len()).collect();
    let mut fits = fits.to_vec();
    let pairs: Vec<(usize, usize)> = (0..pieces.len())
        .flat_map(|a| (a + 1..pieces.len()).map(move |b| (a, b)))
        .filter(|&(a, b)| pieces[a].may_join(&pieces[b]))
        .collect();
    let joint = par::map(&pairs, |&(a, b)| joint(field, &pieces[a], &pieces[b]));
    for ((a, b), fit) in pairs.into_iter().zip(joint) {
        let Some(fit) = fit else { continue };
        // What each piece shows the other.
        let sides = [(a, faced(field, &pieces[b], &pieces[a])), (b, faced(field, &pieces[a], &pieces[b]))];
        let ends = |(k, faced): &(usize, Vec<u32>)| {
            !is_open(field, faced) || ends_at_a_face(field, &fits, of_vertex, *k as u32, faced)
        };
        if sides.iter().any(ends) || !may_continue(mesh, field, &fit, &pieces[a], &sides[1].1) {
            continue;
        }
        let (a, b) = (find(&root, a), find(&root, b));
        if a != b {
            root[a.max(b)] = a.min(b);
            fits[a.min(b)] = Some(fit);
        }
    }
    ((0..root.len()).map(|k| find(&root, k)).collect(), fits)
}

fn find(root: &[usize], mut k: usize) -> usize {
    while root[k] != k {
        k = root[k];
    }
    k
}

/// A region with what joining needs.
struct Piece {
    fit: Option<Fit>,
    loops: Vec<u32>,
    /// Vertices next to another region or to nothing, thinned to [`N_FACING`].
    border: Vec<u32>,
    open_share: f64,
    n: usize,
    samples: Samples,
    mean_cost: f64,
}

impl Piece {
    fn new(field: &Field, fit: Option<Fit>, members: &[u32], loops: &[u32]) -> Self {
        let open: Vec<u32> = members.iter().copied().filter(|&v| field.on_boundary[v as usize]).collect();
        let mut touched: Vec<u32> = open.iter().map(|&v| loops[v as usize]).collect();
        touched.sort_unstable();
        touched.dedup();
        let mut scratch = Scratch::new(field.n_vertices());
        let depths = field.depths(members, 1, false, &mut scratch);
        let outermost = |(&v, depth): (&u32, u8)| (depth == 0 || field.on_boundary[v as usize]).then_some(v);
        let border: Vec<u32> = members.iter().zip(depths).filter_map(outermost).collect();
        let open_share = open.len() as f64 / border.len().max(1) as f64;
        let border = border.iter().copied().step_by(border.len().div_ceil(N_FACING).max(1)).collect();
        let interior = field.eroded(members, BORDER_RINGS, MIN_INTERIOR, &mut scratch);
        let samples = field.samples(&interior, N_TEST);
        let mean_cost = fit.map_or(COST_CAP, |fit| mean_cost(&fit, &samples, &field.weights));
        Self { fit, loops: touched, border, open_share, n: members.len(), samples, mean_cost }
    }

    fn may_join(&self, other: &Self) -> bool {
        let (Some(a), Some(b)) = (self.fit, other.fit) else { return false };
        let ends = self.open_share.min(other.open_share) > MIN_OPEN_SHARE;
        let planes = a.surface.kind() == SurfaceKind::Plane || b.surface.kind() == SurfaceKind::Plane;
        let same_loop = self.loops.iter().any(|l| other.loops.contains(l));
        ends && a.outward == b.outward && (same_loop || !planes)
    }
}

/// Whether what lies beyond the border of a piece that faces another was not seen: it is the scan's.
fn is_open(field: &Field, faced: &[u32]) -> bool {
    let n_open = faced.iter().filter(|&&v| field.on_boundary[v as usize]).count();
    n_open as f64 > MIN_OPEN * faced.len() as f64
}

/// Whether the piece ends on that side where another face cuts it off, as a cross hole ends at the bore it opens into:
/// it touches that face there, and lies close to that face's surface all along, seen or not.
fn ends_at_a_face(
    field: &Field,
    fits: &[Option<Fit>],
    of_vertex: &[Option<u32>],
    piece: u32,
    faced: &[u32],
) -> bool {
    /// Share of that border that touches the other face: a corner does not end it.
    const MIN_TOUCHING: f64 = 0.2;
    let tolerance = BORDER_RINGS as f64 * field.spacing;
    let touches =
        |v: u32, k: u32| field.rings.row(v as usize).iter().any(|&u| of_vertex[u as usize] == Some(k));
    let is_cut_off_by = |k: u32| {
        let n_touching = faced.iter().filter(|&&v| touches(v, k)).count();
        let near =
            |v: &u32, fit: Fit| fit.surface.signed_distance(&field.points[*v as usize]).abs() < tolerance;
        n_touching as f64 > MIN_TOUCHING * faced.len() as f64
            && fits[k as usize].is_some_and(|fit| faced.iter().all(|v| near(v, fit)))
    };
    let mut others: Vec<u32> = faced
        .iter()
        .flat_map(|&v| field.rings.row(v as usize))
        .filter_map(|&u| of_vertex[u as usize].filter(|&k| k != piece))
        .collect();
    others.sort_unstable();
    others.dedup();
    others.into_iter().any(is_cut_off_by)
}

/// Whether the joint surface may go on between the pieces: half way there the mesh winds neither like air nor like
/// material. Deep in a bore it winds like material, as little of what surrounds the place is missing. `faced`: the border
/// of the other piece that faces this one.
fn may_continue(mesh: &Mesh, field: &Field, fit: &Fit, piece: &Piece, faced: &[u32]) -> bool {
    const N_PLACES: usize = 12;
    const LIKE_AIR: f64 = 0.2;
    const LIKE_MATERIAL: f64 = 0.8;
    let is_bore = !fit.outward && matches!(fit.surface.kind(), SurfaceKind::Cylinder | SurfaceKind::Cone);
    let surface_windings = LIKE_AIR..if is_bore { f64::INFINITY } else { LIKE_MATERIAL };
    let stride = faced.len().div_ceil(N_PLACES).max(1);
    let mut windings: Vec<f64> = faced
        .iter()
        .step_by(stride)
        .filter_map(|&v| {
            let across = nearest(field, v, &piece.border)?;
            let middle = nalgebra::center(&field.points[v as usize], &field.points[across as usize]);
            Some(winding_number(mesh, &fit.surface.project(&middle)))
        })
        .collect();
    stats::median(&mut windings).is_some_and(|w| surface_windings.contains(&w))
}

/// Border vertices of `to` that are nearest to some border vertex of `from`, ascending.
fn faced(field: &Field, from: &Piece, to: &Piece) -> Vec<u32> {
    let mut faced: Vec<u32> = from.border.iter().filter_map(|&v| nearest(field, v, &to.border)).collect();
    faced.sort_unstable();
    faced.dedup();
    faced
}

fn nearest(field: &Field, v: u32, others: &[u32]) -> Option<u32> {
    let distance = |u: u32| (field.points[u as usize] - field.points[v as usize]).norm_squared();
    others.iter().copied().min_by(|&x, &y| distance(x).total_cmp(&distance(y)))
}

/// The surface of both pieces, if there is one.
fn joint(field: &Field, a: &Piece, b: &Piece) -> Option<Fit> {
    let (large, small) = if a.n >= b.n { (a, b) } else { (b, a) };
    let start = large.fit?;
    // Hopeless pairs are most of them: the large piece's surface must come near the small one, or be much like its.
    let reach = large.fit.map_or(f64::MAX, |fit| mean_cost(&fit, &small.samples, &field.weights));
    let back = small.fit.map_or(f64::MAX, |fit| mean_cost(&fit, &large.samples, &field.weights));
    if reach.min(back) > 0.8 * COST_CAP
        && !small.fit.is_some_and(|fit| are_alike(&start.surface, &fit.surface))
    {
        return None;
    }
    let both = large.samples.followed_by(&small.samples);
    let fit = refine(&start, &both, &field.weights, 20)?;
    let as_good =
        |piece: &Piece| is_as_good(mean_cost(&fit, &piece.samples, &field.weights), piece.mean_cost);
    (as_good(large) && as_good(small)).then_some(fit)
}

/// Whether two cylinders are so much alike that short pieces of one, far apart, might have given both.
fn are_alike(a: &Surface, b: &Surface) -> bool {
    /// Radians, and ratio of radii: by far more than cylinders that are one differ; the joint fit decides.
    const MAX_ANGLE: f64 = 0.15;
    const MAX_RATIO: f64 = 1.25;
    let (Surface::Cylinder(a), Surface::Cylinder(b)) = (a, b) else { return false };
    let sine = a.axis.direction.cross(&b.axis.direction).norm();
    sine < MAX_ANGLE.sin() && a.radius.max(b.radius) < MAX_RATIO * a.radius.min(b.radius)
}

/// One per vertex: its connected piece of the scan's border; `u32::MAX` inside.
fn border_loops(field: &Field) -> Vec<u32> {
    let mut loops = vec![u32::MAX; field.n_vertices()];
    let mut n_loops = 0;
    for start in 0..field.n_vertices() {
        if !field.on_boundary[start] || loops[start] != u32::MAX {
            continue;
        }
        loops[start] = n_loops;
        let mut stack = vec![start as u32];
        while let Some(v) = stack.pop() {
            for &u in field.rings.row(v as usize) {
                if field.on_boundary[u as usize] && loops[u as usize] == u32::MAX {
                    loops[u as usize] = n_loops;
                    stack.push(u);
                }
            }
        }
        n_loops += 1;
    }
    loops
}
