//! One function per stage: what each is given and what it leaves for the next.

use crate::condition::Support;
use crate::denoise::Denoised;
use crate::mesh::{Adjacency, Mesh, TriId};
use crate::segment::Segmentation;
use crate::tolerance::{Measured, Tolerances};

use super::{Code, Model, Options, SupportSearch, Warning};

/// The conditioned scan.
pub(super) struct Conditioned {
    pub mesh: Mesh,
    pub source_triangle: Vec<TriId>,
}

/// The conditioned scan with what was measured from it.
pub(super) struct Scan {
    pub mesh: Mesh,
    pub source_triangle: Vec<TriId>,
    pub adjacency: Adjacency,
    pub measured: Measured,
    pub tolerances: Tolerances,
}

pub(super) fn condition(mesh: &Mesh) -> Conditioned {
    // TODO(integrator): condition::condition(mesh).
    let source_triangle = (0..mesh.triangles.len() as u32).collect();
    Conditioned { mesh: mesh.clone(), source_triangle }
}

pub(super) fn measure(conditioned: Conditioned, options: &Options) -> Scan {
    let Conditioned { mesh, source_triangle } = conditioned;
    let adjacency = Adjacency::new(&mesh);
    // TODO(integrator): condition::measure(&mesh, &adjacency).
    let measured = Measured {
        largest_coordinate: mesh.largest_coordinate(),
        diagonal: mesh.diagonal(),
        spacing: (mesh.total_area() / mesh.vertices.len().max(1) as f64).sqrt(),
        noise: 0.0,
        normal_noise: 0.0,
        edge_rounding: 0.0,
    };
    let tolerances = Tolerances::new(measured, options.gap);
    Scan { mesh, source_triangle, adjacency, measured, tolerances }
}

pub(super) fn find_support(scan: &Scan, options: &Options) -> Option<Support> {
    if options.support == SupportSearch::None {
        return None;
    }
    // TODO(integrator): condition::find_support(&scan.mesh, &scan.adjacency, &scan.tolerances, options.up).
    let _ = (&scan.adjacency, options.up);
    None
}

pub(super) fn denoise(scan: &Scan) -> Denoised {
    // TODO(integrator): denoise::denoise(.., &DenoiseMethod::default()).
    Denoised { triangle_normals: scan.mesh.triangle_normals(), vertices: scan.mesh.vertices.clone() }
}

pub(super) fn segment(
    scan: &Scan,
    _denoised: &Denoised,
    _support: Option<&Support>,
    _options: &Options,
) -> Segmentation {
    // TODO(integrator): segment::segment(..) on the triangles that are not the table's.
    Segmentation { labels: vec![None; scan.mesh.triangles.len()], primitives: Vec::new() }
}

pub(super) fn regularize(_scan: &Scan, segmentation: Segmentation) -> Segmentation {
    // TODO(integrator): regularize::regularize(..) -> (primitives, constraints).
    segmentation
}

pub(super) fn build(
    _scan: &Scan,
    _segmentation: &Segmentation,
    _support: Option<&Support>,
) -> (Model, Vec<Warning>) {
    // TODO(integrator): brep::close::close, brep::build, brep::check, brep::tessellate.
    (Model::default(), vec![Warning::new(Code::NoSolid, "no solid was made")])
}
