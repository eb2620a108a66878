//! Regions and surfaces of small scans with a spot as wide as their vertex spacing, which is one.

use scanwright::condition::measure;
use scanwright::denoise::ring_filtered_normals;
use scanwright::math::{Point3, Vec3};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::pipeline::{self, Options};
use scanwright::progress::Progress;
use scanwright::segment::{RegionId, SegmentOptions, Segmentation, segment};
use scanwright::surface::{Surface, SurfaceKind};
use scanwright::tolerance::{Measured, Tolerances};

use crate::scanned::{blurred, box_distance, scan, with_noise};

/// Deviation of the noise.
const NOISE: f64 = 0.05;
/// Deviation of the scanner's spot where it is not the point of the test.
pub const SPOT: f64 = 0.8;

/// A scan of `distance`, one unit between vertices, open where the surface leaves the box.
pub fn seen(distance: impl Fn(&Point3) -> f64, spot: f64, lo: [f64; 3], hi: [f64; 3]) -> Mesh {
    with_noise(&scan(blurred(distance, spot, 2.0), lo, hi, 1.0), NOISE, 11)
}

pub fn segmented(mesh: &Mesh, spot: f64) -> Segmentation {
    let adjacency = Adjacency::new(mesh);
    // The spot is given: scans without an edge do not show it.
    let measured = Measured { edge_rounding: spot, ..measure(mesh, &adjacency) };
    let tolerances = Tolerances::new(measured, None);
    let normals = ring_filtered_normals(mesh, &adjacency, &tolerances);
    segment(mesh, &adjacency, &normals, &tolerances, &SegmentOptions::default())
}

/// Types of all regions, sorted; `None` for freeform.
pub fn kinds(segmentation: &Segmentation) -> Vec<Option<SurfaceKind>> {
    let mut kinds: Vec<_> = segmentation.primitives.iter().map(|p| p.surface.map(|s| s.kind())).collect();
    kinds.sort_unstable();
    kinds
}

/// The regions of the triangles whose middle is `inside`, and how many of them each has.
pub fn regions_of(
    mesh: &Mesh,
    segmentation: &Segmentation,
    inside: impl Fn(&Point3) -> bool,
) -> Vec<(RegionId, usize)> {
    let mut counts = vec![0; segmentation.primitives.len()];
    for (t, label) in segmentation.labels.iter().enumerate() {
        if let (Some(region), true) = (label, inside(&mesh.triangle_center(t))) {
            counts[region.0 as usize] += 1;
        }
    }
    let found = counts.into_iter().enumerate().filter(|(_, n)| *n > 0);
    found.map(|(region, n)| (RegionId(region as u32), n)).collect()
}

/// The only surface of a scan.
fn only_surface(mesh: &Mesh, spot: f64) -> Surface {
    let segmentation = segmented(mesh, spot);
    assert_eq!(segmentation.primitives.len(), 1, "{:?}", kinds(&segmentation));
    segmentation.primitives[0].surface.expect("an analytic surface")
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

/// Bound of a radius from `n` vertices: five deviations of a mean, and what the law of the blur leaves out.
fn radius_bound(n: usize, spot: f64, radius: f64) -> f64 {
    5.0 * NOISE / (n as f64).sqrt() + spot.powi(4) / radius.powi(3)
}

/// A shaft or a bore of `radius` about z, a tube without ends.
fn round_wall(radius: f64, outward: bool) -> impl Fn(&Point3) -> f64 {
    move |p| (p.x.hypot(p.y) - radius) * if outward { 1.0 } else { -1.0 }
}

#[test]
fn a_shaft_and_a_bore_have_the_radius_that_blur_took() {
    let (radius, spot) = (8.0, 1.2);
    for outward in [true, false] {
        let mesh = seen(round_wall(radius, outward), spot, [-11.5, -11.5, 0.0], [11.5, 11.5, 24.0]);
        let bound = radius_bound(mesh.vertices.len(), spot, radius);
        let shrunk = spot * spot / (2.0 * radius);
        let raw = mean(mesh.vertices.iter().map(|p| p.x.hypot(p.y)));
        assert!((raw - (radius - shrunk)).abs() < bound, "{raw} in the scan");
        assert!(bound < 0.3 * shrunk, "{bound} would not notice {shrunk}");
        let Surface::Cylinder(found) = only_surface(&mesh, spot) else { panic!("not a cylinder") };
        assert!((found.radius - radius).abs() < bound, "{} within {bound}", found.radius);
    }
}

#[test]
fn a_ball_has_the_radius_that_blur_took() {
    let (radius, spot) = (10.0, 1.2);
    let mesh = seen(|p| p.coords.norm() - radius, spot, [-12.5; 3], [12.5; 3]);
    let bound = radius_bound(mesh.vertices.len(), spot, radius);
    let shrunk = spot * spot / radius;
    let raw = mean(mesh.vertices.iter().map(|p| p.coords.norm()));
    assert!((raw - (radius - shrunk)).abs() < bound, "{raw} in the scan");
    assert!(bound < 0.3 * shrunk, "{bound} would not notice {shrunk}");
    let Surface::Sphere(found) = only_surface(&mesh, spot) else { panic!("not a sphere") };
    assert!((found.radius - radius).abs() < bound, "{} within {bound}", found.radius);
}

#[test]
fn a_ring_has_the_radii_that_blur_took() {
    let (major, minor, spot) = (13.0, 6.0, 1.2);
    let distance = |p: &Point3| (p.x.hypot(p.y) - major).hypot(p.z) - minor;
    let mesh = seen(distance, spot, [-21.5, -21.5, -8.5], [21.5, 21.5, 8.5]);
    let bound = radius_bound(mesh.vertices.len(), spot, minor);
    let shrunk = spot * spot / (2.0 * minor);
    let raw = minor + mean(mesh.vertices.iter().map(distance));
    // The curvature round the axis averages to nothing over the area but for what `r` weighs outside and inside.
    assert!((raw - (minor - shrunk)).abs() < 0.3 * shrunk, "{raw} in the scan");
    assert!(bound < 0.3 * shrunk, "{bound} would not notice {shrunk}");
    let Surface::Torus(found) = only_surface(&mesh, spot) else { panic!("not a torus") };
    assert!((found.minor_radius - minor).abs() < bound, "{} within {bound}", found.minor_radius);
    assert!((found.major_radius - major).abs() < bound, "{} within {bound}", found.major_radius);
}

/// Legs of a chamfer five spacings wide.
const LEG: f64 = 3.54;

#[test]
fn a_chamfer_between_planes_is_a_plane() {
    let distance = |p: &Point3| p.x.max(p.z).max((p.x + p.z + LEG) * 0.5_f64.sqrt());
    let mesh = seen(distance, SPOT, [-18.0, 0.0, -18.0], [4.0, 30.0, 4.0]);
    let segmentation = segmented(&mesh, SPOT);
    assert_eq!(kinds(&segmentation), [Some(SurfaceKind::Plane); 3]);
    let expected = Vec3::new(1.0, 0.0, 1.0).normalize();
    let tilt = segmentation.primitives.iter().filter_map(|p| match p.surface {
        Some(Surface::Plane(plane)) => Some(plane.normal.angle(&expected).to_degrees()),
        _ => None,
    });
    let tilt = tilt.fold(f64::MAX, f64::min);
    assert!(tilt < 3.0, "the chamfer is {tilt} degrees off");
}

/// Radius and height of a turned post.
const POST: (f64, f64) = (14.0, 12.0);

#[test]
fn a_chamfer_of_a_post_is_a_cone() {
    let distance = |p: &Point3| {
        let (side, top) = (p.x.hypot(p.y) - POST.0, p.z - POST.1);
        side.max(top).max((side + top + LEG) * 0.5_f64.sqrt())
    };
    let mesh = seen(distance, SPOT, [-17.0, -17.0, -2.0], [17.0, 17.0, 15.0]);
    let segmentation = segmented(&mesh, SPOT);
    let expected = [SurfaceKind::Plane, SurfaceKind::Cylinder, SurfaceKind::Cone].map(Some);
    assert_eq!(kinds(&segmentation), expected);
    let half_angle = segmentation.primitives.iter().find_map(|p| match p.surface {
        Some(Surface::Cone(cone)) => Some(cone.half_angle.to_degrees()),
        _ => None,
    });
    assert!(half_angle.is_some_and(|a| (a - 45.0).abs() < 3.0), "{half_angle:?}");
}

/// Types of the regions of a post with a fillet, and the fillet's radius if it is a torus.
fn filleted(fillet: f64) -> (Vec<Option<SurfaceKind>>, Option<f64>) {
    let distance = |p: &Point3| {
        let (side, top) = (p.x.hypot(p.y) - POST.0 + fillet, p.z - POST.1 + fillet);
        side.max(0.0).hypot(top.max(0.0)) + side.max(top).min(0.0) - fillet
    };
    let mesh = seen(distance, SPOT, [-17.0, -17.0, -2.0], [17.0, 17.0, 15.0]);
    let segmentation = segmented(&mesh, SPOT);
    let minor = segmentation.primitives.iter().find_map(|p| match p.surface {
        Some(Surface::Torus(torus)) => Some(torus.minor_radius),
        _ => None,
    });
    (kinds(&segmentation), minor)
}

const FILLETED: [Option<SurfaceKind>; 3] =
    [Some(SurfaceKind::Plane), Some(SurfaceKind::Cylinder), Some(SurfaceKind::Torus)];

#[test]
fn a_fillet_of_a_post_is_a_torus() {
    let fillet = 6.0;
    let (kinds, minor) = filleted(fillet);
    assert_eq!(kinds, FILLETED);
    assert!(minor.is_some_and(|a| (a - fillet).abs() < 0.03 * fillet), "{minor:?}");
}

#[test]
fn a_small_fillet_of_a_post_is_a_torus() {
    let fillet = 4.0;
    let (kinds, minor) = filleted(fillet);
    assert_eq!(kinds, FILLETED);
    assert!(minor.is_some_and(|a| (a - fillet).abs() < 0.1 * fillet), "{minor:?}");
}

/// A scan of the edge along y of a block that ends at x = 0 and z = 0, broken by `cut`, a distance in the section.
fn broken_edge(cut: impl Fn(f64, f64) -> f64) -> Mesh {
    seen(|p| p.x.max(p.z).max(cut(p.x, p.z)), SPOT, [-19.5, 0.0, -19.5], [3.5, 60.0, 3.5])
}

/// Rounds the edge off: the circle of `radius` that touches both sides, beyond its contacts.
fn rounded(radius: f64) -> impl Fn(f64, f64) -> f64 {
    move |x, z| if x > -radius && z > -radius { (x + radius).hypot(z + radius) - radius } else { f64::MIN }
}

/// Takes the edge off at 45 degrees, `leg` from it on both sides.
fn chamfered(leg: f64) -> impl Fn(f64, f64) -> f64 {
    move |x, z| (x + z + leg) * std::f64::consts::FRAC_1_SQRT_2
}

#[test]
fn a_fillet_of_four_spacings_is_tangent_to_the_planes_beside_it() {
    let radius = 4.0;
    let segmentation = segmented(&broken_edge(rounded(radius)), SPOT);
    assert_eq!(
        kinds(&segmentation),
        [Some(SurfaceKind::Plane), Some(SurfaceKind::Plane), Some(SurfaceKind::Cylinder)]
    );
    let surfaces = || segmentation.primitives.iter().filter_map(|p| p.surface);
    let cylinder = surfaces().find_map(|s| if let Surface::Cylinder(c) = s { Some(c) } else { None });
    let cylinder = cylinder.expect("a cylinder");
    assert!((cylinder.radius - radius).abs() < 0.1 * radius, "radius {}", cylinder.radius);
    for surface in surfaces() {
        let Surface::Plane(plane) = surface else { continue };
        let below = -plane.signed_distance(&cylinder.axis.origin);
        assert!((below - cylinder.radius).abs() < 1e-6, "the axis lies {below} below a side");
        assert!(cylinder.axis.direction.dot(&plane.normal).abs() < 1e-9);
    }
}

#[test]
fn a_chamfer_of_four_spacings_stays_flat_and_a_sharp_edge_sharp() {
    let planes = |n: usize| vec![Some(SurfaceKind::Plane); n];
    let chamfered = segmented(&broken_edge(chamfered(4.0)), SPOT);
    assert_eq!(kinds(&chamfered), planes(3));
    let sharp = segmented(&broken_edge(|_, _| f64::MIN), SPOT);
    assert_eq!(kinds(&sharp), planes(2));
}

#[test]
fn triangles_at_an_edge_belong_to_the_nearer_side() {
    let mesh = broken_edge(|_, _| f64::MIN);
    let segmentation = segmented(&mesh, SPOT);
    let side_of = |region: RegionId| {
        let Some(Surface::Plane(plane)) = segmentation.primitives[region.0 as usize].surface else {
            panic!("no plane")
        };
        plane.normal.x > plane.normal.z
    };
    let near = |p: &Point3| p.x.max(p.z) > -3.0 && p.x.min(p.z) > -3.0;
    let (mut n, mut n_wrong) = (0, 0);
    for (t, label) in segmentation.labels.iter().enumerate() {
        let center = mesh.triangle_center(t);
        if near(&center) {
            n += 1;
            // The bisector is where both planes are equally far; triangles within the noise of it may be either.
            let past = center.x.abs() - center.z.abs();
            n_wrong +=
                usize::from(past.abs() > 2.0 * NOISE && side_of(label.expect("a label")) != (past < 0.0));
        }
    }
    assert!(n > 300 && n_wrong * 100 <= n, "{n_wrong} of {n} triangles lie on the wrong side");
}

/// Radius of the holes and pins below, whose axis is x.
const HOLE: f64 = 6.0;

fn from_axis(p: &Point3) -> f64 {
    p.y.hypot(p.z)
}

/// Without the triangles whose middle is `hidden`.
pub fn without(mesh: &Mesh, hidden: impl Fn(&Point3) -> bool) -> Mesh {
    mesh.submesh(|t| !hidden(&mesh.triangle_center(t))).0
}

/// The cylinders over the walls of the holes or pins, and how many triangles each has.
fn walls_of_holes(mesh: &Mesh, segmentation: &Segmentation) -> Vec<(RegionId, usize)> {
    let mut walls = regions_of(mesh, segmentation, |p| (from_axis(p) - HOLE).abs() < 0.5 && p.x.abs() < 11.0);
    walls.retain(|(region, n)| {
        let surface = segmentation.primitives[region.0 as usize].surface;
        *n > 40 && surface.is_some_and(|s| s.kind() == SurfaceKind::Cylinder)
    });
    walls
}

#[test]
fn a_bore_seen_from_both_mouths_is_one_region() {
    let distance = |p: &Point3| box_distance(p, [0.0; 3], [13.0, 11.0, 11.0]).max(HOLE - from_axis(p));
    let mesh = seen(distance, SPOT, [-15.5, -13.5, -13.5], [15.5, 13.5, 13.5]);
    let mesh = without(&mesh, |p| p.x.abs() < 5.0 && from_axis(p) < HOLE + 1.0);
    let segmentation = segmented(&mesh, SPOT);
    let walls = walls_of_holes(&mesh, &segmentation);
    assert_eq!(walls.len(), 1, "{walls:?} of {:?}", kinds(&segmentation));
    assert_eq!(segmentation.primitives.len(), 7, "{:?}", kinds(&segmentation));
}

#[test]
fn holes_in_the_legs_of_a_fork_are_two_regions() {
    // The inner mouths were not seen: both walls end on borders of the scan that face each other across the slot.
    let distance = |p: &Point3| {
        let slot = box_distance(p, [0.0, 0.0, 4.0], [4.0, 20.0, 18.0]);
        box_distance(p, [0.0; 3], [13.0, 11.0, 20.0]).max(-slot).max(HOLE - from_axis(p))
    };
    let mesh = seen(distance, SPOT, [-15.5, -13.5, -22.5], [15.5, 13.5, 22.5]);
    let mesh = without(&mesh, |p| p.x.abs() < 5.5 && from_axis(p) < HOLE + 1.5);
    let segmentation = segmented(&mesh, SPOT);
    let walls = walls_of_holes(&mesh, &segmentation);
    assert_eq!(walls.len(), 2, "{walls:?} of {:?}", kinds(&segmentation));
}

#[test]
fn pins_that_face_each_other_are_two_regions() {
    // Their ends were not seen.
    let distance = |p: &Point3| (from_axis(p) - HOLE).max(4.0 - p.x.abs()).max(p.x.abs() - 16.0);
    let mesh = seen(distance, SPOT, [-18.5, -8.5, -8.5], [18.5, 8.5, 8.5]);
    let mesh = without(&mesh, |p| p.x.abs() < 5.5);
    let segmentation = segmented(&mesh, SPOT);
    let walls = walls_of_holes(&mesh, &segmentation);
    assert_eq!(walls.len(), 2, "{walls:?} of {:?}", kinds(&segmentation));
}

/// The scan of a part on a table at height zero, as the pipeline leaves it: the mesh without the table, and the
/// labels of its triangles.
fn run_on_table(part: impl Fn(&Point3) -> f64) -> (Mesh, Segmentation) {
    let mesh = seen(|p| part(p).min(p.z), SPOT, [-22.0, -22.0, -4.0], [22.0, 22.0, 18.5]);
    let result = pipeline::run(&mesh, &Options::default(), &Progress::none()).expect("a result");
    let support = result.support.expect("a table");
    let (part, source, _) = result.mesh.submesh(|t| !support.on_table[t]);
    let labels = source.iter().map(|&t| result.segmentation.labels[t as usize]).collect();
    (part, Segmentation { labels, primitives: result.segmentation.primitives })
}

/// Share of the triangles `inside` that the largest region among them has.
fn largest_share(mesh: &Mesh, segmentation: &Segmentation, inside: impl Fn(&Point3) -> bool) -> f64 {
    let all = (0..mesh.triangles.len()).filter(|t| inside(&mesh.triangle_center(*t))).count();
    let largest = regions_of(mesh, segmentation, inside).into_iter().map(|(_, n)| n).max().unwrap_or(0);
    largest as f64 / all as f64
}

#[test]
fn a_post_on_a_table_is_one_cylinder_down_to_the_cut() {
    let (mesh, segmentation) = run_on_table(|p| (p.x.hypot(p.y) - 10.0).max(p.z - 15.0));
    assert_eq!(kinds(&segmentation), [SurfaceKind::Plane, SurfaceKind::Cylinder].map(Some));
    let share = largest_share(&mesh, &segmentation, |p| p.z < 13.0);
    assert!(share > 0.99, "{share} of the wall is one region");
}

#[test]
fn walls_on_a_table_are_planes_down_to_the_cut() {
    let (mesh, segmentation) = run_on_table(|p| box_distance(p, [0.0, 0.0, 5.0], [10.0, 10.0, 10.0]));
    assert_eq!(kinds(&segmentation), [Some(SurfaceKind::Plane); 5]);
    for axis in 0..2 {
        for side in [-1.0, 1.0] {
            let share = largest_share(&mesh, &segmentation, |p| {
                p[axis] * side > 8.5 && p[1 - axis].abs() < 8.0 && p.z < 13.0
            });
            assert!(share > 0.99, "{share} of a wall is one region");
        }
    }
}
