//! First guesses in closed form, from points and normals.
//!
//! Every surface of revolution is met by its normals' lines on its axis; in the meridian plane the radius follows
//! from the covariance of points and normals, `r = sum (p - pm).(n - nm) / sum |n - nm|^2` (negative where the
//! normals point to the centre). Axis directions tried: the eigenvectors of the centred normal covariance, the
//! smallest of the uncentred one (the Gauss image of a cylinder or cone lies on a circle across the axis), and the
//! slippage axis (H. Pottmann, T. Randrup, "Rotational and helical surface approximation for reverse engineering",
//! Computing 60 (1998), 307-322).

use nalgebra::{Matrix6, SymmetricEigen, Vector2, Vector6};

use super::{Fit, Samples};
use crate::math::{Axis, Frame, Mat3, Point3, UnitVec3, Vec3, centroid, symmetric_eigen, try_unit};
use crate::surface::{Cone, Cylinder, Plane, Sphere, Surface, SurfaceKind, Torus};

/// First guesses of surfaces of `kind` through `samples`, best conditioned first; none when nothing fits at all.
pub fn starts(kind: SurfaceKind, samples: &Samples) -> Vec<Fit> {
    if samples.points.len() < 3 {
        return Vec::new();
    }
    match kind {
        SurfaceKind::Plane => plane(samples).into_iter().collect(),
        SurfaceKind::Sphere => sphere(samples).into_iter().collect(),
        SurfaceKind::Cylinder => axes(samples).iter().filter_map(|a| cylinder(samples, *a)).collect(),
        SurfaceKind::Cone => axes(samples).iter().filter_map(|a| cone(samples, *a)).collect(),
        SurfaceKind::Torus => axes(samples).iter().filter_map(|a| torus(samples, *a)).collect(),
    }
}

fn plane(samples: &Samples) -> Option<Fit> {
    let normal = try_unit(samples.normals.iter().sum())?;
    let surface = Surface::Plane(Plane { point: centroid(&samples.points), normal });
    Some(Fit { surface, outward: true })
}

fn sphere(samples: &Samples) -> Option<Fit> {
    let point_mean = centroid(&samples.points);
    let normal_mean = samples.normals.iter().sum::<Vec3>() / samples.normals.len() as f64;
    let (mut dot, mut square) = (0.0, 0.0);
    for (p, n) in samples.points.iter().zip(&samples.normals) {
        let turn = n - normal_mean;
        dot += (p - point_mean).dot(&turn);
        square += turn.norm_squared();
    }
    let radius = dot / square;
    let valid = radius.is_finite() && radius != 0.0;
    let surface = Surface::Sphere(Sphere { center: point_mean - normal_mean * radius, radius: radius.abs() });
    valid.then_some(Fit { surface, outward: radius > 0.0 })
}

/// Axis directions worth trying.
fn axes(samples: &Samples) -> Vec<UnitVec3> {
    let n = samples.normals.len() as f64;
    let mean = samples.normals.iter().sum::<Vec3>() / n;
    let (mut centered, mut uncentered) = (Mat3::zeros(), Mat3::zeros());
    for normal in &samples.normals {
        let off = normal - mean;
        centered += off * off.transpose();
        uncentered += normal * normal.transpose();
    }
    let mut found: Vec<UnitVec3> = symmetric_eigen(&(centered / n)).iter().map(|pair| pair.1).collect();
    found.push(symmetric_eigen(&(uncentered / n))[0].1);
    found.extend(slippage_axis(samples));
    let mut distinct: Vec<UnitVec3> = Vec::new();
    for axis in found {
        /// Directions within about 3 degrees lead to the same minimum.
        const SAME: f64 = 0.9985;
        if distinct.iter().all(|d| d.dot(&axis).abs() < SAME) {
            distinct.push(axis);
        }
    }
    distinct
}

/// Direction of the motion that moves the surface in itself most nearly.
fn slippage_axis(samples: &Samples) -> Option<UnitVec3> {
    let center = centroid(&samples.points);
    let size =
        samples.points.iter().map(|p| (p - center).norm_squared()).sum::<f64>() / samples.points.len() as f64;
    let size = size.sqrt();
    if size.is_nan() || size <= 0.0 {
        return None;
    }
    let mut matrix = Matrix6::zeros();
    for (p, n) in samples.points.iter().zip(&samples.normals) {
        let arm = (p - center) / size;
        let turn = arm.cross(n);
        let row = Vector6::new(n.x, n.y, n.z, turn.x, turn.y, turn.z);
        matrix += row * row.transpose();
    }
    let eigen = SymmetricEigen::new(matrix);
    let smallest = eigen.eigenvalues.imin();
    let motion = eigen.eigenvectors.column(smallest);
    let turn = Vec3::new(motion[3], motion[4], motion[5]);
    let slide = Vec3::new(motion[0], motion[1], motion[2]);
    // A pure translation slips along an extrusion: its direction is the axis of a cylinder.
    try_unit(if turn.norm() > slide.norm() { turn } else { slide })
}

/// The point where the lines of all normals come nearest to meeting an axis of this direction.
fn axis_position(samples: &Samples, direction: UnitVec3) -> Option<Frame> {
    let frame = Frame::from_z(centroid(&samples.points), direction);
    // In the plane across the axis a normal's line through q with direction m meets c when cross(q - c, m) = 0.
    let mut a = nalgebra::Matrix2::zeros();
    let mut b = Vector2::zeros();
    for (p, n) in samples.points.iter().zip(&samples.normals) {
        let q = frame.local(p);
        let across = Vector2::new(n.dot(&frame.y), -n.dot(&frame.x));
        a += across * across.transpose();
        b += across * across.dot(&q.xy());
    }
    let c = a.try_inverse()? * b;
    Some(Frame { origin: frame.global(&Vec3::new(c.x, c.y, 0.0)), ..frame })
}

/// Points and normals in the meridian half-plane of an axis: (radius, height), (radial, axial).
fn profile(samples: &Samples, axis: &Axis) -> Vec<(Vector2<f64>, Vector2<f64>)> {
    let along = axis.direction.into_inner();
    samples
        .points
        .iter()
        .zip(&samples.normals)
        .map(|(p, n)| {
            let radial = axis.radial(p);
            let outward = radial.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            (Vector2::new(radial.norm(), axis.height(p)), Vector2::new(n.dot(&outward), n.dot(&along)))
        })
        .collect()
}

fn cylinder(samples: &Samples, direction: UnitVec3) -> Option<Fit> {
    let frame = Frame::from_z(centroid(&samples.points), direction);
    let flat: Vec<_> = samples
        .points
        .iter()
        .zip(&samples.normals)
        .map(|(p, n)| (frame.local(p).xy(), Vector2::new(n.dot(&frame.x), n.dot(&frame.y))))
        .collect();
    let (center, radius) = circle(&flat)?;
    let origin = frame.global(&Vec3::new(center.x, center.y, 0.0));
    let surface = Surface::Cylinder(Cylinder { axis: Axis { origin, direction }, radius: radius.abs() });
    Some(Fit { surface, outward: radius > 0.0 })
}

/// Circle from points and normals in a plane; the radius is negative when normals point to the centre.
fn circle(flat: &[(Vector2<f64>, Vector2<f64>)]) -> Option<(Vector2<f64>, f64)> {
    let n = flat.len() as f64;
    let point_mean = flat.iter().map(|f| f.0).sum::<Vector2<f64>>() / n;
    let normal_mean = flat.iter().map(|f| f.1).sum::<Vector2<f64>>() / n;
    let (mut dot, mut square) = (0.0, 0.0);
    for (p, m) in flat {
        dot += (p - point_mean).dot(&(m - normal_mean));
        square += (m - normal_mean).norm_squared();
    }
    let radius = dot / square;
    (radius.is_finite() && radius != 0.0).then(|| (point_mean - normal_mean * radius, radius))
}

fn cone(samples: &Samples, direction: UnitVec3) -> Option<Fit> {
    let frame = axis_position(samples, direction)?;
    let mut axis = Axis { origin: frame.origin, direction };
    let profile = profile(samples, &axis);
    let n = profile.len() as f64;
    let point_mean = profile.iter().map(|f| f.0).sum::<Vector2<f64>>() / n;
    let mut normal_mean = profile.iter().map(|f| f.1).sum::<Vector2<f64>>() / n;
    let outward = normal_mean.x > 0.0;
    if !outward {
        normal_mean = -normal_mean;
    }
    // The natural normal is (cos, -sin): its axial part says which way the radius grows.
    let mut half_angle = (-normal_mean.y).atan2(normal_mean.x);
    let mut height = point_mean.y;
    if half_angle < 0.0 {
        half_angle = -half_angle;
        axis.direction = -axis.direction;
        height = -height;
    }
    axis.origin += axis.direction.into_inner() * height;
    let valid = half_angle > 0.0 && half_angle < std::f64::consts::FRAC_PI_2 && point_mean.x > 0.0;
    valid.then(|| Fit { surface: Surface::Cone(Cone { axis, radius: point_mean.x, half_angle }), outward })
}

fn torus(samples: &Samples, direction: UnitVec3) -> Option<Fit> {
    let frame = axis_position(samples, direction)?;
    let axis = Axis { origin: frame.origin, direction };
    let (center, radius) = circle(&profile(samples, &axis))?;
    let origin: Point3 = axis.origin + direction.into_inner() * center.y;
    let torus =
        Torus { axis: Axis { origin, direction }, major_radius: center.x, minor_radius: radius.abs() };
    (center.x > -radius.abs()).then_some(Fit { surface: Surface::Torus(torus), outward: radius > 0.0 })
}
