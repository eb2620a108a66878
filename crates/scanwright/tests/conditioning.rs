//! Conditioning: damage is undone, nothing else is changed, and any triangles at all come out as oriented manifolds.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use scanwright::condition::{Conditioned, condition};
use scanwright::math::{Point3, Vec3};
use scanwright::mesh::{Adjacency, Mesh, VertId, boundary_loops};
use scanwright::random::Rng;
use std::collections::{BTreeMap, BTreeSet};

#[test]
fn a_damaged_cube_becomes_a_cube_again() {
    for seed in 0..40 {
        let mut rng = Rng::for_task(seed, "damage", 0);
        let whole = cube(1 + rng.below(6) as u32, Vec3::zeros());
        let damaged = damage(&whole, &mut rng);
        let conditioned = check(&damaged);
        let mesh = &conditioned.mesh;
        assert_eq!(mesh.triangles.len(), whole.triangles.len(), "seed {seed}");
        assert_eq!(mesh.vertices.len(), whole.vertices.len(), "seed {seed}");
        assert_eq!(euler_characteristic(mesh), 2, "seed {seed}");
        assert_eq!(conditioned.report.n_boundary_edges, 0, "seed {seed}");
        // Each of the n vertices on average moved by rounding only: far below the weld distance.
        assert_near(mesh.signed_volume(), 1.0, 6.0 * conditioned.report.weld_distance, "volume");
        assert_idempotent(&conditioned, &format!("seed {seed}"));
    }
}

#[test]
fn a_sound_mesh_comes_back_as_it_is() {
    for mesh in [cube(4, Vec3::zeros()), sheet(7, 5), sheet(1, 1), moebius_band(9, true)] {
        let conditioned = check(&mesh);
        assert_eq!(conditioned.mesh, mesh);
        assert!(conditioned.source_triangle.iter().enumerate().all(|(t, &source)| t == source as usize));
    }
}

#[test]
fn an_stl_soup_far_from_the_origin_is_welded() {
    // Coordinates in `f32` at ten thousand diagonals: their step is a hundredth of the edge.
    let mut rng = Rng::for_task(5, "far", 0);
    let n = 5;
    let far = cube(n, Vec3::new(1.7e4, -1.7e4, 0.3));
    let rounded: Vec<Point3> =
        far.vertices.iter().map(|p| Point3::from(p.coords.map(|x| f64::from(x as f32)))).collect();
    let soup = explode(&Mesh { vertices: rounded, triangles: far.triangles }, &mut rng, 1.0);
    let conditioned = check(&soup);
    assert_eq!(conditioned.mesh.vertices.len(), 6 * (n * n) as usize + 2);
    assert_eq!(euler_characteristic(&conditioned.mesh), 2);
}

#[test]
fn scaling_and_moving_change_nothing_but_positions() {
    let mut rng = Rng::for_task(6, "move", 0);
    let mesh = damage(&cube(5, Vec3::zeros()), &mut rng);
    let plain = check(&mesh);
    for scale in [1e-3, 1e3, 1e-20, 1e20] {
        let scaled = Mesh {
            vertices: mesh
                .vertices
                .iter()
                .map(|p| Point3::from(scale * (p.coords + Vec3::new(3.0, -2.0, 9.0))))
                .collect(),
            triangles: mesh.triangles.clone(),
        };
        let conditioned = check(&scaled);
        assert_eq!(conditioned.mesh.triangles, plain.mesh.triangles, "{scale}");
        assert_eq!(conditioned.source_triangle, plain.source_triangle, "{scale}");
    }
}

#[test]
fn cubes_that_touch_come_apart() {
    let n = 3;
    let at_a_vertex = (Vec3::new(1.0, 1.0, 1.0), 1, 0);
    let along_an_edge = (Vec3::new(1.0, 1.0, 0.0), n as usize + 1, n as usize);
    // The order of the triangles must not tell which belong together.
    for seed in 0..8 {
        for (offset, n_added, n_edges) in [at_a_vertex, along_an_edge] {
            let both = union(&[cube(n, Vec3::zeros()), cube(n, offset)]);
            let conditioned = check(&shuffled(&both, &mut Rng::for_task(seed, "touch", 0)));
            let report = &conditioned.report;
            assert_eq!((report.n_split_vertices, report.n_split_edges), (n_added, n_edges), "{offset}");
            assert_eq!((report.n_components, report.n_boundary_edges), (2, 0), "{offset}");
            assert_eq!(euler_characteristic(&conditioned.mesh), 4, "{offset}");
            assert_near(conditioned.mesh.signed_volume(), 2.0, 1e-12, "volume");
            assert_idempotent(&conditioned, "touching cubes");
        }
    }
}

#[test]
fn a_fin_is_cut_from_the_surface_that_it_stands_on() {
    let mut mesh = sheet(4, 4);
    // Over the inner edge from (1, 2) to (2, 2), at a right angle.
    let edge = [(1.0, 2.0), (2.0, 2.0)].map(|(x, y)| find(&mesh, Point3::new(x, y, 0.0)));
    mesh.vertices.push(Point3::new(1.5, 2.0, 1.0));
    mesh.triangles.push([edge[0], edge[1], mesh.vertices.len() as u32 - 1]);
    let conditioned = check(&mesh);
    assert_eq!(conditioned.report.n_split_edges, 1);
    assert_eq!(conditioned.report.n_components, 2);
    // The sheet's own rim and the fin's three sides.
    assert_eq!(conditioned.report.n_boundary_edges, 16 + 3);
    assert_eq!(conditioned.mesh.triangles, {
        let n = mesh.vertices.len() as u32;
        *mesh.triangles.last_mut().unwrap() = [n, n + 1, n - 1];
        mesh.triangles
    });
}

#[test]
fn a_one_sided_band_is_cut_open_once() {
    let conditioned = check(&moebius_band(12, false));
    // The two sides of the cut are a row of one edge here.
    assert_eq!(conditioned.report.n_one_sided_edges, 1);
    assert_eq!((conditioned.report.n_boundary_loops, conditioned.report.n_components), (1, 1));
    assert_eq!(euler_characteristic(&conditioned.mesh), 1);
    assert_idempotent(&conditioned, "band");
}

#[test]
fn closed_pieces_face_outward_and_open_ones_keep_their_side() {
    let inside_out = flipped(&cube(3, Vec3::zeros()), |_| true);
    let conditioned = check(&inside_out);
    assert_near(conditioned.mesh.signed_volume(), 1.0, 1e-12, "volume");
    assert_eq!(conditioned.report.n_flipped_triangles, inside_out.triangles.len());

    let mut with_hole = flipped(&cube(5, Vec3::zeros()), |_| true);
    with_hole.triangles.pop();
    assert!(check(&with_hole).mesh.signed_volume() > 0.9);

    // A box without its lid, seen from inside, and a sheet: open. The larger part is right.
    let mut open_box = flipped(&cube(3, Vec3::zeros()), |_| true);
    open_box.triangles.truncate(open_box.triangles.len() * 5 / 6);
    for mesh in [open_box, sheet(6, 6)] {
        let partly = flipped(&mesh, |t| t % 3 == 0);
        assert_eq!(check(&partly).mesh.triangles, mesh.triangles);
    }
}

#[test]
fn a_cavity_stays_a_cavity() {
    let scaled =
        |mesh: Mesh, by: f64| Mesh { vertices: mesh.vertices.iter().map(|p| p * by).collect(), ..mesh };
    let inner = flipped(&cube(2, Vec3::new(1.0, 1.0, 1.0)), |_| true);
    let hollow = union(&[scaled(cube(2, Vec3::zeros()), 3.0), inner.clone()]);
    assert_near(check(&hollow).mesh.signed_volume(), 26.0, 1e-9, "volume of the hollow cube");
    // With nothing around it the same piece is only inside out.
    assert_near(check(&inner).mesh.signed_volume(), 1.0, 1e-9, "volume alone");
}

#[test]
fn specks_go_and_seam_pieces_stay() {
    let part = cube(20, Vec3::zeros());
    let crumb = |offset: Vec3| {
        let vertices =
            cube(1, Vec3::zeros()).vertices.iter().map(|p| Point3::from(0.01 * p.coords + offset)).collect();
        Mesh { vertices, triangles: cube(1, Vec3::zeros()).triangles }
    };
    // Edges are 1/20: two of them away is a seam, ten are not.
    let near = crumb(Vec3::new(1.1, 0.5, 0.5));
    let far = crumb(Vec3::new(1.5, 0.5, 0.5));
    let conditioned = check(&union(&[far.clone(), part.clone(), near, far]));
    let report = &conditioned.report;
    assert_eq!((report.n_specks, report.n_speck_triangles, report.n_components), (1, 12, 2));
    assert_eq!(conditioned.source_triangle.first(), Some(&12));
    assert_eq!(conditioned.mesh.triangles.len(), part.triangles.len() + 12);

    // Thousands of crumbs and nothing else: the scan is what it is.
    let crumbs: Vec<Mesh> = (0..3000).map(|i| crumb(Vec3::new(f64::from(i), 0.0, 0.0))).collect();
    assert_eq!(check(&union(&crumbs)).report.n_components, 3000);
    // A long thin sliver of a wall is not small.
    let wire = Mesh {
        vertices: vec![Point3::new(3.0, 0.0, 0.0), Point3::new(3.0, 0.001, 0.0), Point3::new(3.0, 0.0, 1.0)],
        triangles: vec![[0, 1, 2]],
    };
    assert_eq!(check(&union(&[part, wire])).report.n_specks, 0);
}

#[test]
fn holes_are_kept_and_counted() {
    let mut mesh = sheet(9, 9);
    let (before, triangles) = (mesh.triangles.len(), &mut mesh.triangles);
    // Two squares in the middle of the sheet, and one corner to corner with the second.
    for square in [40, 60, 70] {
        triangles.retain(|t| !sheet(9, 9).triangles[2 * square..2 * square + 2].contains(t));
    }
    assert_eq!(mesh.triangles.len(), before - 6);
    let conditioned = check(&mesh);
    assert_eq!(conditioned.mesh.triangles.len(), mesh.triangles.len());
    assert_eq!(conditioned.report.n_boundary_edges, 36 + 3 * 4);
    let loops = boundary_loops(&conditioned.mesh, &Adjacency::new(&conditioned.mesh));
    let lengths: BTreeSet<usize> = loops.iter().map(Vec::len).collect();
    // Squares 60 and 70 share a vertex: there the sheet has two fans, one hole runs round both.
    assert_eq!((loops.len(), lengths), (3, BTreeSet::from([4, 8, 36])));
}

#[test]
fn empty_flat_and_tiny_meshes_pass() {
    let point = Point3::new(1.0, 2.0, 3.0);
    let on_a_line = |i: u32| Point3::new(f64::from(i), 2.0 * f64::from(i), 0.0);
    let cases = [
        (Mesh::default(), 0),
        (Mesh { vertices: vec![point; 3], triangles: vec![] }, 0),
        (Mesh { vertices: vec![point; 9], triangles: vec![[0, 1, 2], [3, 4, 5], [0, 0, 0]] }, 0),
        (Mesh { vertices: vec![Point3::origin(); 3], triangles: vec![[0, 1, 2]] }, 0),
        (Mesh { vertices: (0..3).map(on_a_line).collect(), triangles: vec![[0, 1, 2]] }, 0),
        (
            Mesh { vertices: (0..9).map(|i| point * f64::from(i * i)).collect(), triangles: vec![[0, 1, 8]] },
            0,
        ),
        (sheet(1, 1), 2),
        (Mesh { vertices: sheet(1, 1).vertices, triangles: vec![[0, 1, 2], [2, 1, 0], [1, 2, 0]] }, 1),
    ];
    for (mesh, n_triangles) in cases {
        let conditioned = check(&mesh);
        assert_eq!(conditioned.mesh.triangles.len(), n_triangles, "{mesh:?}");
        assert_idempotent(&conditioned, "small");
    }
}

#[test]
fn triangles_on_a_line_do_not_open_the_surface() {
    let whole = cube(4, Vec3::zeros());
    for seed in 0..20 {
        let mut mesh = whole.clone();
        let mut rng = Rng::for_task(seed, "caps", 0);
        let mut n_caps = 0;
        for _ in 0..30 {
            // A new vertex inside a side: the triangle behind it is not split, a flat one fills the gap.
            let t = rng.below(whole.triangles.len());
            let [a, b, c] = mesh.triangles[t];
            let middle = between(&mesh, a, b, 0.25 * (1 + rng.below(3)) as f64);
            if mesh.vertices.contains(&middle) {
                continue;
            }
            let m = mesh.vertices.len() as u32;
            mesh.vertices.push(middle);
            mesh.triangles[t] = [m, b, c];
            mesh.triangles.extend([[a, m, c], [a, b, m]]);
            n_caps += 1;
        }
        let conditioned = check(&shuffled(&mesh, &mut rng));
        assert_eq!(conditioned.report.n_boundary_edges, 0, "seed {seed}: {:?}", conditioned.report);
        assert_eq!(euler_characteristic(&conditioned.mesh), 2);
        assert_eq!(conditioned.report.n_swapped_caps, n_caps);
        assert_near(conditioned.mesh.signed_volume(), 1.0, 1e-12, "volume");
        assert_idempotent(&conditioned, "caps");
    }
}

#[test]
fn values_find_their_way_back_to_the_input() {
    let mut mesh = sheet(2, 1);
    mesh.triangles.insert(1, [0, 0, 1]);
    mesh.triangles.insert(3, mesh.triangles[0]);
    let conditioned = check(&mesh);
    assert_eq!(conditioned.to_input(&[1, 2, 3, 4], -1), [1, -1, 2, -1, 3, 4]);
}

#[test]
fn dense_clouds_of_vertices_take_linear_time() {
    // All within a few weld distances but for one far vertex: the worst for a grid.
    let mut rng = Rng::for_task(8, "dense", 0);
    let n = 200_000;
    let mut vertices: Vec<Point3> =
        (0..n).map(|_| Point3::new(rng.uniform(), rng.uniform(), rng.uniform()) * 1e-4).collect();
    vertices.push(Point3::new(1.0, 0.0, 0.0));
    let triangles = (0..n - 2).map(|v| [v, v + 1, v + 2]).collect();
    check(&Mesh { vertices: vertices.clone(), triangles });
    // And one edge that all triangles share.
    check(&Mesh { vertices, triangles: (2..n).map(|v| [0, 1, v]).collect() });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn any_triangles_become_an_oriented_manifold(
        corners in prop::collection::vec((0_u32..9, 0_u32..9, 0_u32..9), 0..60),
        places in prop::collection::vec((0_i8..3, 0_i8..3, 0_i8..3), 9),
    ) {
        let vertices = places.iter().map(|&(x, y, z)| Point3::new(f64::from(x), f64::from(y), f64::from(z))).collect();
        let triangles = corners.iter().map(|&(a, b, c)| [a, b, c]).collect();
        let conditioned = check(&Mesh { vertices, triangles });
        check(&conditioned.mesh);
    }

    #[test]
    fn damaged_meshes_keep_their_shape(seed: u64, n in 1_u32..5, share in 0.0..1.0) {
        let mut rng = Rng::for_task(seed, "prop", 0);
        let whole = union(&[cube(n, Vec3::zeros()), cube(2, Vec3::new(2.0, 0.0, 0.0))]);
        let exploded = explode(&whole, &mut rng, share);
        let conditioned = check(&flipped(&exploded, |_| rng.uniform() < 0.5));
        prop_assert_eq!(euler_characteristic(&conditioned.mesh), 4);
        prop_assert_eq!(conditioned.report.n_components, 2);
        assert_near(conditioned.mesh.signed_volume(), 2.0, 1e-9, "volume");
    }
}

// -------------------------------------------------------------------------------------------------- formulas

/// Conditions and holds the result to what every later stage relies on.
fn check(mesh: &Mesh) -> Conditioned {
    let conditioned = condition(mesh);
    let Conditioned { mesh: result, source_triangle, report } = &conditioned;
    assert_eq!(source_triangle.len(), result.triangles.len());
    assert!(source_triangle.is_sorted_by(|a, b| a < b));
    for (t, &source) in source_triangle.iter().enumerate() {
        // A triangle that was flat has taken half of another; which one is not told.
        let given = if report.n_swapped_caps > 0 {
            mesh.vertices.clone()
        } else {
            mesh.corners(source as usize).into()
        };
        for corner in result.corners(t) {
            let moved = given.iter().map(|p| (p - corner).norm()).fold(f64::INFINITY, f64::min);
            assert!(moved <= report.weld_distance, "triangle {t} has moved by {moved}");
        }
        assert!(result.area(t) > 0.0, "triangle {t} is flat");
    }
    let dropped = report.n_zero_area_triangles + report.n_repeated_triangles + report.n_speck_triangles;
    assert_eq!(result.triangles.len() + dropped, report.n_input_triangles);
    let n_boundary = assert_oriented_manifold(result);
    assert_eq!(report.n_boundary_edges, n_boundary);
    let adjacency = Adjacency::new(result);
    assert_eq!(report.n_components, adjacency.components().1);
    let loops = boundary_loops(result, &adjacency);
    assert_eq!(report.n_boundary_loops, loops.len());
    assert_eq!(n_boundary, loops.iter().map(Vec::len).sum::<usize>());
    conditioned
}

/// Every directed edge once, every vertex used and of one fan. Returns the number of boundary edges.
fn assert_oriented_manifold(mesh: &Mesh) -> usize {
    let mut next_about = vec![BTreeMap::new(); mesh.vertices.len()];
    for [a, b, c] in mesh.triangles.iter().copied() {
        for [v, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
            let twice = next_about[v as usize].insert(from, to);
            assert!(twice.is_none(), "edge {v}-{from} is used twice in one sense");
        }
    }
    let mut n_boundary = 0;
    for (v, next) in next_about.iter().enumerate() {
        assert!(!next.is_empty(), "vertex {v} is unused");
        let ends: BTreeSet<VertId> = next.values().copied().collect();
        let starts: Vec<VertId> = next.keys().copied().filter(|from| !ends.contains(from)).collect();
        assert!(starts.len() <= 1, "vertex {v} has {} open fans", starts.len());
        n_boundary += starts.len();
        let start = starts.first().copied().unwrap_or(*next.keys().next().unwrap());
        let mut at = start;
        let mut n_steps = 0;
        while let Some(&to) = next.get(&at) {
            (at, n_steps) = (to, n_steps + 1);
            if at == start {
                break;
            }
        }
        assert_eq!(n_steps, next.len(), "vertex {v} has several fans");
    }
    n_boundary
}

fn assert_idempotent(conditioned: &Conditioned, what: &str) {
    let again = condition(&conditioned.mesh);
    assert_eq!(again.mesh, conditioned.mesh, "{what}");
    assert_eq!(again.report.n_flipped_triangles, 0, "{what}");
}

fn assert_near(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance, "{what}: {a} is not {b} within {tolerance}");
}

fn euler_characteristic(mesh: &Mesh) -> i64 {
    let sides = |t: &[VertId; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let edges: BTreeSet<[VertId; 2]> =
        mesh.triangles.iter().flat_map(sides).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    mesh.vertices.len() as i64 - edges.len() as i64 + mesh.triangles.len() as i64
}

/// Unit cube of `n` by `n` squares a side, its lowest corner at `offset`.
fn cube(n: u32, offset: Vec3) -> Mesh {
    let mut index = BTreeMap::new();
    let mut mesh = Mesh::default();
    let mut vertex = |at: [u32; 3], mesh: &mut Mesh| {
        *index.entry(at).or_insert_with(|| {
            let position = Vec3::from(at.map(f64::from)) / f64::from(n) + offset;
            mesh.vertices.push(Point3::from(position));
            mesh.vertices.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n {
                for j in 0..n {
                    let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[p, q]| {
                        let mut at = [0; 3];
                        (at[axis], at[(axis + 1) % 3], at[(axis + 2) % 3]) = (side, p, q);
                        vertex(at, &mut mesh)
                    });
                    let [a, b, c, d] =
                        if side == n { corners } else { [corners[0], corners[3], corners[2], corners[1]] };
                    mesh.triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
    }
    mesh
}

/// Unit squares in the plane z = 0, numbered along x first.
fn sheet(n: u32, m: u32) -> Mesh {
    let vertices =
        (0..=m).flat_map(|j| (0..=n).map(move |i| Point3::new(f64::from(i), f64::from(j), 0.0))).collect();
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let squares = (0..m).flat_map(|j| (0..n).map(move |i| (i, j)));
    let triangles = squares
        .flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    Mesh { vertices, triangles }
}

/// A closed band of `n` squares with a half twist; cut open between the last and the first if `open`.
fn moebius_band(n: u32, open: bool) -> Mesh {
    let point = |i: u32, side: f64| {
        let turn = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let radius = 4.0 + side * (0.5 * turn).cos();
        Point3::new(radius * turn.cos(), radius * turn.sin(), side * (0.5 * turn).sin())
    };
    // Open, the last pair stops short of the first, or it would be welded to it.
    let n_pairs = if open { n - 1 } else { n };
    let vertices = (0..n_pairs).flat_map(|i| [point(i, -1.0), point(i, 1.0)]).collect();
    let triangles = (0..n_pairs - u32::from(open))
        .flat_map(|i| {
            let (a, b) = (2 * i, 2 * i + 1);
            // After the half twist the first pair is met upside down.
            let (c, d) = if i + 1 < n { (2 * i + 2, 2 * i + 3) } else { (1, 0) };
            [[a, c, b], [b, c, d]]
        })
        .collect();
    Mesh { vertices, triangles }
}

fn union(meshes: &[Mesh]) -> Mesh {
    let mut all = Mesh::default();
    for mesh in meshes {
        let base = all.vertices.len() as u32;
        all.vertices.extend_from_slice(&mesh.vertices);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| base + v)));
    }
    all
}

fn between(mesh: &Mesh, a: VertId, b: VertId, share: f64) -> Point3 {
    let [a, b] = [a, b].map(|v| mesh.vertices[v as usize]);
    a + share * (b - a)
}

fn find(mesh: &Mesh, point: Point3) -> VertId {
    mesh.vertices.iter().position(|p| *p == point).unwrap() as VertId
}

fn flipped(mesh: &Mesh, mut flip: impl FnMut(usize) -> bool) -> Mesh {
    let turn = |(t, &[a, b, c]): (usize, &[VertId; 3])| if flip(t) { [a, c, b] } else { [a, b, c] };
    Mesh { vertices: mesh.vertices.clone(), triangles: mesh.triangles.iter().enumerate().map(turn).collect() }
}

fn shuffled(mesh: &Mesh, rng: &mut Rng) -> Mesh {
    let mut shuffled = mesh.clone();
    for t in 1..mesh.triangles.len() {
        shuffled.triangles.swap(t, rng.below(t + 1));
    }
    shuffled
}

/// Gives the share `share` of the corners vertices of their own.
fn explode(mesh: &Mesh, rng: &mut Rng, share: f64) -> Mesh {
    let mut exploded = mesh.clone();
    for corner in exploded.triangles.as_flattened_mut() {
        if rng.uniform() < share {
            exploded.vertices.push(mesh.vertices[*corner as usize]);
            *corner = exploded.vertices.len() as VertId - 1;
        }
    }
    exploded
}

/// Splits vertices, moves some within rounding, flips triangles, repeats some either way and adds flat ones.
fn damage(mesh: &Mesh, rng: &mut Rng) -> Mesh {
    let mut damaged = explode(mesh, rng, 0.5);
    // A fifth of the weld distance of a unit cube, either way: copies are two fifths apart at most, three axes less
    // than one.
    for p in &mut damaged.vertices {
        *p += Vec3::from_fn(|_, _| 0.4e-6 * (rng.uniform() - 0.5));
    }
    damaged = flipped(&damaged, |_| rng.uniform() < 0.4);
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = damaged.triangles[t];
        match rng.below(8) {
            0 => damaged.triangles.push([c, a, b]),
            1 => damaged.triangles.push([c, b, a]),
            2 => damaged.triangles.push([a, b, a]),
            _ => {}
        }
    }
    damaged
}
