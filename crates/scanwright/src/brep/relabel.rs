//! Changes of labels beside a flaw that may mend it; whether they do is found by building (`mend`).

use super::attempt::{Attempt, Bench};
use super::halfedge::HalfEdges;
use super::mend::Mend;
use super::straighten;
use crate::surface::Surface;

/// Changes of labels that may mend the flaws of an attempt, the surest first, then the least.
pub(super) fn relabellings(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    let (sure, mut mends) = false_edges(bench, attempt);
    let sure = straightenings(bench, attempt).into_iter().chain(sure).chain(misplaced(bench, attempt));
    let mut patches: Vec<usize> = attempt.flaws.iter().flat_map(|f| f.patches.iter().copied()).collect();
    patches.sort_unstable();
    patches.dedup();
    let mut seen: Vec<usize> = Vec::new();
    for p in patches {
        let group = attempt.draft.group_of(p);
        if seen.contains(&group[0]) {
            continue;
        }
        seen.push(group[0]);
        mends.extend(giving_away(bench, attempt, &group));
    }
    mends.sort_by_key(|m| if let Mend::Relabel { triangles, .. } = m { triangles.len() } else { 0 });
    sure.chain(mends).collect()
}

/// The borders beside flaws whose surfaces touch, each moved to where they touch.
pub(super) fn straightenings(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    let flawed = |pair: &[u32; 2]| {
        attempt
            .flaws
            .iter()
            .any(|f| pair.iter().all(|r| f.patches.iter().any(|p| attempt.draft.patches[*p].region == *r)))
    };
    straighten::straightenings(bench, &attempt.choice.labels, &attempt.choice.demoted)
        .into_iter()
        .filter(|(pair, _)| flawed(pair))
        .map(|(_, (triangles, labels))| Mend::Relabel { triangles, labels })
        .collect()
}

/// Short edges beside flaws whose ends may be one corner: a scanner's spot hides an edge shorter than itself, and surfaces
/// that meet at a low angle put one there for a small error of theirs.
pub(super) fn sharings(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    /// In deviations of the spot: its width.
    const SPOT: f64 = 2.0;
    let draft = &attempt.draft;
    let (spacing, reach) = (bench.tolerances.spacing(), SPOT * bench.tolerances.edge_rounding());
    let mut flawed = vec![false; draft.patches.len()];
    attempt.flaws.iter().flat_map(|f| &f.patches).for_each(|p| flawed[*p] = true);
    let chains = draft.topology.chains.iter();
    let beside = chains.filter(|c| flawed[c.left as usize] || c.right.is_some_and(|r| flawed[r as usize]));
    let short =
        beside.filter(|c| draft.corners.may_be_one(c, &draft.topology, &draft.courses, spacing, reach));
    short.map(|chain| Mend::Share { ends: [chain.start(), chain.end()] }).collect()
}

/// Ways to do without the patches of one face: every triangle to the nearest of the neighbours, or all to one.
fn giving_away(bench: &Bench, attempt: &Attempt, group: &[usize]) -> Vec<Mend> {
    /// Neighbours with the longest common borders that are asked.
    const MAX_TAKERS: usize = 3;
    let draft = &attempt.draft;
    let region = draft.patches[group[0]].region;
    let triangles: Vec<u32> =
        group.iter().flat_map(|p| draft.patches[*p].triangles.iter().copied()).collect();
    let mut takers: Vec<(u32, usize)> = Vec::new();
    for t in &triangles {
        for u in bench.half_edges.neighbours(*t as usize).into_iter().flatten() {
            let other = attempt.choice.labels[u];
            if other == region {
                continue;
            }
            match takers.iter_mut().find(|taker| taker.0 == other) {
                Some(taker) => taker.1 += 1,
                None => takers.push((other, 1)),
            }
        }
    }
    takers.sort_by_key(|t| (std::cmp::Reverse(t.1), t.0));
    takers.truncate(MAX_TAKERS);
    let surfaces: Vec<(u32, Surface)> =
        takers.iter().filter_map(|(r, _)| bench.surfaces[*r as usize].map(|s| (*r, s))).collect();
    let mut mends = Vec::new();
    if surfaces.len() > 1 {
        let nearest = |t: &u32| {
            let off = surfaces.iter().map(|(r, s)| (*r, off(bench, *t, *r, s)));
            off.min_by(|a, b| a.1.total_cmp(&b.1)).expect("there are some")
        };
        let (labels, off): (Vec<u32>, Vec<f64>) = triangles.iter().map(nearest).unzip();
        if harmless(bench, off) {
            mends.push(Mend::Relabel { triangles: triangles.clone(), labels });
        }
    }
    for (taker, surface) in &surfaces {
        if harmless(bench, triangles.iter().map(|t| off(bench, *t, *taker, surface)).collect()) {
            mends.push(Mend::Relabel { triangles: triangles.clone(), labels: vec![*taker; triangles.len()] });
        }
    }
    mends
}

/// Distance of a triangle from the surface of a region; without end where it faces the other way: the two sides of a
/// thin wall are near each other and not one face.
fn off(bench: &Bench, triangle: u32, region: u32, surface: &Surface) -> f64 {
    let mesh = &bench.closed.mesh;
    let (distance, normal) = surface.distance_and_normal(&mesh.triangle_center(triangle as usize));
    let along = normal.dot(&mesh.cross(triangle as usize));
    let same_side = (along > 0.0) == bench.closed.primitives[region as usize].outward;
    if same_side { distance.abs() } else { f64::INFINITY }
}

/// Whether triangles this far from the surface that takes them are lost in what a scan rounds off.
fn harmless(bench: &Bench, mut distances: Vec<f64>) -> bool {
    /// In spacings: the rounding of an edge.
    const ROUNDED: f64 = 1.2;
    /// Share of the triangles that must be nearer.
    const MOST: f64 = 0.9;
    crate::math::stats::quantile(&mut distances, MOST)
        .is_none_or(|d| d <= ROUNDED * bench.tolerances.spacing())
}

/// Triangles that lie off the surface of their own region, beside a flaw, and nearer to that of a neighbour: what the
/// scan shows of a table through a bore, or of a wall beyond a worn edge.
pub(super) fn misplaced(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    /// In spacings: farther than the rounding of an edge.
    const OFF: f64 = 1.2;
    /// Share of that distance within which the other surface must be.
    const NEARER: f64 = 0.5;
    let labels = &attempt.choice.labels;
    let mut mends = Vec::new();
    for region in attempt.flawed_regions() {
        let Some(own) = bench.surfaces[region as usize] else { continue };
        let members: Vec<u32> = (0..labels.len() as u32).filter(|t| labels[*t as usize] == region).collect();
        let mut beside: Vec<u32> = members
            .iter()
            .flat_map(|t| bench.half_edges.neighbours(*t as usize))
            .flatten()
            .map(|u| labels[u])
            .filter(|l| *l != region)
            .collect();
        beside.sort_unstable();
        beside.dedup();
        let beside: Vec<(u32, Surface)> =
            beside.into_iter().filter_map(|r| bench.surfaces[r as usize].map(|s| (r, s))).collect();
        let (mut triangles, mut given) = (Vec::new(), Vec::new());
        for t in members {
            let center = bench.closed.mesh.triangle_center(t as usize);
            let off = own.signed_distance(&center).abs();
            let away = |s: &Surface| s.signed_distance(&center).abs();
            let nearest = beside.iter().min_by(|x, y| away(&x.1).total_cmp(&away(&y.1)));
            let Some((other, surface)) = nearest else { continue };
            if off > OFF * bench.tolerances.spacing() && away(surface) < NEARER * off {
                triangles.push(t);
                given.push(*other);
            }
        }
        if !triangles.is_empty() {
            mends.push(Mend::Relabel { triangles, labels: given });
        }
    }
    mends
}

/// Edges whose surfaces do not meet, given away.
pub(super) fn sure_false_edges(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    false_edges(bench, attempt).0
}

/// Edges of A|B that may not exist, because one face C passes between two wrong corners: a band round each goes to C.
/// First those whose surfaces do not meet, then those whose corners are wrong.
fn false_edges(bench: &Bench, attempt: &Attempt) -> (Vec<Mend>, Vec<Mend>) {
    /// Longest chain, in mesh edges, that may be turned between two faces that do not both touch its ends.
    const MAX_FLIP: usize = 10;
    /// Rings of triangles on each side of the edge that are given away.
    const RINGS: usize = 2;
    let draft = &attempt.draft;
    let region = |p: u32| draft.patches[p as usize].region;
    let at = |c: u32| -> Vec<u32> { draft.patches_at(c).into_iter().map(|p| region(p as u32)).collect() };
    let (mut sure, mut doubtful) = (Vec::new(), Vec::new());
    for (chain, course) in draft.topology.chains.iter().zip(&draft.courses) {
        let Some(right) = chain.right else { continue };
        let (a, b) = (region(chain.left), region(right));
        let ends = [chain.start(), chain.end()].map(|v| draft.corners.corner_of[v as usize]);
        let [Some(start), Some(end)] = ends else { continue };
        let residual = |c: u32| draft.corners.corners[c as usize].residual;
        let apart = a != b && course.apart(bench.tolerances.spacing()) > bench.limit;
        if !apart && residual(start).max(residual(end)) <= bench.limit {
            continue;
        }
        let (first, last) = (at(start), at(end));
        let others = |regions: &[u32]| regions.iter().copied().find(|r| *r != a && *r != b);
        let shared = first.iter().copied().find(|r| *r != a && *r != b && last.contains(r));
        let taker = if start == end || shared.is_none() {
            (chain.vertices.len() <= MAX_FLIP).then(|| others(&first).or(others(&last))).flatten()
        } else {
            shared
        };
        let Some(taker) = taker else { continue };
        let triangles = band(bench, &attempt.choice.labels, &chain.vertices, [a, b], RINGS);
        let labels = vec![taker; triangles.len()];
        if apart { &mut sure } else { &mut doubtful }.push(Mend::Relabel { triangles, labels });
    }
    (sure, doubtful)
}

/// Triangles of two regions within some rings of a run of vertices.
fn band(bench: &Bench, labels: &[u32], vertices: &[u32], regions: [u32; 2], rings: usize) -> Vec<u32> {
    let mut front: Vec<u32> = vertices.to_vec();
    let mut triangles: Vec<u32> = Vec::new();
    for _ in 0..rings {
        let around = front.iter().flat_map(|v| bench.half_edges.leaving(*v)).map(|h| HalfEdges::triangle(*h));
        triangles.extend(around.filter(|t| regions.contains(&labels[*t])).map(|t| t as u32));
        triangles.sort_unstable();
        triangles.dedup();
        front = triangles.iter().flat_map(|t| bench.closed.mesh.triangles[*t as usize]).collect();
        front.sort_unstable();
        front.dedup();
    }
    triangles
}
