//! A primitive turned to the direction that relations give it.

use nalgebra::{DMatrix, Dyn, Matrix2, OMatrix, Rotation3, U2, Vector2};

use super::directions::Direction;
use super::evidence::{Evidence, tilts_of_direction};
use crate::fit::parameter_names;
use crate::math::{Frame, UnitVec3, Vec3, angle_between};
use crate::recognize::{Primitive, Residual};
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// Growth of the residual that a turn may cost, in standard deviations of the noise.
const MAX_GROWTH: f64 = 0.5;

/// `primitive` with the direction `target`; its other parameters take the values that are most probable given that
/// direction. `None` when its points refuse: their root mean square distance would grow by [`MAX_GROWTH`].
///
/// A limit in parts of the residual itself is not asked for: on a face with one independent sample of the noise, the
/// true direction may raise the residual by a tenth and is no worse for it; whether a turn is more than noise explains
/// is what the relations have been tested for.
pub(super) fn turned(
    primitive: &Primitive,
    evidence: &Evidence,
    target: &Direction,
    tolerances: &Tolerances,
) -> Option<Primitive> {
    let surface = primitive.surface.as_ref()?;
    let old = &evidence.frame;
    let sign = if target.unit.dot(&old.z) < 0.0 { -1.0 } else { 1.0 };
    let unit = UnitVec3::new_unchecked(target.unit.into_inner() * sign);
    let moved = with_direction(surface, evidence, unit)?;
    let before = residual(surface, evidence);
    let after = residual(&moved, evidence);
    let sigma = tolerances.noise().max(primitive.residual.rms).max(tolerances.rounding());
    if after.rms - before.rms >= MAX_GROWTH * sigma {
        return None;
    }
    let tilts = tilts_of_direction(old, &target.covariance);
    Some(Primitive {
        surface: Some(moved),
        residual: grown(&primitive.residual, &before, &after),
        covariance: covariance(&primitive.covariance, surface, old, unit, &tilts),
        ..primitive.clone()
    })
}

/// The surface turned about the middle of its samples to `unit`, then moved and resized by the conditional mean of a
/// Gaussian, `C_ot C_tt^-1 delta_t` (T. Anderson, "An Introduction to Multivariate Statistical Analysis" (1958),
/// theorem 2.5.1).
fn with_direction(surface: &Surface, evidence: &Evidence, unit: UnitVec3) -> Option<Surface> {
    let frame = &evidence.frame;
    let turn = turn_between(&frame.z, &unit);
    let tilts = Vector2::new(turn.dot(&frame.x), turn.dot(&frame.y));
    let follow = regression(&evidence.covariance, evidence.tilt)? * tilts;
    let rotation = Rotation3::new(turn);
    let pivot = frame.origin.coords;
    let mut translation = pivot - rotation * pivot;
    let mut shape = [0.0; 2];
    for (name, by) in parameter_names(surface).iter().zip(follow.iter()) {
        match *name {
            "offset_x" => translation += frame.x.into_inner() * *by,
            "offset_y" => translation += frame.y.into_inner() * *by,
            "offset" | "offset_z" => translation += frame.z.into_inner() * *by,
            "half_angle" | "minor_radius" => shape[1] = *by,
            "radius" | "major_radius" => shape[0] = *by,
            _ => {}
        }
    }
    let mut moved = surface.transformed(&rotation, 1.0, &translation);
    match &mut moved {
        Surface::Plane(s) => s.normal = unit,
        Surface::Cylinder(s) => {
            s.axis.direction = unit;
            s.radius += shape[0];
        }
        Surface::Cone(s) => {
            s.axis.direction = unit;
            s.radius += shape[0];
            s.half_angle += shape[1];
        }
        Surface::Torus(s) => {
            s.axis.direction = unit;
            s.major_radius += shape[0];
            s.minor_radius += shape[1];
        }
        Surface::Sphere(_) => {}
    }
    exists(&moved).then_some(moved)
}

/// Whether the surface has the sizes of its type.
fn exists(surface: &Surface) -> bool {
    let sized = match surface {
        Surface::Plane(_) | Surface::Sphere(_) => true,
        Surface::Cylinder(s) => s.radius > 0.0,
        Surface::Cone(s) => {
            s.radius > 0.0 && s.half_angle > 0.0 && s.half_angle < std::f64::consts::FRAC_PI_2
        }
        Surface::Torus(s) => s.minor_radius > 0.0 && s.major_radius > -s.minor_radius,
    };
    sized && surface.is_finite()
}

/// The shortest turn that takes `from` to `to`, as a rotation vector.
fn turn_between(from: &UnitVec3, to: &UnitVec3) -> Vec3 {
    let axis = from.cross(to);
    let sin = axis.norm();
    if sin > 0.0 { axis * (angle_between(from, to) / sin) } else { Vec3::zeros() }
}

/// All parameters' regression on the tilts, `C_:t C_tt^-1`: for the tilts themselves the identity.
fn regression(covariance: &DMatrix<f64>, tilt: usize) -> Option<OMatrix<f64, Dyn, U2>> {
    let own: Matrix2<f64> = covariance.fixed_view::<2, 2>(tilt, tilt).into_owned();
    let inverse = own.try_inverse()?;
    Some(covariance.fixed_columns::<2>(tilt) * inverse)
}

/// `stated`, the covariance of the parameters in `old`, when the tilts have covariance `tilts` instead of their own;
/// in the frame of the new direction.
fn covariance(
    stated: &[Vec<f64>],
    surface: &Surface,
    old: &Frame,
    unit: UnitVec3,
    tilts: &Matrix2<f64>,
) -> Vec<Vec<f64>> {
    let names = parameter_names(surface);
    let n = stated.len();
    let stated = DMatrix::from_fn(n, n, |i, j| stated[i][j]);
    let Some(tilt) = names.iter().position(|name| *name == "tilt_x").filter(|_| n == names.len()) else {
        return Vec::new();
    };
    let Some(follow) = regression(&stated, tilt) else { return Vec::new() };
    let own: Matrix2<f64> = stated.fixed_view::<2, 2>(tilt, tilt).into_owned();
    let changed = &stated + &follow * (tilts - own) * follow.transpose();
    // The axes of the frame may jump when its third direction moves by little.
    let new = Frame::from_z(old.origin, unit);
    let angle = new.x.dot(&old.y).atan2(new.x.dot(&old.x));
    let (sin, cos) = angle.sin_cos();
    let mut turn = DMatrix::identity(n, n);
    for x in names.iter().enumerate().filter(|(_, name)| name.ends_with("_x")).map(|(i, _)| i) {
        (turn[(x, x)], turn[(x, x + 1)]) = (cos, sin);
        (turn[(x + 1, x)], turn[(x + 1, x + 1)]) = (-sin, cos);
    }
    let turned = &turn * changed * turn.transpose();
    (0..n).map(|i| (0..n).map(|j| 0.5 * (turned[(i, j)] + turned[(j, i)])).collect()).collect()
}

fn residual(surface: &Surface, evidence: &Evidence) -> Residual {
    let distances: Vec<f64> = evidence.samples.points.iter().map(|p| surface.signed_distance(p)).collect();
    Residual::from_distances(&distances)
}

/// `stated` grown as the evidence's residual has: the points of the fit are not known here.
fn grown(stated: &Residual, before: &Residual, after: &Residual) -> Residual {
    let times = |stated: f64, before: f64, after: f64| {
        if before > 0.0 { stated * after / before } else { stated.max(after) }
    };
    Residual {
        rms: times(stated.rms, before.rms, after.rms),
        p95: times(stated.p95, before.p95, after.p95),
        max: times(stated.max, before.max, after.max),
    }
}
