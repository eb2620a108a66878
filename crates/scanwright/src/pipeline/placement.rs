//! A result in the frame of the part's datums instead of the scan's coordinates.

use crate::condition::Support;
use crate::datum::{self, Candidate, Datum};
use crate::math::{Point3, Pose, Vec3, centroid};
use crate::mesh::Mesh;
use crate::segment::{RegionId, Segmentation};
use crate::surface::Plane;
use crate::tolerance::Tolerances;

/// How a result came into the frame of its datums.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Takes the scan's coordinates to the result's.
    pub pose: Pose,
    /// The region that is level: a plane, or the main axis of a turned part.
    pub level: RegionId,
    /// The region that stops the turn about z.
    pub rotate: Option<RegionId>,
    /// How many planes of symmetry the origin lies in.
    pub mirrors: usize,
    /// The regions that fix the origin where no symmetry does, in order.
    pub zero: Vec<RegionId>,
    /// Whether no datum stops the turn about z.
    pub free_turn: bool,
    /// Along how many directions no datum fixes the origin.
    pub free_ways: usize,
}

/// The placement that a part's own regions give; `None` when it has neither a plane nor an axis.
pub(super) fn find(
    mesh: &Mesh,
    segmentation: &Segmentation,
    support: Option<&Support>,
    tolerances: &Tolerances,
) -> Option<Placement> {
    let (regions, candidates): (Vec<RegionId>, Vec<Candidate>) =
        candidates(mesh, segmentation).into_iter().unzip();
    let plan = datum::choose(&candidates, Some(tolerances.spacing()))?;
    let up = support.map(|s| s.plane.normal);
    let found = datum::auto_frame(&candidates, &plan, up, &centroid(&mesh.vertices))?;
    Some(Placement {
        pose: Pose::into_frame(&found.frame),
        level: regions[plan.level],
        rotate: plan.rotate.map(|k| regions[k]),
        mirrors: plan.mirrors.len(),
        zero: plan.zero.iter().map(|&k| regions[k]).collect(),
        free_turn: found.free_turn,
        free_ways: found.free_ways,
    })
}

/// Regions with a surface, their areas and middles.
fn candidates(mesh: &Mesh, segmentation: &Segmentation) -> Vec<(RegionId, Candidate)> {
    let mut sums = vec![(0.0, Vec3::zeros()); segmentation.primitives.len()];
    for (t, label) in segmentation.labels.iter().enumerate() {
        if let Some(RegionId(k)) = label {
            let area = mesh.area(t);
            sums[*k as usize].0 += area;
            sums[*k as usize].1 += mesh.triangle_center(t).coords * area;
        }
    }
    let seen = segmentation.primitives.iter().zip(sums).enumerate().filter(|(_, (_, sum))| sum.0 > 0.0);
    let of = |(k, (primitive, (area, first))): (usize, (&crate::recognize::Primitive, (f64, Vec3)))| {
        let center = Point3::from(first / area);
        let datum = Datum { surface: primitive.surface?, outward: primitive.outward, center };
        Some((RegionId(k as u32), Candidate { datum, area }))
    };
    seen.filter_map(of).collect()
}

/// The table after a motion.
pub(super) fn moved_support(support: &Support, pose: &Pose) -> Support {
    let outlines = support.outlines.iter();
    Support {
        plane: Plane { point: pose.point(&support.plane.point), normal: pose.unit(&support.plane.normal) },
        on_table: support.on_table.clone(),
        outlines: outlines.map(|outline| outline.iter().map(|p| pose.point(p)).collect()).collect(),
    }
}
