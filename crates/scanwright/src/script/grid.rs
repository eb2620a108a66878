//! Space cut by what the faces of a solid leave on one sweep: cells of the profile's plane times ranges of the motion,
//! each asked by samples how much of it is material.

use super::arrangement::{Arrangement, Cell, is_inside};
use super::body::Body;
use super::curve::Curve;
use super::feature::{Feature, Sign};
use super::min_cut::Labelling;
use super::sweep::{Motion, Point2, Sweep};
use super::trace::{Level, Trace, Traces};
use crate::math::Point3;
use crate::par;
use crate::random::Rng;
use crate::tolerance::Tolerances;

/// Curves of one grid, the largest faces first: cells grow with their square.
const MOST_CURVES: usize = 48;
/// Levels of one grid.
const MOST_LEVELS: usize = 30;
/// Blocks of one grid.
const MOST_BLOCKS: usize = 8000;
/// Share of the body's size that the rectangle of a profile goes beyond it.
const MARGIN: f64 = 0.05;

/// A cell over one range of the motion.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub(super) volume: f64,
    pub(super) samples: Vec<Point3>,
    /// One per sample: whether it is in the material.
    pub(super) inside: Vec<bool>,
    /// One per sample: whether the model's body holds it.
    there: Vec<bool>,
    /// One per sample: whether a hole of the model holds it.
    drilled: Vec<bool>,
}

impl Block {
    /// Share of the samples that the model's body holds or a hole will take.
    fn share_there(&self) -> f64 {
        let n = self.there.iter().zip(&self.drilled).filter(|(t, d)| **t || **d).count();
        n as f64 / self.there.len().max(1) as f64
    }

    /// Share of the samples in the material.
    pub(super) fn fill(&self) -> f64 {
        self.inside.iter().filter(|i| **i).count() as f64 / self.inside.len().max(1) as f64
    }
}

/// See the module.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    pub(super) sweep: Sweep,
    pub(super) traces: Vec<Trace>,
    pub(super) levels: Vec<Level>,
    pub(super) plane: Arrangement,
    /// Ranges of the motion; one whole turn where `is_whole`.
    pub(super) slabs: Vec<(f64, f64)>,
    /// Whether the only slab is a whole turn.
    pub(super) is_whole: bool,
    /// `cell * n_slabs + slab`.
    pub(super) blocks: Vec<Block>,
    /// `side * n_slabs + slab`: share of a side's sweep that faces of its curves lie on.
    pub(super) walls: Vec<f64>,
    /// `cell * (n_slabs + 1) + level`: share of a cell that faces lie on where the slab begins.
    pub(super) floors: Vec<f64>,
}

/// A labelling of the blocks and what it is worth.
#[derive(Debug, Clone)]
pub(super) struct Choice {
    /// One per block.
    pub(super) is_in: Vec<bool>,
    /// Volume set right less `wrong` times the volume set wrong.
    pub(super) gain: f64,
    /// Share of its border that is no face and does not lie on what is there already.
    pub(super) open: f64,
}

/// Two blocks with a common border.
#[derive(Debug, Clone, Copy)]
pub(super) struct Border {
    pub(super) blocks: [usize; 2],
    pub(super) area: f64,
    /// How much of it is no face.
    pub(super) open: f64,
}

impl Grid {
    /// `whole_turn`: levels are not used, a profile goes all the way round. `None` when nothing is kept by the motion.
    pub(super) fn new(
        body: &Body,
        sweep: Sweep,
        whole_turn: bool,
        tolerance: f64,
        seed: u64,
    ) -> Option<Self> {
        let Traces { mut curves, mut levels } = Traces::new(body, &sweep, tolerance);
        if !curves.iter().any(|c| !c.faces.is_empty()) {
            return None;
        }
        curves.truncate(MOST_CURVES);
        let (low, high, range) = extent(body, &sweep);
        let is_whole = sweep.motion == Motion::Around && (whole_turn || levels.is_empty());
        if is_whole {
            levels.clear();
        }
        if levels.len() > MOST_LEVELS {
            levels.retain(|l| !l.faces.is_empty());
            levels.truncate(MOST_LEVELS);
        }
        let slabs = slabs(&sweep, &mut levels, range, tolerance);
        let plane = cut_plane(&mut curves, (low, high), MOST_BLOCKS / slabs.len(), tolerance)?;
        let mut grid = Self {
            sweep,
            traces: curves,
            levels,
            plane,
            slabs,
            is_whole,
            blocks: Vec::new(),
            walls: Vec::new(),
            floors: Vec::new(),
        };
        grid.fill(body, seed);
        grid.back(body, tolerance);
        Some(grid)
    }

    /// Samples every block.
    fn fill(&mut self, body: &Body, seed: u64) {
        let n_slabs = self.slabs.len();
        let volumes: Vec<f64> = (0..self.plane.cells.len() * n_slabs)
            .map(|b| {
                let cell = &self.plane.cells[b / n_slabs];
                let (from, to) = self.slabs[b % n_slabs];
                cell.area * (to - from) * self.sweep.density(&centroid(cell))
            })
            .collect();
        let total: f64 = volumes.iter().sum();
        self.blocks = par::map_indices(volumes.len(), |b| {
            /// Samples of the smallest block, and how many more a block gets that is everything.
            const FEWEST: f64 = 24.0;
            const SHARED: f64 = 4000.0;
            const MOST: usize = 300;
            let n = ((FEWEST + SHARED * volumes[b] / total) as usize).min(MOST);
            let mut rng = Rng::for_task(seed, "script-blocks", b as u64);
            let cell = &self.plane.cells[b / n_slabs];
            let (from, to) = self.slabs[b % n_slabs];
            let samples: Vec<Point3> = points_in(cell, n, &mut rng, |p| self.sweep.density(p))
                .iter()
                .map(|p| self.sweep.point(p, from + (to - from) * rng.uniform()))
                .collect();
            let inside = samples.iter().map(|p| body.contains(p)).collect();
            let none = vec![false; samples.len()];
            Block { volume: volumes[b], samples, inside, there: none.clone(), drilled: none }
        });
    }

    /// Finds which walls and floors of the blocks are faces.
    fn back(&mut self, body: &Body, tolerance: f64) {
        /// Samples along a side and along the motion.
        const ALONG: usize = 4;
        let n_slabs = self.slabs.len();
        let near = 2.0 * tolerance;
        let on = |p: &Point3, faces: &[usize]| {
            let (face, distance) = body.nearest_face(p);
            distance <= near && faces.contains(&(face.0 as usize))
        };
        self.walls = par::map_indices(self.plane.sides.len() * n_slabs, |i| {
            let (side, slab) = (i / n_slabs, i % n_slabs);
            let s = &self.plane.sides[side];
            let faces: Vec<usize> = s
                .curves
                .iter()
                .filter(|c| **c < self.traces.len())
                .flat_map(|c| self.traces[*c].faces.iter().copied())
                .collect();
            if faces.is_empty() || self.is_same_on_both_sides(side, slab) {
                return 0.0;
            }
            let curve = &self.plane.curves[s.curve];
            let (from, to) = self.slabs[slab];
            let share = |k: usize| (k as f64 + 0.5) / ALONG as f64;
            let hits = (0..ALONG * ALONG).filter(|k| {
                let at = curve.at(s.range.0 + (s.range.1 - s.range.0) * share(k / ALONG));
                on(&self.sweep.point(&at, from + (to - from) * share(k % ALONG)), &faces)
            });
            hits.count() as f64 / (ALONG * ALONG) as f64
        });
        let n_floors = n_slabs + 1;
        self.floors = par::map_indices(self.plane.cells.len() * n_floors, |i| {
            let (cell, floor) = (i / n_floors, i % n_floors);
            let at = self.floor(floor);
            let Some(level) = self.level_at(at) else { return 0.0 };
            if level.faces.is_empty() {
                return 0.0;
            }
            let samples = &self.blocks[cell * n_slabs + floor.min(n_slabs - 1)].samples;
            let samples = &samples[..samples.len().min(ALONG * ALONG)];
            let hits = samples.iter().filter(|p| {
                let (profile, _) = self.sweep.coordinates(p);
                on(&self.sweep.point(&profile, at), &level.faces)
            });
            hits.count() as f64 / samples.len().max(1) as f64
        });
    }

    /// Where a slab begins; where the last one ends.
    fn floor(&self, floor: usize) -> f64 {
        if floor < self.slabs.len() { self.slabs[floor].0 } else { self.slabs[floor - 1].1 }
    }

    /// The level at a place of the motion.
    pub(super) fn level_at(&self, at: f64) -> Option<&Level> {
        let tau = std::f64::consts::TAU;
        let is_at = |level: &&Level| match self.sweep.motion {
            Motion::Along => level.at == at,
            Motion::Around => {
                let off = (level.at - at).rem_euclid(tau);
                off.min(tau - off) < Tolerances::SAME
            }
        };
        self.levels.iter().find(is_at)
    }

    fn is_same_on_both_sides(&self, side: usize, slab: usize) -> bool {
        let fills = self.plane.sides[side].cells.map(|c| c.map_or(0.0, |c| self.block(c, slab).fill()));
        fills == [0.0, 0.0] || fills == [1.0, 1.0]
    }

    pub(super) fn block(&self, cell: usize, slab: usize) -> &Block {
        &self.blocks[cell * self.slabs.len() + slab]
    }

    /// Takes note of a feature of the body.
    pub(super) fn note(&mut self, feature: &Feature) {
        self.each_held(feature, |block, i| block.there[i] = feature.sign == Sign::Add);
    }

    /// Takes note of a hole: within it, it does not matter what the body is.
    pub(super) fn note_hole(&mut self, hole: &Feature) {
        self.each_held(hole, |block, i| block.drilled[i] = true);
    }

    fn each_held(&mut self, feature: &Feature, change: impl Fn(&mut Block, usize)) {
        for block in &mut self.blocks {
            for i in 0..block.samples.len() {
                if feature.contains(&block.samples[i]) {
                    change(block, i);
                }
            }
        }
    }

    /// What any choice of blocks can set right at most.
    pub(super) fn most(&self, sign: Sign, wrong: f64) -> f64 {
        self.worth(sign, wrong).iter().map(|w| w.0.max(0.0)).sum()
    }

    /// One per block: what it sets right less what it sets wrong; how much of it does not matter.
    fn worth(&self, sign: Sign, wrong_counts: f64) -> Vec<(f64, f64)> {
        par::map(&self.blocks, |block| {
            let n = block.samples.len().max(1) as f64;
            let (mut right, mut wrong, mut open) = (0.0, 0.0, 0.0);
            for i in 0..block.samples.len() {
                let inside = block.inside[i];
                let is_open = !inside && block.drilled[i];
                match (sign, inside, block.there[i]) {
                    (_, false, there) if is_open => {
                        open += f64::from(u8::from(there != (sign == Sign::Add)));
                    }
                    (Sign::Add, true, false) | (Sign::Cut, false, true) => right += 1.0,
                    (Sign::Add, false, false) | (Sign::Cut, true, true) => wrong += 1.0,
                    _ => {}
                }
            }
            ((right - wrong_counts * wrong) * block.volume / n, open * block.volume / n)
        })
    }

    /// The blocks that a feature of a sign should be made of, given what there is.
    pub(super) fn choose(&self, sign: Sign, wrong: f64, tolerance: f64) -> Choice {
        /// Share of an open block that counts as gained, so that bodies are whole where holes are drilled.
        const OPEN: f64 = 0.05;
        let bonus = if sign == Sign::Add { OPEN } else { -OPEN };
        let worth: Vec<(f64, f64)> =
            self.worth(sign, wrong).into_iter().map(|w| (w.0, w.1 * bonus)).collect();
        // A thickness of half the tolerance is worth as much as the wall that it needs.
        let scale = 1.0 / (0.5 * tolerance);
        let total: f64 = self.blocks.iter().map(|b| b.volume).sum::<f64>() * scale;
        let gains = worth.iter().map(|w| (w.0 + w.1) * scale / total).collect();
        let borders = self.borders();
        let pairs = borders.iter().map(|b| (b.blocks[0], b.blocks[1], b.open / total)).collect();
        let is_in = Labelling { gains, pairs }.solve();
        let gain = worth.iter().zip(&is_in).filter(|w| *w.1).map(|w| w.0.0).sum();
        let (mut open, mut area) = (0.0, f64::MIN_POSITIVE);
        for border in &borders {
            let [a, b] = border.blocks;
            if is_in[a] != is_in[b] {
                let outside = &self.blocks[if is_in[a] { b } else { a }];
                area += border.area;
                open += border.open * (1.0 - outside.share_there());
            }
        }
        Choice { is_in, gain, open: open / area }
    }

    /// Neighbouring blocks.
    pub(super) fn borders(&self) -> Vec<Border> {
        let n_slabs = self.slabs.len();
        let mut borders = Vec::new();
        for (s, side) in self.plane.sides.iter().enumerate() {
            let [Some(a), Some(b)] = side.cells else { continue };
            let density = self.sweep.density(&self.plane.middle(s));
            for (slab, (from, to)) in self.slabs.iter().enumerate() {
                let area = self.plane.length(s) * (to - from) * density;
                let open = area * (1.0 - self.walls[s * n_slabs + slab]);
                borders.push(Border { blocks: [a, b].map(|c| c * n_slabs + slab), area, open });
            }
        }
        let wraps = self.sweep.motion == Motion::Around && !self.is_whole;
        for (c, cell) in self.plane.cells.iter().enumerate() {
            for slab in 1..n_slabs + usize::from(wraps) {
                let area = cell.area;
                let open = area * (1.0 - self.floors[c * (n_slabs + 1) + slab]);
                borders.push(Border {
                    blocks: [slab - 1, slab % n_slabs].map(|s| c * n_slabs + s),
                    area,
                    open,
                });
            }
        }
        borders
    }

    /// The features that a labelling stands for.
    pub(super) fn features(&self, is_in: &[bool], sign: Sign) -> Vec<Feature> {
        super::outline::features(self, is_in, sign)
    }
}

/// The plane cut along `curves`, of which the last, that bound least, are left out while there are more than `most` cells.
fn cut_plane(
    curves: &mut Vec<Trace>,
    (low, high): (Point2, Point2),
    most: usize,
    tolerance: f64,
) -> Option<Arrangement> {
    /// Shares of the tolerance that are tried: where points that are merged leave no consistent cells, fewer are.
    const SHARES: [f64; 4] = [1.0, 0.3, 0.1, 0.01];
    /// Fewer curves than that bound nothing.
    const FEWEST: usize = 3;
    while curves.len() >= FEWEST {
        let shapes: Vec<Curve> = curves.iter().map(|c| c.curve).collect();
        let cut = SHARES.iter().find_map(|share| Arrangement::new(&shapes, low, high, share * tolerance));
        match cut {
            Some(plane) if plane.cells.len() <= most => return Some(plane),
            _ => curves.truncate(curves.len() * 3 / 4),
        }
    }
    None
}

/// Corners of the profile's rectangle and the range of the motion that hold the whole body.
fn extent(body: &Body, sweep: &Sweep) -> (Point2, Point2, (f64, f64)) {
    let margin = MARGIN * (body.bounds.1 - body.bounds.0).norm();
    let (mut low, mut high) = (Point2::repeat(f64::INFINITY), Point2::repeat(f64::NEG_INFINITY));
    let mut range = (f64::INFINITY, f64::NEG_INFINITY);
    for p in &body.tessellation.mesh.vertices {
        let (profile, moved) = sweep.coordinates(p);
        low = low.inf(&profile);
        high = high.sup(&profile);
        range = (range.0.min(moved), range.1.max(moved));
    }
    low -= Point2::repeat(margin);
    high += Point2::repeat(margin);
    if sweep.motion == Motion::Around {
        low.x = 0.0;
    }
    (low, high, range)
}

/// Ranges between levels; levels are added where the body ends.
fn slabs(sweep: &Sweep, levels: &mut Vec<Level>, range: (f64, f64), tolerance: f64) -> Vec<(f64, f64)> {
    let tau = std::f64::consts::TAU;
    if sweep.motion == Motion::Around {
        if levels.is_empty() {
            return vec![(0.0, tau)];
        }
        levels.sort_by(|a, b| a.at.total_cmp(&b.at));
        let next = levels[1..].iter().map(|l| l.at).chain([levels[0].at + tau]);
        return levels.iter().map(|l| l.at).zip(next).collect();
    }
    for end in [range.0, range.1] {
        if levels.iter().all(|l| (l.at - end).abs() > tolerance) {
            levels.push(Level { at: end, faces: Vec::new() });
        }
    }
    levels.sort_by(|a, b| a.at.total_cmp(&b.at));
    levels.windows(2).map(|w| (w[0].at, w[1].at)).collect()
}

/// Centroid of a cell's polygon.
fn centroid(cell: &Cell) -> Point2 {
    let base = cell.polygon[0];
    let mut sum = Point2::zeros();
    for (i, a) in cell.polygon.iter().enumerate() {
        let b = cell.polygon[(i + 1) % cell.polygon.len()];
        sum += (a + b - base * 2.0) * (super::curve::cross(&(a - base), &(b - base)) / 6.0);
    }
    base + sum / cell.area
}

/// Random points of a cell, as dense as `density`.
fn points_in(cell: &Cell, n: usize, rng: &mut Rng, density: impl Fn(&Point2) -> f64) -> Vec<Point2> {
    /// Tries per point: a thin crescent fills little of its box.
    const TRIES: usize = 60;
    let first = cell.polygon[0];
    let (low, high) = cell.polygon.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
    let densest = density(&high).max(density(&low)).max(f64::MIN_POSITIVE);
    let mut points = Vec::with_capacity(n);
    for _ in 0..n * TRIES {
        if points.len() == n {
            break;
        }
        let p =
            Point2::new(low.x + (high.x - low.x) * rng.uniform(), low.y + (high.y - low.y) * rng.uniform());
        if rng.uniform() * densest <= density(&p) && is_inside([cell.polygon.as_slice()], &p) {
            points.push(p);
        }
    }
    points
}
