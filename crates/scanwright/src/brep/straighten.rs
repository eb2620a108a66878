//! Puts the border between two surfaces that touch where they touch.
//!
//! Beside their contact such surfaces differ by less than the noise, so that the border of a segmentation wanders
//! there: a bar and its bend by a dozen spacings. An edge along such a border lies on neither. Here the triangles
//! between the border and the contact change sides, as far as they
//! fit the other surface as well or nobody saw them. Cost O(triangles).

use std::collections::BTreeMap;

use super::attempt::Bench;
use super::geometry::{TANGENT, TANGENT_RESIDUAL};
use super::meet::{Field, PARALLEL, contact_field, meet, spine_direction};
use crate::math::{Point3, Vec3, angle_between, centroid};
use crate::surface::Surface;

/// Triangles that change sides, and their new labels.
pub(super) type Change = (Vec<u32>, Vec<u32>);

/// Per pair of touching regions whose border lies off the contact: what to change.
pub(super) fn straightenings(bench: &Bench, labels: &[u32], demoted: &[bool]) -> Vec<([u32; 2], Change)> {
    let mut borders: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for (t, a) in labels.iter().enumerate() {
        for u in bench.half_edges.neighbours(t).into_iter().flatten().filter(|u| labels[*u] != *a) {
            let b = labels[u];
            borders.entry([*a.min(&b), *a.max(&b)]).or_default().push(t as u32);
        }
    }
    let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    labels.iter().enumerate().for_each(|(t, l)| members.entry(*l).or_default().push(t as u32));
    let borders: Vec<([u32; 2], Vec<u32>)> = borders.into_iter().collect();
    let changes = crate::par::map(&borders, |(pair, border)| {
        let [a, b] = pair.map(|r| bench.surfaces[r as usize].filter(|_| !demoted[r as usize]));
        let surfaces = [a?, b?];
        let members = pair.map(|r| &members[&r][..]);
        let (field, upper) = touching(bench, &surfaces, border)
            .into_iter()
            .filter_map(|field| sides(bench, &field, members).map(|(upper, share)| (field, upper, share)))
            .max_by(|x, y| x.2.total_cmp(&y.2))
            .map(|(field, upper, _)| (field, upper))?;
        let change = straightened(bench, labels, *pair, &surfaces, (&field, upper), border)?;
        Some((*pair, change))
    });
    changes.into_iter().flatten().collect()
}

/// Equations that the contact of two surfaces beside a border may have, if they touch there.
fn touching(bench: &Bench, [a, b]: &[Surface; 2], border: &[u32]) -> Vec<Field> {
    /// Border triangles that are asked.
    const N_PROBES: usize = 24;
    /// In spacings: surfaces that touch at a bend of a hundred spacings differ by a fifth of one as far from there.
    const REACH: f64 = 16.0;
    /// Share of the probes that must come to the contact.
    const MOST: f64 = 0.8;
    let spacing = bench.tolerances.spacing();
    let step = border.len().div_ceil(N_PROBES);
    let probes: Vec<Point3> =
        border.iter().step_by(step).map(|t| bench.closed.mesh.triangle_center(*t as usize)).collect();
    let middle = centroid(&probes);
    let nearest = probes.iter().min_by(|p, q| (*p - middle).norm().total_cmp(&(*q - middle).norm()));
    let Some(center) = nearest.copied() else { return Vec::new() };
    let mut courses: Vec<Vec3> = Vec::new();
    for surface in [a, b] {
        if let Some(along) = spine_direction(surface, &center) {
            courses.push(along.into_inner());
            courses.push(along.cross(&surface.normal(&center)));
        }
    }
    let mut touching = Vec::new();
    for along in courses {
        let Some(field) = contact_field(a, b, &center, &along) else { continue };
        let fields = [Field::Surface(*a), Field::Surface(*b), field];
        let met: Vec<_> = probes.iter().map(|p| meet(p, &fields, REACH * spacing, PARALLEL)).collect();
        let good = met.iter().filter(|m| {
            let angle = angle_between(&a.normal(&m.point), &b.normal(&m.point));
            angle.min(std::f64::consts::PI - angle) < TANGENT
                && m.residual < TANGENT_RESIDUAL * spacing
                && field.value(&m.point).abs() < TANGENT_RESIDUAL * spacing
        });
        if good.count() as f64 >= MOST * met.len() as f64 {
            touching.push(field);
        }
    }
    touching
}

/// Which of two regions lies above a contact, and the smaller share of a region that lies on its side.
fn sides(bench: &Bench, field: &Field, members: [&[u32]; 2]) -> Option<(usize, f64)> {
    /// Share of each region that must lie on its side.
    const MOST: f64 = 0.6;
    let above = |t: &&u32| field.value(&bench.closed.mesh.triangle_center(**t as usize)) > 0.0;
    let [a, b] = members.map(|m| m.iter().filter(above).count() as f64 / m.len() as f64);
    let (upper, share) = if a > b { (0, a.min(1.0 - b)) } else { (1, b.min(1.0 - a)) };
    (share >= MOST).then_some((upper, share))
}

/// The triangles on the wrong side of the contact that hang together with the border.
fn straightened(
    bench: &Bench,
    labels: &[u32],
    pair: [u32; 2],
    surfaces: &[Surface; 2],
    (field, upper): (&Field, usize),
    border: &[u32],
) -> Option<Change> {
    /// In spacings: what the rounding of an edge hides.
    const ROUNDED: f64 = 1.2;
    let center = |t: u32| bench.closed.mesh.triangle_center(t as usize);
    let above = |t: u32| field.value(&center(t)) > 0.0;
    let side = |t: u32| if above(t) { upper } else { 1 - upper };
    let wrong = |t: u32| {
        let label = labels[t as usize];
        let other = side(t);
        pair.contains(&label)
            && label != pair[other]
            && (bench.closed.assumed[t as usize]
                || surfaces[other].signed_distance(&center(t)).abs() <= ROUNDED * bench.tolerances.spacing())
    };
    let mut found: Vec<u32> = border.to_vec();
    found.sort_unstable();
    found.dedup();
    found.retain(|t| wrong(*t));
    let mut seen: std::collections::BTreeSet<u32> = found.iter().copied().collect();
    let mut at = 0;
    while at < found.len() {
        for u in bench.half_edges.neighbours(found[at] as usize).into_iter().flatten() {
            if wrong(u as u32) && seen.insert(u as u32) {
                found.push(u as u32);
            }
        }
        at += 1;
    }
    let new = found.iter().map(|t| pair[side(*t)]).collect();
    (!found.is_empty()).then_some((found, new))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brep::LabelledMesh;
    use crate::math::{Axis, UnitVec3};
    use crate::mesh::Mesh;
    use crate::recognize::{Primitive, Residual};
    use crate::segment::RegionId;
    use crate::surface::{Cylinder, Plane};
    use crate::tolerance::{Measured, Tolerances};

    /// A floor for negative x that goes over into a cylinder of this radius.
    const RADIUS: f64 = 60.0;

    fn labelled(labels: Vec<u32>, mesh: Mesh) -> LabelledMesh {
        let surfaces = [
            Surface::Plane(Plane { point: Point3::origin(), normal: Vec3::z_axis() }),
            Surface::Cylinder(Cylinder {
                axis: Axis { origin: Point3::new(0.0, 0.0, -RADIUS), direction: Vec3::y_axis() as UnitVec3 },
                radius: RADIUS,
            }),
        ];
        let primitives = surfaces.map(|s| Primitive {
            surface: Some(s),
            outward: true,
            residual: Residual::from_distances(&[0.0]),
            covariance: Vec::new(),
            ambiguous: None,
        });
        let assumed = vec![false; labels.len()];
        let labels = labels.into_iter().map(RegionId).collect();
        LabelledMesh { mesh, labels, primitives: primitives.to_vec(), assumed }
    }

    fn sheet() -> Mesh {
        let at = |i: u32, j: u32| {
            let x = f64::from(i) - 30.0;
            let z = if x > 0.0 { (RADIUS * RADIUS - x * x).sqrt() - RADIUS } else { 0.0 };
            Point3::new(x, f64::from(j), z)
        };
        let vertices = (0..=60).flat_map(|i| (0..=40).map(move |j| at(i, j))).collect();
        let index = |i: u32, j: u32| i * 41 + j;
        let cell = |i, j| {
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        let triangles = (0..60).flat_map(|i| (0..40).flat_map(move |j| cell(i, j))).collect();
        Mesh { vertices, triangles }
    }

    #[test]
    fn a_wandering_border_goes_to_the_contact() {
        let mesh = sheet();
        let centers: Vec<Point3> = (0..mesh.triangles.len()).map(|t| mesh.triangle_center(t)).collect();
        let mut labels: Vec<u32> = centers.iter().map(|p| u32::from(p.x > 6.0 * (0.4 * p.y).sin())).collect();
        let wrong = |labels: &[u32]| {
            centers.iter().zip(labels).filter(|(p, l)| p.x.abs() > 0.5 && (p.x > 0.0) != (**l == 1)).count()
        };
        assert!(wrong(&labels) > 100);
        let closed = labelled(labels.clone(), mesh);
        let tolerances = Tolerances::new(
            Measured {
                largest_coordinate: 40.0,
                diagonal: 75.0,
                spacing: 1.0,
                noise: 0.0,
                normal_noise: 0.0,
                edge_rounding: 0.0,
            },
            None,
        );
        let bench = Bench::new(&closed, &tolerances);
        let changes = straightenings(&bench, &labels, &[false; 2]);
        assert_eq!(changes.len(), 1);
        for (t, label) in changes[0].1.0.iter().zip(&changes[0].1.1) {
            labels[*t as usize] = *label;
        }
        assert_eq!(wrong(&labels), 0);
        assert!(straightenings(&bench, &labels, &[true, false]).is_empty());
    }
}
