//! Second-order data of a surface at the foot of a point, and its derivatives by the shape parameters.

use super::{Cone, Cylinder, Plane, Sphere, Surface, Torus, each};
use crate::math::{Axis, Point3, UnitVec3, Vec3, any_perpendicular, try_unit};

/// Distance, frame of principal directions and curvatures at the foot of a point.
///
/// Curvatures are those of the offset surface through the point itself, positive where the natural normal turns
/// with the motion (a cylinder's is `1 / rho`): the Hessian of the signed distance is
/// `sum curvature_k tangent_k tangent_k^T`.
#[derive(Debug, Clone, Copy)]
pub struct Jet {
    /// Signed distance.
    pub distance: f64,
    /// Natural normal.
    pub normal: Vec3,
    /// Principal directions.
    pub tangents: [Vec3; 2],
    /// Principal curvatures, one per direction.
    pub curvatures: [f64; 2],
    /// Derivative of the distance by each shape parameter.
    pub distance_by_shape: [f64; 2],
    /// Derivative of the component of a fixed normal along the first tangent by each shape parameter.
    pub tilt_by_shape: [f64; 2],
}

impl Surface {
    /// Number of shape parameters: radius; radius and half-angle; major and minor radius.
    pub fn n_shape(&self) -> usize {
        match self {
            Self::Plane(_) => 0,
            Self::Cylinder(_) | Self::Sphere(_) => 1,
            Self::Cone(_) | Self::Torus(_) => 2,
        }
    }

    /// The jet at the foot of `point`.
    pub fn jet(&self, point: &Point3) -> Jet {
        each!(self, s => s.jets()(point))
    }

    /// Calls `consume` with the index and the jet of each of `points`; what the points share is computed once.
    pub fn for_each_jet(&self, points: &[Point3], mut consume: impl FnMut(usize, &Jet)) {
        each!(self, s => {
            let jet = s.jets();
            for (i, point) in points.iter().enumerate() {
                consume(i, &jet(point));
            }
        });
    }
}

impl Plane {
    fn jets(&self) -> impl Fn(&Point3) -> Jet {
        let tangents = perpendiculars(self.normal);
        move |point| Jet {
            distance: self.signed_distance(point),
            normal: self.normal.into_inner(),
            tangents,
            curvatures: [0.0; 2],
            distance_by_shape: [0.0; 2],
            tilt_by_shape: [0.0; 2],
        }
    }
}

impl Sphere {
    fn jets(&self) -> impl Fn(&Point3) -> Jet {
        |point| {
            let normal = self.normal(point);
            let from_center = (point - self.center).norm();
            Jet {
                distance: from_center - self.radius,
                normal: normal.into_inner(),
                tangents: perpendiculars(normal),
                curvatures: [1.0 / from_center.max(f64::MIN_POSITIVE); 2],
                distance_by_shape: [-1.0, 0.0],
                tilt_by_shape: [0.0; 2],
            }
        }
    }
}

impl Cylinder {
    fn jets(&self) -> impl Fn(&Point3) -> Jet {
        |point| {
            let meridian = Meridian::new(&self.axis, point);
            Jet {
                distance: meridian.radius - self.radius,
                normal: meridian.outward,
                tangents: [meridian.along, meridian.around],
                curvatures: [0.0, 1.0 / meridian.radius],
                distance_by_shape: [-1.0, 0.0],
                tilt_by_shape: [0.0; 2],
            }
        }
    }
}

impl Cone {
    fn jets(&self) -> impl Fn(&Point3) -> Jet {
        let (sin, cos) = self.half_angle.sin_cos();
        move |point| {
            let meridian = Meridian::new(&self.axis, point);
            let off = meridian.radius - self.radius;
            Jet {
                distance: off * cos - meridian.height * sin,
                normal: meridian.outward * cos - meridian.along * sin,
                tangents: [meridian.outward * sin + meridian.along * cos, meridian.around],
                curvatures: [0.0, cos / meridian.radius],
                distance_by_shape: [-cos, -off * sin - meridian.height * cos],
                tilt_by_shape: [0.0, 1.0],
            }
        }
    }
}

impl Torus {
    fn jets(&self) -> impl Fn(&Point3) -> Jet {
        |point| {
            let meridian = Meridian::new(&self.axis, point);
            let off = meridian.radius - self.major_radius;
            let from_spine = (off * off + meridian.height * meridian.height).sqrt().max(f64::MIN_POSITIVE);
            let (cos, sin) = (off / from_spine, meridian.height / from_spine);
            Jet {
                distance: from_spine - self.minor_radius,
                normal: meridian.outward * cos + meridian.along * sin,
                tangents: [meridian.along * cos - meridian.outward * sin, meridian.around],
                curvatures: [1.0 / from_spine, cos / meridian.radius],
                distance_by_shape: [-cos, -1.0],
                tilt_by_shape: [-sin / from_spine, 0.0],
            }
        }
    }
}

/// A point seen from an axis of revolution.
struct Meridian {
    radius: f64,
    height: f64,
    outward: Vec3,
    along: Vec3,
    around: Vec3,
}

impl Meridian {
    fn new(axis: &Axis, point: &Point3) -> Self {
        let radial = axis.radial(point);
        let outward = try_unit(radial).unwrap_or_else(|| any_perpendicular(&axis.direction)).into_inner();
        let along = axis.direction.into_inner();
        Self {
            radius: radial.norm().max(f64::MIN_POSITIVE),
            height: axis.height(point),
            outward,
            along,
            around: along.cross(&outward),
        }
    }
}

fn perpendiculars(normal: UnitVec3) -> [Vec3; 2] {
    let first = any_perpendicular(&normal).into_inner();
    [first, normal.cross(&first)]
}
