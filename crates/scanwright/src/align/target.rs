//! A model made ready to be asked for its nearest face.
//!
//! Triangles only say which face is meant. Where that face has an analytic surface the distance is the surface's own, so
//! that a cylinder drawn with thirty-six flats costs no accuracy; beyond the border of a face it is the distance to the
//! border.

use super::borders::Borders;
use crate::deviation::{Feature, Found, Nearest};
use crate::math::{Point3, Vec3};
use crate::mesh::{Adjacency, TriId};
use crate::prior::{PriorFace, PriorModel};
use crate::surface::Surface;

/// Whether distances are to a model's surfaces or to its triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// To the analytic surface of a face that has one: triangles only approximate it. For CAD files.
    Surfaces,
    /// To the triangles, which are the model. For meshes, whose surfaces were fitted to them.
    Triangles,
}

/// A model ready for distances.
#[derive(Debug)]
pub struct Target<'a> {
    /// The model.
    pub model: &'a PriorModel,
    measure: Measure,
    nearest: Nearest,
    normals: Vec<Vec3>,
    /// One per triangle: how far it and its edges are from the surfaces they stand for, length.
    slack: Vec<f64>,
    pub(super) borders: Borders,
}

/// The place of a model that a point belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The face: its place in the model's list.
    pub face: u32,
    /// The triangle of the model that is nearest.
    pub triangle: TriId,
    /// The place itself.
    pub foot: Point3,
    /// Distance of the point, positive outside.
    pub distance: f64,
    /// Unit normal there, out of the material; the gradient of the distance.
    pub normal: Vec3,
    /// Whether the place is so near a sharp edge that a scanner rounds it, or the point lies beyond the border of a face.
    pub at_border: bool,
}

/// Cosine of the largest angle between the normals of a point and of the face it belongs to: 60 degrees, which noise
/// does not reach and the next wall exceeds.
pub const LEAST_COSINE: f64 = 0.5;

impl<'a> Target<'a> {
    /// `border`: distance from a sharp edge within which a scanner rounds it, length; see
    /// [`border_width`](super::border_width). `None` when the model has no triangle with an area.
    pub fn new(model: &'a PriorModel, measure: Measure, border: f64) -> Option<Self> {
        let nearest = Nearest::new(&model.mesh)?;
        let adjacency = Adjacency::new(&model.mesh);
        let normals = model.mesh.triangle_normals();
        let slack = slack(model, measure, &adjacency);
        let borders = Borders::new(model, &adjacency, &normals, &nearest, border);
        Some(Self { model, measure, nearest, normals, slack, borders })
    }

    /// Where on the model a point with a normal belongs, when that is nearer than `within`. A normal of length zero fits
    /// every face.
    pub fn hit(&self, point: &Point3, normal: &Vec3, within: f64) -> Option<Hit> {
        let unknown = *normal == Vec3::zeros();
        let fits = |t: TriId| unknown || self.normals[t as usize].dot(normal) > LEAST_COSINE;
        let found = self.nearest.find(point, within, fits)?;
        let hit = self.exact(point, &found);
        let at_border = hit.at_border || self.borders.near(found.triangle, &hit.foot);
        Some(Hit { at_border, ..hit })
    }

    /// Length: the model's bounding box's diagonal.
    pub fn diagonal(&self) -> f64 {
        self.model.mesh.diagonal()
    }

    /// Sum of the principal curvatures of a face near `point`, positive where its material bulges; zero without a surface.
    pub fn curvature(&self, face: u32, point: &Point3) -> f64 {
        surface_of(self.face(face)).map_or(0.0, |(surface, sign)| sign * surface.curvature_sum(point))
    }

    /// Its face of that number.
    pub fn face(&self, face: u32) -> &PriorFace {
        &self.model.faces[face as usize]
    }

    /// The surface that distances to a face are to, and its sign.
    fn surface(&self, face: u32) -> Option<(&Surface, f64)> {
        surface_of(self.face(face))
    }

    fn exact(&self, point: &Point3, found: &Found) -> Hit {
        let t = found.triangle as usize;
        let face = self.model.face_of[t];
        let base = Hit {
            face,
            triangle: found.triangle,
            foot: found.closest,
            distance: found.signed_distance(point),
            normal: self.normals[t],
            at_border: false,
        };
        let of_mesh = Self::of_triangles(point, found, base);
        let Some((surface, sign)) = self.surface(face) else { return of_mesh };
        let (natural, gradient) = surface.distance_and_normal(point);
        let normal = gradient.into_inner() * sign;
        if self.measure == Measure::Triangles {
            // The triangles say how far; which way is smoother on the surface.
            let inside = found.feature == Feature::Inside;
            return if inside { Hit { normal, ..of_mesh } } else { of_mesh };
        }
        let foot = point - gradient.into_inner() * natural;
        let turn = (normal - self.normals[t]).norm();
        let slack = 2.0 * (self.slack[t] + natural.abs() * turn) + rounding(point);
        let within = found.feature == Feature::Inside || (foot - found.closest).norm() <= slack;
        if within {
            return Hit { foot, distance: natural * sign, normal, ..base };
        }
        Hit { at_border: true, ..of_mesh }
    }

    /// The place on the triangles: beyond a border the way there is the gradient.
    fn of_triangles(point: &Point3, found: &Found, base: Hit) -> Hit {
        let way = point - found.closest;
        let known = found.feature != Feature::Inside && way.norm() > rounding(point);
        if known { Hit { normal: way / base.distance, ..base } } else { base }
    }
}

/// What rounding leaves of the coordinates of a point.
fn rounding(point: &Point3) -> f64 {
    /// Operations that each round once.
    const OPERATIONS: f64 = 64.0;
    OPERATIONS * f64::EPSILON * point.coords.amax()
}

/// A face's surface and the sign that makes its natural normal point out of the material.
pub(super) fn surface_of(face: &PriorFace) -> Option<(&Surface, f64)> {
    face.surface.as_ref().map(|surface| (surface, if face.outward { 1.0 } else { -1.0 }))
}

/// One per triangle: the largest distance of its middle and the middles of its edges from its surface, and of those of
/// its edges from the surface across.
fn slack(model: &PriorModel, measure: Measure, adjacency: &Adjacency) -> Vec<f64> {
    let mesh = &model.mesh;
    if measure == Measure::Triangles {
        return vec![0.0; mesh.triangles.len()];
    }
    let off = |t: usize, point: &Point3| {
        let face = &model.faces[model.face_of[t] as usize];
        face.surface.as_ref().map_or(0.0, |surface| surface.signed_distance(point).abs())
    };
    (0..mesh.triangles.len())
        .map(|t| {
            let corners = mesh.corners(t);
            let mut slack = off(t, &mesh.triangle_center(t));
            for k in 0..3 {
                let middle = nalgebra::center(&corners[k], &corners[(k + 1) % 3]);
                let across = adjacency.across[t][k].map_or(0.0, |u| off(u as usize, &middle));
                slack = slack.max(off(t, &middle)).max(across);
            }
            slack
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::align::samples::drum;

    #[test]
    fn points_on_a_cylinder_between_its_flats_are_on_the_model() {
        // Flats of ten degrees are 0.4 % of the radius inside.
        let model = drum(10.0, 8.0, 36);
        let target = Target::new(&model, Measure::Surfaces, 0.5).unwrap();
        let triangles = Target::new(&model, Measure::Triangles, 0.5).unwrap();
        let mut farthest: f64 = 0.0;
        for k in 0..200 {
            let angle = 0.1 + f64::from(k);
            let out = Vec3::new(angle.cos(), angle.sin(), 0.0);
            // Heights reach the rims, where wall and lids meet.
            let height = 4.0 * (f64::from(k % 11) / 5.0 - 1.0);
            let point = Point3::from(out * 10.0 + Vec3::z() * height);
            let hit = target.hit(&point, &out, 1.0).unwrap();
            assert!(hit.distance.abs() < 1e-14 * 10.0, "{} at {point}", hit.distance);
            farthest = farthest.max(triangles.hit(&point, &out, 1.0).unwrap().distance);
            let off = target.hit(&(point + out * 0.3), &out, 1.0).unwrap();
            assert!((off.distance - 0.3).abs() < 1e-13 && (off.normal - out).norm() < 1e-13);
        }
        let sagitta = 10.0 * (1.0 - (5.0_f64.to_radians()).cos());
        assert!((farthest - sagitta).abs() < 0.2 * sagitta, "{farthest} against {sagitta}");
    }

    #[test]
    fn beyond_a_border_the_way_to_it_counts_and_other_normals_do_not() {
        let model = drum(10.0, 8.0, 36);
        let target = Target::new(&model, Measure::Surfaces, 0.5).unwrap();
        let over_rim = Point3::new(11.0, 0.0, 5.0);
        let hit = target.hit(&over_rim, &Vec3::zeros(), 10.0).unwrap();
        assert!((hit.distance - 2.0_f64.sqrt()).abs() < 1e-12 && hit.at_border, "{hit:?}");
        // A point of a bore just under the wall: its normal is the wall's turned round.
        assert_eq!(target.hit(&Point3::new(9.5, 0.0, 0.0), &-Vec3::x(), 5.0), None);
        assert!(!target.hit(&Point3::new(2.0, 0.0, 4.1), &Vec3::z(), 5.0).unwrap().at_border);
    }
}
