//! Solids with all relations, and where these leave faces without sound surfaces, with fewer of them.
//!
//! Making sizes equal moves faces by less than the scan shows, and yet an edge of a narrow fillet may vanish over it. The
//! solid decides: of those with all relations, without equal sizes and planes, and without any, the first that is sound, has
//! every analytic face on its surface and passes the scan is taken, else the one with the least area that is not so. Without
//! any relation only where all of the part was seen.

use crate::brep::{Face, Geometry, Solid};
use crate::deviation::{self, Deviation};
use crate::dimension::Dimension;
use crate::recognize::Primitive;
use crate::regularize::{Regularized, Relation, RelationKind, Relations};
use crate::segment::Segmentation;
use crate::surface::Surface;
use crate::tolerance::Tolerances;

use super::stages::{self, Stated};
use super::{Model, Options, Regions, Warning, model};

/// Relations that solids are made with, most first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Extent {
    All,
    WithoutSizes,
    None,
}

/// Primitives with relations, and the solids of them.
pub(super) struct Attempt {
    pub segmentation: Segmentation,
    pub relations: Vec<Relation>,
    pub dimensions: Vec<Dimension>,
    pub model: Model,
    pub warnings: Vec<Warning>,
    /// Of the part's vertices from the model.
    pub deviation: Option<Deviation>,
}

/// The best of the attempts. `revise`: see [`super::run_revised`].
pub(super) fn best(
    regions: &Regions,
    stated: &Stated,
    options: &Options,
    revise: &mut dyn FnMut(&mut [Primitive]),
) -> Attempt {
    let first = attempt(regions, stated, options, Extent::All, revise);
    let cost = first.cost(regions);
    // What the user asks for is not second-guessed.
    if options.relations != Relations::Auto || cost.is_small(regions) {
        return first;
    }
    let found = first.relations.clone();
    let mut best = (cost, Extent::All, first);
    for extent in [Extent::WithoutSizes, Extent::None] {
        if best.0.is_small(regions) {
            break;
        }
        if extent == Extent::WithoutSizes && !found.iter().any(|r| r.accepted && is_size(r.kind)) {
            continue;
        }
        // What nobody saw is extended from faces that only relations hold in their direction.
        let is_seen = best.2.model.facts.iter().all(|facts| facts.n_assumed == 0);
        if extent == Extent::None && !is_seen {
            continue;
        }
        let other = attempt(regions, stated, options, extent, revise);
        let cost = other.cost(regions);
        if cost.is_less(&best.0) {
            best = (cost, extent, other);
        }
    }
    let (_, extent, mut attempt) = best;
    attempt.relations = told(found, attempt.relations, extent);
    attempt
}

fn attempt(
    regions: &Regions,
    stated: &Stated,
    options: &Options,
    extent: Extent,
    revise: &mut dyn FnMut(&mut [Primitive]),
) -> Attempt {
    let Regions { scan, support, part, .. } = regions;
    let relations = if extent == Extent::None { Relations::Off } else { options.relations.clone() };
    let options = Options { relations, ..options.clone() };
    let sizes = extent == Extent::All;
    let Regularized { mut segmentation, relations } =
        stages::regularize(part, stated, &scan.tolerances, &options, sizes);
    revise(&mut segmentation.primitives);
    let dimensions = stages::dimensions(part, stated, &mut segmentation, &options);
    let (model, warnings) = model::build(&part.mesh, &segmentation, support.as_ref(), &scan.tolerances);
    let deviation = deviation::measure(&part.mesh.vertices, &model.mesh);
    Attempt { segmentation, relations, dimensions, model, warnings, deviation }
}

/// The relations as they are in the attempt that was taken, and those of the first that it is made without.
fn told(found: Vec<Relation>, taken: Vec<Relation>, extent: Extent) -> Vec<Relation> {
    let left = |relation: &Relation| match extent {
        Extent::All => false,
        Extent::WithoutSizes => is_size(relation.kind),
        Extent::None => true,
    };
    if extent == Extent::All {
        return taken;
    }
    let refused = found.into_iter().filter(left).map(|relation| Relation {
        accepted: false,
        reason: relation.reason.or_else(|| Some("the solid is sounder without it".to_owned())),
        ..relation
    });
    taken.into_iter().chain(refused).collect()
}

fn is_size(kind: RelationKind) -> bool {
    use RelationKind::{Coaxial, CommonAngle, Parallel, Perpendicular};
    !matches!(kind, Parallel | Perpendicular | CommonAngle | Coaxial)
}

/// What is wrong with the solids of an attempt.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Cost {
    /// Solids that are open or that our own check refused.
    n_unsound: usize,
    /// Area of faces that are not on the surface of their region, length squared.
    replaced: f64,
    /// Area of the scan that the model does not pass, length squared.
    off: f64,
}

/// Distance, in spacings, from which a vertex is off the model: rounded edges and noise stay within it.
const OFF: f64 = 2.0;
/// Share of the part's area up to which what the model does not pass is the scan's junk.
const JUNK: f64 = 0.005;

impl Cost {
    fn is_small(&self, regions: &Regions) -> bool {
        self.n_unsound == 0 && self.replaced == 0.0 && self.off < JUNK * regions.part.mesh.total_area()
    }

    fn is_less(&self, other: &Self) -> bool {
        let area = |cost: &Self| cost.replaced + cost.off;
        self.n_unsound.cmp(&other.n_unsound).then(area(self).total_cmp(&area(other))).is_lt()
    }
}

impl Attempt {
    fn cost(&self, of: &Regions) -> Cost {
        let Model { solids, facts, mesh, regions, primitives, .. } = &self.model;
        let unsound = facts.iter().filter(|facts| !facts.closed || !facts.problems.is_empty());
        // Regions of which some face is not on their surface, and how much of their area that is.
        let mut share = vec![(0_usize, 0_usize); primitives.len()];
        for (solid, face) in solids.iter().flat_map(|solid| solid.faces.iter().map(move |face| (solid, face)))
        {
            let (replaced, all) = &mut share[face.region.0 as usize];
            *all += 1;
            *replaced += usize::from(is_replaced(solid, face, primitives));
        }
        let replaced = regions.iter().enumerate().map(|(t, region)| match share[region.0 as usize] {
            (0, _) => 0.0,
            (replaced, all) => mesh.area(t) * replaced as f64 / all as f64,
        });
        let no_solid = usize::from(solids.is_empty());
        let farthest = OFF * of.scan.tolerances.spacing();
        let off = self.deviation.as_ref().map_or(1.0, |deviation| 1.0 - deviation.share_within(farthest));
        let off = off * of.part.mesh.total_area();
        Cost { n_unsound: unsound.count() + no_solid, replaced: replaced.sum(), off }
    }
}

/// Whether a face of an analytic region is a spline or a facet.
fn is_replaced(solid: &Solid, face: &Face, primitives: &[Primitive]) -> bool {
    let Some(own) = primitives.get(face.region.0 as usize).and_then(|p| p.surface) else { return false };
    match (solid.geometry(face), own) {
        (Geometry::Spline(_), _) => true,
        (Geometry::Analytic(Surface::Plane(facet)), Surface::Plane(own)) => {
            facet.normal.cross(&own.normal).norm() > Tolerances::SAME
        }
        (Geometry::Analytic(surface), own) => surface.kind() != own.kind(),
    }
}
