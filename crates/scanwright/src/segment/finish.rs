//! The last labels: slivers dropped, leftovers given to neighbours, pieces of one surface joined.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::field::{Field, Scratch};
use super::label::Labels;
use super::turned::Resolved;
use super::{RegionId, SegmentOptions, Segmentation};
use super::{blunt, border, bridge, contact, fillet, lands, primitive, turned};
use crate::fit::Fit;
use crate::mesh::{Adjacency, Mesh};
use crate::par;
use crate::recognize::Primitive;

/// Regions of fewer vertices are given to their neighbours.
const MIN_REGION: usize = 20;
/// Share of a region's vertices that do not touch another: a strip of three rows has a third, one of two has none.
const MIN_INSIDE_SHARE: f64 = 0.25;
/// Rings over which leftovers are given to a neighbour: the rounding of an edge, twice.
const FLOOD_RINGS: u32 = 5;
/// Distance from a surface over which leftovers may be of it, in deviations of the spot and of the noise: what is farther
/// off is no rounded edge but the floor of a groove.
const LARGEST_REACH: f64 = 3.0;
/// Unexplained sets of more vertices become freeform regions.
const MIN_FREEFORM: usize = 80;

/// Turns vertex labels into regions of triangles with fitted primitives.
pub(super) fn finish(
    mesh: &Mesh,
    adjacency: &Adjacency,
    field: &Field,
    labels: &Labels,
    options: &SegmentOptions,
) -> Segmentation {
    let mut regions = Regions::from_labels(field, labels, options);
    regions.settle_leftovers(field);
    regions.join(mesh, field);
    turned::unite(field, &mut regions);
    blunt::retype(field, &mut regions);
    turned::resolve(field, &mut regions);
    let fillets = fillet::insert(field, &mut regions);
    let rounds = lands::find(field, &mut regions);
    let members = regions.members();
    let mut primitives = par::map_indices(regions.fits.len(), |k| {
        let fit_of = |v: u32| regions.of_vertex[v as usize].and_then(|k| regions.fits[k as usize]);
        match regions.fits[k] {
            Some(fit) => primitive::fitted(field, &fit, &members[k], fit_of),
            None => Primitive::freeform(),
        }
    });
    let lands = par::map(&rounds, |round| round.primitives(field, &members));
    for (k, primitive) in lands.into_iter().flatten() {
        primitives[k as usize] = primitive;
    }
    let tangent = par::map(&fillets, |fillet| fillet.primitive(field, &primitives, &members));
    for (fillet, primitive) in fillets.iter().zip(tangent) {
        if let Some(primitive) = primitive {
            primitives[fillet.region as usize] = primitive;
        }
    }
    let labels = triangle_labels(mesh, field, &regions, &primitives);
    let fillets: Vec<u32> = fillets.iter().filter(|f| !f.flat).map(|f| f.region).collect();
    let mut labels = border::sharpened(mesh, adjacency, &labels, &primitives, &fillets);
    contact::settle(mesh, adjacency, &mut labels, &primitives, field.spacing);
    Segmentation { labels, primitives }
}

/// What a region asks for: cost, then order of arrival; vertex, region, ring.
type Claim = (OrderedCost, u64, u32, u32, u32);

/// One region per connected set of equal labels.
pub(super) struct Regions {
    /// One per vertex.
    pub of_vertex: Vec<Option<u32>>,
    /// One per region; none for freeform.
    pub fits: Vec<Option<Fit>>,
}

impl Regions {
    fn from_labels(field: &Field, labels: &Labels, options: &SegmentOptions) -> Self {
        let mut scratch = Scratch::new(field.n_vertices());
        let mut regions = Self { of_vertex: vec![None; field.n_vertices()], fits: Vec::new() };
        let min_depth =
            options.min_face.map(|width| (0.5 * width / field.spacing).clamp(1.0, 200.0) as usize);
        for (label, members) in labels.components(field) {
            let depths = field.depths(&members, min_depth.unwrap_or(2), false, &mut scratch);
            let n_inside = depths.iter().filter(|d| usize::from(**d) >= min_depth.unwrap_or(1)).count();
            let wide = match min_depth {
                Some(_) => n_inside > 0,
                None => n_inside as f64 > MIN_INSIDE_SHARE * members.len() as f64,
            };
            if members.len() < MIN_REGION || !wide {
                continue;
            }
            for &v in &members {
                regions.of_vertex[v as usize] = Some(regions.fits.len() as u32);
            }
            regions.fits.push(Some(labels.fits[label as usize]));
        }
        regions
    }

    /// Gives leftovers near a surface to it; of the others, large sets become freeform regions, and the rest goes to the
    /// nearest region.
    fn settle_leftovers(&mut self, field: &Field) {
        self.flood(field, FLOOD_RINGS, LARGEST_REACH * (field.blur + field.weights.distance_sigma));
        self.add_freeform(field);
        self.flood(field, u32::MAX, f64::INFINITY);
    }

    /// Gives unlabelled vertices within `rings` of a region, and within `reach` of its surface, to the surface they are
    /// nearest to.
    fn flood(&mut self, field: &Field, rings: u32, reach: f64) {
        let mut heap = BinaryHeap::new();
        let mut order = 0_u64;
        let mut push = |heap: &mut BinaryHeap<Reverse<Claim>>, fits: &[Option<Fit>], v, k, ring| {
            let cost = fits[k as usize]
                .map_or(0.0, |fit| fit.surface.signed_distance(&field.points[v as usize]).abs());
            order += 1;
            if cost <= reach {
                heap.push(Reverse((OrderedCost(cost), order, v, k, ring)));
            }
        };
        for v in 0..field.n_vertices() {
            let Some(k) = self.of_vertex[v] else { continue };
            for &u in field.rings.row(v) {
                if self.of_vertex[u as usize].is_none() {
                    push(&mut heap, &self.fits, u, k, 1);
                }
            }
        }
        while let Some(Reverse((_, _, v, k, ring))) = heap.pop() {
            if self.of_vertex[v as usize].is_some() {
                continue;
            }
            self.of_vertex[v as usize] = Some(k);
            if ring < rings {
                for &u in field.rings.row(v as usize) {
                    if self.of_vertex[u as usize].is_none() {
                        push(&mut heap, &self.fits, u, k, ring + 1);
                    }
                }
            }
        }
    }

    /// Connected sets that nothing explains become regions of their own.
    fn add_freeform(&mut self, field: &Field) {
        let leftovers = field.connected(|v| self.of_vertex[v as usize].is_none().then_some(()));
        for ((), members) in leftovers {
            let touches_none = members
                .iter()
                .all(|&v| field.rings.row(v as usize).iter().all(|&u| self.of_vertex[u as usize].is_none()));
            if members.len() > MIN_FREEFORM || touches_none {
                for &v in &members {
                    self.of_vertex[v as usize] = Some(self.fits.len() as u32);
                }
                self.fits.push(None);
            }
        }
    }

    /// Makes one region of each surface seen in several pieces; regions are numbered anew.
    fn join(&mut self, mesh: &Mesh, field: &Field) {
        let (root, fits) = bridge::unions(mesh, field, &self.of_vertex, &self.fits, &self.members());
        let mut number = vec![0; root.len()];
        let mut kept = Vec::new();
        for k in 0..root.len() {
            if root[k] == k {
                number[k] = kept.len() as u32;
                kept.push(fits[k]);
            }
        }
        for label in self.of_vertex.iter_mut().flatten() {
            *label = number[root[*label as usize]];
        }
        self.fits = kept;
    }

    /// Puts faces in place of regions; returns theirs.
    pub fn replace(&mut self, replaced: &[u32], by: Resolved) -> Vec<u32> {
        let mut numbers = replaced.iter().copied();
        let mut new = Vec::new();
        for (fit, members) in by.faces {
            let k = numbers.next().unwrap_or(self.fits.len() as u32);
            if k as usize == self.fits.len() {
                self.fits.push(None);
            }
            self.fits[k as usize] = Some(fit);
            for v in members {
                self.of_vertex[v as usize] = Some(k);
            }
            new.push(k);
        }
        for (end, members) in by.ends {
            for v in members {
                self.of_vertex[v as usize] = Some(end);
            }
        }
        new
    }

    /// Numbers regions anew, without those that have no vertices.
    pub fn compact(&mut self) {
        let mut number = vec![None; self.fits.len()];
        for k in self.of_vertex.iter().flatten() {
            number[*k as usize] = Some(0);
        }
        for (n, slot) in (0..).zip(number.iter_mut().flatten()) {
            *slot = n;
        }
        let mut kept = number.iter();
        self.fits.retain(|_| kept.next().is_some_and(Option::is_some));
        for label in self.of_vertex.iter_mut().flatten() {
            *label = number[*label as usize].expect("a region with a vertex is kept");
        }
    }

    /// Vertices of each region, ascending.
    pub fn members(&self) -> Vec<Vec<u32>> {
        let mut members = vec![Vec::new(); self.fits.len()];
        for (v, k) in self.of_vertex.iter().enumerate() {
            if let Some(k) = k {
                members[*k as usize].push(v as u32);
            }
        }
        members
    }
}

/// A finite cost with an order.
#[derive(Debug, Clone, Copy, PartialEq)]
struct OrderedCost(f64);

impl Eq for OrderedCost {}

impl PartialOrd for OrderedCost {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for OrderedCost {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// The label of most corners; where all three differ, the surface nearest to the triangle's centre.
fn triangle_labels(
    mesh: &Mesh,
    field: &Field,
    regions: &Regions,
    primitives: &[Primitive],
) -> Vec<Option<RegionId>> {
    par::map_indices(mesh.triangles.len(), |t| {
        let [a, b, c] = mesh.triangles[t].map(|v| regions.of_vertex[v as usize]);
        let label = if a == b || a == c {
            a
        } else if b == c {
            b
        } else {
            let center = mesh.triangle_center(t);
            let distance = |k: &u32| {
                primitives[*k as usize].surface.map_or(field.spacing, |s| s.signed_distance(&center).abs())
            };
            [a, b, c].into_iter().flatten().min_by(|x, y| distance(x).total_cmp(&distance(y)))
        };
        label.map(RegionId)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::measure;
    use crate::math::{Point3, Vec3};
    use crate::surface::{Plane, Surface};
    use crate::tolerance::Tolerances;

    /// Columns of a sheet, one apart, and its rows; those of a trench in it, three deep.
    const SIZE: (u32, u32) = (40, 12);
    const TRENCH: std::ops::Range<u32> = 14..26;

    fn sheet() -> Mesh {
        let mut mesh = Mesh::default();
        for (i, j) in (0..SIZE.0).flat_map(|i| (0..SIZE.1).map(move |j| (i, j))) {
            let depth = if TRENCH.contains(&i) { 3.0 } else { 0.0 };
            mesh.vertices.push(Point3::new(f64::from(i), f64::from(j), -depth));
            if i + 1 < SIZE.0 && j + 1 < SIZE.1 {
                let at = |i: u32, j: u32| i * SIZE.1 + j;
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    }

    #[test]
    fn the_floor_of_a_trench_is_given_to_no_side() {
        let mesh = sheet();
        let adjacency = Adjacency::new(&mesh);
        let tolerances = Tolerances::new(measure(&mesh, &adjacency), None);
        let normals = vec![Vec3::z(); mesh.vertices.len()];
        let field = Field::new(&mesh, &adjacency, &normals, &tolerances, None);
        let plane = Plane { point: Point3::origin(), normal: Vec3::z_axis() };
        let fit = Fit { surface: Surface::Plane(plane), outward: true };
        // Both sides lie on one plane; nothing described the trench.
        let side = |i: u32| (!TRENCH.contains(&i)).then_some(u32::from(i >= TRENCH.end));
        let column = |v: u32| v / SIZE.1;
        let mut regions = Regions {
            of_vertex: (0..mesh.vertices.len() as u32).map(|v| side(column(v))).collect(),
            fits: vec![Some(fit); 2],
        };
        regions.settle_leftovers(&field);
        for v in 0..mesh.vertices.len() as u32 {
            let expected = side(column(v)).unwrap_or(2);
            assert_eq!(regions.of_vertex[v as usize], Some(expected), "column {}", column(v));
        }
        assert_eq!(regions.fits, [Some(fit), Some(fit), None], "the trench is freeform");
    }
}
