//! Groups of triangles become regions with surfaces.

use std::ops::Range;

use crate::fit::Fit;
use crate::mesh::{Adjacency, Mesh, connected};
use crate::par;
use crate::recognize::{COST_CAP, Primitive, choose};
use crate::segment::field::{Field, Scratch};
use crate::segment::grow::{ACCEPT_COST, BORDER_RINGS, MIN_INTERIOR};
use crate::segment::{RegionId, Scan, Segmentation, primitive};

/// Pieces of fewer triangles are given to a neighbour.
const MIN_PIECE: usize = 40;
/// Samples of a fit.
const N_SAMPLES: usize = 400;
/// What a region costs beside its misfit, in vertices that nothing explains.
const PRICE: f64 = 10.0;

/// Numbers of groups that are tried out.
const N_TRIED: usize = 6;

/// The numbers of groups, of those in `numbers`, with the widest gaps after them, widest first;
/// none when there are none.
pub(in crate::segment) fn widest_gaps(numbers: Range<usize>, gap: impl Fn(usize) -> f64) -> Vec<usize> {
    let mut numbers: Vec<usize> = numbers.collect();
    numbers.sort_by(|&a, &b| gap(b).total_cmp(&gap(a)).then(a.cmp(&b)));
    numbers.truncate(N_TRIED);
    numbers
}

/// The regions of that number of groups, of those `tried`, which surfaces describe best. `groups`: the group of every
/// triangle for a number.
pub(in crate::segment) fn best_described(
    scan: &Scan,
    tried: &[usize],
    groups: impl Fn(usize) -> Vec<u32> + Sync + Send,
) -> Segmentation {
    let segmented = par::map(tried, |&k| of_groups(scan, &groups(k)));
    let best = segmented.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, regions)| regions.segmentation(scan.field)).unwrap_or_default()
}

/// Regions of the triangles, each with its surface.
struct Regions {
    /// One per triangle.
    labels: Vec<u32>,
    /// One per region: its vertices, and its surface; none where no type fits.
    members: Vec<Vec<u32>>,
    fits: Vec<Option<Fit>>,
}

/// The connected pieces of groups of triangles, small ones given to their neighbours; and what they cost: how badly the
/// best surfaces describe them, and a price per region.
fn of_groups(scan: &Scan, groups: &[u32]) -> (f64, Regions) {
    let Scan { mesh, adjacency, field, .. } = *scan;
    let labels = without_specks(adjacency, pieces(adjacency, groups));
    let n = labels.iter().max().map_or(0, |last| *last as usize + 1);
    let members = members(mesh, &labels, n);
    let chosen = par::map(&members, |vertices| {
        let mut scratch = Scratch::new(field.n_vertices());
        let interior = field.eroded(vertices, BORDER_RINGS, MIN_INTERIOR, &mut scratch);
        let samples = field.samples(&interior, N_SAMPLES);
        choose(&samples, interior.len(), &field.weights, &field.limits, None)
    });
    let cost = chosen.iter().zip(&members).map(|(choice, vertices)| {
        let mean = choice.as_ref().map_or(COST_CAP, |c| c.mean_cost);
        mean * vertices.len() as f64 + PRICE * COST_CAP
    });
    let cost = cost.sum();
    let fits = chosen.iter().map(|c| c.filter(|c| c.mean_cost < ACCEPT_COST).map(|c| c.fit)).collect();
    (cost, Regions { labels, members, fits })
}

impl Regions {
    /// The regions with their primitives.
    fn segmentation(self, field: &Field) -> Segmentation {
        let mut region_of = vec![None; field.n_vertices()];
        for (k, vertices) in self.members.iter().enumerate() {
            for &v in vertices {
                region_of[v as usize] = Some(k);
            }
        }
        let primitives = par::map_indices(self.fits.len(), |k| {
            let fit_of = |v: u32| region_of[v as usize].and_then(|k: usize| self.fits[k]);
            self.fits[k].map_or_else(Primitive::freeform, |fit| {
                primitive::fitted(field, &fit, &self.members[k], fit_of)
            })
        });
        Segmentation { labels: self.labels.iter().map(|k| Some(RegionId(*k))).collect(), primitives }
    }
}

/// The connected pieces of equal labels, numbered by their first triangles.
fn pieces(adjacency: &Adjacency, groups: &[u32]) -> Vec<u32> {
    let across = |t: u32| adjacency.across[t as usize].into_iter().flatten().collect::<Vec<_>>();
    let mut pieces = vec![0; groups.len()];
    for (k, (_, members)) in
        connected(groups.len(), |t| Some(groups[t as usize]), across).into_iter().enumerate()
    {
        for t in members {
            pieces[t as usize] = k as u32;
        }
    }
    pieces
}

/// Labels without pieces of few triangles, smallest first: each goes to the neighbour with the longest common border.
fn without_specks(adjacency: &Adjacency, mut labels: Vec<u32>) -> Vec<u32> {
    loop {
        let n = labels.iter().max().map_or(0, |last| *last as usize + 1);
        let mut counts = vec![0_usize; n];
        for label in &labels {
            counts[*label as usize] += 1;
        }
        // One neighbour per speck; specks beside specks may take several rounds.
        let mut votes: Vec<Vec<(u32, usize)>> = vec![Vec::new(); n];
        for (t, across) in adjacency.across.iter().enumerate() {
            let own = labels[t];
            if counts[own as usize] >= MIN_PIECE {
                continue;
            }
            for u in across.iter().flatten() {
                let other = labels[*u as usize];
                // Only towards what is larger, so that two specks do not change places.
                let is_larger = (counts[other as usize], other) > (counts[own as usize], own);
                if other != own && is_larger {
                    match votes[own as usize].iter_mut().find(|v| v.0 == other) {
                        Some(vote) => vote.1 += 1,
                        None => votes[own as usize].push((other, 1)),
                    }
                }
            }
        }
        let into: Vec<u32> = (0..n as u32)
            .map(|k| {
                votes[k as usize].iter().max_by_key(|v| (v.1, std::cmp::Reverse(v.0))).map_or(k, |v| v.0)
            })
            .collect();
        if into.iter().enumerate().all(|(k, other)| k as u32 == *other) {
            return numbered(labels);
        }
        // Towards what is larger there are no cycles: each speck goes where the one it goes to has gone.
        for label in &mut labels {
            while into[*label as usize] != *label {
                *label = into[*label as usize];
            }
        }
    }
}

/// Labels numbered anew in the order of their first triangles.
fn numbered(labels: Vec<u32>) -> Vec<u32> {
    let n = labels.iter().max().map_or(0, |last| *last as usize + 1);
    let mut number = vec![u32::MAX; n];
    let mut next = 0;
    labels
        .into_iter()
        .map(|label| {
            let slot = &mut number[label as usize];
            if *slot == u32::MAX {
                *slot = next;
                next += 1;
            }
            *slot
        })
        .collect()
}

/// Vertices of each region: where most triangles around are of it.
fn members(mesh: &Mesh, labels: &[u32], n: usize) -> Vec<Vec<u32>> {
    let mut around: Vec<(u32, u32)> = mesh
        .triangles
        .iter()
        .zip(labels)
        .flat_map(|(triangle, label)| triangle.map(|v| (v, *label)))
        .collect();
    around.sort_unstable();
    let mut members = vec![Vec::new(); n];
    for of_vertex in around.chunk_by(|a, b| a.0 == b.0) {
        let most = of_vertex.chunk_by(|a, b| a.1 == b.1).max_by_key(|g| (g.len(), std::cmp::Reverse(g[0].1)));
        if let Some(group) = most {
            members[group[0].1 as usize].push(of_vertex[0].0);
        }
    }
    members
}
