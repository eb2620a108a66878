//! Fillets between faces that stand.
//!
//! A fillet a few vertices wide has no interior to type: its middle rows read as a chamfer and its outer rows go to
//! the faces beside it. But once those faces are known it has one free parameter, the radius of a ball that rolls
//! along both, and what the scanner makes of it is known too (`section`). Every strip between two faces, and every
//! edge, is asked whether a sharp corner, a chamfer or a fillet describes it best (`evidence`); a fillet becomes the
//! cylinder or torus that is tangent to both faces (`rolling_ball`) and takes the vertices between its contacts. So do
//! chamfers of edges where no region shows them, as a plane or cone that takes what is nearest to it.

mod evidence;
mod rolling_ball;
mod section;

use evidence::Edge;
use rolling_ball::Sweep;
use section::{Corner, Place};

use super::field::{Field, Scratch};
use super::finish::Regions;
use super::grow::{BORDER_RINGS, MIN_INTERIOR};
use super::primitive;
use crate::fit::{Fit, refine};
use crate::math::Point3;
use crate::mesh::connected;
use crate::par;
use crate::recognize::{COST_CAP, Primitive};

/// A fillet that was put in, or a chamfer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fillet {
    /// Its own.
    pub region: u32,
    /// The regions that it lies between; a fillet is tangent to them.
    sides: [u32; 2],
    convex: bool,
    /// Whether it is a chamfer.
    pub flat: bool,
}

impl Fillet {
    /// The surface between its sides as finally fitted, with the radius or depth that the scan shows then; `None` when
    /// they have none any more.
    pub fn primitive(
        &self,
        field: &Field,
        primitives: &[Primitive],
        members: &[Vec<u32>],
    ) -> Option<Primitive> {
        let [a, b] = self.sides.map(|k| primitives[k as usize].fit());
        let (a, b) = (a?, b?);
        let mine = &members[self.region as usize];
        let places = places(field, &a, &b, self.convex, mine)?;
        let sweep = Sweep::of(&a.surface, &b.surface, field.spacing)?;
        let edge = Edge::new(field, &places);
        let corner = if self.flat { edge.chamfer() } else { edge.fillet(field.limits.min_radius) }.corner;
        let fit = sweep.surface(&a, &b, &corner, self.convex, &middle(field, mine, &places))?;
        Some(primitive::given(field, &fit, mine))
    }
}

/// Passes over all edges: sides are fitted again without what the first pass took from them.
const PASSES: usize = 2;
/// Rings that the widest strip may have between its middle and its border.
const STRIP_RINGS: usize = 7;
/// Share of a strip's vertices that are within those rings, and of its border that each side has.
const STRIP_SHARE: f64 = 0.95;
const SIDE_SHARE: f64 = 0.2;
/// Vertices of the shortest edge, those of both sides: ten on each.
const MIN_EDGE: usize = 20;
/// Fewer vertices are no face.
const MIN_FILLET: usize = 20;
/// Angles between faces, radians, at which a fillet is told from its sides, and at which the section is one.
const ANGLES: (f64, f64) = (0.25, 2.7);
/// Misfit by which a fillet must be better than a sharp edge.
const BETTER_THAN_SHARP: f64 = 12.0;
/// Misfit by which it may be worse than a chamfer in a concave corner: the chamfer has one parameter more (the Bayesian
/// criterion's price with about fifty samples), and corners are not filled with flats. Edges may be broken by either,
/// and the fillet must be as good.
const WORSE_THAN_CHAMFER: f64 = 4.0;
/// Arc, in spacings, below which a fillet that no strip shows must be better than a chamfer by as much.
const WIDE_ARC: f64 = 3.5;
/// Largest systematic deviation of a fillet, sigmas of one vertex.
const MAX_SYSTEMATIC: f64 = 0.8;

/// Puts fillets into the regions where the scan shows them; returns them.
pub(super) fn insert(field: &Field, regions: &mut Regions) -> Vec<Fillet> {
    let mut fillets: Vec<Fillet> = Vec::new();
    for _ in 0..PASSES {
        let candidates = candidates(field, regions);
        let mut found: Vec<Found> =
            par::map(&candidates, |c| Found::of(field, regions, c)).into_iter().flatten().collect();
        found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let mut changed = vec![false; regions.fits.len()];
        let mut is_fillet = vec![false; regions.fits.len()];
        for found in found {
            let sides = found.candidate.sides;
            let is_flat = matches!(found.corner, Corner::Chamfer { .. });
            let blocked = found.candidate.strip.is_some_and(|k| changed[k as usize])
                || sides.iter().any(|&k| is_fillet[k as usize])
                // What breaks an edge leaves no edge that is broken again.
                || is_flat && fillets.iter().any(|f| sides.contains(&f.region));
            if blocked {
                continue;
            }
            let region = found.apply(regions);
            changed.resize(regions.fits.len(), false);
            is_fillet.resize(regions.fits.len(), false);
            changed[region as usize] = true;
            is_fillet[region as usize] = true;
            for side in sides {
                changed[side as usize] = true;
            }
            fillets.retain(|f| f.region != region);
            fillets.push(Fillet { region, sides, convex: found.convex, flat: is_flat });
        }
        refit(field, regions, &changed, &is_fillet);
    }
    let members = regions.members();
    fillets.retain(|f| members[f.region as usize].len() >= MIN_FILLET);
    fillets.sort_by_key(|f| f.region);
    fillets
}

/// Fits changed regions again, fillets aside.
fn refit(field: &Field, regions: &mut Regions, changed: &[bool], is_fillet: &[bool]) {
    const STEPS: usize = 12;
    const N_SAMPLES: usize = 400;
    let members = regions.members();
    let fits = par::map_indices(regions.fits.len(), |k| {
        let fit = regions.fits[k]?;
        if !changed[k] || is_fillet[k] || members[k].is_empty() {
            return Some(fit);
        }
        let mut scratch = Scratch::new(field.n_vertices());
        let interior = field.eroded(&members[k], BORDER_RINGS, MIN_INTERIOR, &mut scratch);
        refine(&fit, &field.samples(&interior, N_SAMPLES), &field.weights, STEPS).or(Some(fit))
    });
    regions.fits = fits;
}

/// Where a fillet may be: between two sides, in place of a strip or along their common edge.
#[derive(Debug, Clone)]
struct Candidate {
    strip: Option<u32>,
    sides: [u32; 2],
    /// Vertices of the strip or of the edge.
    core: Vec<u32>,
}

impl Candidate {
    /// Vertices of the strip and its sides that may lie on the fillet or show where it ends.
    fn band(&self, field: &Field, regions: &Regions) -> Vec<u32> {
        /// Rings beside a strip, and beside an edge that the fillet itself lies across; the spot's reach is added.
        const BESIDE_STRIP: usize = 3;
        const BESIDE_EDGE: usize = 5;
        let is_part = |k: u32| Some(k) == self.strip || self.sides.contains(&k);
        let spot = (2.0 * field.blur / field.spacing).ceil() as usize;
        let reach = spot + if self.strip.is_some() { BESIDE_STRIP } else { BESIDE_EDGE };
        let around = field.dilated(&self.core, reach, &mut Scratch::new(field.n_vertices()));
        around.into_iter().filter(|&v| regions.of_vertex[v as usize].is_some_and(is_part)).collect()
    }
}

fn candidates(field: &Field, regions: &Regions) -> Vec<Candidate> {
    let members = regions.members();
    let mut found: Vec<Candidate> =
        par::map_indices(members.len(), |k| strip(field, regions, k as u32, &members[k]))
            .into_iter()
            .flatten()
            .collect();
    found.extend(edges(field, regions));
    found
}

/// The region as a strip between two others.
fn strip(field: &Field, regions: &Regions, region: u32, members: &[u32]) -> Option<Candidate> {
    let mut scratch = Scratch::new(field.n_vertices());
    let depths = field.depths(members, STRIP_RINGS, false, &mut scratch);
    let n_narrow = depths.iter().filter(|d| usize::from(**d) < STRIP_RINGS).count();
    if members.len() < MIN_FILLET || (n_narrow as f64) < STRIP_SHARE * members.len() as f64 {
        return None;
    }
    let mut around: Vec<u32> = members
        .iter()
        .flat_map(|&v| field.rings.row(v as usize))
        .filter_map(|&u| regions.of_vertex[u as usize])
        .filter(|&k| k != region)
        .collect();
    around.sort_unstable();
    let n_around = around.len();
    let mut counts: Vec<(usize, u32)> =
        around.chunk_by(|a, b| a == b).map(|run| (run.len(), run[0])).collect();
    counts.sort_by_key(|&(n, k)| (std::cmp::Reverse(n), k));
    let [(_, a), (least, b), ..] = counts[..] else { return None };
    (least as f64 >= SIDE_SHARE * n_around as f64).then(|| Candidate {
        strip: Some(region),
        sides: [a.min(b), a.max(b)],
        core: members.to_vec(),
    })
}

/// Connected edges between two regions that touch.
fn edges(field: &Field, regions: &Regions) -> Vec<Candidate> {
    let mut on_edge: Vec<([u32; 2], u32)> = Vec::new();
    for v in 0..field.n_vertices() {
        let Some(a) = regions.of_vertex[v] else { continue };
        for &u in field.rings.row(v) {
            if let Some(b) = regions.of_vertex[u as usize]
                && a != b
            {
                on_edge.push(([a.min(b), a.max(b)], v as u32));
            }
        }
    }
    on_edge.sort_unstable();
    on_edge.dedup();
    let beside = |i: u32| {
        let (sides, v) = on_edge[i as usize];
        let place = |u: &u32| on_edge.binary_search(&(sides, *u)).ok();
        field.rings.row(v as usize).iter().filter_map(place).map(|i| i as u32).collect::<Vec<_>>()
    };
    connected(on_edge.len(), |i| Some(on_edge[i as usize].0), beside)
        .into_iter()
        .filter(|(_, edge)| edge.len() >= MIN_EDGE)
        .map(|(sides, edge)| {
            let core = edge.into_iter().map(|i| on_edge[i as usize].1).collect();
            Candidate { strip: None, sides, core }
        })
        .collect()
}

/// A fillet with the vertices that it and its sides take.
#[derive(Debug)]
struct Found {
    candidate: Candidate,
    fit: Fit,
    corner: Corner,
    convex: bool,
    /// Misfit that it saves.
    gain: f64,
    /// Vertices between its contacts, and those beyond the first and the second.
    between: Vec<u32>,
    beyond: [Vec<u32>; 2],
}

impl Found {
    fn of(field: &Field, regions: &Regions, candidate: &Candidate) -> Option<Self> {
        let [a, b] = candidate.sides.map(|k| regions.fits[k as usize]);
        let (a, b) = (a?, b?);
        let sweep = Sweep::of(&a.surface, &b.surface, field.spacing)?;
        let band = candidate.band(field, regions);
        let convex = is_convex(field, &a, &b, &candidate.core);
        let places = places(field, &a, &b, convex, &band)?;
        let (corner, gain) = chosen(field, candidate, &places, convex)?;
        let fit = sweep.surface(&a, &b, &corner, convex, &middle(field, &band, &places))?;
        let (mut between, mut beyond) = (Vec::new(), [Vec::new(), Vec::new()]);
        for (&v, place) in band.iter().zip(&places) {
            match place.past_borders(&corner) {
                (x, y) if x >= 0.0 && y >= 0.0 => between.push(v),
                (x, y) if x < y => beyond[0].push(v),
                _ => beyond[1].push(v),
            }
        }
        let is_flat = matches!(corner, Corner::Chamfer { .. });
        (between.len() >= MIN_FILLET && (is_flat || explains(field, &fit, &between))).then(|| Self {
            candidate: candidate.clone(),
            fit,
            corner,
            convex,
            gain,
            between,
            beyond,
        })
    }

    /// Labels the vertices; returns the region of the fillet.
    fn apply(&self, regions: &mut Regions) -> u32 {
        let region = self.candidate.strip.unwrap_or(regions.fits.len() as u32);
        if region as usize == regions.fits.len() {
            regions.fits.push(None);
        }
        regions.fits[region as usize] = Some(self.fit);
        let is_part = |k: Option<u32>| k.is_some_and(|k| k == region || self.candidate.sides.contains(&k));
        let [a, b] = self.candidate.sides;
        for (vertices, label) in [(&self.between, region), (&self.beyond[0], a), (&self.beyond[1], b)] {
            for &v in vertices {
                let slot = &mut regions.of_vertex[v as usize];
                // Beyond its contacts only what the fillet had goes to the sides.
                let may = if label == region { is_part(*slot) } else { *slot == Some(region) };
                if may {
                    *slot = Some(label);
                }
            }
        }
        region
    }
}

/// The fillet or chamfer that describes an edge best, and the misfit that it saves; `None` when a sharp edge does, or
/// where fillet and chamfer describe an edge without a strip equally well.
fn chosen(field: &Field, candidate: &Candidate, places: &[Place], convex: bool) -> Option<(Corner, f64)> {
    let edge = Edge::new(field, places);
    let (sharp, chamfer, fillet) = (edge.sharp(), edge.chamfer(), edge.fillet(field.limits.min_radius));
    let Corner::Fillet { radius } = fillet.corner else { return None };
    let over_sharp = sharp.misfit - fillet.misfit;
    let over_chamfer = chamfer.misfit - fillet.misfit;
    let angle = places.iter().map(Place::angle).sum::<f64>() / places.len() as f64;
    let is_shown = candidate.strip.is_some() || radius * angle > WIDE_ARC * field.spacing;
    let least = match (is_shown, convex) {
        (false, _) => WORSE_THAN_CHAMFER,
        (true, false) => -WORSE_THAN_CHAMFER,
        (true, true) => 0.0,
    };
    if over_sharp >= BETTER_THAN_SHARP && over_chamfer >= least && fillet.systematic <= MAX_SYSTEMATIC {
        return Some((fillet.corner, over_sharp.min(over_chamfer)));
    }
    if !convex || candidate.strip.is_some() {
        return None;
    }
    let chamfer_over_sharp = sharp.misfit - chamfer.misfit;
    let is_chamfer = field.blur_is_measured
        && chamfer_over_sharp >= BETTER_THAN_SHARP + WORSE_THAN_CHAMFER
        && over_chamfer <= -WORSE_THAN_CHAMFER
        && chamfer.systematic <= MAX_SYSTEMATIC;
    is_chamfer.then_some((chamfer.corner, chamfer_over_sharp.min(-over_chamfer)))
}

/// Whether the part's edge is rounded off and not its corner filled.
fn is_convex(field: &Field, a: &Fit, b: &Fit, core: &[u32]) -> bool {
    let sum = |v: &u32| {
        let point = &field.points[*v as usize];
        a.distance_and_outward_normal(point).0 + b.distance_and_outward_normal(point).0
    };
    core.iter().map(sum).sum::<f64>() < 0.0
}

/// The vertices in the section of the two surfaces; `None` where they do not meet at an angle.
fn places(field: &Field, a: &Fit, b: &Fit, convex: bool, band: &[u32]) -> Option<Vec<Place>> {
    let side = if convex { 1.0 } else { -1.0 };
    let place = |&v: &u32| {
        let point = &field.points[v as usize];
        let (da, na) = a.distance_and_outward_normal(point);
        let (db, nb) = b.distance_and_outward_normal(point);
        let angle = na.dot(&nb).clamp(-1.0, 1.0).acos();
        Place::new(side * da, side * db, angle)
    };
    let places: Vec<Place> = band.iter().map(place).collect();
    places.iter().all(|p| (ANGLES.0..ANGLES.1).contains(&p.angle())).then_some(places)
}

/// A vertex as near to both surfaces as any.
fn middle(field: &Field, band: &[u32], places: &[Place]) -> Point3 {
    let nearest = band
        .iter()
        .zip(places)
        .min_by(|x, y| x.1.across().abs().total_cmp(&y.1.across().abs()).then(x.0.cmp(y.0)));
    nearest.map_or_else(Point3::origin, |(&v, _)| field.points[v as usize])
}

/// Whether the surface itself, curved along the edge as the section is not, describes its vertices.
fn explains(field: &Field, fit: &Fit, vertices: &[u32]) -> bool {
    /// Mean cost, in squares of the noise: what the section's flatness leaves out at a fillet on a small bore.
    const MAX_COST: f64 = 5.0;
    let cost = |&v: &u32| {
        let point = &field.points[v as usize];
        let seen = fit.surface.signed_distance(point)
            + 0.5 * field.blur * field.blur * fit.surface.curvature_sum(point);
        (seen / field.weights.distance_sigma).powi(2).min(COST_CAP)
    };
    vertices.iter().map(cost).sum::<f64>() < MAX_COST * vertices.len() as f64
}
