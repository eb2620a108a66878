//! 3D-NCuts and 3D-PIC on parts whose faces are known.

use scanwright::condition::measure;
use scanwright::denoise::ring_filtered_normals;
use scanwright::math::{Point3, Vec3};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::par;
use scanwright::segment::{Nodes, SegmentMethod, SegmentOptions, Segmentation, Spectral, segment};
use scanwright::surface::SurfaceKind;
use scanwright::tolerance::Tolerances;

use crate::scans;
use crate::segmentation::kinds;

pub fn segmented(mesh: &Mesh, method: SegmentMethod) -> Segmentation {
    let adjacency = Adjacency::new(mesh);
    let tolerances = Tolerances::new(measure(mesh, &adjacency), None);
    let normals = ring_filtered_normals(mesh, &adjacency, &tolerances);
    let options = SegmentOptions { method, ..SegmentOptions::default() };
    segment(mesh, &adjacency, &normals, &tolerances, &options)
}

/// A block of 40 by 30 by 20 with noise of a twentieth of its spacing.
fn block() -> Mesh {
    scans::with_noise(scans::block([40.0, 30.0, 20.0], 1.0), 0.05, 5)
}

/// Share of the block's area whose triangles carry the label of most of their face.
fn agreement(mesh: &Mesh, segmentation: &Segmentation) -> f64 {
    let half = [20.0, 15.0, 10.0];
    let (low, high) = mesh.bounds().expect("it has vertices");
    let middle = nalgebra::center(&low, &high);
    let face = |p: Point3| {
        let off = p - middle;
        let scaled = [0, 1, 2].map(|k| off[k] / half[k]);
        let axis = (0..3).max_by(|&a, &b| scaled[a].abs().total_cmp(&scaled[b].abs())).unwrap_or(0);
        2 * axis + usize::from(scaled[axis] > 0.0)
    };
    let n_regions = segmentation.primitives.len();
    let mut areas = vec![vec![0.0; n_regions]; 6];
    for t in 0..mesh.triangles.len() {
        let label = segmentation.labels[t].expect("every triangle has a region").0 as usize;
        areas[face(mesh.triangle_center(t))][label] += mesh.area(t);
    }
    let kept: f64 = areas.iter().map(|row| row.iter().fold(0.0_f64, |m, a| m.max(*a))).sum();
    kept / mesh.total_area()
}

#[test]
fn a_block_is_cut_into_its_faces_whose_number_is_given() {
    let mesh = block();
    let of = |nodes| Spectral { n_regions: Some(6), nodes, seed: 1 };
    // Not by PIC from vertices: those on the block's edges, joined to no face, are groups of their own to it.
    for method in [
        SegmentMethod::NCuts(of(Nodes::Patches)),
        SegmentMethod::NCuts(of(Nodes::Vertices)),
        SegmentMethod::Pic(of(Nodes::Patches)),
    ] {
        let segmentation = segmented(&mesh, method);
        assert_eq!(kinds(&segmentation), [Some(SurfaceKind::Plane); 6], "{method:?}");
        let agreement = agreement(&mesh, &segmentation);
        // Patches are a few triangles wide, and those at the edges are shared out.
        assert!(agreement > 0.95, "{method:?}: {agreement}");
    }
}

#[test]
fn the_number_of_faces_of_a_block_is_found() {
    let mesh = block();
    for method in [SegmentMethod::NCuts(Spectral::default()), SegmentMethod::Pic(Spectral::default())] {
        let segmentation = segmented(&mesh, method);
        assert_eq!(segmentation.primitives.len(), 6, "{method:?}: {:?}", kinds(&segmentation));
    }
}

#[test]
fn parts_that_do_not_touch_share_no_region() {
    let far = scans::moved(block(), Vec3::new(100.0, 0.0, 0.0));
    let n_first = block().triangles.len();
    let both = scans::together(block(), &far);
    let spectral = Spectral { n_regions: Some(12), ..Spectral::default() };
    let segmentation = segmented(&both, SegmentMethod::NCuts(spectral));
    assert_eq!(segmentation.primitives.len(), 12, "{:?}", kinds(&segmentation));
    let (first, second) = segmentation.labels.split_at(n_first);
    assert!(first.iter().all(|label| !second.contains(label)), "a region of both");
}

#[test]
fn the_number_of_threads_does_not_change_the_regions() {
    let mesh = block();
    let spectral = Spectral { n_regions: Some(6), ..Spectral::default() };
    for method in [SegmentMethod::NCuts(spectral), SegmentMethod::Pic(spectral)] {
        let by = |n| par::with_threads(Some(n), || segmented(&mesh, method));
        assert_eq!(by(1), by(4), "{method:?}");
    }
}

#[test]
fn a_block_among_many_small_pieces_is_still_cut_into_its_faces() {
    let mut mesh = block();
    for k in 0..45 {
        let speck = scans::block([3.0, 3.0, 3.0], 1.0);
        mesh = scans::together(mesh, &scans::moved(speck, Vec3::new(50.0 + 10.0 * f64::from(k), 0.0, 0.0)));
    }
    let n_block = block().triangles.len();
    let segmentation = segmented(&mesh, SegmentMethod::NCuts(Spectral::default()));
    let mut of_block: Vec<u32> = segmentation.labels[..n_block].iter().flatten().map(|r| r.0).collect();
    of_block.sort_unstable();
    of_block.dedup();
    assert_eq!(of_block.len(), 6, "{:?}", kinds(&segmentation).len());
}

/// Its faces are alike, so that only random starts tell them apart, and it is so fine that those even out slowly.
#[test]
fn power_iteration_cuts_a_fine_cube_into_its_faces() {
    const SIDE: f64 = 100.0;
    let mesh = scans::block([SIDE; 3], 1.0);
    for seed in [1, 2] {
        let pic = SegmentMethod::Pic(Spectral { n_regions: Some(6), seed, ..Spectral::default() });
        let segmentation = segmented(&mesh, pic);
        assert_eq!(kinds(&segmentation), [Some(SurfaceKind::Plane); 6], "seed {seed}");
        let mut counts = [0; 6];
        segmentation.labels.iter().flatten().for_each(|label| counts[label.0 as usize] += 1);
        // All faces have one size, but for rows of triangles that go to the wrong side of an edge.
        let (face, row) = (2.0 * SIDE * SIDE, 2.0 * SIDE);
        let is_face = |count: &i32| (f64::from(*count) - face).abs() < 4.0 * row;
        assert!(counts.iter().all(is_face), "seed {seed}: {counts:?}, a face has {face}");
    }
}

#[test]
fn vertices_are_grouped_up_to_what_memory_holds() {
    let of = |n_regions, nodes| Spectral { n_regions, nodes, seed: 1 }.most_vertices();
    assert_eq!(of(None, Nodes::Patches), None);
    // The basis has 6 (k + 1) + 60 vectors, and 2 GiB hold 2^28 numbers.
    assert_eq!(of(None, Nodes::Vertices), Some((1 << 28) / (6 * 41 + 60)));
    assert_eq!(of(Some(500), Nodes::Vertices), Some((1 << 28) / (6 * 501 + 60)));
}
