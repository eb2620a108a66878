//! What differs between a model and a part by more than uncertainty and noise explain.

use super::{FaceCheck, Feature, Sightings};
use crate::align::{Alignment, Part, Target, border_width};
use crate::math::{Point3, Vec3};
use crate::mesh::Mesh;
use crate::segment::RegionId;
use crate::surface::{Surface, SurfaceKind};

/// What kind of difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ChangeKind {
    /// A face of the model is not on the part.
    Missing,
    /// A face of the part is not on the model.
    New,
    /// A face lies elsewhere.
    Moved,
    /// A face looks another way.
    Turned,
    /// A face has another size.
    Resized,
}

/// A difference.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// What kind.
    pub kind: ChangeKind,
    /// The face of the model, its place in the list.
    pub face: Option<u32>,
    /// The region of the scan.
    pub region: Option<RegionId>,
    /// The quantity, such as `radius`; `face` for whole faces.
    pub quantity: &'static str,
    /// By how much: length, or radians of a turn or half-angle; area of a missing or new face.
    pub value: f64,
    /// Standard uncertainty of it; `None` for whole faces.
    pub uncertainty: Option<f64>,
    /// Which way a place is off, in the model's coordinates.
    pub shift: Option<Vec3>,
    /// The surface that is new or measured, in the model's coordinates.
    pub surface: Option<Surface>,
}

/// Standard uncertainties from which a difference is one: of a thousand numbers that are as designed, none.
const SIGNIFICANT: f64 = 4.0;
/// Deviations of the scan's distances from which a difference is one, however many vertices show it: what edges,
/// blur and borders leave.
const LEAST_SIGMAS: f64 = 0.25;

pub(super) fn find(
    target: &Target,
    part: &Part,
    alignment: &Alignment,
    sightings: &Sightings,
    faces: &[FaceCheck],
    features: &[Feature],
) -> Vec<Change> {
    let mut changes: Vec<Change> = features.iter().flat_map(|f| of_feature(f, faces, alignment)).collect();
    let mut missing: Vec<Change> = faces
        .iter()
        .filter(|face| face.is_absent())
        .map(|face| Change {
            kind: ChangeKind::Missing,
            face: Some(face.face),
            region: None,
            quantity: "face",
            value: face.coverage.area,
            uncertainty: None,
            shift: None,
            surface: target.face(face.face).surface,
        })
        .collect();
    let mut new = new_faces(part, alignment, sightings, features);
    changes.extend(pairs(target, part, &mut missing, &mut new, alignment));
    changes.extend(missing);
    changes.extend(new);
    changes.sort_by_key(|a| (a.kind, a.face, a.region));
    changes
}

/// Sizes, places and directions that differ.
fn of_feature(feature: &Feature, faces: &[FaceCheck], alignment: &Alignment) -> Vec<Change> {
    if faces.iter().any(|face| face.face == feature.face && face.is_absent()) {
        return Vec::new();
    }
    let least = LEAST_SIGMAS * alignment.sigma;
    let differs = feature.quantities.iter().filter(|q| q.z() > SIGNIFICANT && q.deviation.abs() > least);
    differs
        .map(|q| Change {
            kind: match q.name {
                "position" => ChangeKind::Moved,
                "orientation" => ChangeKind::Turned,
                _ => ChangeKind::Resized,
            },
            face: Some(feature.face),
            region: None,
            quantity: q.name,
            value: q.measured - q.nominal,
            uncertainty: Some(q.uncertainty),
            shift: q.shift,
            surface: Some(feature.measured),
        })
        .collect()
}

/// Regions of the scan that no face explains, neither as the model has it nor as it was measured: a face that was moved is
/// not a new one.
fn new_faces(part: &Part, alignment: &Alignment, sightings: &Sightings, features: &[Feature]) -> Vec<Change> {
    /// Share of a region's vertices up to which the model explains so few that the region is new.
    const EXPLAINED: f64 = 0.5;
    /// Vertices that a region has at least, and spacings that it is wide.
    const LEAST: usize = 30;
    let near = 6.0 * alignment.sigma;
    let rounded = near + border_width(&part.tolerances);
    let n = part.segmentation.primitives.len();
    let mut areas = vec![0.0; n];
    let mut vertices: Vec<Vec<u32>> = vec![Vec::new(); n];
    for (t, label) in part.segmentation.labels.iter().enumerate() {
        if let Some(RegionId(k)) = label {
            areas[*k as usize] += part.mesh.area(t);
            vertices[*k as usize].extend(part.mesh.triangles[t]);
        }
    }
    let mut found = Vec::new();
    for (k, mine) in vertices.iter_mut().enumerate() {
        mine.sort_unstable();
        mine.dedup();
        let explains = |v: &&u32| {
            sightings.of_vertex[**v as usize].is_some_and(|s| {
                let limit = if s.at_border { rounded } else { near };
                let measured = features.iter().find(|f| f.face == s.face).map(|f| &f.measured);
                s.distance.abs() < limit
                    || measured.is_some_and(|surface| surface.signed_distance(&s.point).abs() < limit)
            })
        };
        let explained = mine.iter().filter(explains).count();
        if mine.len() < LEAST || explained as f64 > EXPLAINED * mine.len() as f64 {
            continue;
        }
        let surface = part.segmentation.primitives[k].surface.map(|s| s.moved(&alignment.pose));
        found.push(Change {
            kind: ChangeKind::New,
            face: None,
            region: Some(RegionId(k as u32)),
            quantity: "face",
            value: areas[k],
            uncertainty: None,
            shift: None,
            surface,
        });
    }
    found
}

/// A missing face and a new one of the same type and size are one face that was moved: both are taken from their lists.
fn pairs(
    target: &Target,
    part: &Part,
    missing: &mut Vec<Change>,
    new: &mut Vec<Change>,
    alignment: &Alignment,
) -> Vec<Change> {
    /// Share of a face's width by which its middle may lie beside where it was.
    const BESIDE: f64 = 0.3;
    let mut moved = Vec::new();
    missing.retain(|gone| {
        let Some(from) = gone.surface else { return true };
        let candidates = new.iter().enumerate().filter_map(|(k, change)| {
            let to = change.surface?;
            let apart =
                middle_of_region(part, alignment, change.region?)? - middle_of_face(target, gone.face?)?;
            // A flat face says where it lies along its normal only: across it, it must still be where it was.
            let beside = match from {
                Surface::Plane(s) => (apart - s.normal.into_inner() * apart.dot(&s.normal)).norm(),
                _ => 0.0,
            };
            let near = beside < BESIDE * gone.value.min(change.value).sqrt();
            shift_between(&from, &to, target).filter(|_| near).map(|shift| (k, shift, to))
        });
        let nearest = candidates.min_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
        let Some((k, shift, to)) = nearest else { return true };
        let change = new.remove(k);
        moved.push(Change {
            kind: ChangeKind::Moved,
            face: gone.face,
            region: change.region,
            quantity: "position",
            value: shift.norm(),
            // Of a region fitted by itself; its own covariance is small beside how it was cut out.
            uncertainty: Some(alignment.sigma),
            shift: Some(shift),
            surface: Some(to),
        });
        false
    });
    moved
}

fn middle_of_face(target: &Target, face: u32) -> Option<Point3> {
    let model = target.model;
    let mine = (0..model.mesh.triangles.len()).filter(|&t| model.face_of[t] == face);
    middle(&model.mesh, mine)
}

fn middle_of_region(part: &Part, alignment: &Alignment, region: RegionId) -> Option<Point3> {
    let labels = &part.segmentation.labels;
    let mine = (0..labels.len()).filter(|&t| labels[t] == Some(region));
    middle(&part.mesh, mine).map(|p| alignment.pose.point(&p))
}

/// Middle of the area of some triangles.
fn middle(mesh: &Mesh, triangles: impl Iterator<Item = usize>) -> Option<Point3> {
    let (mut area, mut first) = (0.0, Vec3::zeros());
    for t in triangles {
        area += mesh.area(t);
        first += mesh.triangle_center(t).coords * mesh.area(t);
    }
    (area > 0.0).then(|| Point3::from(first / area))
}

/// How far a surface lies from another that it may be, moved; `None` when it is another.
fn shift_between(from: &Surface, to: &Surface, target: &Target) -> Option<Vec3> {
    /// Size and turn within which it is the same face, and share of the diagonal that it moves.
    const SIZE: f64 = 0.1;
    const COSINE: f64 = 0.98;
    const FAR: f64 = 0.3;
    let sizes = |s: &Surface| match s {
        Surface::Cylinder(s) => s.radius,
        Surface::Sphere(s) => s.radius,
        Surface::Torus(s) => s.minor_radius,
        Surface::Cone(s) => s.half_angle,
        Surface::Plane(_) => 1.0,
    };
    let same = from.kind() == to.kind() && (sizes(from) / sizes(to) - 1.0).abs() < SIZE;
    let middle = target.model.mesh.bounds().map(|(lo, hi)| nalgebra::center(&lo, &hi))?;
    let shift = match (from, to) {
        (Surface::Plane(a), Surface::Plane(b)) => {
            (a.normal.dot(&b.normal) > COSINE).then(|| a.normal.into_inner() * a.signed_distance(&b.point))
        }
        (Surface::Sphere(a), Surface::Sphere(b)) => Some(b.center - a.center),
        _ => {
            let (a, b) = from.axis().zip(to.axis())?;
            let parallel = a.direction.dot(&b.direction).abs() > COSINE;
            parallel.then(|| match from.kind() {
                SurfaceKind::Torus => b.origin - a.origin,
                _ => b.foot(&middle) - a.foot(&middle),
            })
        }
    };
    shift.filter(|shift| same && shift.norm() < FAR * target.diagonal())
}

impl Change {
    /// One sentence. `names`: of the model's faces. `unit`: of lengths.
    pub fn text(&self, names: &[String], unit: &str) -> String {
        let name = self.face.map_or_else(String::new, |f| names[f as usize].clone());
        let kind = self.surface.map_or("face without a type", |s| s.kind().name());
        let spread =
            |unit: &str| self.uncertainty.map_or_else(String::new, |u| format!(" +- {u:.2e} {unit}"));
        match self.kind {
            ChangeKind::Missing => format!("{name} ({kind}, {:.4} {unit}^2) is not there", self.value),
            ChangeKind::New => format!(
                "region {} of the scan ({kind}, {:.4} {unit}^2) is on no face of the model",
                self.region.map_or(0, |r| r.0),
                self.value
            ),
            ChangeKind::Moved => {
                let way = self
                    .shift
                    .map_or_else(String::new, |s| format!(" by ({:.4}, {:.4}, {:.4})", s.x, s.y, s.z));
                format!("{name} ({kind}) is off by {:+.4} {unit}{way}{}", self.value, spread(unit))
            }
            ChangeKind::Turned => {
                let degrees = self.uncertainty.map_or(0.0, f64::to_degrees);
                format!("{name} ({kind}) is turned by {:.3} +- {degrees:.3} degrees", self.value.to_degrees())
            }
            ChangeKind::Resized if self.quantity == "half_angle" => {
                let degrees = self.uncertainty.map_or(0.0, f64::to_degrees);
                format!(
                    "{name} ({kind}) has a half angle off by {:+.3} +- {degrees:.3} degrees",
                    self.value.to_degrees()
                )
            }
            ChangeKind::Resized => format!(
                "{name} ({kind}) has a {} off by {:+.4} {unit}{}",
                self.quantity.replace('_', " "),
                self.value,
                spread(unit)
            ),
        }
    }
}
