//! Holes: what is empty inside round walls that go all the way about an axis, down to what closes them.
//!
//! Holes are drilled last, so the body may be anything within them; that makes it whole where its profile is looked
//! for. A hole holds every empty cell beside such a wall, and what else is empty and saves it from ending in the open: a
//! minimum cut over the cells of the half plane beside the axis.

use super::body::Body;
use super::curve::Curve;
use super::feature::{Feature, Sign};
use super::grid::Grid;
use super::min_cut::Labelling;
use super::sweep::Point2;

/// Share of a cell that may be material although the cell is empty: samples beside its border.
const EMPTY: f64 = 0.02;

/// The holes about the axis of a grid of whole turns.
pub(super) fn holes(body: &Body, grid: &Grid) -> Vec<Feature> {
    /// Share of a side that must be wall.
    const WALL: f64 = 0.3;
    let round: Vec<bool> = grid.traces.iter().map(|t| is_wall_of_hole(body, grid, &t.faces, t)).collect();
    let n = grid.plane.cells.len();
    let borders = grid.borders();
    let total: f64 = borders.iter().map(|b| b.open).sum();
    let empty: Vec<bool> = (0..n).map(|c| grid.block(c, 0).fill() <= EMPTY).collect();
    let mut gains: Vec<f64> = empty.iter().map(|e| if *e { 0.0 } else { -2.0 }).collect();
    let mut any = false;
    for (s, side) in grid.plane.sides.iter().enumerate() {
        let is_round = side.curves.iter().any(|c| round.get(*c).copied().unwrap_or(false));
        if !is_round || grid.walls[s] < WALL {
            continue;
        }
        for cell in side.cells.into_iter().flatten() {
            if empty[cell] && is_on_axis_side(grid, s, cell) {
                gains[cell] = 2.0;
                any = true;
            }
        }
    }
    if !any {
        return Vec::new();
    }
    // What reaches the end of the rectangle ends in the open there.
    for (s, side) in grid.plane.sides.iter().enumerate() {
        let density = grid.sweep.density(&grid.plane.middle(s));
        if let [Some(cell), None] | [None, Some(cell)] = side.cells {
            gains[cell] -= grid.plane.length(s) * std::f64::consts::TAU * density / total;
        }
    }
    /// What a straight wall costs where another hole crosses it, as a share: it goes on there rather than ends twice.
    const CROSSED: f64 = 0.02;
    let is_straight = |c: &usize| {
        round.get(*c).copied().unwrap_or(false)
            && matches!(grid.plane.curves[*c], Curve::Line { direction, .. } if direction.x.abs() < 1e-3)
    };
    let runs_on = |a: usize, b: usize| {
        let border = &grid.plane.cells[a].border;
        border.iter().any(|&(side, forward)| {
            let s = &grid.plane.sides[side];
            s.cells[usize::from(forward)] == Some(b) && s.curves.iter().any(is_straight)
        })
    };
    let pairs = borders.iter().map(|border| {
        let [a, b] = border.blocks;
        let share = if runs_on(a, b) { CROSSED } else { 1.0 };
        (a, b, share * border.open / total)
    });
    let pairs = pairs.collect();
    grid.features(&Labelling { gains, pairs }.solve(), Sign::Cut)
}

/// Whether faces are a wall that looks to the axis and is seen all the way round it.
fn is_wall_of_hole(body: &Body, grid: &Grid, faces: &[usize], trace: &super::trace::Trace) -> bool {
    /// Sectors of a turn, and how many of them must be seen: a crossing hole may hide some.
    const SECTORS: usize = 24;
    const SEEN: usize = 20;
    /// Component of the wall's normal across the axis below which it is a floor.
    const STEEP: f64 = 0.1;
    let looks_inward = match trace.curve {
        Curve::Line { direction, .. } => {
            let left = -direction.y;
            let to_material = if trace.is_material_inside { left } else { -left };
            to_material > STEEP
        }
        Curve::Circle { center, .. } => center.x == 0.0 && !trace.is_material_inside,
    };
    if faces.is_empty() || !looks_inward {
        return false;
    }
    let mut seen = [false; SECTORS];
    for face in faces {
        for &t in &body.triangles[*face] {
            let corners = body.tessellation.mesh.corners(t as usize);
            let center = body.tessellation.mesh.triangle_center(t as usize);
            for p in corners.iter().map(|c| nalgebra::center(c, &center)) {
                seen[grid.sweep.frame.sector(&p, SECTORS)] = true;
            }
        }
    }
    seen.iter().filter(|s| **s).count() >= SEEN
}

/// Whether a cell lies on the side of the axis of one of its sides.
fn is_on_axis_side(grid: &Grid, side: usize, cell: usize) -> bool {
    let s = &grid.plane.sides[side];
    let curve = &grid.plane.curves[s.curve];
    let middle = grid.plane.middle(side);
    let left: Point2 = match curve {
        Curve::Line { direction, .. } => Point2::new(-direction.y, direction.x),
        // The left of a circle that is run counter-clockwise is its inside.
        Curve::Circle { center, .. } => center - middle,
    };
    (s.cells[0] == Some(cell)) == (left.x < 0.0)
}
