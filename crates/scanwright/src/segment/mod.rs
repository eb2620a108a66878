//! Regions of the scan, one primitive each.
//!
//! By default fit-driven, no number of regions asked: hypotheses of all five types are grown from smooth seeds and refitted as
//! they grow (`grow`), a subset that explains the mesh is selected greedily (`select`), vertices are labelled by
//! energy (`label`), regions are retyped, merged and grown again (`refresh`), neighbours that cost less as one surface
//! become one (`merge`), and what is left over is given to its neighbours or called freeform (`finish`). Thresholds are
//! sigmas of the measured noise and vertex spacings.

mod baseline;
mod blunt;
mod border;
mod bridge;
mod contact;
mod cover;
mod edge;
mod field;
mod fillet;
mod finish;
mod grow;
mod label;
mod lands;
mod merge;
mod narrow;
mod primitive;
mod refresh;
mod select;
mod spectral;
mod split;
mod turned;

pub use baseline::Baseline;
pub use field::Field;
pub use spectral::{MOST_ASKED, Nodes, Spectral};

use field::{Hypothesis, Scratch};

use crate::math::Vec3;
use crate::mesh::{Adjacency, Mesh};
use crate::par;
use crate::recognize::Primitive;
use crate::surface::{Plane, SurfaceKind};
use crate::tolerance::Tolerances;

/// Index of a region: its place in [`Segmentation::primitives`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
pub struct RegionId(pub u32);

/// The labelling of all triangles of a mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Segmentation {
    /// One per triangle; `None` where nothing describes it.
    pub labels: Vec<Option<RegionId>>,
    /// One per region.
    pub primitives: Vec<Primitive>,
}

/// How a mesh is segmented.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SegmentMethod {
    /// Surfaces grown, selected and labelled: see the module.
    #[default]
    FitDriven,
    /// The thesis's 3D-NCuts: groups by the eigenvectors of a graph.
    NCuts(Spectral),
    /// The thesis's 3D-PIC: groups by power iteration on a graph.
    Pic(Spectral),
    /// Hierarchical fitting primitives: patches merged by how well one surface fits them.
    Hfp(Baseline),
    /// Liu and Zhang's: groups by the eigenvectors of all distances over the surface.
    LiuZhang(Baseline),
    /// Xiao and others': peaks of the Gauss map, then modes of the mean curvature. It finds the number itself.
    Xiao {
        /// Seed of its random votes.
        seed: u64,
    },
}

impl SegmentMethod {
    /// Most vertices that a part may have, where a method has a limit: see [`Spectral::most_vertices`].
    pub fn most_vertices(&self) -> Option<usize> {
        match self {
            Self::NCuts(spectral) | Self::Pic(spectral) => spectral.most_vertices(),
            Self::FitDriven | Self::Hfp(_) | Self::LiuZhang(_) | Self::Xiao { .. } => None,
        }
    }
}

/// What a user may choose; everything else follows the measured noise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SegmentOptions {
    /// How; default: fit-driven.
    pub method: SegmentMethod,
    /// Faces narrower than this are given to their neighbours, length; default: what the scan can show.
    pub min_face: Option<f64>,
    /// The table that was cut away, its normal up: the scanner rounded the edge between it and the part.
    pub ground: Option<Plane>,
}

/// A conditioned mesh as all methods but the default see it.
struct Scan<'a> {
    mesh: &'a Mesh,
    adjacency: &'a Adjacency,
    field: &'a Field<'a>,
    /// Deviation of the raw normals of triangles, radians.
    normal_noise: f64,
}

/// Segments a conditioned mesh.
///
/// `normals`: one filtered unit normal per vertex, out of the material.
pub fn segment(
    mesh: &Mesh,
    adjacency: &Adjacency,
    normals: &[Vec3],
    tolerances: &Tolerances,
    options: &SegmentOptions,
) -> Segmentation {
    let field = Field::new(mesh, adjacency, normals, tolerances, options.ground);
    let scan = Scan { mesh, adjacency, field: &field, normal_noise: tolerances.normal_noise() };
    match &options.method {
        SegmentMethod::NCuts(spectral) => spectral::run(&scan, spectral::Vectors::Eigen, spectral),
        SegmentMethod::Pic(spectral) => spectral::run(&scan, spectral::Vectors::Power, spectral),
        SegmentMethod::Hfp(baseline) => baseline::hfp::run(&scan, baseline),
        SegmentMethod::LiuZhang(baseline) => baseline::liu_zhang::run(&scan, baseline),
        SegmentMethod::Xiao { seed } => baseline::xiao::run(&scan, *seed),
        SegmentMethod::FitDriven => fit_driven(mesh, adjacency, field, options),
    }
}

/// The primitive of a mesh that is one region, a segment that somebody else cut out.
///
/// `normals`: one filtered unit normal per vertex, out of the material.
pub fn as_one(mesh: &Mesh, adjacency: &Adjacency, normals: &[Vec3], tolerances: &Tolerances) -> Primitive {
    primitive::of_all(&Field::new(mesh, adjacency, normals, tolerances, None))
}

fn fit_driven(
    mesh: &Mesh,
    adjacency: &Adjacency,
    mut field: Field,
    options: &SegmentOptions,
) -> Segmentation {
    let mut hypotheses = Vec::new();
    let mut labels = label::Labels::none(&field);
    for (round, patch_sizes) in PATCH_SIZES.iter().enumerate() {
        grow::explore(&field, &mut hypotheses, patch_sizes, round > 0, &labels);
        for _ in 0..2 {
            labels = labelled(&field, &mut hypotheses);
            field.adapt_noise(&labels);
            hypotheses = refresh::refresh(&field, &labels);
        }
    }
    // No alternatives here: nothing would test them once more.
    let (selected, cover) = select::select(&field, &hypotheses);
    labels = label::label(&field, &selected, &cover);
    merge::merge(&field, &cover, &mut labels);
    finish::finish(mesh, adjacency, &field, &labels, options)
}

/// Labels by the best set of surfaces. Simpler surfaces that may stand in for complex ones join the hypotheses.
fn labelled(field: &Field, hypotheses: &mut Vec<Hypothesis>) -> label::Labels {
    let (selected, _) = select::select(field, hypotheses);
    hypotheses.extend(alternatives(field, &selected));
    let (selected, cover) = select::select(field, hypotheses);
    label::label(field, &selected, &cover)
}

/// Simpler surfaces that might stand in for the complex ones selected.
fn alternatives(field: &Field, selected: &[Hypothesis]) -> Vec<Hypothesis> {
    let found = par::map(selected, |hypothesis| match hypothesis.fit.surface.kind() {
        SurfaceKind::Plane | SurfaceKind::Cylinder => Vec::new(),
        _ => split::parts(field, hypothesis, &mut Scratch::new(field.n_vertices())),
    });
    found.into_iter().flatten().collect()
}

/// Vertices of a seed's first patch, per round: later rounds look for what is small.
const PATCH_SIZES: [&[usize]; 3] = [&[40], &[20, 60], &[14, 30]];
