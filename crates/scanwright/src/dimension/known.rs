//! A primitive with what is known of it, and how its motions move points.

use nalgebra::{DMatrix, DVector};

use crate::fit::{parameter_frame, parameter_names};
use crate::math::{Frame, Point3, UnitVec3, Vec3, centroid};
use crate::mesh::Mesh;
use crate::recognize::{Primitive, arc_seen};
use crate::segment::Segmentation;
use crate::surface::Surface;
use crate::uncertainty::Interior;

/// One primitive of a part.
#[derive(Debug, Clone)]
pub(super) struct Known {
    /// Its number.
    pub id: u32,
    pub surface: Surface,
    pub outward: bool,
    /// What its covariance refers to: the middle of its points.
    pub frame: Frame,
    /// In the order of `fit::parameter_names`.
    pub covariance: DMatrix<f64>,
    /// Triangles of its region, and their area.
    pub n_triangles: usize,
    pub area: f64,
    /// How much of its turn was seen, radians; `None` for planes.
    pub arc: Option<f64>,
    /// Whether its type is not certain.
    pub ambiguous: bool,
    /// Some of its points.
    pub points: Vec<Point3>,
}

/// Points that stand for those of a face.
const N_POINTS: usize = 400;

impl Known {
    fn new(mesh: &Mesh, vertices: &[u32], k: usize, primitive: &Primitive) -> Option<Self> {
        let surface = primitive.surface?;
        let n = parameter_names(&surface).len();
        if primitive.covariance.len() != n || vertices.is_empty() {
            return None;
        }
        let points: Vec<Point3> = vertices.iter().map(|&v| mesh.vertices[v as usize]).collect();
        let stride = points.len().div_ceil(N_POINTS);
        Some(Self {
            id: k as u32,
            surface,
            outward: primitive.outward,
            frame: parameter_frame(&surface, centroid(&points)),
            covariance: DMatrix::from_fn(n, n, |i, j| primitive.covariance[i][j]),
            n_triangles: 0,
            area: 0.0,
            arc: arc_seen(&surface, &points),
            ambiguous: primitive.ambiguous.is_some(),
            points: points.into_iter().step_by(stride).collect(),
        })
    }

    /// The primitives whose parameters are known, in order.
    pub fn all(mesh: &Mesh, interior: &Interior, segmentation: &Segmentation) -> Vec<Self> {
        let of = |(k, primitive): (usize, &Primitive)| Self::new(mesh, &interior.vertices[k], k, primitive);
        let mut all: Vec<Self> = segmentation.primitives.iter().enumerate().filter_map(of).collect();
        let mut place = vec![None; segmentation.primitives.len()];
        for (i, known) in all.iter().enumerate() {
            place[known.id as usize] = Some(i);
        }
        for (t, label) in segmentation.labels.iter().enumerate() {
            if let Some(i) = label.and_then(|region| place[region.0 as usize]) {
                all[i].area += mesh.area(t);
                all[i].n_triangles += 1;
            }
        }
        all
    }

    /// Normal of a plane, direction of an axis.
    pub fn direction(&self) -> Option<UnitVec3> {
        match &self.surface {
            Surface::Plane(plane) => Some(plane.normal),
            other => other.axis().map(|axis| axis.direction),
        }
    }

    pub fn is_plane(&self) -> bool {
        matches!(self.surface, Surface::Plane(_))
    }

    /// Variance of a named parameter.
    pub fn variance(&self, name: &str) -> Option<f64> {
        let k = parameter_names(&self.surface).iter().position(|n| *n == name)?;
        Some(self.covariance[(k, k)])
    }

    /// Variance of where the surface's frame carries `point`, along `along`: of the place of an axis or a plane there.
    pub fn variance_at(&self, point: &Point3, along: &Vec3) -> f64 {
        let arm = point - self.frame.origin;
        let axes = [self.frame.x, self.frame.y, self.frame.z].map(UnitVec3::into_inner);
        let names = parameter_names(&self.surface);
        let row = DVector::from_iterator(
            names.len(),
            names.iter().map(|name| match *name {
                "offset_x" | "center_x" => axes[0].dot(along),
                "offset_y" | "center_y" => axes[1].dot(along),
                "offset" | "offset_z" | "center_z" => axes[2].dot(along),
                "tilt_x" => axes[0].cross(&arm).dot(along),
                "tilt_y" => axes[1].cross(&arm).dot(along),
                _ => 0.0,
            }),
        );
        row.dot(&(&self.covariance * &row)).max(0.0)
    }

    /// Variance of its direction along the unit vector `along`, which is perpendicular to it; radians squared.
    pub fn variance_of_direction(&self, along: &Vec3) -> f64 {
        let ahead = self.frame.origin + self.frame.z.into_inner();
        let names = parameter_names(&self.surface);
        let Some(tilt) = names.iter().position(|name| *name == "tilt_x") else { return 0.0 };
        let arm = ahead - self.frame.origin;
        let row = [self.frame.x, self.frame.y].map(|axis| axis.cross(&arm).dot(along));
        let mut sum = 0.0;
        for (i, a) in row.iter().enumerate() {
            for (j, b) in row.iter().enumerate() {
                sum += a * b * self.covariance[(tilt + i, tilt + j)];
            }
        }
        sum.max(0.0)
    }
}
