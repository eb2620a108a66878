//! Whether enough was seen of a face for a size to be known as well as asked, and if not, what is missing.
//!
//! What a wider scan would give is foretold from what was seen: the same points, spread over a wider arc about the same
//! axis at the same density, have a covariance too. That is exact for a surface of revolution seen the same all round,
//! and an estimate where the arc is not seen as densely as the rest.

use std::f64::consts::{PI, TAU};

use super::Primitive;
use crate::fit::{Noise, Samples, correlated_covariance, parameter_names};
use crate::math::{Axis, Frame, Point3, centroid, try_unit};
use crate::surface::Surface;

/// What one face says about its sizes.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Sufficiency {
    /// Largest standard uncertainty of its lengths: radii; of a plane its place along the normal.
    pub uncertainty: f64,
    /// What is missing; `None` when that is small enough.
    pub missing: Option<Missing>,
}

/// What would make the sizes of a face known well enough.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Missing {
    /// More of its turn (of a sphere: a wider cap), at the density of the rest; radians.
    Arc(f64),
    /// So many times the points, when all of the turn would not do.
    Points(f64),
}

impl Missing {
    /// One phrase.
    pub fn text(&self) -> String {
        match self {
            Self::Arc(angle) => {
                format!("about {:.0} degrees more of it must be seen", angle.to_degrees())
            }
            Self::Points(times) => format!("about {times:.0} times as many points are needed"),
        }
    }
}

/// Step in which wider arcs are tried, radians.
const STEP: f64 = 5.0 * PI / 180.0;
/// Points that stand for those of a face.
const MOST_POINTS: usize = 1_500;

/// How much of its turn a round face was seen over, radians; of a sphere the polar angle about the middle of what was
/// seen. `None` for planes, and without points.
pub fn arc_seen(surface: &Surface, points: &[Point3]) -> Option<f64> {
    let whole = if let Surface::Sphere(_) = surface { PI } else { TAU };
    if matches!(surface, Surface::Plane(_)) || points.is_empty() {
        return None;
    }
    // All round, there is no widest gap to begin after.
    Some(Seen::new(surface, points).map_or(whole, |seen| seen.arc))
}

/// Whether the sizes of a primitive seen at `points`, the vertices of its region, are known within `target`; `None` for
/// freeform, and where the data leave a parameter open altogether.
pub fn sufficiency(
    primitive: &Primitive,
    points: &[Point3],
    target: f64,
    noise: &Noise,
) -> Option<Sufficiency> {
    let surface = primitive.surface.as_ref()?;
    let uncertainty = of_lengths(surface, &primitive.covariance)?;
    if uncertainty <= target {
        return Some(Sufficiency { uncertainty, missing: None });
    }
    let stride = points.len().div_ceil(MOST_POINTS).max(1);
    let few: Vec<Point3> = points.iter().copied().step_by(stride).collect();
    let missing = wider(surface, &few, points.len(), uncertainty, target, noise);
    Some(Sufficiency { uncertainty, missing: Some(missing) })
}

/// Largest standard uncertainty of a length.
fn of_lengths(surface: &Surface, covariance: &[Vec<f64>]) -> Option<f64> {
    let lengths = ["offset", "radius", "major_radius", "minor_radius"];
    let names = parameter_names(surface).iter().enumerate();
    let variances =
        names.filter(|(_, name)| lengths.contains(name)).map(|(i, _)| Some(covariance.get(i)?[i]));
    let largest = variances.collect::<Option<Vec<f64>>>()?.into_iter().fold(0.0, f64::max);
    (largest > 0.0).then(|| largest.sqrt())
}

fn wider(
    surface: &Surface,
    points: &[Point3],
    n_vertices: usize,
    uncertainty: f64,
    target: f64,
    noise: &Noise,
) -> Missing {
    let more_points = |uncertainty: f64| Missing::Points((uncertainty / target).powi(2).ceil());
    let Some(seen) = Seen::new(surface, points) else { return more_points(uncertainty) };
    let foretold = |arc: f64| {
        let times = arc / seen.arc;
        let samples = Samples { points: seen.stretched(points, times), normals: Vec::new() };
        let n_vertices = (times * n_vertices as f64) as usize;
        of_lengths(surface, &correlated_covariance(surface, &samples, n_vertices, &[*noise], |_| 0.0))
    };
    let Some(now) = foretold(seen.arc) else { return more_points(uncertainty) };
    let mut best = uncertainty;
    let mut arc = seen.arc;
    while arc < seen.whole {
        arc = (arc + STEP).min(seen.whole);
        if let Some(then) = foretold(arc) {
            best = best.min(uncertainty * then / now);
            if best <= target {
                return Missing::Arc(arc - seen.arc);
            }
        }
    }
    more_points(best)
}

/// The arc in which a face is seen about its axis; of a sphere, the polar angle about the middle of what was seen.
struct Seen {
    surface: Surface,
    frame: Frame,
    /// Where the arc begins.
    start: f64,
    arc: f64,
    whole: f64,
}

impl Seen {
    fn new(surface: &Surface, points: &[Point3]) -> Option<Self> {
        let (frame, whole) = match surface {
            Surface::Plane(_) => return None,
            Surface::Sphere(s) => (Frame::from_z(s.center, try_unit(centroid(points) - s.center)?), PI),
            Surface::Cylinder(_) | Surface::Cone(_) | Surface::Torus(_) => {
                let Axis { origin, direction } = surface.axis()?;
                (Frame::from_z(origin, direction), TAU)
            }
        };
        let mut seen = Self { surface: *surface, frame, start: 0.0, arc: 0.0, whole };
        let mut angles: Vec<f64> = points.iter().map(|p| seen.angle(p)).collect();
        angles.sort_by(f64::total_cmp);
        if let Surface::Sphere(_) = surface {
            seen.arc = *angles.last()?;
        } else {
            // The widest gap is what was not seen.
            let next = angles.iter().skip(1).chain(angles.first()).zip(&angles);
            let (gap, end) = next
                .map(|(next, here)| ((next - here).rem_euclid(TAU), *next))
                .max_by(|a, b| a.0.total_cmp(&b.0))?;
            (seen.start, seen.arc) = (end, TAU - gap);
        }
        (seen.arc > 0.0 && seen.arc < whole).then_some(seen)
    }

    /// Angle of a point: about the axis, or from it for a sphere.
    fn angle(&self, point: &Point3) -> f64 {
        let local = self.frame.local(point);
        match self.surface {
            Surface::Sphere(_) => local.xy().norm().atan2(local.z),
            _ => local.y.atan2(local.x),
        }
    }

    /// The points with their angles drawn out.
    fn stretched(&self, points: &[Point3], times: f64) -> Vec<Point3> {
        let moved = |point: &Point3| {
            let mut local = self.frame.local(point);
            let angle = self.angle(point);
            if let Surface::Sphere(_) = self.surface {
                let (sin, cos) = (angle * times).sin_cos();
                let across = local.xy().try_normalize(0.0).unwrap_or_default() * local.norm();
                local = nalgebra::Vector3::new(across.x * sin, across.y * sin, local.norm() * cos);
            } else {
                let turn = (angle - self.start).rem_euclid(TAU) * (times - 1.0);
                let turned = nalgebra::Rotation2::new(turn) * local.xy();
                local = nalgebra::Vector3::new(turned.x, turned.y, local.z);
            }
            self.frame.global(&local)
        };
        points.iter().map(moved).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::Fit;
    use crate::math::Vec3;
    use crate::random::Rng;
    use crate::surface::Cylinder;

    const RADIUS: f64 = 10.0;
    const SIGMA: f64 = 0.05;
    const NOISE: Noise = Noise { white: SIGMA, correlated: SIGMA, length: 2.0 };

    /// A wall of some degrees, its points half a length apart.
    fn wall(degrees: f64) -> (Primitive, Vec<Point3>) {
        let axis = Axis { origin: Point3::origin(), direction: Vec3::z_axis() };
        let surface = Surface::Cylinder(Cylinder { axis, radius: RADIUS });
        let mut rng = Rng::for_task(1, "sufficiency", 0);
        let n_round = (2.0 * degrees.to_radians() * RADIUS) as usize;
        let points: Vec<Point3> = (0..=n_round)
            .flat_map(|i| (0..40).map(move |j| (i, j)))
            .map(|(i, j)| {
                let (sin, cos) = (degrees.to_radians() * i as f64 / n_round as f64).sin_cos();
                let r = RADIUS + SIGMA * rng.normal();
                Point3::new(r * cos, r * sin, 0.5 * f64::from(j))
            })
            .collect();
        let samples = Samples { points: points.clone(), normals: Vec::new() };
        let fit = Fit { surface, outward: true };
        let mut primitive = Primitive::with_evidence(fit, &samples, points.len());
        primitive.covariance = correlated_covariance(&surface, &samples, points.len(), &[NOISE], |_| 0.0);
        (primitive, points)
    }

    fn missing(degrees: f64, target: f64) -> Option<Missing> {
        let (primitive, points) = wall(degrees);
        sufficiency(&primitive, &points, target, &NOISE).expect("a cylinder").missing
    }

    #[test]
    fn the_arc_that_is_said_to_be_missing_is_the_one_that_suffices() {
        let known = |degrees: f64| {
            let (primitive, points) = wall(degrees);
            sufficiency(&primitive, &points, 1.0, &NOISE).expect("a cylinder").uncertainty
        };
        for (seen, wanted) in [(40.0, 90.0), (60.0, 120.0), (90.0, 200.0)] {
            let target = known(wanted);
            let Some(Missing::Arc(arc)) = missing(seen, target) else { panic!("{seen}: an arc is missing") };
            let told = seen + arc.to_degrees();
            // The noise that each scan shows differs by a few hundredths.
            assert!((told - wanted).abs() < 0.15 * wanted, "{seen}: {told} instead of {wanted}");
            assert_eq!(missing(wanted, 1.05 * target), None);
        }
    }

    #[test]
    fn where_the_whole_turn_would_not_do_points_are_missing() {
        let (primitive, points) = wall(358.0);
        let known = sufficiency(&primitive, &points, 1.0, &NOISE).expect("a cylinder").uncertainty;
        let Some(Missing::Points(times)) = missing(358.0, known / 3.0) else { panic!("points are missing") };
        assert!((8.0..=10.0).contains(&times), "{times} times");
        assert!(Missing::Points(times).text().contains("times as many points"));
    }
}
