//! One function per stage: what each is given and what it leaves for the next.

use crate::brep::LabelledMesh;
use crate::brep::close;
use crate::condition::{self, ConditionReport, Conditioned, Support};
use crate::math::Vec3;
use crate::mesh::{Adjacency, Mesh, TriId};
use crate::segment::{self, RegionId, SegmentOptions, Segmentation};
use crate::tolerance::{Measured, Tolerances};

use super::{Code, Model, Options, SupportSearch, Warning, warning};

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
    match options.support {
        SupportSearch::None => None,
        SupportSearch::Auto => {
            condition::find_support(&scan.mesh, &scan.adjacency, &scan.tolerances, options.up)
        }
    }
}

/// The scan without the table.
pub(super) struct Part {
    pub mesh: Mesh,
    pub adjacency: Adjacency,
    /// One per triangle of the part: its index in the conditioned scan.
    pub scan_triangle: Vec<TriId>,
}

pub(super) fn without_support(scan: &Scan, support: Option<&Support>) -> Part {
    let (mesh, scan_triangle, _) = scan.mesh.submesh(|t| support.is_none_or(|s| !s.on_table[t]));
    let adjacency = Adjacency::new(&mesh);
    Part { mesh, adjacency, scan_triangle }
}

/// One filtered unit normal per vertex.
pub(super) fn denoise(part: &Part, _tolerances: &Tolerances) -> Vec<Vec3> {
    // TODO(integrator): denoise::denoise(.., &DenoiseMethod::default()), vertex normals of its result.
    part.mesh.vertex_normals()
}

pub(super) fn segment(
    part: &Part,
    normals: &[Vec3],
    tolerances: &Tolerances,
    options: &Options,
) -> Segmentation {
    let options = SegmentOptions { min_face: options.min_face };
    segment::segment(&part.mesh, &part.adjacency, normals, tolerances, &options)
}

pub(super) fn regularize(segmentation: Segmentation, _tolerances: &Tolerances) -> Segmentation {
    // TODO(integrator): regularize::regularize(..) -> (primitives, constraints).
    segmentation
}

pub(super) fn build(
    part: &Part,
    segmentation: &Segmentation,
    support: Option<&Support>,
    tolerances: &Tolerances,
) -> (Model, Vec<Warning>) {
    let closed = close::close(&part.mesh, segmentation, support, tolerances);
    let mut warnings = warning::of_closing(&closed);
    // TODO(integrator): brep::build, brep::check, brep::tessellate; until then the closed mesh stands for the solid.
    warnings.push(Warning::new(Code::NoSolid, "no solid was made"));
    let LabelledMesh { mesh, labels, primitives, assumed } = closed.labelled;
    (Model { solids: Vec::new(), mesh, regions: labels, primitives, assumed }, warnings)
}

/// The labels of the part as labels of the conditioned scan.
pub(super) fn labels_of_scan(scan: &Scan, part: &Part, labels: &[Option<RegionId>]) -> Vec<Option<RegionId>> {
    let mut all = vec![None; scan.mesh.triangles.len()];
    for (label, &t) in labels.iter().zip(&part.scan_triangle) {
        all[t as usize] = *label;
    }
    all
}
