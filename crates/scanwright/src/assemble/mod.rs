//! Parts already modelled, placed in a scan of the object that they make.
//!
//! Each part is laid on the scan by its surfaces ([`align`](crate::align)); the one that explains the largest area is
//! kept, what it explains is taken from the scan, and the others are looked for in what is left. Parts that the scan shows
//! too little of are said so.
//!
//! Cost: at most one alignment for each pair of parts; those that nothing was taken from are not repeated.

use crate::align::{AlignError, Alignment, Measure, Options, Part, Scene, Target, align, border_width};
use crate::prior::PriorModel;
use crate::tolerance::Tolerances;

/// A part in the scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// How the scan lies on the part: `part_from_scan`, with its uncertainty.
    pub alignment: Alignment,
    /// Share of the part's area that the scan shows.
    pub covered: f64,
}

/// Why a part was not placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotPlaced {
    /// The model has no triangle with an area.
    #[error("its model has no area")]
    Empty,
    /// The scan that is left has no place for it.
    #[error("{0}")]
    NoPlace(AlignError),
    /// The best place is held by too little.
    #[error(
        "where it fits best the scan shows {:.0} % of its area, and {:.0} % is the least",
        100.0 * .0, 100.0 * LEAST_COVERED
    )]
    TooLittle(f64),
    /// What is seen of it leaves its place open.
    #[error("what the scan shows of it does not tell {0}")]
    Undetermined(String),
}

/// Share of a part's area that a scan must show. By chance a part finds two of its walls that are opposite: a third of a cube.
const LEAST_COVERED: f64 = 0.35;
/// Motions that may stay open: the turn of a turned part about its own axis.
const MOST_FREE: usize = 1;

/// Places parts in the scan of an assembly; one result per model, whose lengths are in the scan's unit.
pub fn place(models: &[PriorModel], scan: &Part) -> Vec<Result<Placement, NotPlaced>> {
    let mut rest = scan.clone();
    let mut tries: Vec<Option<Try>> = models.iter().map(|_| None).collect();
    let mut results: Vec<Option<Result<Placement, NotPlaced>>> = models.iter().map(|_| None).collect();
    loop {
        let open: Vec<usize> = (0..models.len()).filter(|i| results[*i].is_none()).collect();
        for &i in &open {
            if tries[i].is_none() {
                tries[i] = Some(Try::new(&models[i], &rest));
            }
        }
        let area = |i: &usize| tries[*i].as_ref().map_or(0.0, Try::placed_area);
        // The first of equals, so that occurrences of one part keep their order.
        let best = open.iter().copied().reduce(|best, i| if area(&i) > area(&best) { i } else { best });
        let Some(best) = best.filter(|i| area(i) > 0.0) else { break };
        let Some(Try { result, triangles, .. }) = tries[best].take() else { break };
        results[best] = Some(result);
        rest = without(&rest, &triangles);
        for other in &mut tries {
            // Lists of triangles follow the scan that they were found in.
            *other = other.take().and_then(|found| found.without(&triangles));
        }
    }
    let open = results.into_iter().zip(tries);
    open.map(|(result, found)| result.or(found.map(|f| f.result)).unwrap_or(Err(NotPlaced::Empty))).collect()
}

/// A part on what is left of the scan.
struct Try {
    result: Result<Placement, NotPlaced>,
    /// Triangles of the scan that it explains, ascending.
    triangles: Vec<usize>,
    /// Their area.
    area: f64,
}

impl Try {
    fn new(model: &PriorModel, scan: &Part) -> Self {
        let failed = |reason| Self { result: Err(reason), triangles: Vec::new(), area: 0.0 };
        let Some(target) = Target::new(model, Measure::Surfaces, border_width(&scan.tolerances)) else {
            return failed(NotPlaced::Empty);
        };
        let options = Options { scene: Scene::Assembly, ..Options::default() };
        let alignment = match align(&target, scan, &options) {
            Ok(alignment) => alignment,
            Err(error) => return failed(NotPlaced::NoPlace(error)),
        };
        // Once more with what it explains alone: then the points, their middle and their spread are its own, and its
        // symmetries are found.
        let own = only(scan, &explained(&target, scan, &alignment));
        let options = Options { start: Some(alignment.pose), ..Options::default() };
        let alignment = align(&target, &own, &options).unwrap_or(alignment);
        let triangles = explained(&target, scan, &alignment);
        let area: f64 = triangles.iter().map(|t| scan.mesh.area(*t)).sum();
        let covered = area / model.mesh.total_area();
        let result = if covered < LEAST_COVERED {
            Err(NotPlaced::TooLittle(covered))
        } else if alignment.freedom.count() > MOST_FREE {
            Err(NotPlaced::Undetermined(alignment.freedom.text().unwrap_or_default()))
        } else {
            Ok(Placement { alignment, covered })
        };
        Self { result, triangles, area }
    }

    fn placed_area(&self) -> f64 {
        if self.result.is_ok() { self.area } else { 0.0 }
    }

    /// The same on the scan without `taken`; `None` where some of what it explains is gone.
    fn without(self, taken: &[usize]) -> Option<Self> {
        let mut kept = Vec::with_capacity(self.triangles.len());
        for t in &self.triangles {
            match taken.binary_search(t) {
                Ok(_) => return None,
                Err(before) => kept.push(t - before),
            }
        }
        // What found no place in more of the scan is tried again in less: other surfaces come first then.
        self.result.is_ok().then_some(Self { triangles: kept, ..self })
    }
}

/// Triangles of the scan whose corners all lie on the placed part, ascending.
fn explained(target: &Target, scan: &Part, alignment: &Alignment) -> Vec<usize> {
    let reach = reach(&scan.tolerances);
    let on_part = crate::par::map_indices(scan.mesh.vertices.len(), |v| {
        let point = alignment.pose.point(&scan.mesh.vertices[v]);
        let normal = alignment.pose.rotation * scan.normals[v];
        target.hit(&point, &normal, reach).is_some()
    });
    let triangles = scan.mesh.triangles.iter().enumerate();
    triangles.filter(|(_, t)| t.iter().all(|v| on_part[*v as usize])).map(|(i, _)| i).collect()
}

/// Length: distance from a placed part within which its scan lies, edges rounded.
fn reach(tolerances: &Tolerances) -> f64 {
    /// Spacings that a rounded edge stands off.
    const SPACINGS: f64 = 1.0;
    /// Deviations of noise.
    const DEVIATIONS: f64 = 5.0;
    SPACINGS * tolerances.spacing() + DEVIATIONS * tolerances.noise()
}

/// The scan without triangles, given ascending.
fn without(scan: &Part, taken: &[usize]) -> Part {
    part_of(scan, |t| taken.binary_search(&t).is_err())
}

/// Triangles of the scan, given ascending.
fn only(scan: &Part, kept: &[usize]) -> Part {
    part_of(scan, |t| kept.binary_search(&t).is_ok())
}

fn part_of(scan: &Part, keep: impl Fn(usize) -> bool) -> Part {
    let (mesh, old_triangles, old_vertices) = scan.mesh.submesh(keep);
    let mut segmentation = scan.segmentation.clone();
    segmentation.labels = old_triangles.iter().map(|t| scan.segmentation.labels[*t as usize]).collect();
    Part {
        mesh,
        // Normals are those of the whole scan: at a cut they would lean.
        normals: old_vertices.iter().map(|v| scan.normals[*v as usize]).collect(),
        scan_vertex: old_vertices.iter().map(|v| scan.scan_vertex[*v as usize]).collect(),
        segmentation,
        tolerances: scan.tolerances,
        noise: scan.noise,
    }
}
