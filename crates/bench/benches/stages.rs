//! One group per stage; the parameter is the number of triangles of the scan.

use std::hint::black_box;
use std::time::Duration;

use bench::bushing;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use scanwright::brep::close;
use scanwright::math::Vec3;
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::pipeline::{self, Options};
use scanwright::progress::Progress;
use scanwright::render::{Camera, Color, Sheet, View, picture};
use scanwright::segment::{self, SegmentOptions, Segmentation};
use scanwright::tolerance::Tolerances;
use scanwright::{condition, deviation, io};

const SIZES: [usize; 3] = [10_000, 40_000, 160_000];
/// Stages that take seconds are timed on these.
const SMALL_SIZES: [usize; 2] = [10_000, 40_000];

fn read(c: &mut Criterion) {
    each(
        c,
        "read PLY",
        &SIZES,
        |mesh| io::write_ply(mesh, None, None),
        |bytes| io::read_mesh(bytes, "x.ply"),
    );
}

fn adjacency(c: &mut Criterion) {
    each(c, "adjacency", &SIZES, Mesh::clone, Adjacency::new);
}

fn conditioning(c: &mut Criterion) {
    each(c, "condition", &SIZES, Mesh::clone, condition::condition);
    each(c, "measure", &SIZES, prepare, |(mesh, adjacency, _)| condition::measure(mesh, adjacency));
    each(c, "find support", &SIZES, prepare, |(mesh, adjacency, tolerances)| {
        condition::find_support(mesh, adjacency, tolerances, None)
    });
}

fn segmentation(c: &mut Criterion) {
    each(c, "segment", &SMALL_SIZES, prepare, segmented);
}

fn closing(c: &mut Criterion) {
    let prepare_labels = |mesh: &Mesh| {
        let prepared = prepare(mesh);
        let labels = segmented(&prepared);
        (prepared, labels)
    };
    each(c, "close", &SMALL_SIZES, prepare_labels, |((mesh, _, tolerances), segmentation)| {
        close::close(mesh, segmentation, None, tolerances)
    });
}

fn deviations(c: &mut Criterion) {
    each(c, "deviation", &SIZES, Mesh::clone, |mesh| deviation::measure(&mesh.vertices, mesh));
}

fn pictures(c: &mut Criterion) {
    each(c, "picture", &SIZES, Mesh::clone, |mesh| {
        let n = mesh.triangles.len();
        let camera = Camera::around(Vec3::z_axis(), 0.5, 0.5);
        let view = View { mesh, colors: &vec![Color::SCAN; n], groups: &vec![0; n], camera, title: "" };
        picture(&[view], &Sheet { width: 800, height: 600, frame: &mesh.vertices, legend: &[] })
    });
}

fn whole(c: &mut Criterion) {
    each(c, "whole pipeline", &SMALL_SIZES, Mesh::clone, |mesh| {
        pipeline::run(mesh, &Options::default(), &Progress::none())
    });
}

/// Times `work` on what `setup` makes of scans of all `sizes`.
fn each<S, T>(
    c: &mut Criterion,
    name: &str,
    sizes: &[usize],
    setup: impl Fn(&Mesh) -> S,
    work: impl Fn(&S) -> T,
) {
    let mut group = c.benchmark_group(name);
    group.sample_size(10).measurement_time(Duration::from_secs(3));
    for &size in sizes {
        let input = setup(&bushing(size));
        group.bench_with_input(BenchmarkId::from_parameter(size), &input, |b, input| {
            b.iter(|| work(black_box(input)));
        });
    }
    group.finish();
}

fn prepare(mesh: &Mesh) -> (Mesh, Adjacency, Tolerances) {
    let adjacency = Adjacency::new(mesh);
    let tolerances = Tolerances::new(condition::measure(mesh, &adjacency), None);
    (mesh.clone(), adjacency, tolerances)
}

fn segmented((mesh, adjacency, tolerances): &(Mesh, Adjacency, Tolerances)) -> Segmentation {
    segment::segment(mesh, adjacency, &mesh.vertex_normals(), tolerances, &SegmentOptions::default())
}

criterion_group! {
    stages, read, adjacency, conditioning, segmentation, closing, deviations, pictures, whole
}
criterion_main!(stages);
