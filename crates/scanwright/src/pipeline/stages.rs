//! One function per stage: what each is given and what it leaves for the next.

use crate::condition::{self, ConditionReport, Conditioned, Support};
use crate::denoise;
use crate::dimension::{self, Dimension};
use crate::fit::Noise;
use crate::math::Vec3;
use crate::mesh::{Adjacency, Mesh, TriId};
use crate::regularize::{self, RegularizeOptions, Regularized};
use crate::segment::{self, SegmentOptions, Segmentation};
use crate::tolerance::{Measured, Tolerances};
use crate::uncertainty::{self, Interior};

use super::{Options, SupportSearch};

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
        SupportSearch::Auto => {
            condition::find_support(&scan.mesh, &scan.adjacency, &scan.tolerances, options.up)
        }
        SupportSearch::None => None,
    }
}

/// What is left of the scan without its table.
pub(super) struct Part {
    pub mesh: Mesh,
    pub adjacency: Adjacency,
    /// One per triangle of the part: the triangle of the scan it is.
    pub scan_triangle: Vec<TriId>,
}

pub(super) fn part(scan: &Scan, support: Option<&Support>) -> Part {
    let (mesh, scan_triangle, _) = scan.mesh.submesh(|t| support.is_none_or(|s| !s.on_table[t]));
    Part { adjacency: Adjacency::new(&mesh), mesh, scan_triangle }
}

/// One filtered unit normal per vertex of the part.
pub(super) fn denoise(part: &Part, tolerances: &Tolerances) -> Vec<Vec3> {
    denoise::ring_filtered_normals(&part.mesh, &part.adjacency, tolerances)
}

pub(super) fn segment(
    part: &Part,
    normals: &[Vec3],
    support: Option<&Support>,
    tolerances: &Tolerances,
    options: &Options,
) -> Segmentation {
    let options = SegmentOptions {
        method: options.method,
        min_face: options.min_face,
        ground: support.map(|s| s.plane),
    };
    segment::segment(&part.mesh, &part.adjacency, normals, tolerances, &options)
}

/// The segmentation of the part as one of the whole scan: nothing on the table has a label.
pub(super) fn on_scan(scan: &Scan, part: &Part, segmentation: &Segmentation) -> Segmentation {
    let mut labels = vec![None; scan.mesh.triangles.len()];
    for (label, &t) in segmentation.labels.iter().zip(&part.scan_triangle) {
        labels[t as usize] = *label;
    }
    Segmentation { labels, primitives: segmentation.primitives.clone() }
}

/// The segmentation with what is known of each primitive, the vertices and the noise that say so.
pub(super) struct Stated {
    pub segmentation: Segmentation,
    pub interior: Interior,
    pub noise: Noise,
}

pub(super) fn stated(part: &Part, segmentation: &Segmentation, tolerances: &Tolerances) -> Stated {
    let Part { mesh, adjacency, .. } = part;
    let interior = Interior::new(mesh, adjacency, segmentation, tolerances);
    let noise = uncertainty::measure(mesh, adjacency, &interior, segmentation, tolerances);
    let segmentation = uncertainty::stated(mesh, &interior, segmentation, &noise, tolerances);
    Stated { segmentation, interior, noise }
}

/// The segmentation with the relations between its primitives made exact. `sizes`: whether sizes and planes are among them.
pub(super) fn regularize(
    part: &Part,
    stated: &Stated,
    tolerances: &Tolerances,
    options: &Options,
    sizes: bool,
) -> Regularized {
    let Stated { segmentation, interior, noise } = stated;
    let options =
        RegularizeOptions { relations: options.relations.clone(), manufacture: options.manufacture, sizes };
    regularize::regularize(&part.mesh, interior, segmentation, noise, tolerances, &options)
}

/// Dimensions of the part; with `--snap` the round ones are put into `segmentation`.
pub(super) fn dimensions(
    part: &Part,
    stated: &Stated,
    segmentation: &mut Segmentation,
    options: &Options,
) -> Vec<Dimension> {
    let Part { mesh, adjacency, .. } = part;
    let mut dimensions =
        dimension::dimensions(mesh, adjacency, &stated.interior, segmentation, &options.systematic);
    let Options { millimetres, manufacture, .. } = options;
    dimension::offer(&mut dimensions, &segmentation.primitives, *millimetres, manufacture);
    if options.snap {
        *segmentation = dimension::snapped(segmentation, &mut dimensions);
    }
    dimensions
}
