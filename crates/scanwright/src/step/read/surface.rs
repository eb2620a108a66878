//! Surfaces of faces: read, and named where they are one of the five.

use super::StepReadError;
use super::curve::{self, CLOSED, Curve, implied_knots, knots, pole, positive};
use super::nurbs::{NurbsSurface, Pole};
use super::part21::{Exchange, Instance};
use super::patch::{Patch, Shape, Uv};
use super::placement::{direction, frame, point, vector};
use crate::math::{Axis, Frame, Point3, UnitVec3, Vec3, try_unit};
use crate::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};
use crate::tolerance::Tolerances;

/// Most surfaces that one is trimmed from in turn.
const LONGEST_CHAIN: usize = 8;
/// Angle, radians, within which directions of a swept surface are one: they are written with nine digits and more.
const SAME: f64 = Tolerances::SAME;

/// Reads a surface. `radians`: the unit of angles; `border`: points of the face's border, which tell the side of an apex
/// and the part of a spindle that is meant.
pub(super) fn read(
    exchange: &Exchange,
    id: u64,
    radians: f64,
    border: &[Point3],
) -> Result<Patch, StepReadError> {
    let mut entity = exchange.get(id)?;
    for _ in 0..LONGEST_CHAIN {
        let trimmed = ["RECTANGULAR_TRIMMED_SURFACE", "CURVE_BOUNDED_SURFACE"].iter().find(|t| entity.is(t));
        let Some(name) = trimmed else { return of_entity(exchange, &entity, radians, border) };
        entity = exchange.get(entity.fields(name, 1).reference(0)?)?;
    }
    Err(StepReadError::Cycle(id))
}

fn of_entity(
    exchange: &Exchange,
    entity: &Instance,
    radians: f64,
    border: &[Point3],
) -> Result<Patch, StepReadError> {
    let placed = || {
        let name = if entity.leaves.len() > 1 { "ELEMENTARY_SURFACE" } else { "" };
        entity.fields(name, 1).reference(0).and_then(|id| frame(exchange, id))
    };
    if entity.is("PLANE") {
        return Ok(analytic(Shape::Plane, placed()?));
    }
    if entity.is("CYLINDRICAL_SURFACE") {
        let radius = positive(entity, entity.fields("CYLINDRICAL_SURFACE", 2).real(0)?)?;
        return Ok(analytic(Shape::Cylinder { radius }, placed()?));
    }
    if entity.is("CONICAL_SURFACE") {
        let fields = entity.fields("CONICAL_SURFACE", 2);
        return cone(entity, placed()?, (fields.real(0)?, fields.real(1)? * radians), border);
    }
    if entity.is("SPHERICAL_SURFACE") {
        let radius = positive(entity, entity.fields("SPHERICAL_SURFACE", 2).real(0)?)?;
        return Ok(analytic(Shape::Sphere { radius }, placed()?));
    }
    if entity.is("TOROIDAL_SURFACE") || entity.is("DEGENERATE_TOROIDAL_SURFACE") {
        let fields = entity.fields("TOROIDAL_SURFACE", 2);
        let (major, minor) = (fields.real(0)?.abs(), positive(entity, fields.real(1)?)?);
        let inner = entity.fields("DEGENERATE_TOROIDAL_SURFACE", 4).flag(0).is_ok_and(|outer| !outer);
        return Ok(torus(placed()?, (major, minor), inner, border));
    }
    if entity.is("SURFACE_OF_LINEAR_EXTRUSION") {
        return extrusion(exchange, entity);
    }
    if entity.is("SURFACE_OF_REVOLUTION") {
        return revolution(exchange, entity, border);
    }
    if entity.is("B_SPLINE_SURFACE") || entity.leaves.iter().any(|l| SPLINES.contains(&l.name)) {
        return spline(exchange, entity);
    }
    Err(entity.unsupported())
}

const SPLINES: &[&str] = &[
    "B_SPLINE_SURFACE_WITH_KNOTS",
    "BEZIER_SURFACE",
    "QUASI_UNIFORM_SURFACE",
    "UNIFORM_SURFACE",
    "RATIONAL_B_SPLINE_SURFACE",
];

/// A sphere about the axis of a frame.
pub(super) fn sphere(frame: Frame, radius: f64) -> Patch {
    analytic(Shape::Sphere { radius }, frame)
}

/// One of the five in its own parameters.
fn analytic(shape: Shape, frame: Frame) -> Patch {
    use std::f64::consts::{FRAC_PI_2, TAU};
    let axis = Axis { origin: frame.origin, direction: frame.z };
    let on_axis = |h: f64| frame.origin + frame.z.into_inner() * h;
    let (mut periods, mut poles) = ([Some(TAU), None], [None, None]);
    let surface = match &shape {
        Shape::Cylinder { radius } => Surface::Cylinder(Cylinder { axis, radius: *radius }),
        Shape::Cone { radius, slope, below } => {
            let apex = -radius / slope;
            poles[usize::from(*below == (*slope > 0.0))] = Some((apex, on_axis(apex)));
            // The axis points to where the radius of this nappe grows.
            let grows = (*slope > 0.0) != *below;
            let direction = if grows { frame.z } else { -frame.z };
            // Beside the placement where that is on the nappe, one radius or height from the apex where it is not.
            let (height, here) = if (*radius < 0.0) == *below && *radius != 0.0 {
                (0.0, radius.abs())
            } else {
                let away = if grows { 1.0 } else { -1.0 };
                (apex + away * apex.abs().max(1.0), slope.abs() * apex.abs().max(1.0))
            };
            let axis = Axis { origin: on_axis(height), direction };
            Surface::Cone(Cone { axis, radius: here, half_angle: slope.abs().atan() })
        }
        Shape::Sphere { radius } => {
            poles = [Some((-FRAC_PI_2, on_axis(-radius))), Some((FRAC_PI_2, on_axis(*radius)))];
            Surface::Sphere(Sphere { center: frame.origin, radius: *radius })
        }
        Shape::Torus { major, minor, lemon } => {
            if major < minor {
                let v = (-major / minor).acos();
                let h = minor * v.sin();
                poles = if *lemon {
                    [Some((v, on_axis(h))), Some((TAU - v, on_axis(-h)))]
                } else {
                    [Some((-v, on_axis(-h))), Some((v, on_axis(h)))]
                };
            } else {
                periods[1] = Some(TAU);
            }
            let major_radius = if *lemon { -major } else { *major };
            Surface::Torus(Torus { axis, major_radius, minor_radius: *minor })
        }
        Shape::Plane => return Patch::plane(frame),
        Shape::Extrusion { .. } | Shape::Revolution { .. } | Shape::Spline { .. } => {
            unreachable!("only the five come here")
        }
    };
    Patch { shape, frame, analytic: Some(surface), periods, poles, mirrored: false }
}

fn cone(
    entity: &Instance,
    frame: Frame,
    (radius, half_angle): (f64, f64),
    border: &[Point3],
) -> Result<Patch, StepReadError> {
    let slope = half_angle.tan();
    if slope == 0.0 && radius > 0.0 {
        return Ok(analytic(Shape::Cylinder { radius }, frame));
    }
    if half_angle.abs() >= std::f64::consts::FRAC_PI_2 || slope == 0.0 || radius < 0.0 {
        let found = format!("has radius {radius} and half angle {half_angle} rad");
        return Err(entity.wrong(found, "a radius and an acute angle"));
    }
    let sides = border.iter().map(|p| radius + frame.local(p).z * slope);
    let below = sides.sum::<f64>() < 0.0;
    Ok(analytic(Shape::Cone { radius, slope, below }, frame))
}

fn torus(frame: Frame, (major, minor): (f64, f64), inner: bool, border: &[Point3]) -> Patch {
    let off = |signed: f64| -> f64 {
        let distance = |p: &Point3| {
            let l = frame.local(p);
            ((l.x.hypot(l.y) - signed).hypot(l.z) - minor).abs()
        };
        border.iter().map(distance).sum()
    };
    let (apple, lemon) = (off(major), off(-major));
    let lemon = major < minor && major > 0.0 && if apple == lemon { inner } else { lemon < apple };
    analytic(Shape::Torus { major, minor, lemon }, frame)
}

fn extrusion(exchange: &Exchange, entity: &Instance) -> Result<Patch, StepReadError> {
    let fields = entity.fields("SURFACE_OF_LINEAR_EXTRUSION", 2);
    let base = entity.fields("SWEPT_SURFACE", 1);
    let curve = curve::read(exchange, base.reference(0)?)?;
    let sweep = vector(exchange, fields.reference(0)?)?;
    let along = try_unit(sweep).ok_or_else(|| entity.wrong("is swept by nothing", "a direction"))?;
    match &curve {
        Curve::Line { origin, direction } => {
            let normal = try_unit(direction.cross(&sweep))
                .ok_or_else(|| entity.wrong("is a line swept along itself", "a surface"))?;
            let x = UnitVec3::new_normalize(*direction);
            let y = UnitVec3::new_normalize(normal.cross(&x));
            return Ok(analytic(Shape::Plane, Frame { origin: *origin, x, y, z: normal }));
        }
        Curve::Ellipse { frame, semi_axes: (a, b) } if a == b && frame.z.cross(&along).norm() <= SAME => {
            let mut patch = analytic(Shape::Cylinder { radius: *a }, *frame);
            // Swept against the circle's own axis, the file's normal points inwards.
            patch.mirrored = frame.z.dot(&along) < 0.0;
            return Ok(patch);
        }
        Curve::Parabola { .. } | Curve::Hyperbola { .. } => return Err(entity.unsupported()),
        _ => {}
    }
    let frame = Frame::from_z(Point3::origin(), along);
    let periods = [curve.period(), None];
    let starts = starts(&curve);
    let shape = Shape::Extrusion { curve, direction: sweep, starts };
    Ok(Patch { shape, frame, analytic: None, periods, poles: [None, None], mirrored: false })
}

/// Points of a profile from which projections start.
fn starts(curve: &Curve) -> Vec<(f64, Point3)> {
    const ROUND: usize = 64;
    if let Curve::Spline { starts, .. } = curve {
        return starts.clone();
    }
    let at = (0..=ROUND).map(|i| std::f64::consts::TAU * i as f64 / ROUND as f64);
    at.map(|t| (t, curve.point(t))).collect()
}

fn revolution(exchange: &Exchange, entity: &Instance, border: &[Point3]) -> Result<Patch, StepReadError> {
    let fields = entity.fields("SURFACE_OF_REVOLUTION", 2);
    let curve = curve::read(exchange, entity.fields("SWEPT_SURFACE", 1).reference(0)?)?;
    let axis = exchange.get(fields.reference(0)?)?;
    let placement = axis.fields("AXIS1_PLACEMENT", 1);
    let z = placement.optional(1).map_or(Ok(Vec3::z_axis()), |id| direction(exchange, id))?;
    let origin = point(exchange, placement.reference(0)?)?;
    let frame = Frame::from_z(origin, z);
    match &curve {
        Curve::Line { origin, direction } => {
            if let Some(patch) = turned_line(entity, &frame, origin, direction, border)? {
                return Ok(patch);
            }
            return Err(entity.unsupported());
        }
        Curve::Ellipse { frame: circle, semi_axes: (a, b) } if a == b => {
            if let Some(patch) = turned_circle(&frame, circle, *a, border) {
                return Ok(patch);
            }
        }
        Curve::Parabola { .. } | Curve::Hyperbola { .. } => return Err(entity.unsupported()),
        _ => {}
    }
    let periods = [Some(std::f64::consts::TAU), curve.period()];
    let mut poles = [None, None];
    if let Curve::Spline { curve: spline, closed: false, starts } = &curve {
        let (low, high) = spline.knots.range();
        let size = starts.iter().map(|(_, p)| (p - starts[0].1).norm()).fold(0.0, f64::max);
        for (end, t) in [low, high].into_iter().enumerate() {
            let p = curve.point(t);
            let l = frame.local(&p);
            if l.x.hypot(l.y) <= CLOSED * size {
                poles[end] = Some((t, p));
            }
        }
    }
    let starts = starts(&curve);
    Ok(Patch {
        shape: Shape::Revolution { curve, starts },
        frame,
        analytic: None,
        periods,
        poles,
        mirrored: false,
    })
}

/// A line turned about an axis in its plane: a plane, a cylinder or a cone. `None` for a hyperboloid.
fn turned_line(
    entity: &Instance,
    frame: &Frame,
    origin: &Point3,
    along: &Vec3,
    border: &[Point3],
) -> Result<Option<Patch>, StepReadError> {
    let along = along.normalize();
    let p = frame.local(origin);
    let (rise, radius) = (along.dot(&frame.z), p.x.hypot(p.y));
    let radial = try_unit(frame.x.into_inner() * p.x + frame.y.into_inner() * p.y);
    let in_plane = radial.is_none_or(|r| along.dot(&r.cross(&frame.z)).abs() <= SAME);
    if !in_plane {
        return Ok(None);
    }
    let at = Frame { origin: frame.origin + frame.z.into_inner() * p.z, ..*frame };
    // How fast the line leaves the axis; from the axis itself it does so in its own direction.
    let outward = radial.map_or((1.0 - rise * rise).max(0.0).sqrt(), |r| along.dot(&r));
    let mut patch = if rise.abs() <= SAME {
        analytic(Shape::Plane, at)
    } else if outward.abs() <= SAME {
        analytic(Shape::Cylinder { radius: positive(entity, radius)? }, at)
    } else {
        cone(entity, at, (radius, (outward / rise).atan()), border)?
    };
    // The file's normal is that of the turn crossed with the line.
    let off_axis = patch.frame.x.into_inner();
    let of_file = frame.z.cross(&off_axis).cross(&(off_axis * outward + frame.z.into_inner() * rise));
    let sample = match &patch.shape {
        Shape::Plane => patch.frame.z.into_inner(),
        _ => off_axis - frame.z.into_inner() * (outward / rise),
    };
    patch.mirrored = of_file.dot(&sample) < 0.0;
    Ok(Some(patch))
}

/// A circle turned about an axis in its plane: a torus, or a sphere where its centre is on the axis.
fn turned_circle(frame: &Frame, circle: &Frame, radius: f64, border: &[Point3]) -> Option<Patch> {
    let center = frame.local(&circle.origin);
    let major = center.x.hypot(center.y);
    let upright = circle.z.dot(&frame.z).abs() <= SAME;
    let in_plane = upright && (frame.origin - circle.origin).dot(&circle.z).abs() <= SAME * (radius + major);
    if !in_plane {
        return None;
    }
    let at = Frame { origin: frame.origin + frame.z.into_inner() * center.z, ..*frame };
    let mut patch = if major <= SAME * radius {
        analytic(Shape::Sphere { radius }, at)
    } else {
        torus(at, (major, radius), false, border)
    };
    // The outermost point of the circle: the turn crossed with the circle's direction there.
    let outward = if major <= SAME * radius {
        frame.z.cross(&circle.z).normalize()
    } else {
        (circle.origin - at.origin).normalize()
    };
    let of_file = frame.z.cross(&outward).cross(&circle.z.cross(&outward));
    patch.mirrored = of_file.dot(&outward) < 0.0;
    Some(patch)
}

fn spline(exchange: &Exchange, entity: &Instance) -> Result<Patch, StepReadError> {
    let base = entity.fields("B_SPLINE_SURFACE", 1);
    let degrees = [base.count(0)?, base.count(1)?];
    let rows = base.rows(2)?;
    let n = [rows.len(), rows.first().map_or(0, super::part21::Fields::len)];
    let weights = if entity.is("RATIONAL_B_SPLINE_SURFACE") {
        Some(entity.fields("RATIONAL_B_SPLINE_SURFACE", 8).rows(0)?)
    } else {
        None
    };
    let mut poles: Vec<Pole> = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        let ids = row.as_references()?;
        let row_weights = match &weights {
            Some(weights) => weights.get(i).map_or(Ok(Vec::new()), super::part21::Fields::as_reals)?,
            None => vec![1.0; ids.len()],
        };
        if ids.len() != n[1] || row_weights.len() != n[1] {
            return Err(
                entity.wrong("has rows of different lengths", "as many poles and weights in each row")
            );
        }
        for (id, weight) in ids.iter().zip(row_weights) {
            poles.push(pole(entity, point(exchange, *id)?, weight)?);
        }
    }
    let of = |i: usize| {
        if !entity.is("B_SPLINE_SURFACE_WITH_KNOTS") {
            return implied_knots(entity, degrees[i], n[i]);
        }
        let fields = entity.fields("B_SPLINE_SURFACE_WITH_KNOTS", 8);
        knots(entity, degrees[i], n[i], &fields.counts(i)?, &fields.reals(i + 2)?)
    };
    Ok(spline_patch(NurbsSurface { u: of(0)?, v: of(1)?, poles }))
}

/// A spline with what closes it: sides that meet, and sides that are one point.
fn spline_patch(surface: NurbsSurface) -> Patch {
    let positions: Vec<Point3> = surface.poles.iter().map(|p| Point3::from(p.xyz() / p.w)).collect();
    let size = crate::mesh::Mesh { vertices: positions.clone(), triangles: Vec::new() }.diagonal();
    let near = CLOSED * size;
    let side = |s: &NurbsSurface, high: bool| -> Vec<Point3> {
        const ALONG: usize = 24;
        let ((u0, u1), (v0, v1)) = (s.u.range(), s.v.range());
        let v = if high { v1 } else { v0 };
        (0..=ALONG).map(|i| s.jet(u0 + (u1 - u0) * i as f64 / ALONG as f64, v).0).collect()
    };
    let is_pole = |points: &[Point3]| points.iter().all(|p| (p - points[0]).norm() <= near);
    let transposed = surface.transposed();
    // A side that is one point becomes one of the second parameter.
    let swap = !(is_pole(&side(&surface, false)) || is_pole(&side(&surface, true)))
        && (is_pole(&side(&transposed, false)) || is_pole(&side(&transposed, true)));
    let (surface, other) = if swap { (transposed, surface) } else { (surface, transposed) };
    let meet =
        |s: &NurbsSurface| side(s, false).iter().zip(side(s, true)).all(|(a, b)| (a - b).norm() <= near);
    let length = |(low, high): (f64, f64)| high - low;
    let mut poles = [None, None];
    for high in [false, true] {
        let points = side(&surface, high);
        let (v0, v1) = surface.v.range();
        if is_pole(&points) {
            poles[usize::from(high)] = Some((if high { v1 } else { v0 }, points[0]));
        }
    }
    let v_closes = poles == [None, None] && meet(&surface);
    let periods =
        [meet(&other).then(|| length(surface.u.range())), v_closes.then(|| length(surface.v.range()))];
    let starts = spline_starts(&surface);
    let frame = Frame::from_z(Point3::origin(), Vec3::z_axis());
    let shape = Shape::Spline { surface, starts, size };
    let mut patch = Patch { shape, frame, analytic: None, periods, poles, mirrored: swap };
    patch.analytic = flat(&positions, size);
    patch
}

fn spline_starts(surface: &NurbsSurface) -> Vec<(Point3, Uv)> {
    /// Starts in one direction: two for each span of a curve, and no more than a scan of them costs.
    const MOST: usize = 40;
    let places = |knots: &super::nurbs::Knots| -> Vec<f64> {
        let (low, high) = knots.range();
        let n = (knots.breaks().len() * (knots.degree + 1)).clamp(8, MOST);
        (0..n).map(|i| low + (high - low) * (i as f64 + 0.5) / n as f64).collect()
    };
    let (us, vs) = (places(&surface.u), places(&surface.v));
    us.iter().flat_map(|u| vs.iter().map(|v| (surface.jet(*u, *v).0, [*u, *v]))).collect()
}

/// The plane that all poles lie in.
fn flat(poles: &[Point3], size: f64) -> Option<Surface> {
    let center = crate::math::centroid(poles);
    let [(_, normal), ..] = crate::math::principal_axes(poles, center);
    let off = poles.iter().map(|p| (p - center).dot(&normal).abs()).fold(0.0, f64::max);
    (off <= SAME * size && size > 0.0).then_some(Surface::Plane(Plane { point: center, normal }))
}
