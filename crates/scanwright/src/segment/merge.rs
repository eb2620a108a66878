//! The last word on neighbours that may be one surface: whatever costs less, border included.
//!
//! Selection and labelling can only choose among the surfaces that were grown. A face whose waves two surfaces follow
//! stays in two pieces, though one surface would do: no single mean cost tells that from two faces, for what a few
//! vertices at the end of a face show is noise, and what as many in a chamfer show is not. Here the whole energy
//! decides: what all vertices cost under one joint surface, against what they cost now, the price of a surface and
//! the border between the two (label costs: A. Delong, A. Osokin, H. Isack, Y. Boykov, "Fast approximate energy
//! minimization with label costs", International Journal of Computer Vision 96 (2012), 1-27).

use std::collections::BTreeMap;

use super::cover::Cover;
use super::field::{Field, Scratch};
use super::grow::{BORDER_RINGS, MIN_INTERIOR, n_settled};
use super::label::{BORDER_COST, Labels};
use super::select::{DEAD_ZONE, PRICE, UNEXPLAINED};
use super::split::VERTICES_PER_SAMPLE;
use crate::fit::Fit;
use crate::par;
use crate::recognize::{COST_CAP, fit_kind, mean_cost};
use crate::surface::SurfaceKind;

/// Vertices of the smallest region that can be merged.
const MIN_REGION: usize = 20;
/// Samples of each of two regions that a joint surface must not be far off.
const N_SAMPLES: usize = 200;
/// Mean cost of either region under a joint surface, at most: no border is worth a region that it does not describe.
const MOST_COST: f64 = 5.0;

/// A connected set of one label.
#[derive(Debug)]
struct Piece {
    /// Labels of the surfaces that it was made of: it has no edges with them.
    labels: Vec<u32>,
    fit: Fit,
    members: Vec<u32>,
    interior: Vec<u32>,
    /// Sum of what its members cost now.
    cost: f64,
}

/// A joint surface of two pieces, and what it saves.
#[derive(Debug, Clone, Copy)]
struct Joint {
    saved: f64,
    fit: Fit,
}

/// Joins neighbours whose joint surface saves more than it costs, the most saving pair first.
pub(super) fn merge(field: &Field, cover: &Cover, labels: &mut Labels) {
    let mut scratch = Scratch::new(field.n_vertices());
    let mut pieces: Vec<Piece> = labels
        .components(field)
        .into_iter()
        .filter(|(_, members)| members.len() >= MIN_REGION)
        .map(|(label, members)| Piece {
            labels: vec![label],
            fit: labels.fits[label as usize],
            interior: field.eroded(&members, BORDER_RINGS, MIN_INTERIOR, &mut scratch),
            cost: members.iter().map(|&v| capped(cover.cost(field, label, v))).sum(),
            members,
        })
        .collect();
    let mut borders = borders(field, &pieces);
    let pairs: Vec<((usize, usize), usize)> = borders.iter().map(|(pair, n)| (*pair, *n)).collect();
    let found = par::map(&pairs, |&((a, b), n)| joint(field, cover, &pieces[a], &pieces[b], n));
    let mut joints: BTreeMap<(usize, usize), Joint> =
        pairs.iter().zip(found).filter_map(|((pair, _), joint)| joint.map(|j| (*pair, j))).collect();
    while let Some((&(a, b), &best)) =
        joints.iter().max_by(|x, y| x.1.saved.total_cmp(&y.1.saved).then(y.0.cmp(x.0)))
    {
        absorb(field, cover, &mut pieces, (a, b), best.fit, labels);
        borders = renamed(&borders, b, a);
        joints.retain(|&(x, y), _| ![x, y].iter().any(|k| *k == a || *k == b));
        let fresh: Vec<((usize, usize), usize)> =
            borders.iter().filter(|((x, y), _)| *x == a || *y == a).map(|(pair, n)| (*pair, *n)).collect();
        let found = par::map(&fresh, |&((x, y), n)| joint(field, cover, &pieces[x], &pieces[y], n));
        joints.extend(fresh.iter().zip(found).filter_map(|((pair, _), joint)| joint.map(|j| (*pair, j))));
    }
}

/// Makes one piece of two, under a label of its own.
fn absorb(
    field: &Field,
    cover: &Cover,
    pieces: &mut [Piece],
    (a, b): (usize, usize),
    fit: Fit,
    labels: &mut Labels,
) {
    let label = labels.fits.len() as u32;
    labels.fits.push(fit);
    let (members, interior) =
        (std::mem::take(&mut pieces[b].members), std::mem::take(&mut pieces[b].interior));
    let of_other = std::mem::take(&mut pieces[b].labels);
    let piece = &mut pieces[a];
    piece.labels.extend(of_other);
    piece.members.extend(members);
    piece.interior.extend(interior);
    piece.cost = piece.members.iter().map(|&v| capped(cover.cost_under(field, &fit, &piece.labels, v))).sum();
    piece.fit = fit;
    for &v in &piece.members {
        labels.of_vertex[v as usize] = Some(label);
    }
}

/// The joint surface of two pieces that saves most; `None` when none saves anything.
fn joint(field: &Field, cover: &Cover, a: &Piece, b: &Piece, n_border: usize) -> Option<Joint> {
    let [sa, sb] = [a, b].map(|piece| field.samples(&piece.interior, N_SAMPLES));
    let apart = |fit: &Fit, samples| mean_cost(fit, samples, &field.weights) > 0.8 * COST_CAP;
    if apart(&a.fit, &sb) && apart(&b.fit, &sa) {
        return None;
    }
    if let Some(fit) = explains_as_wave(field, cover, a, b) {
        return Some(Joint { saved: f64::INFINITY, fit });
    }
    let (na, nb) = (a.interior.len(), b.interior.len());
    let n_samples = n_settled(na + nb);
    let share = |n: usize| (n_samples * n / (na + nb)).clamp(n_samples / 10, n_samples);
    let both = field.samples(&a.interior, share(na)).followed_by(&field.samples(&b.interior, share(nb)));
    let price = |kind: SurfaceKind| PRICE * kind.degrees_of_freedom() as f64;
    let [ka, kb] = [a, b].map(|piece| piece.fit.surface.kind());
    let refitted = [a, b].map(|piece| {
        fit_kind(piece.fit.surface.kind(), &both, &field.weights, &field.limits, Some(&piece.fit))
    });
    let larger = if na < nb { b.fit } else { a.fit };
    let candidates = std::iter::once(larger).chain(refitted.into_iter().flatten().map(|choice| choice.fit));
    candidates
        .filter_map(|fit| {
            let bearable =
                [&sa, &sb].iter().all(|samples| mean_cost(&fit, samples, &field.weights) < MOST_COST);
            if !bearable {
                return None;
            }
            let now = a.cost + b.cost + price(ka) + price(kb) + BORDER_COST * n_border as f64;
            let made_of = [a.labels.as_slice(), &b.labels].concat();
            let members = a.members.iter().chain(&b.members);
            let then: f64 = members.map(|&v| capped(cover.cost_under(field, &fit, &made_of, v))).sum();
            let saved = now - then - price(fit.surface.kind());
            (saved > 0.0).then_some(Joint { saved, fit })
        })
        .max_by(|x, y| x.saved.total_cmp(&y.saved))
}

/// Mean cost under the surface of a face of `n_face` vertices up to which `n` others beside it may be a wave of it; `None`
/// where they are too many or the face is not large. Of `k` places with normal deviations the highest lies about
/// `sqrt(2 ln k)` deviations off (H. Cramér, "Mathematical Methods of Statistics", Princeton 1946, 28.6), so that on a
/// large face some always look like faces of their own. Taken for half of the variance: waves, as much as white noise.
pub(super) fn highest_wave(n_face: usize, n: usize) -> Option<f64> {
    /// Share of the face that a wave may take.
    const SMALL: f64 = 0.05;
    /// Places of a large face: on smaller ones the energy decides better (`docs/segmentation.md`).
    const MANY: f64 = 750.0;
    let n_places = n_face as f64 / VERTICES_PER_SAMPLE;
    (n_places >= MANY && n as f64 <= SMALL * n_face as f64).then(|| n_places.ln() + 0.5)
}

/// The surface of the larger of two pieces of one kind, where the smaller may be a wave of it.
fn explains_as_wave(field: &Field, cover: &Cover, a: &Piece, b: &Piece) -> Option<Fit> {
    let (large, small) = if a.members.len() < b.members.len() { (b, a) } else { (a, b) };
    let highest = highest_wave(large.members.len(), small.members.len())
        .filter(|_| large.fit.surface.kind() == small.fit.surface.kind())?;
    let made_of = [a.labels.as_slice(), &b.labels].concat();
    let sum: f64 =
        small.members.iter().map(|&v| capped(cover.cost_under(field, &large.fit, &made_of, v))).sum();
    (sum < highest * small.members.len() as f64).then_some(large.fit)
}

fn capped(cost: f64) -> f64 {
    cost.clamp(f64::from(DEAD_ZONE), f64::from(UNEXPLAINED))
}

/// Number of edges between each two pieces that touch.
fn borders(field: &Field, pieces: &[Piece]) -> BTreeMap<(usize, usize), usize> {
    let mut owner: Vec<Option<usize>> = vec![None; field.n_vertices()];
    for (k, piece) in pieces.iter().enumerate() {
        for &v in &piece.members {
            owner[v as usize] = Some(k);
        }
    }
    let mut borders = BTreeMap::new();
    for v in 0..field.n_vertices() {
        let Some(a) = owner[v] else { continue };
        for &u in field.rings.row(v) {
            if let Some(b) = owner[u as usize]
                && a < b
            {
                *borders.entry((a, b)).or_insert(0) += 1;
            }
        }
    }
    borders
}

/// The same borders when piece `from` has become part of `to`.
fn renamed(
    borders: &BTreeMap<(usize, usize), usize>,
    from: usize,
    to: usize,
) -> BTreeMap<(usize, usize), usize> {
    let name = |k: usize| if k == from { to } else { k };
    let mut all = BTreeMap::new();
    for (&(a, b), &n) in borders {
        let (a, b) = (name(a), name(b));
        if a != b {
            *all.entry((a.min(b), a.max(b))).or_insert(0) += n;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::measure;
    use crate::math::{Point3, UnitVec3, Vec3};
    use crate::mesh::{Adjacency, Mesh};
    use crate::segment::field::Hypothesis;
    use crate::surface::{Plane, Surface};
    use crate::tolerance::Tolerances;

    /// A sheet of so many vertices along and across, one apart, at the heights of these places.
    fn sheet(size: [u32; 2], mut height: impl FnMut(u32, u32) -> f64) -> Mesh {
        let mut mesh = Mesh::default();
        for (i, j) in (0..size[0]).flat_map(|i| (0..size[1]).map(move |j| (i, j))) {
            mesh.vertices.push(Point3::new(f64::from(i), f64::from(j), height(i, j)));
            if i + 1 < size[0] && j + 1 < size[1] {
                let at = |i: u32, j: u32| i * size[1] + j;
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    }

    /// Number of labels that are left of two planes; `side`: which of them a vertex has.
    fn n_left(mesh: &Mesh, planes: &[Plane; 2], side: impl Fn(u32) -> usize) -> usize {
        let adjacency = Adjacency::new(mesh);
        let tolerances = Tolerances::new(measure(mesh, &adjacency), None);
        let n = mesh.vertices.len() as u32;
        let normals: Vec<Vec3> = (0..n).map(|v| planes[side(v)].normal.into_inner()).collect();
        let field = Field::new(mesh, &adjacency, &normals, &tolerances, None);
        let fits = planes.map(|plane| Fit { surface: Surface::Plane(plane), outward: true });
        let hypotheses: Vec<Hypothesis> = (0..2)
            .map(|k| {
                let own = (0..n).filter(|&v| side(v) == k);
                let support = own.map(|v| (v, field.cost(&fits[k], v) as f32)).collect();
                Hypothesis { fit: fits[k], mean_cost: 1.0, support }
            })
            .collect();
        let cover = Cover::of(&field, hypotheses.iter());
        let of_vertex = (0..n).map(|v| Some(side(v) as u32)).collect();
        let mut labels = Labels { of_vertex, fits: fits.to_vec() };
        merge(&field, &cover, &mut labels);
        let mut left = labels.of_vertex;
        left.sort_unstable();
        left.dedup();
        left.len()
    }

    /// What is left of a sheet with noise of 0.05 that has these slopes before and beyond a cut.
    fn n_left_of_slopes(slopes: [f64; 2]) -> usize {
        const SIZE: [u32; 2] = [60, 24];
        const CUT: u32 = 40;
        let mut rng = crate::random::Rng::for_task(1, "sheet", 0);
        let mesh = sheet(SIZE, |i, _| {
            (f64::from(i) - f64::from(CUT)) * slopes[usize::from(i >= CUT)] + 0.05 * rng.normal()
        });
        let planes = slopes.map(|slope| Plane {
            point: Point3::new(f64::from(CUT), 0.0, 0.0),
            normal: UnitVec3::new_normalize(Vec3::new(-slope, 0.0, 1.0)),
        });
        n_left(&mesh, &planes, |v| usize::from(v / SIZE[1] >= CUT))
    }

    #[test]
    fn two_planes_that_follow_the_waves_of_one_face_are_one() {
        // At the far end the other plane is half a deviation of the noise off.
        assert_eq!(n_left_of_slopes([0.001, -0.001]), 1);
    }

    #[test]
    fn two_faces_that_the_scan_tells_apart_stay_two() {
        assert_eq!(n_left_of_slopes([0.0, 0.15]), 2, "a chamfer of nine degrees");
    }

    /// What is left of a sheet without noise, `side` vertices long and wide, of which a patch of 40 by 40 lies higher.
    fn n_left_of_lifted(side: u32, height: f64) -> usize {
        let is_lifted = |i: u32, j: u32| [i, j].iter().all(|x| (10..50).contains(x));
        let mesh = sheet([side, side], |i, j| if is_lifted(i, j) { height } else { 0.0 });
        let planes = [0.0, height].map(|z| Plane { point: Point3::new(0.0, 0.0, z), normal: Vec3::z_axis() });
        n_left(&mesh, &planes, |v| usize::from(is_lifted(v / side, v % side)))
    }

    #[test]
    fn a_place_that_waves_lift_is_no_face_of_a_large_one_and_a_step_is() {
        // Noise has its floor, 0.08: these are 2.75 and 3.75 deviations.
        let (wave, step) = (0.22, 0.30);
        assert_eq!(n_left_of_lifted(200, wave), 1, "one of 1000 places");
        assert_eq!(
            n_left_of_lifted(150, wave),
            2,
            "the face is not large, and the patch no small part of it"
        );
        assert_eq!(n_left_of_lifted(200, step), 2, "higher than 1000 places should be");
    }
}
