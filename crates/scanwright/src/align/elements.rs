//! What surfaces of a model and of a scan have in common: type, side, size, direction and place.

use super::Part;
use crate::math::{Point3, Vec3};
use crate::mesh::Mesh;
use crate::prior::PriorModel;
use crate::segment::RegionId;
use crate::surface::{Surface, SurfaceKind};

/// A surface with the data it was seen on.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    /// The surface.
    pub surface: Surface,
    /// Whether its natural normal points out of the material.
    pub outward: bool,
    /// Area of its triangles.
    pub area: f64,
    /// Their middle.
    pub center: Point3,
    /// Radius about the middle that holds them, as if spread evenly over a ball.
    pub reach: f64,
}

/// What an element fixes of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Locus {
    /// A height along its direction.
    Plane,
    /// A line.
    Line,
    /// A point.
    Point,
}

impl Element {
    /// Out of the material of a plane; along an axis.
    pub(super) fn direction(&self) -> Option<Vec3> {
        match &self.surface {
            Surface::Plane(s) => Some(s.normal.into_inner() * if self.outward { 1.0 } else { -1.0 }),
            other => other.axis().map(|axis| axis.direction.into_inner()),
        }
    }

    /// Whether the opposite direction is another element.
    pub(super) fn oriented(&self) -> bool {
        matches!(self.surface.kind(), SurfaceKind::Plane | SurfaceKind::Cone)
    }

    pub(super) fn locus(&self) -> Locus {
        match self.surface {
            Surface::Plane(_) => Locus::Plane,
            Surface::Cylinder(_) | Surface::Cone(_) => Locus::Line,
            Surface::Sphere(_) | Surface::Torus(_) => Locus::Point,
        }
    }

    /// The point of its locus nearest to its data.
    pub(super) fn place(&self) -> Point3 {
        match &self.surface {
            Surface::Plane(_) => self.surface.project(&self.center),
            Surface::Cylinder(s) => s.axis.foot(&self.center),
            Surface::Cone(s) => s.axis.foot(&self.center),
            Surface::Sphere(s) => s.center,
            Surface::Torus(s) => s.axis.origin,
        }
    }

    /// Radii.
    pub(super) fn sizes(&self) -> [f64; 2] {
        match &self.surface {
            Surface::Plane(_) => [0.0; 2],
            Surface::Cylinder(s) => [s.radius, 0.0],
            Surface::Sphere(s) => [s.radius, 0.0],
            Surface::Torus(s) => [s.major_radius, s.minor_radius],
            // At the middle of its data, where the cone is as wide as it was seen.
            Surface::Cone(s) => [s.radius + s.axis.height(&self.center) * s.half_angle.tan(), 0.0],
        }
    }
}

/// Surfaces of a model: faces that lie on one surface are one element. Largest first.
pub fn of_model(model: &PriorModel) -> Vec<Element> {
    let mut sums = vec![Sum::default(); model.faces.len()];
    for (t, &face) in model.face_of.iter().enumerate() {
        sums[face as usize].add(&model.mesh, t);
    }
    let size = model.mesh.diagonal();
    let mut merged: Vec<(Surface, bool, Sum)> = Vec::new();
    for (face, sum) in model.faces.iter().zip(sums) {
        let Some(surface) = face.surface.filter(|_| sum.area > 0.0) else { continue };
        let same = |(other, outward, _): &&mut (Surface, bool, Sum)| {
            *outward == face.outward && coincide(&surface, other, &sum.center(), size)
        };
        match merged.iter_mut().find(same) {
            Some((_, _, known)) => known.join(&sum),
            None => merged.push((surface, face.outward, sum)),
        }
    }
    sorted(merged.into_iter().map(|(surface, outward, sum)| sum.element(surface, outward)).collect())
}

/// Whether two surfaces are one for a model of this size: equal to a millionth of it.
fn coincide(a: &Surface, b: &Surface, near: &Point3, size: f64) -> bool {
    const SHARE: f64 = 1e-6;
    if a.kind() != b.kind() {
        return false;
    }
    let spread = [Vec3::x(), Vec3::y(), Vec3::z()].map(|d| d * (0.1 * size));
    spread.iter().flat_map(|d| [near + d, near - d]).all(|p| {
        let foot = a.project(&p);
        b.signed_distance(&foot).abs() <= SHARE * size
    })
}

/// Regions of a scan that have a surface, largest first.
pub fn of_part(part: &Part) -> Vec<(RegionId, Element)> {
    let mut sums = vec![Sum::default(); part.segmentation.primitives.len()];
    for (t, label) in part.segmentation.labels.iter().enumerate() {
        if let Some(RegionId(k)) = label {
            sums[*k as usize].add(&part.mesh, t);
        }
    }
    let seen = part.segmentation.primitives.iter().zip(sums).enumerate().filter(|(_, (_, sum))| sum.area > 0.0);
    let mut elements: Vec<(RegionId, Element)> =
        seen.filter_map(|(k, (p, sum))| Some((RegionId(k as u32), sum.element(p.surface?, p.outward)))).collect();
    elements.sort_by(|a, b| b.1.area.total_cmp(&a.1.area));
    elements
}

fn sorted(mut elements: Vec<Element>) -> Vec<Element> {
    elements.sort_by(|a, b| b.area.total_cmp(&a.area));
    elements
}

/// Area and moments of triangles.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    area: f64,
    first: Vec3,
    second: f64,
}

impl Sum {
    fn add(&mut self, mesh: &Mesh, t: usize) {
        let (area, center) = (mesh.area(t), mesh.triangle_center(t).coords);
        // Second moment of a triangle: its middles of edges, a third of the area each.
        let [a, b, c] = mesh.corners(t).map(|p| p.coords);
        let middles = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
        self.area += area;
        self.first += center * area;
        self.second += area / 3.0 * middles.iter().map(Vec3::norm_squared).sum::<f64>();
    }

    fn join(&mut self, other: &Self) {
        self.area += other.area;
        self.first += other.first;
        self.second += other.second;
    }

    fn center(&self) -> Point3 {
        Point3::from(self.first / self.area)
    }

    fn element(&self, surface: Surface, outward: bool) -> Element {
        let center = self.center();
        let spread_sq = (self.second / self.area - center.coords.norm_squared()).max(0.0);
        // A ball's root mean square radius is the root of 3/5 of its radius.
        Element { surface, outward, area: self.area, center, reach: (spread_sq / 0.6).sqrt() }
    }
}
