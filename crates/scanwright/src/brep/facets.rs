//! Where no surface and no B-spline gives a sound face, the triangles of the scan there become flat faces.
//!
//! Only for flaws that receiving programs would refuse the part for. A flaw is mended where it is: the triangles within
//! some spacings of it are cut out of their regions, whatever these are, and each is a face between three straight
//! edges. Its corners stay on the mesh, those at the rim on the surfaces beside it, so nothing is left to extend or to
//! intersect. Where a B-spline is at fault that took the place of a surface, the surface may come back between the
//! facets. What does not help is not kept; the reach grows while something is wrong, and in the end takes the whole of
//! the faces at fault.

use std::collections::BTreeSet;

use super::attempt::{Attempt, Bench, Flaw};
use super::batch::search;
use super::domain::nearest_on_spline;
use super::mend::Mend;
use crate::math::Point3;

/// In spacings: how far round a flaw triangles are taken, least first; then the whole of the faces at fault.
const REACHES: [f64; 3] = [3.0, 6.0, 12.0];
/// In spacings: triangles farther from the surface of their face than its rounded borders are taken with those beside
/// them, for a rim has to lie on the surfaces beside it.
const MISFIT: f64 = 1.2;
/// Most triangles that become faces: more, and few programs would open the part.
pub(super) const MOST: usize = 8_000;
/// Most flaws that zones are made for at a time, the worst: beyond, the part is past mending and only time is lost.
const MOST_FLAWS: usize = 100;
/// Builds per scan.
const MAX_TRIALS: usize = 40;

/// The soundest attempt that facets beside the flaws of `start` lead to.
pub(super) fn faceted(bench: &Bench, start: Attempt) -> Attempt {
    search(bench, start, MAX_TRIALS, Attempt::is_fatal, |a| zones(bench, a))
}

/// For every fatal flaw the triangles round it that may become facets, the smallest zones first.
fn zones(bench: &Bench, attempt: &Attempt) -> Vec<Mend> {
    let labels = &attempt.choice.labels;
    let n_left = MOST.saturating_sub(labels.iter().filter(|l| **l == bench.facets).count());
    let mut flaws: Vec<&Flaw> = attempt.flaws.iter().filter(|f| f.fatal).collect();
    if flaws.len() > MOST_FLAWS {
        flaws.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        flaws.truncate(MOST_FLAWS);
    }
    let mut mends = Vec::new();
    for reach in REACHES.map(Some).into_iter().chain([None]) {
        for flaw in &flaws {
            let mut zone = match reach {
                Some(reach) => round(bench, attempt, flaw, reach),
                None => of_patches(attempt, flaw).collect(),
            };
            add_misfits(bench, attempt, &mut zone);
            zone.retain(|t| labels[*t as usize] != bench.facets);
            if let Some((region, lost)) = restorable(bench, attempt, flaw) {
                let triangles: Vec<u32> = zone.union(&lost).copied().collect();
                if triangles.len() <= n_left {
                    mends.push(Mend::Restore { region, triangles, label: bench.facets });
                }
            }
            if !zone.is_empty() && zone.len() <= n_left {
                let labels = vec![bench.facets; zone.len()];
                mends.push(Mend::Relabel { triangles: zone.into_iter().collect(), labels });
            }
        }
    }
    mends
}

/// Triangles of the patches at fault.
fn of_patches<'a>(attempt: &'a Attempt, flaw: &'a Flaw) -> impl Iterator<Item = u32> + 'a {
    flaw.patches.iter().flat_map(|p| attempt.draft.patches[*p].triangles.iter().copied())
}

/// For a flaw of a B-spline that took the place of a surface: the region, and its triangles that lie off that surface.
fn restorable(bench: &Bench, attempt: &Attempt, flaw: &Flaw) -> Option<(u32, BTreeSet<u32>)> {
    let regions = flaw.patches.iter().map(|p| attempt.draft.patches[*p].region);
    let region = regions.into_iter().find(|r| attempt.choice.demoted[*r as usize])?;
    let surface = bench.surfaces[region as usize]?;
    let limit = MISFIT * bench.tolerances.spacing();
    let off = |t: &u32| {
        bench.closed.mesh.corners(*t as usize).iter().any(|p| surface.signed_distance(p).abs() > limit)
    };
    let labels = attempt.choice.labels.iter().enumerate();
    let own = labels.filter(|(_, l)| **l == region).map(|(t, _)| t as u32);
    Some((region, own.filter(off).collect()))
}

/// Triangles within `reach` spacings of where a flaw is, connected with the nearest of the patches at fault.
fn round(bench: &Bench, attempt: &Attempt, flaw: &Flaw, reach: f64) -> BTreeSet<u32> {
    let mesh = &bench.closed.mesh;
    let reach = reach * bench.tolerances.spacing();
    let off = |t: u32, p: &Point3| (mesh.triangle_center(t as usize) - p).norm_squared();
    let mut zone = BTreeSet::new();
    for at in &flaw.at {
        let nearest = of_patches(attempt, flaw).min_by(|a, b| off(*a, at).total_cmp(&off(*b, at)));
        let Some(nearest) = nearest else { continue };
        let center = mesh.triangle_center(nearest as usize);
        let mut found = BTreeSet::from([nearest]);
        let mut front = vec![nearest];
        while let Some(t) = front.pop() {
            for u in bench.half_edges.neighbours(t as usize).into_iter().flatten() {
                let u = u as u32;
                if off(u, &center) <= reach * reach && found.insert(u) {
                    front.push(u);
                }
            }
        }
        zone.extend(found);
    }
    zone
}

/// Adds the triangles connected with a zone that lie off the surface of their own face.
fn add_misfits(bench: &Bench, attempt: &Attempt, zone: &mut BTreeSet<u32>) {
    let mesh = &bench.closed.mesh;
    let limit = MISFIT * bench.tolerances.spacing();
    let misfit = |t: usize| {
        let patch = attempt.draft.patch_of[t] as usize;
        let surface = attempt.draft.patches[patch].surface;
        mesh.corners(t).iter().any(|p| match (&surface, &attempt.splines[patch]) {
            (Some(surface), _) => surface.signed_distance(p).abs() > limit,
            (None, Some(fitted)) => (nearest_on_spline(&fitted.surface, p) - p).norm() > limit,
            (None, None) => false,
        })
    };
    let mut front: Vec<u32> = zone.iter().copied().collect();
    while let Some(t) = front.pop() {
        for u in bench.half_edges.neighbours(t as usize).into_iter().flatten() {
            if !zone.contains(&(u as u32)) && misfit(u) {
                zone.insert(u as u32);
                front.push(u as u32);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brep::attempt::Choice;
    use crate::brep::check::check;
    use crate::brep::plain;
    use crate::brep::solid::Geometry;
    use crate::brep::thin::{Thinned, Thinning};
    use crate::brep::{LabelledMesh, tessellate};
    use crate::math::{Axis, Vec3};
    use crate::mesh::Mesh;
    use crate::recognize::{Primitive, Residual};
    use crate::segment::RegionId;
    use crate::surface::{Cylinder, Plane, Surface};
    use crate::tolerance::{Measured, Tolerances};

    const RADIUS: f64 = 10.0;
    const HEIGHT: f64 = 12.0;
    const N_ROUND: u32 = 64;
    const N_UP: u32 = 12;

    /// A rod: its wall is region 0, its bottom 1, its top 2.
    fn rod() -> LabelledMesh {
        let mut vertices = Vec::new();
        for i in 0..=N_UP {
            for k in 0..N_ROUND {
                let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / f64::from(N_ROUND)).sin_cos();
                vertices.push(Point3::new(
                    RADIUS * cos,
                    RADIUS * sin,
                    HEIGHT * f64::from(i) / f64::from(N_UP),
                ));
            }
        }
        let (mut triangles, mut labels) = (Vec::new(), Vec::new());
        let at = |i: u32, k: u32| i * N_ROUND + k % N_ROUND;
        for (i, k) in (0..N_UP).flat_map(|i| (0..N_ROUND).map(move |k| (i, k))) {
            triangles.push([at(i, k), at(i, k + 1), at(i + 1, k)]);
            triangles.push([at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)]);
            labels.extend([RegionId(0); 2]);
        }
        for (center, ring, label) in [(0.0, 0, 1), (HEIGHT, N_UP, 2)] {
            vertices.push(Point3::new(0.0, 0.0, center));
            let middle = vertices.len() as u32 - 1;
            for k in 0..N_ROUND {
                let (a, b) = (at(ring, k), at(ring, k + 1));
                triangles.push(if label == 1 { [middle, b, a] } else { [middle, a, b] });
                labels.push(RegionId(label));
            }
        }
        let plane = |z: f64, up: f64| {
            Surface::Plane(Plane {
                point: Point3::new(0.0, 0.0, z),
                normal: nalgebra::Unit::new_normalize(Vec3::z() * up),
            })
        };
        let axis = Axis { origin: Point3::origin(), direction: Vec3::z_axis() };
        let surfaces =
            [Surface::Cylinder(Cylinder { axis, radius: RADIUS }), plane(0.0, -1.0), plane(HEIGHT, 1.0)];
        let primitives = surfaces.map(|surface| Primitive {
            surface: Some(surface),
            outward: true,
            residual: Residual::default(),
            covariance: Vec::new(),
            ambiguous: None,
        });
        let assumed = vec![false; labels.len()];
        LabelledMesh { mesh: Mesh { vertices, triangles }, labels, primitives: primitives.to_vec(), assumed }
    }

    fn tolerances() -> Tolerances {
        let diagonal = (8.0 * RADIUS * RADIUS + HEIGHT * HEIGHT).sqrt();
        let measured = Measured {
            largest_coordinate: HEIGHT,
            diagonal,
            spacing: 1.0,
            noise: 0.0,
            normal_noise: 0.0,
            edge_rounding: 0.0,
        };
        Tolerances::new(measured, None)
    }

    fn choice(rod: &LabelledMesh, bench: &Bench, facet: impl Fn(&Point3) -> bool) -> Choice {
        let center = |t: usize| rod.mesh.triangle_center(t);
        let label = |t: usize| if facet(&center(t)) { bench.facets } else { rod.labels[t].0 };
        Choice {
            labels: (0..rod.labels.len()).map(label).collect(),
            demoted: vec![false; bench.surfaces.len()],
            shared: Vec::new(),
        }
    }

    #[test]
    fn facets_over_an_edge_fit_between_the_surfaces_beside_them() {
        let rod = rod();
        let tolerances = tolerances();
        let bench = Bench::new(&rod, &tolerances);
        for spline in [false, true] {
            // A piece of the wall and of the top, all round the edge between them.
            let mut choice = choice(&rod, &bench, |p| p.x > 0.0 && p.y.abs() < 5.0 && p.z > 6.5);
            choice.demoted[0] = spline;
            let attempt = bench.attempt(choice);
            let [made] = &attempt.solids[..] else { panic!("one solid, not {}", attempt.solids.len()) };
            assert_eq!(check(&made.solid, bench.limit), [], "wall a spline: {spline}");
            let n_facets = attempt.choice.labels.iter().filter(|l| **l == bench.facets).count();
            let flat = |s: &Geometry| matches!(s, Geometry::Analytic(Surface::Plane(_)));
            let n_flat = made.solid.surfaces.iter().filter(|s| flat(s)).count();
            assert!(n_facets > 50 && n_flat == n_facets + 2, "{n_flat} planes, {n_facets} facets");
            // No facet belongs to a region that does not exist.
            assert!(made.solid.faces.iter().all(|face| face.region.0 < 3));
            let volume = tessellate(&made.solid).mesh.signed_volume();
            let exact = std::f64::consts::PI * RADIUS * RADIUS * HEIGHT;
            // Chords of the mesh and of the triangles lie inside by at most the square of ten degrees.
            assert!((volume - exact).abs() < 0.015 * exact, "{volume} instead of {exact}");
        }
    }

    #[test]
    fn thinned_facets_are_fewer_and_as_near() {
        let rod = rod();
        let tolerances = tolerances();
        let bench = Bench::new(&rod, &tolerances);
        let choice = choice(&rod, &bench, |p| p.x > 0.0 && p.y.abs() < 5.0 && p.z > 6.5);
        let n_before = choice.labels.iter().filter(|l| **l == bench.facets).count();
        let is_plane: Vec<bool> =
            bench.surfaces.iter().map(|s| matches!(s, Some(Surface::Plane(_)))).collect();
        let thinning =
            Thinning { bench: &bench, labels: &choice.labels, is_plane: &is_plane, share: 1.0, rims: true };
        let Thinned { closed: thin, labels, .. } = thinning.run().expect("fewer facets");
        let n_after = labels.iter().filter(|l| **l == bench.facets).count();
        assert!(2 * n_after < n_before, "{n_after} of {n_before} facets are left");
        let thin_bench = Bench::new(&thin, &tolerances);
        let attempt = thin_bench.attempt(Choice { labels, ..choice });
        let [made] = &attempt.solids[..] else { panic!("one solid, not {}", attempt.solids.len()) };
        assert_eq!(check(&made.solid, bench.limit), []);
        let volume = tessellate(&made.solid).mesh.signed_volume();
        let exact = std::f64::consts::PI * RADIUS * RADIUS * HEIGHT;
        assert!((volume - exact).abs() < 0.02 * exact, "{volume} instead of {exact}");
    }

    /// A plane for the top that meets the wall nowhere near the mesh.
    fn missing_plane() -> Surface {
        Surface::Plane(Plane {
            point: Point3::new(0.0, 0.0, HEIGHT),
            normal: nalgebra::Unit::new_normalize(Vec3::new(1.0, 0.2, 0.05)),
        })
    }

    fn with_slivers(mut rod: LabelledMesh) -> LabelledMesh {
        // Edges are split at one of their ends, which leaves triangles without area that no edge flip removes.
        for t in [100, 300, 500] {
            let [a, b, _] = rod.mesh.triangles[t];
            let middle = rod.mesh.vertices.len() as u32;
            rod.mesh.vertices.push(rod.mesh.vertices[a as usize]);
            for u in 0..rod.mesh.triangles.len() {
                let corners = rod.mesh.triangles[u];
                if corners.contains(&a) && corners.contains(&b) {
                    rod.mesh.triangles[u] = corners.map(|v| if v == a { middle } else { v });
                    rod.mesh.triangles.push(corners.map(|v| if v == b { middle } else { v }));
                    rod.labels.push(rod.labels[u]);
                    rod.assumed.push(false);
                }
            }
        }
        rod
    }

    #[test]
    fn what_mending_leaves_ends_in_a_sound_solid() {
        let mut rod = with_slivers(rod());
        rod.primitives[2].surface = Some(missing_plane());
        let tolerances = tolerances();
        let bench = Bench::new(&rod, &tolerances);
        let start = bench.attempt(choice(&rod, &bench, |_| false));
        assert!(start.is_fatal());
        let exact = std::f64::consts::PI * RADIUS * RADIUS * HEIGHT;
        for built in [plain::plainly_built(&bench, start), plain::whole(&bench).expect("it is closed")] {
            let [solid] = &built.solids[..] else { panic!("one solid, not {}", built.solids.len()) };
            assert_eq!(check(solid, bench.limit), []);
            let volume = tessellate(solid).mesh.signed_volume();
            assert!((volume - exact).abs() < 0.03 * exact, "{volume} instead of {exact}");
        }
    }

    #[test]
    fn a_surface_that_misses_its_neighbours_is_mended_where_it_does() {
        let mut rod = rod();
        rod.primitives[2].surface = Some(missing_plane());
        let tolerances = tolerances();
        let bench = Bench::new(&rod, &tolerances);
        let start = bench.attempt(choice(&rod, &bench, |_| false));
        assert!(start.severity() > 0.0);
        let mended = faceted(&bench, start);
        assert!(!mended.flaws.iter().any(|f| f.fatal), "{:?}", mended.flaws);
        let facets = mended.choice.labels.iter().filter(|l| **l == bench.facets).count();
        assert!(facets > 0 && facets < rod.labels.len());
    }
}
