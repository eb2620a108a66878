//! Faces that only show what they are together: narrow turned ones in their profile, lands on one round, bores across
//! what was not seen, lands of thin wedges. The spot is nearly as wide as the vertex spacing, which is one.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use scanwright::math::{Point3, Vec3};
use scanwright::segment::RegionId;
use scanwright::surface::{Cylinder, Plane, Surface, SurfaceKind};

use crate::scanned::{blurred, box_distance, scan, with_noise};
use crate::segmentation::{SPOT, kinds, regions_of, seen, segmented, without};

fn from_z(p: &Point3) -> f64 {
    p.x.hypot(p.y)
}

#[test]
fn a_bore_seen_little_of_from_both_mouths_is_one_region() {
    // Deep in the block the mesh winds like material: hardly anything of what surrounds the place is missing.
    let (radius, half) = (5.0, 22.0);
    let from_axis = |p: &Point3| p.y.hypot(p.z);
    let distance = |p: &Point3| box_distance(p, [0.0; 3], [half, 9.0, 9.0]).max(radius - from_axis(p));
    let mesh = seen(distance, SPOT, [-24.5, -11.5, -11.5], [24.5, 11.5, 11.5]);
    let mesh = without(&mesh, |p| p.x.abs() < half - 7.0 && from_axis(p) < radius + 1.0);
    let segmentation = segmented(&mesh, SPOT);
    let mut walls = regions_of(&mesh, &segmentation, |p| {
        (from_axis(p) - radius).abs() < 0.5 && p.x.abs() > half - 6.0 && p.x.abs() < half - 1.5
    });
    walls.retain(|w| w.1 > 40);
    assert_eq!(walls.len(), 1, "{walls:?} of {:?}", kinds(&segmentation));
}

#[test]
fn a_cross_hole_ends_at_a_bore_that_was_not_seen_there() {
    let (outer, bore, hole) = (15.0, 9.5, 3.5);
    let from_x = |p: &Point3| p.y.hypot(p.z);
    let distance = |p: &Point3| {
        let tube = (from_z(p) - outer).max(bore - from_z(p)).max(p.z.abs() - 16.0);
        tube.max(hole - from_x(p))
    };
    let mesh = seen(distance, SPOT, [-17.5, -17.5, -18.5], [17.5, 17.5, 18.5]);
    // The scanner saw the upper half of the bore: where the hole opens into the other half nothing seems to end it.
    let mesh = without(&mesh, |p| from_z(p) < bore + 0.6 && p.z < 1.0);
    let segmentation = segmented(&mesh, SPOT);
    let mut walls = regions_of(&mesh, &segmentation, |p| {
        (from_x(p) - hole).abs() < 0.5 && from_z(p) > bore + 1.5 && from_z(p) < outer - 1.5
    });
    walls.retain(|w| w.1 > 30);
    assert_eq!(walls.len(), 2, "{walls:?} of {:?}", kinds(&segmentation));
}

#[test]
fn lands_of_a_splined_shaft_share_one_cylinder() {
    let (tip, root, inner, n_teeth, half_slot) = (32.0, 27.0, 20.0, 20.0, 2.9);
    let distance = |p: &Point3| {
        let pitch = TAU / n_teeth;
        let turn = (p.y.atan2(p.x) / pitch).round() * pitch;
        let across = p.y * turn.cos() - p.x * turn.sin();
        let slot = (across.abs() - half_slot).max(root - from_z(p));
        (from_z(p) - tip).max(-slot).max(inner - from_z(p))
    };
    let spot = 0.4;
    let mesh = seen(distance, spot, [-34.5, -34.5, 0.0], [34.5, 34.5, 22.0]);
    let segmentation = segmented(&mesh, spot);
    let is_land = |c: &Cylinder| {
        (c.radius - tip).abs() < 0.4
            && c.axis.direction.z.abs() > 0.9999
            && c.axis.radial(&Point3::origin()).norm() < 0.4
    };
    let lands = segmentation
        .primitives
        .iter()
        .filter(|p| p.outward && matches!(p.surface, Some(Surface::Cylinder(c)) if is_land(&c)))
        .count();
    assert!(lands >= 18, "{lands} lands of {:?}", kinds(&segmentation));
}

/// A tube about `axis` whose mouth is chamfered inside and outside, `leg` of each.
fn chamfered_mouth(leg: f64, axis: Vec3) -> impl Fn(&Point3) -> f64 {
    let (outer, inner) = (18.0, 18.0 - 2.0 * leg - 3.2);
    move |p: &Point3| {
        let top = p.coords.dot(&axis);
        let r = (p.coords - axis * top).norm();
        let sides = (r - outer).max(inner - r).max(top);
        sides.max((r - outer + top + leg) * FRAC_1_SQRT_2).max((inner - r + top + leg) * FRAC_1_SQRT_2)
    }
}

#[test]
fn chamfer_ring_and_chamfer_are_told_apart_by_their_profile() {
    let leg = 2.4;
    // Askew to the scanner's grid, as parts lie.
    let axis = Vec3::new(0.21, 0.13, 1.0).normalize();
    let mesh = seen(chamfered_mouth(leg, axis), SPOT, [-23.5, -22.5, -17.0], [23.5, 22.5, 8.0]);
    let segmentation = segmented(&mesh, SPOT);
    let expected = [
        SurfaceKind::Plane,
        SurfaceKind::Cylinder,
        SurfaceKind::Cylinder,
        SurfaceKind::Cone,
        SurfaceKind::Cone,
    ];
    assert_eq!(kinds(&segmentation), expected.map(Some));
    for surface in segmentation.primitives.iter().filter_map(|p| p.surface) {
        match surface {
            Surface::Plane(plane) => {
                let height = plane.signed_distance(&Point3::origin()).abs();
                assert!(height < 0.15, "the ring lies {height} off");
            }
            Surface::Cone(cone) => {
                let off = (cone.half_angle.to_degrees() - 45.0).abs();
                assert!(off < 4.0, "a chamfer is {off} degrees off");
            }
            _ => {}
        }
    }
}

/// A wedge of 45 degrees along y.
fn wedge(p: &Point3) -> f64 {
    p.x.max((p.z - p.x) * FRAC_1_SQRT_2)
}

/// The scan of a wedge whose edge is cut off by a land of `width`, and the planes found.
fn blunt_wedge(width: f64) -> Vec<Plane> {
    let mesh = seen(|p| wedge(p).max(p.z + width), SPOT, WEDGE_BOX.0, WEDGE_BOX.1);
    let segmentation = segmented(&mesh, SPOT);
    assert_eq!(kinds(&segmentation), [Some(SurfaceKind::Plane); 3], "a land of {width}");
    let plane = |s: Surface| if let Surface::Plane(plane) = s { Some(plane) } else { None };
    segmentation.primitives.iter().filter_map(|p| plane(p.surface?)).collect()
}

const WEDGE_BOX: ([f64; 3], [f64; 3]) = ([-16.5, 0.0, -19.5], [2.5, 60.0, 2.5]);

/// Distance of the middle of a land of `width` from a plane.
fn off_land(plane: &Plane, width: f64) -> f64 {
    plane.signed_distance(&Point3::new(-0.5 * width, 30.0, -width)).abs()
}

#[test]
fn a_land_of_two_spacings_on_a_thin_wedge_is_a_plane() {
    let width = 2.0;
    let level = |plane: &&Plane| plane.normal.angle(&Vec3::z()).to_degrees() < 12.0;
    let planes = blunt_wedge(width);
    let land = planes.iter().find(level).expect("a land");
    assert!(off_land(land, width) < 0.3, "the land lies {} off", off_land(land, width));
}

#[test]
fn a_land_that_no_region_shows_is_put_in() {
    // The edge is too blunt for any spot; so narrow a land shows where it is, and hardly its direction.
    let width = 1.75;
    let off = |plane: &Plane| off_land(plane, width);
    let nearest = blunt_wedge(width).iter().map(off).fold(f64::INFINITY, f64::min);
    assert!(nearest < 0.3, "the land lies {nearest} off");
    // A sharp wedge under the same spot has none.
    let sharp = segmented(&seen(wedge, SPOT, WEDGE_BOX.0, WEDGE_BOX.1), SPOT);
    assert_eq!(kinds(&sharp), [Some(SurfaceKind::Plane); 2]);
}

#[test]
fn a_collar_with_blunt_ends_is_a_cylinder() {
    // Nine spacings wide under a spot of 1.3, its underside not seen: no neighbour says what rounds its lower end.
    let (shaft, collar, height, spot) = (12.0, 20.0, 9.0, 1.3);
    let distance = |p: &Point3| {
        let ring = (from_z(p) - collar).max(-p.z).max(p.z - height);
        ring.min(from_z(p) - shaft)
    };
    let clean = scan(blurred(distance, spot, 2.0), [-22.5, -22.5, -16.5], [22.5, 22.5, 24.5], 1.0);
    // A handheld scanner's noise.
    let mesh = with_noise(&clean, 0.2, 7);
    let mesh = without(&mesh, |p| p.z < 0.7 && p.z > -6.0 && from_z(p) < collar - 0.7);
    let segmentation = segmented(&mesh, spot);
    let mut walls = regions_of(&mesh, &segmentation, |p| {
        (from_z(p) - collar).abs() < 0.5 && p.z > 2.0 && p.z < height - 2.0
    });
    walls.sort_by_key(|w| std::cmp::Reverse(w.1));
    let kind = segmentation.primitives[walls[0].0.0 as usize].surface.map(|s| s.kind());
    assert_eq!(kind, Some(SurfaceKind::Cylinder), "{:?}", kinds(&segmentation));
}

#[test]
fn a_bent_pipe_changes_over_where_its_surfaces_touch() {
    let (bend, pipe) = (22.0, 6.0);
    let distance = |p: &Point3| {
        let off = if p.y > 0.0 { from_z(p) - bend } else { p.x.abs() - bend };
        off.hypot(p.z) - pipe
    };
    let mesh = seen(distance, SPOT, [-30.5, -24.5, -8.5], [30.5, 30.5, 8.5]);
    let segmentation = segmented(&mesh, SPOT);
    assert_eq!(
        kinds(&segmentation),
        [Some(SurfaceKind::Cylinder), Some(SurfaceKind::Cylinder), Some(SurfaceKind::Torus)]
    );
    let is_bend = |region: RegionId| {
        segmentation.primitives[region.0 as usize].surface.is_some_and(|s| s.kind() == SurfaceKind::Torus)
    };
    let farthest = (0..mesh.triangles.len()).filter_map(|t| {
        let y = mesh.triangle_center(t).y;
        let is_wrong = is_bend(segmentation.labels[t]?) != (y > 0.0);
        is_wrong.then_some(y.abs())
    });
    // The bend's centre is known to a fraction of a spacing.
    let farthest = farthest.fold(0.0, f64::max);
    assert!(farthest < 1.5, "triangles {farthest} from the contact have the wrong surface");
}
