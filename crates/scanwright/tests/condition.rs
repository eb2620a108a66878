//! Tests of measuring and of the table.

use scanwright::condition::{find_support, measure};
use scanwright::math::{Point3, UnitVec3, Vec3, angle_between};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::tolerance::Tolerances;

use crate::scanned::{blend, box_distance, scan, with_noise};
use crate::scans;

#[test]
fn planted_noise_is_measured_within_a_few_percent() {
    let clean = block();
    for sigma in [0.02, 0.08, 0.2] {
        let measured = measured(&with_noise(&clean, sigma, 1));
        // Over 10,000 patches of 13 degrees of freedom each vertex counts: 1 % of statistics, 2 % of clipping, and
        // some patches that touch an edge.
        assert!((measured.noise / sigma - 1.0).abs() < 0.06, "{sigma}: {measured:?}");
    }
}

#[test]
fn normal_noise_is_the_deviation_from_the_true_normals() {
    let clean = block();
    let noisy = with_noise(&clean, 0.1, 2);
    let (true_normals, normals) = (clean.triangle_normals(), noisy.triangle_normals());
    let mut angles: Vec<f64> = true_normals.iter().zip(&normals).map(|(a, b)| angle_between(a, b)).collect();
    angles.sort_by(f64::total_cmp);
    // The median of a Rayleigh distribution is 1.177 of its parameter. The quadric of a patch takes 6 of 19 degrees
    // of freedom, so it follows the noise a little: at most one part in four.
    let expected = angles[angles.len() / 2] / 1.1774;
    let ratio = measured(&noisy).normal_noise / expected;
    assert!((0.75..1.1).contains(&ratio), "{ratio}");
}

#[test]
fn a_flat_sided_block_without_noise_has_none() {
    let measured = measured(&block());
    assert!(measured.noise < 1e-6 * measured.spacing, "{measured:?}");
    assert!(measured.normal_noise < 1e-5, "{measured:?}");
}

#[test]
fn measures_follow_scale_and_shift() {
    let mesh = with_noise(&block(), 0.05, 3);
    let first = measured(&mesh);
    let shift = Vec3::new(1e3, -2e3, 5e2);
    for scale in [1e-3, 1e3] {
        let vertices = mesh.vertices.iter().map(|p| Point3::from((p.coords + shift) * scale)).collect();
        let second = measured(&Mesh { vertices, triangles: mesh.triangles.clone() });
        let pairs = [
            (first.spacing * scale, second.spacing),
            (first.noise * scale, second.noise),
            (first.normal_noise, second.normal_noise),
            (first.edge_rounding * scale, second.edge_rounding),
        ];
        for (a, b) in pairs {
            // Shifting costs digits of the coordinates: 1e3 / 0.05 * 1e-16, and decisions may fall differently.
            assert!((a - b).abs() <= 1e-6 * a, "{first:?} {second:?}");
        }
    }
}

#[test]
fn sharp_edges_show_that_there_is_no_spot() {
    // Zero would mean that nothing is known, and segmentation would take a spacing for the spot.
    let block = scans::block([24.0, 18.0, 12.0], 1.2);
    let measured = measured(&block);
    assert!(measured.edge_rounding > 0.0 && measured.edge_rounding < 0.2 * measured.spacing, "{measured:?}");
}

#[test]
fn the_spot_is_read_from_rounded_edges() {
    for spot in [0.8, 1.2] {
        let roof = sheet(120, 80, |u, v| {
            let t = (u - 60.0) * 0.707;
            Point3::new(t, v, -mean_distance(t, spot))
        });
        for sign in [1.0, -1.0] {
            // Seen from the other side the ridge is a valley: rounding is the same.
            let vertices = roof.vertices.iter().map(|p| Point3::new(p.x, p.y, p.z * sign)).collect();
            let mesh = Mesh { vertices, triangles: roof.triangles.clone() };
            let found = measured(&with_noise(&mesh, 0.03, 4)).edge_rounding;
            assert!((found / spot - 1.0).abs() < 0.2, "{spot} {sign}: {found}");
        }
    }
}

#[test]
fn a_fillet_beside_sharp_edges_is_not_the_spot() {
    let rounding = |filleted: bool| {
        let roofs = sheet(240, 80, |u, v| {
            // Two ridges, 85 apart: the second one is three times as round.
            let (t, spot) = if u < 120.0 { ((u - 60.0) * 0.707, 0.8) } else { ((u - 180.0) * 0.707, 2.4) };
            let spot = if filleted { spot } else { 0.8 };
            let across = if u < 120.0 { t } else { t + 84.84 };
            Point3::new(across, v, -mean_distance(t, spot))
        });
        measured(&with_noise(&roofs, 0.03, 5)).edge_rounding
    };
    let (sharp, mixed) = (rounding(false), rounding(true));
    assert!((mixed / sharp - 1.0).abs() < 0.1, "{sharp} {mixed}");
}

#[test]
fn hostile_meshes_are_measured_without_panic() {
    let triangle = |points: [Point3; 3]| Mesh { vertices: points.to_vec(), triangles: vec![[0, 1, 2]] };
    let origin = Point3::origin();
    let x = Point3::new(1.0, 0.0, 0.0);
    for mesh in [
        Mesh::default(),
        triangle([origin; 3]),
        triangle([origin, x, Point3::new(2.0, 0.0, 0.0)]),
        triangle([origin, x, Point3::new(0.0, 1.0, 0.0)]),
        Mesh { vertices: vec![origin, x, x], triangles: vec![[0, 1, 2]; 40] },
        Mesh { vertices: vec![origin; 5], triangles: vec![] },
    ] {
        let adjacency = Adjacency::new(&mesh);
        let measured = measure(&mesh, &adjacency);
        assert!(measured.noise.is_finite() && measured.spacing.is_finite() && measured.edge_rounding == 0.0);
        assert_eq!(find_support(&mesh, &adjacency, &Tolerances::new(measured, None), None), None);
    }
}

#[test]
fn tables_with_one_to_four_parts_are_cut_off() {
    for n_parts in [1, 2, 4] {
        for noise in [0.02, 0.2] {
            check_table(&scene(n_parts), noise, n_parts);
        }
    }
}

#[test]
fn a_tilted_table_is_found_too() {
    let tilt = nalgebra::Rotation3::from_euler_angles(0.4, -0.9, 0.2);
    let (mesh, adjacency, tolerances) = prepared(&scene(1), 0.1);
    let straight = find_support(&mesh, &adjacency, &tolerances, None).unwrap();
    let vertices = mesh.vertices.iter().map(|p| tilt * p).collect();
    let tilted = Mesh { vertices, triangles: mesh.triangles.clone() };
    let found = find_support(&tilted, &adjacency, &tolerances, None).unwrap();
    let expected = tilt * straight.plane.normal.into_inner();
    assert!(angle_between(&expected, &found.plane.normal) < 1e-9);
    assert_eq!(straight.on_table, found.on_table);
}

#[test]
fn what_narrow_bores_show_of_the_table_is_table() {
    // Fusion lifts the table in the bore as a whole: it is nowhere as low as the table round the part.
    let part = |p: &Point3| box_distance(p, [0.0; 3], [12.0, 12.0, 9.0]).max(3.5 - p.x.hypot(p.y));
    let distance = |p: &Point3| blend(p.z, part(p), 5.0);
    let scene = scan(distance, [-30.3, -30.3, -3.3], [30.0, 30.0, 13.0], 1.0);
    let (mesh, adjacency, tolerances) = prepared(&scene, 0.15);
    let support = find_support(&mesh, &adjacency, &tolerances, None).expect("there is a table");
    let low = |t: &usize| {
        let p = scene.triangle_center(*t);
        p.x.hypot(p.y) < 1.5 && p.z < 2.0
    };
    let shown: Vec<usize> = (0..mesh.triangles.len()).filter(low).collect();
    assert!(shown.len() > 10 && shown.iter().all(|t| scene.triangle_center(*t).z > 0.15));
    let kept = shown.iter().filter(|t| !support.on_table[**t]).count();
    // Noise tilts some of them like the skirt of a wall.
    assert!(2 * kept < shown.len(), "{kept} of {} triangles are taken for part", shown.len());
}

#[test]
fn a_hint_against_the_table_leaves_it() {
    let (mesh, adjacency, tolerances) = prepared(&scene(1), 0.1);
    let up = |z: f64| Some(UnitVec3::new_normalize(Vec3::new(0.1, 0.0, z)));
    assert!(find_support(&mesh, &adjacency, &tolerances, up(1.0)).is_some());
    assert!(find_support(&mesh, &adjacency, &tolerances, up(-1.0)).is_none());
}

#[test]
fn parts_without_a_table_keep_their_planes() {
    let plate = |p: &Point3| box_distance(p, [0.0; 3], [30.0, 20.0, 1.5]);
    let boss = |p: &Point3| plate(p).min(box_distance(p, [0.0, 0.0, 6.0], [8.0, 8.0, 6.0]));
    let whole = scan(plate, [-33.3, -23.3, -4.3], [33.0, 23.0, 4.0], 1.0);
    let open_below = scan(boss, [-33.3, -23.3, -0.8], [33.0, 23.0, 15.0], 1.0);
    let one_sided = scan(plate, [-29.3, -19.3, 0.1], [29.0, 19.0, 4.0], 1.0);
    for (name, mesh) in [("whole", whole), ("open below", open_below), ("one side of a plate", one_sided)] {
        let (mesh, adjacency, tolerances) = prepared(&mesh, 0.1);
        assert_eq!(find_support(&mesh, &adjacency, &tolerances, None), None, "{name}");
    }
}

fn check_table(scene: &Mesh, noise: f64, n_parts: usize) {
    let (mesh, adjacency, tolerances) = prepared(scene, noise);
    let support = find_support(&mesh, &adjacency, &tolerances, None).expect("there is a table");
    assert!(angle_between(&support.plane.normal, &Vec3::z()) < 0.01);
    assert!(support.plane.point.z.abs() < 0.05);
    // Beyond the blend, triangles lower than half a spacing are the table; the parts rise to 6 and more.
    let (mut right, mut wrong) = (0, 0);
    for (t, on_table) in support.on_table.iter().enumerate() {
        let p = scene.triangle_center(t);
        let to_part = part_distance(&p, n_parts);
        if to_part.abs() < 2.0 && p.z < 3.0 {
            continue;
        }
        let is_table = to_part > 2.0;
        if is_table && *on_table {
            right += 2;
        } else if is_table != *on_table {
            wrong += 1;
        }
    }
    let f1 = f64::from(right) / f64::from(right + wrong);
    assert!(f1 >= 0.99, "{n_parts} parts, noise {noise}: {f1}");
    assert_eq!(support.outlines.len(), n_parts, "{n_parts} parts, noise {noise}");
    for outline in &support.outlines {
        // 16 by 16, farther out by what the blend adds on each side: up to one and a half.
        let area = polygon_area(outline);
        assert!((240.0..380.0).contains(&area), "{area}");
        assert!(outline.iter().all(|p| support.plane.signed_distance(p).abs() < 1e-9));
    }
}

/// Boxes of 16 by 16 on a table, up to four.
fn scene(n_parts: usize) -> Mesh {
    let distance = move |p: &Point3| blend(p.z, part_distance(p, n_parts), 2.0);
    scan(distance, [-40.3, -40.3, -3.3], [40.0, 40.0, 13.0], 1.0)
}

fn part_distance(p: &Point3, n_parts: usize) -> f64 {
    let centers = [[-15.0, -15.0], [15.0, -15.0], [-15.0, 15.0], [15.0, 15.0]];
    let heights = [9.0, 6.0, 7.0, 10.0];
    let one = |i: usize| box_distance(p, [centers[i][0], centers[i][1], 0.0], [8.0, 8.0, heights[i]]);
    (0..n_parts).map(one).fold(f64::MAX, f64::min)
}

fn prepared(clean: &Mesh, noise: f64) -> (Mesh, Adjacency, Tolerances) {
    let mesh = with_noise(clean, noise, 7);
    let adjacency = Adjacency::new(&mesh);
    let tolerances = Tolerances::new(measure(&mesh, &adjacency), None);
    (mesh, adjacency, tolerances)
}

fn measured(mesh: &Mesh) -> scanwright::tolerance::Measured {
    measure(mesh, &Adjacency::new(mesh))
}

/// A closed block of 40 by 30 by 20 spacings.
fn block() -> Mesh {
    let distance = |p: &Point3| box_distance(p, [0.0; 3], [20.0, 15.0, 10.0]);
    scan(distance, [-23.3, -18.3, -13.3], [23.0, 18.0, 13.0], 1.0)
}

/// A sheet of `nu` by `nv` squares.
fn sheet(nu: usize, nv: usize, at: impl Fn(f64, f64) -> Point3) -> Mesh {
    let mut mesh = Mesh::default();
    for u in 0..=nu {
        for v in 0..=nv {
            mesh.vertices.push(at(u as f64, v as f64));
        }
    }
    for u in 0..nu {
        for v in 0..nv {
            let [a, b] = [u, u + 1].map(|u| (u * (nv + 1) + v) as u32);
            mesh.triangles.push([a, b, b + 1]);
            mesh.triangles.push([a, b + 1, a + 1]);
        }
    }
    mesh
}

/// Mean of |t + spot x| for standard normal x, by the trapezoid rule.
fn mean_distance(t: f64, spot: f64) -> f64 {
    let (mut sum, mut weight) = (0.0, 0.0);
    for i in -600..=600 {
        let x = f64::from(i) * 0.01;
        let w = (-0.5 * x * x).exp();
        sum += w * (t + spot * x).abs();
        weight += w;
    }
    sum / weight
}

fn polygon_area(outline: &[Point3]) -> f64 {
    let n = outline.len();
    let doubled: f64 =
        (0..n).map(|i| (outline[i], outline[(i + 1) % n])).map(|(a, b)| a.x * b.y - b.x * a.y).sum();
    0.5 * doubled.abs()
}
