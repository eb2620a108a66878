//! A primitive turned to the direction and moved onto the line that relations give it.

use nalgebra::{DMatrix, DVector, Matrix3x2, Rotation3, Vector2};

use super::directions::Direction;
use super::evidence::{Evidence, moves, turn_to};
use super::lines::PlacedLine;
use super::sizes::PlacedPlane;
use crate::fit::parameter_names;
use crate::math::{Axis, Frame, Mat3, Point3, UnitVec3, Vec3};
use crate::recognize::{Primitive, Residual};
use crate::surface::Surface;
use crate::tolerance::Tolerances;

/// Growth of the residual that a relation may cost, in standard deviations of the noise.
const MAX_GROWTH: f64 = 0.5;

/// What relations ask of a primitive.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Target {
    /// Its direction, up to sign; of a sphere, that of its line.
    pub direction: Option<Direction>,
    /// The line of its axis or centre, if that is on one; there is a direction then.
    pub line: Option<PlacedLine>,
    /// The plane that it shares; there is a direction then.
    pub plane: Option<PlacedPlane>,
    /// Sizes that it shares.
    pub sizes: [Option<AskedSize>; 2],
}

/// A size that several share.
#[derive(Debug, Clone, Copy)]
pub(super) struct AskedSize {
    /// Place in `fit::parameter_names`.
    pub parameter: usize,
    pub value: f64,
    pub variance: f64,
}

impl Target {
    pub fn is_empty(&self) -> bool {
        self.direction.is_none() && self.sizes.iter().all(Option::is_none)
    }
}

/// The sizes of a surface by their names.
pub(super) fn size_of(surface: &Surface, name: &str) -> Option<f64> {
    match (surface, name) {
        (Surface::Cylinder(s), "radius") => Some(s.radius),
        (Surface::Sphere(s), "radius") => Some(s.radius),
        (Surface::Cone(s), "half_angle") => Some(s.half_angle),
        (Surface::Torus(s), "major_radius") => Some(s.major_radius),
        (Surface::Torus(s), "minor_radius") => Some(s.minor_radius),
        _ => None,
    }
}

/// `primitive` as `target` asks; its other parameters take the values that are most probable given that.
/// `None` when its points refuse: their root mean square distance would grow by [`MAX_GROWTH`].
///
/// A limit in parts of the residual itself is not asked for: on a face with one independent sample of the noise, the
/// true direction may raise the residual by a tenth and is no worse for it; whether a turn is more than noise explains
/// is what the relations have been tested for.
pub(super) fn related(
    primitive: &Primitive,
    evidence: &Evidence,
    target: &Target,
    tolerances: &Tolerances,
) -> Option<Primitive> {
    let surface = primitive.surface.as_ref()?;
    let asked = Asked::new(surface, evidence, target);
    let moved = asked.moved(surface, evidence, tolerances.spacing())?;
    let before = residual(surface, evidence);
    let after = residual(&moved, evidence);
    let sigma = tolerances.noise().max(primitive.residual.rms).max(tolerances.rounding());
    if after.rms - before.rms >= MAX_GROWTH * sigma {
        return None;
    }
    Some(Primitive {
        surface: Some(moved),
        residual: grown(&primitive.residual, &before, &after),
        covariance: asked.covariance(&primitive.covariance, surface, &evidence.frame),
        ..primitive.clone()
    })
}

/// What a target asks of the parameters of a surface.
struct Asked {
    target: Target,
    /// The turn to the target's direction; zero for a sphere.
    turn: Vec3,
    /// One combination of the parameters per row, orthonormal.
    rows: DMatrix<f64>,
    /// What each moves by.
    by: DVector<f64>,
    /// Their covariance.
    covariance: DMatrix<f64>,
}

impl Asked {
    fn new(surface: &Surface, evidence: &Evidence, target: &Target) -> Self {
        let frame = &evidence.frame;
        let directed = evidence.tilt.zip(target.direction);
        let turn = directed.map_or(Vec3::zeros(), |(_, direction)| turn_to(&frame.z, &direction.unit));
        let names = parameter_names(surface);
        let n = names.len();
        let sizes: Vec<AskedSize> = target.sizes.iter().flatten().copied().collect();
        let m = 2 * (usize::from(directed.is_some()) + usize::from(target.line.is_some()))
            + usize::from(target.plane.is_some())
            + sizes.len();
        let mut asked = Self {
            target: *target,
            turn,
            rows: DMatrix::zeros(m, n),
            by: DVector::zeros(m),
            covariance: DMatrix::zeros(m, m),
        };
        // What the direction moves each row by.
        let mut by_direction = DMatrix::zeros(m, 3);
        let mut row = 0;
        if let Some((tilt, _)) = directed {
            asked.rows.fixed_view_mut::<2, 2>(0, tilt).fill_with_identity();
            asked.by.fixed_rows_mut::<2>(0).copy_from(&Vector2::new(turn.dot(&frame.x), turn.dot(&frame.y)));
            by_direction.fixed_rows_mut::<2>(0).copy_from(&moves(frame).transpose());
            row += 2;
        }
        if let Some((line, direction)) = target.line.as_ref().zip(target.direction) {
            let first = row;
            row += 2;
            let across = match surface {
                Surface::Sphere(_) => direction.tangents(),
                _ => Matrix3x2::from_columns(&[frame.x.into_inner(), frame.y.into_inner()]),
            };
            let middle = match surface {
                Surface::Sphere(sphere) => sphere.center,
                _ => surface.axis().map_or(frame.origin, |axis| axis.foot(&frame.origin)),
            };
            let axis = Axis { origin: line.through, direction: direction.unit };
            // A sphere's centre moves along the coordinate axes, another surface along two axes of its frame.
            if directed.is_some() {
                asked.rows.fixed_view_mut::<2, 2>(first, 0).fill_with_identity();
            } else {
                asked.rows.fixed_view_mut::<2, 3>(first, 0).copy_from(&across.transpose());
            }
            asked.by.fixed_rows_mut::<2>(first).copy_from(&(-across.transpose() * axis.radial(&middle)));
            let lever = line.by_direction + Mat3::identity() * axis.height(&middle);
            by_direction.fixed_rows_mut::<2>(first).copy_from(&(across.transpose() * lever));
            let own = across.transpose() * line.covariance * across;
            asked.covariance.fixed_view_mut::<2, 2>(first, first).copy_from(&own);
        }
        if let Some((plane, Surface::Plane(own))) = target.plane.as_ref().zip(Some(surface)) {
            // Both along the own normal, which the common one is turned to.
            let sign = if plane.normal.dot(&own.normal) < 0.0 { -1.0 } else { 1.0 };
            asked.rows[(row, 0)] = 1.0;
            asked.by[row] = own.signed_distance(&frame.origin) - sign * plane.distance(&frame.origin);
            by_direction.row_mut(row).copy_from(&(sign * plane.by_direction(&frame.origin)).transpose());
            asked.covariance[(row, row)] = plane.variance;
            row += 1;
        }
        for size in sizes {
            asked.rows[(row, size.parameter)] = 1.0;
            asked.by[row] = size_of(surface, names[size.parameter]).map_or(0.0, |own| size.value - own);
            asked.covariance[(row, row)] = size.variance;
            row += 1;
        }
        if let Some(direction) = target.direction {
            asked.covariance += &by_direction * direction.covariance * by_direction.transpose();
        }
        asked
    }

    /// The surface with what is asked, its other parameters such that the distances of its points change least.
    ///
    /// First by the conditional mean of a Gaussian, `C_oa C_aa^-1 delta_a` for what is asked (T. Anderson, "An
    /// Introduction to Multivariate Statistical Analysis" (1958), theorem 2.5.1), then by steps of Gauss and Newton: a
    /// strip that was fitted degrees off is beyond first order.
    fn moved(&self, surface: &Surface, evidence: &Evidence, spacing: f64) -> Option<Surface> {
        /// Steps at most: the error of one is the square of that before.
        const STEPS: usize = 8;
        let mut by = self.regression(&evidence.covariance)? * &self.by;
        let mut best = f64::INFINITY;
        let mut moved = None;
        for _ in 0..STEPS {
            let Some(trial) = self.moved_by(surface, &evidence.frame, &by) else { break };
            let (step, cost) = evidence.correction(surface, &trial, &by, &self.rows, spacing)?;
            if cost.is_nan() || cost >= best {
                break;
            }
            (best, moved) = (cost, Some(trial));
            by += step;
        }
        moved
    }

    /// The surface turned about the middle of its samples, its other parameters moved `by`; `None` if there is none.
    fn moved_by(&self, surface: &Surface, frame: &Frame, by: &DVector<f64>) -> Option<Surface> {
        let rotation = Rotation3::new(self.turn);
        let pivot = frame.origin.coords;
        let mut translation = pivot - rotation * pivot;
        let mut shape = [0.0; 2];
        let names = parameter_names(surface);
        for (name, by) in names.iter().zip(by.iter()) {
            match *name {
                "offset_x" | "center_x" => translation += frame.x.into_inner() * *by,
                "offset_y" | "center_y" => translation += frame.y.into_inner() * *by,
                "offset" | "offset_z" | "center_z" => translation += frame.z.into_inner() * *by,
                "half_angle" | "minor_radius" => shape[1] = *by,
                "radius" | "major_radius" => shape[0] = *by,
                _ => {}
            }
        }
        let mut moved = surface.transformed(&rotation, 1.0, &translation);
        match &mut moved {
            Surface::Plane(s) => self.place(&mut s.point, Some(&mut s.normal)),
            Surface::Cylinder(s) => {
                self.place(&mut s.axis.origin, Some(&mut s.axis.direction));
                s.radius += shape[0];
            }
            Surface::Cone(s) => {
                self.place(&mut s.axis.origin, Some(&mut s.axis.direction));
                s.radius += shape[0];
                s.half_angle += shape[1];
            }
            Surface::Torus(s) => {
                self.place(&mut s.axis.origin, Some(&mut s.axis.direction));
                s.major_radius += shape[0];
                s.minor_radius += shape[1];
            }
            Surface::Sphere(s) => {
                self.place(&mut s.center, None);
                s.radius += shape[0];
            }
        }
        for size in self.target.sizes.iter().flatten() {
            set_size(&mut moved, names[size.parameter], size.value);
        }
        exists(&moved).then_some(moved)
    }

    /// Direction and line without the rounding of a rotation and of first order.
    fn place(&self, origin: &mut Point3, direction: Option<&mut UnitVec3>) {
        let Some(Direction { unit, .. }) = self.target.direction else { return };
        if let Some(line) = &self.target.line {
            *origin = Axis { origin: line.through, direction: unit }.foot(origin);
        }
        if let Some(plane) = &self.target.plane {
            *origin -= plane.normal.into_inner() * plane.distance(origin);
        }
        if let Some(direction) = direction {
            *direction = if unit.dot(direction) < 0.0 { -unit } else { unit };
        }
    }

    /// All parameters' regression on what is asked, `C_:a C_aa^-1`: for what is asked itself the identity.
    fn regression(&self, covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let cross = covariance * self.rows.transpose();
        let inverse = (&self.rows * &cross).try_inverse()?;
        Some(cross * inverse)
    }

    /// `stated`, the covariance of the parameters in `old`, when what is asked has its own covariance instead; in the
    /// frame of the new direction.
    fn covariance(&self, stated: &[Vec<f64>], surface: &Surface, old: &Frame) -> Vec<Vec<f64>> {
        let names = parameter_names(surface);
        let n = stated.len();
        if n != names.len() {
            return Vec::new();
        }
        let stated = DMatrix::from_fn(n, n, |i, j| stated[i][j]);
        let Some(follow) = self.regression(&stated) else { return Vec::new() };
        let own = &self.rows * &stated * self.rows.transpose();
        let changed = &stated + &follow * (&self.covariance - own) * follow.transpose();
        let mut turn = DMatrix::identity(n, n);
        if !matches!(surface, Surface::Sphere(_)) {
            // The axes of the frame may jump when its third direction moves by little.
            let new = Frame::from_z(
                old.origin,
                UnitVec3::new_normalize(Rotation3::new(self.turn) * old.z.into_inner()),
            );
            let angle = new.x.dot(&old.y).atan2(new.x.dot(&old.x));
            let (sin, cos) = angle.sin_cos();
            for x in names.iter().enumerate().filter(|(_, name)| name.ends_with("_x")).map(|(i, _)| i) {
                (turn[(x, x)], turn[(x, x + 1)]) = (cos, sin);
                (turn[(x + 1, x)], turn[(x + 1, x + 1)]) = (-sin, cos);
            }
        }
        let turned = &turn * changed * turn.transpose();
        (0..n).map(|i| (0..n).map(|j| 0.5 * (turned[(i, j)] + turned[(j, i)])).collect()).collect()
    }
}

/// A shared size without the rounding of a sum.
fn set_size(surface: &mut Surface, name: &str, value: f64) {
    match (surface, name) {
        (Surface::Cylinder(s), "radius") => s.radius = value,
        (Surface::Sphere(s), "radius") => s.radius = value,
        (Surface::Cone(s), "half_angle") => s.half_angle = value,
        (Surface::Torus(s), "major_radius") => s.major_radius = value,
        (Surface::Torus(s), "minor_radius") => s.minor_radius = value,
        _ => {}
    }
}

/// Whether the surface has the sizes of its type.
fn exists(surface: &Surface) -> bool {
    let sized = match surface {
        Surface::Plane(_) => true,
        Surface::Sphere(s) => s.radius > 0.0,
        Surface::Cylinder(s) => s.radius > 0.0,
        Surface::Cone(s) => {
            s.radius > 0.0 && s.half_angle > 0.0 && s.half_angle < std::f64::consts::FRAC_PI_2
        }
        Surface::Torus(s) => s.minor_radius > 0.0 && s.major_radius > -s.minor_radius,
    };
    sized && surface.is_finite()
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
