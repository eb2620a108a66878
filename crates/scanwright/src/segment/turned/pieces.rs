//! Pieces of one turned face.
//!
//! Noise and shadows break a wide turned face in pieces, each with an axis of its own. Beside a face that shows the axis
//! well they are held against what turns about that axis: a cylinder, an annulus, a cone, a torus or a sphere, the
//! simplest that describes every piece as well as the piece's own surface does. Neighbours that share one become one
//! face; a face whose own axis is off takes the common one.

use std::collections::BTreeMap;

use super::generatrix::Generatrix;
use super::run::{MIN_SECTORS, N_SECTORS};
use super::{axes, level_sectors};
use crate::fit::{Fit, Samples};
use crate::math::Axis;
use crate::par;
use crate::recognize::{COST_CAP, excess_cost, is_as_good, mean_cost};
use crate::segment::field::{Field, Scratch};
use crate::segment::finish::Regions;
use crate::segment::grow::{BORDER_RINGS, MIN_INTERIOR, SUPPORT_COST};
use crate::surface::SurfaceKind;

/// Samples per piece in a test.
const N_TEST: usize = 150;
/// A surface that describes a piece worse than this describes it by chance.
const MAX_COST: f64 = 5.0;

/// Gives the pieces of one turned face one region, and turned faces the axis of those that show it best.
pub(in crate::segment) fn unite(field: &Field, regions: &mut Regions) {
    let shows_axis = |kind| matches!(kind, SurfaceKind::Cylinder | SurfaceKind::Cone);
    let mut settled = vec![false; regions.fits.len()];
    for (owner, axis) in axes(field, regions, &regions.members(), shows_axis) {
        if settled[owner] {
            continue;
        }
        settled[owner] = true;
        let mut faces = faces(field, regions, &axis, &settled);
        join(field, regions, &axis, &mut faces);
        for face in &faces {
            let Some(fit) = face.shared(field, &axis).filter(|_| face.is_new(regions, &axis, field)) else {
                continue;
            };
            for &k in &face.regions {
                settled[k as usize] = true;
            }
            let first = face.regions[0];
            regions.fits[first as usize] = Some(fit);
            for label in regions.of_vertex.iter_mut().flatten() {
                if face.regions.contains(label) {
                    *label = first;
                }
            }
        }
    }
    regions.compact();
}

/// One or several pieces that turn about one axis.
#[derive(Debug, Clone)]
struct Face {
    regions: Vec<u32>,
    /// Of each piece: samples of its interior, and how well its own surface describes them.
    evidence: Vec<(Samples, f64)>,
    interior: Vec<u32>,
    sectors: [bool; N_SECTORS],
}

/// The regions that turn about the axis, as far as their extent shows.
fn faces(field: &Field, regions: &Regions, axis: &Axis, settled: &[bool]) -> Vec<Face> {
    let members = regions.members();
    let face = |k: usize| {
        let fit = regions.fits[k].filter(|_| !settled[k])?;
        let sectors = level_sectors(field, axis, &members[k])?;
        let depths = field.depths(&members[k], BORDER_RINGS, false, &mut Scratch::new(field.n_vertices()));
        let is_inside = |(_, depth): &(&u32, &u8)| usize::from(**depth) >= BORDER_RINGS;
        let interior: Vec<u32> = members[k].iter().zip(&depths).filter(is_inside).map(|(v, _)| *v).collect();
        // What is narrower is resolved with its neighbours.
        if interior.len() < MIN_INTERIOR {
            return None;
        }
        let samples = field.samples(&interior, N_TEST);
        let own = mean_cost(&fit, &samples, &field.weights);
        Some(Face { regions: vec![k as u32], evidence: vec![(samples, own)], interior, sectors })
    };
    par::map_indices(members.len(), face).into_iter().flatten().collect()
}

/// Joins faces that touch and share a surface, those that it describes best first.
fn join(field: &Field, regions: &Regions, axis: &Axis, faces: &mut Vec<Face>) {
    let contacts = contacts(field, regions);
    let contacts_of = |a: &Face, b: &Face| -> Vec<u32> {
        let pairs = a.regions.iter().flat_map(|&k| b.regions.iter().map(move |&l| (k.min(l), k.max(l))));
        pairs.filter_map(|pair| contacts.get(&pair)).flatten().copied().collect()
    };
    let joint = |a: &Face, b: &Face| {
        let shared = contacts_of(a, b);
        let both = (!shared.is_empty()).then(|| a.with(b))?;
        let fit = both.shared(field, axis)?;
        continues(field, &fit, &shared).then(|| (both.excess(field, &fit), both))
    };
    let pairs: Vec<(usize, usize)> =
        (0..faces.len()).flat_map(|i| (i + 1..faces.len()).map(move |j| (i, j))).collect();
    let mut joints: Vec<((usize, usize), f64, Face)> =
        par::map(&pairs, |&(i, j)| joint(&faces[i], &faces[j]).map(|(excess, face)| ((i, j), excess, face)))
            .into_iter()
            .flatten()
            .collect();
    let mut gone = vec![false; faces.len()];
    while let Some(best) = (0..joints.len())
        .min_by(|&a, &b| joints[a].1.total_cmp(&joints[b].1).then(joints[a].0.cmp(&joints[b].0)))
    {
        let ((i, j), _, face) = joints.swap_remove(best);
        faces[i] = face;
        gone[j] = true;
        joints.retain(|((a, b), ..)| ![i, j].contains(a) && ![i, j].contains(b));
        let others: Vec<usize> = (0..faces.len()).filter(|&k| k != i && !gone[k]).collect();
        let new = par::map(&others, |&k| {
            joint(&faces[i], &faces[k]).map(|(excess, face)| ((i.min(k), i.max(k)), excess, face))
        });
        joints.extend(new.into_iter().flatten());
    }
    let mut gone = gone.into_iter();
    faces.retain(|_| gone.next() == Some(false));
}

impl Face {
    fn with(&self, other: &Self) -> Self {
        let mut both = self.clone();
        both.regions.extend(&other.regions);
        both.evidence.extend(other.evidence.iter().cloned());
        both.interior.extend(&other.interior);
        for (mine, theirs) in both.sectors.iter_mut().zip(other.sectors) {
            *mine |= theirs;
        }
        both.regions.sort_unstable();
        both
    }

    /// Whether the face is in pieces, or in one with an axis of its own.
    fn is_new(&self, regions: &Regions, axis: &Axis, field: &Field) -> bool {
        /// Sine of the angle between two axes that are one: over a face a hundred spacings long, a tenth of a spacing.
        const PARALLEL: f64 = 1e-3;
        /// Spacings between them.
        const APART: f64 = 0.1;
        if self.regions.len() > 1 {
            return true;
        }
        let Some(fit) = regions.fits[self.regions[0] as usize] else { return false };
        fit.surface.axis().is_some_and(|own| {
            own.direction.cross(&axis.direction).norm() > PARALLEL
                || own.radial(&axis.origin).norm() > APART * field.spacing
        })
    }

    /// The simplest surface about the axis that describes every piece as well as its own does.
    fn shared(&self, field: &Field, axis: &Axis) -> Option<Fit> {
        if self.sectors.iter().filter(|s| **s).count() < MIN_SECTORS {
            return None;
        }
        let generatrix = Generatrix::of(field, axis, &self.interior);
        generatrix.surfaces(field).into_iter().find(|fit| {
            self.evidence.iter().all(|(samples, own)| {
                let shared = mean_cost(fit, samples, &field.weights);
                shared < MAX_COST && is_as_good(shared, *own)
            })
        })
    }

    /// Largest cost of a piece beyond what its own surface costs.
    fn excess(&self, field: &Field, fit: &Fit) -> f64 {
        let of = |(samples, own): &(Samples, f64)| excess_cost(mean_cost(fit, samples, &field.weights), *own);
        self.evidence.iter().map(of).fold(-COST_CAP, f64::max)
    }
}

/// Whether a surface goes on where two of its pieces touch, and is not cut there by a groove that nothing described.
fn continues(field: &Field, fit: &Fit, contact: &[u32]) -> bool {
    let on_surface = |v: &&u32| field.cost(fit, **v) < SUPPORT_COST;
    2 * contact.iter().filter(on_surface).count() > contact.len()
}

/// Vertices where two regions touch, by the pair.
fn contacts(field: &Field, regions: &Regions) -> BTreeMap<(u32, u32), Vec<u32>> {
    let mut contacts: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
    for v in 0..field.n_vertices() {
        let Some(a) = regions.of_vertex[v] else { continue };
        let mut others: Vec<u32> = field
            .rings
            .row(v)
            .iter()
            .filter_map(|&u| regions.of_vertex[u as usize])
            .filter(|&b| b != a)
            .collect();
        others.sort_unstable();
        others.dedup();
        for b in others {
            contacts.entry((a.min(b), a.max(b))).or_default().push(v as u32);
        }
    }
    contacts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::measure;
    use crate::math::{Point3, Vec3};
    use crate::mesh::{Adjacency, Mesh};
    use crate::surface::{Cylinder, Surface};
    use crate::tolerance::Tolerances;

    #[test]
    fn a_shaft_does_not_go_on_across_a_groove() {
        // Rings of a shaft, one apart; the middle ones lie two deeper.
        let (radius, n_round, groove) = (20.0, 120, 14..18);
        let mut mesh = Mesh::default();
        for (k, i) in (0..32_u32).flat_map(|k| (0..n_round).map(move |i| (k, i))) {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(n_round)).sin_cos();
            let radius = if groove.contains(&k) { radius - 2.0 } else { radius };
            mesh.vertices.push(Point3::new(radius * cos, radius * sin, f64::from(k)));
            if k > 0 {
                let at = |k: u32, i: u32| k * n_round + i % n_round;
                let [a, b, c, d] = [at(k - 1, i), at(k - 1, i + 1), at(k, i + 1), at(k, i)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let adjacency = Adjacency::new(&mesh);
        let tolerances = Tolerances::new(measure(&mesh, &adjacency), None);
        let outward: Vec<Vec3> = mesh.vertices.iter().map(|p| Vec3::new(p.x, p.y, 0.0).normalize()).collect();
        let field = Field::new(&mesh, &adjacency, &outward, &tolerances, None);
        let axis = Axis { origin: Point3::origin(), direction: Vec3::z_axis() };
        let fit = Fit { surface: Surface::Cylinder(Cylinder { axis, radius }), outward: true };
        // Two pieces that touch at ring `border`.
        let touching_at = |border: u32| {
            let of_vertex = (0..mesh.vertices.len() as u32).map(|v| Some(u32::from(v / n_round >= border)));
            let regions = Regions { of_vertex: of_vertex.collect(), fits: vec![Some(fit); 2] };
            let contacts = contacts(&field, &regions);
            assert_eq!(contacts.keys().collect::<Vec<_>>(), [&(0, 1)]);
            continues(&field, &fit, &contacts[&(0, 1)])
        };
        assert!(!touching_at(16), "in the groove");
        assert!(touching_at(8), "on the shaft");
    }
}
