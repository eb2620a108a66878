//! One function per stage: what each is given and what it leaves for the next.

use crate::condition::{self, ConditionReport, Conditioned, Support};
use crate::math::Vec3;
use crate::mesh::{Adjacency, Mesh, TriId};
use crate::segment::{self, SegmentOptions, Segmentation};
use crate::tolerance::{Measured, Tolerances};

use super::{Code, Model, Options, SupportSearch, Warning};

/// The conditioned scan with what was measured from it.
pub(super) struct Scan {
    pub mesh: Mesh,
    pub source_triangle: Vec<TriId>,
    pub report: ConditionReport,
    pub adjacency: Adjacency,
    pub measured: Measured,
    pub tolerances: Tolerances,
}

pub(super) fn measure(conditioned: Conditioned, options: &Options) -> Scan {
    let Conditioned { mesh, source_triangle, report } = conditioned;
    let adjacency = Adjacency::new(&mesh);
    let measured = condition::measure(&mesh, &adjacency);
    let tolerances = Tolerances::new(measured, options.gap);
    Scan { mesh, source_triangle, report, adjacency, measured, tolerances }
}

pub(super) fn find_support(scan: &Scan, options: &Options) -> Option<Support> {
    if options.support == SupportSearch::None {
        return None;
    }
    // TODO(integrator): condition::find_support(&scan.mesh, &scan.adjacency, &scan.tolerances, options.up).
    let _ = (&scan.adjacency, options.up);
    None
}

/// One filtered unit normal per vertex.
pub(super) fn denoise(scan: &Scan) -> Vec<Vec3> {
    // TODO(integrator): denoise::denoise(.., &DenoiseMethod::default()), vertex normals of its result.
    scan.mesh.vertex_normals()
}

pub(super) fn segment(
    scan: &Scan,
    normals: &[Vec3],
    _support: Option<&Support>,
    options: &Options,
) -> Segmentation {
    // TODO(integrator): without the triangles that are the table's.
    let options = SegmentOptions { min_face: options.min_face };
    segment::segment(&scan.mesh, &scan.adjacency, normals, &scan.tolerances, &options)
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
