//! What each face measures: its own type of surface fitted to the vertices that show it, beside the model's.

use super::{Form, Options, Sighting, Sightings, Verdict, decide, form};
use crate::align::{Alignment, LEAST_COSINE, Part, Target};
use crate::fit::{
    Fit, Samples, Weights, correlated_covariance, least_squares, parameter_frame, parameter_names, refine,
};
use crate::math::{Axis, Frame, Point3, UnitVec3, Vec3, angle_between, centroid, stats, try_unit};
use crate::par;
use crate::surface::{Surface, SurfaceKind};

/// A number of a face with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// `radius`, `major_radius`, `minor_radius`, `half_angle`, `position` or `orientation`.
    pub name: &'static str,
    /// The model's value; zero for position and orientation.
    pub nominal: f64,
    /// What was measured: for a position how far it lies from the model's (of a plane: along its normal, positive
    /// outward), for an orientation the angle to the model's, radians.
    pub measured: f64,
    /// Standard uncertainty, the placement's included.
    pub uncertainty: f64,
    /// Which way a position is off.
    pub shift: Option<Vec3>,
    /// The length that is held against the tolerance: of an angle, what it makes over the face.
    pub deviation: f64,
    /// Standard uncertainty of that length.
    pub deviation_uncertainty: f64,
    /// What holds of it; `None` without a tolerance.
    pub verdict: Option<Verdict>,
}

impl Quantity {
    /// Its difference from the model in standard uncertainties.
    pub fn z(&self) -> f64 {
        (self.measured - self.nominal).abs() / self.uncertainty.max(f64::MIN_POSITIVE)
    }
}

/// A face as it was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Feature {
    /// The face: its place in the model's list.
    pub face: u32,
    /// The model's surface.
    pub nominal: Surface,
    /// The surface through the vertices that show it, in the model's coordinates.
    pub measured: Surface,
    /// Vertices it was fitted to.
    pub n_points: usize,
    /// Their middle.
    pub center: Point3,
    /// Root mean square of their distances, length.
    pub rms: f64,
    /// Its numbers.
    pub quantities: Vec<Quantity>,
    /// Its form.
    pub form: Form,
}

/// Vertices without which a face has no numbers.
const LEAST_POINTS: usize = 30;
/// Vertices that a fit takes.
const MOST_POINTS: usize = 8_000;
/// Deviations beyond which a vertex does not belong to a face.
const OUTLIER: f64 = 4.685;

/// One per face that has a surface and was seen well enough, in the order of the faces.
pub(super) fn measure(
    target: &Target,
    part: &Part,
    alignment: &Alignment,
    sightings: &Sightings,
    options: &Options,
) -> Vec<Feature> {
    let by_face = sightings.by_face(target.model.faces.len());
    let of_face = |f: usize| {
        let face = &target.model.faces[f];
        let seen = &by_face[f];
        let context = Context { part, alignment, options };
        if seen.len() < LEAST_POINTS {
            None
        } else {
            context.feature(f as u32, &face.surface?, face.outward, seen)
        }
    };
    par::map_indices(by_face.len(), of_face).into_iter().flatten().collect()
}

struct Context<'a> {
    part: &'a Part,
    alignment: &'a Alignment,
    options: &'a Options,
}

impl Context<'_> {
    fn feature(&self, face: u32, nominal: &Surface, outward: bool, seen: &[Sighting]) -> Option<Feature> {
        // What the scanner's spot bends is undone point by point.
        let straight = |s: &Sighting| s.point + s.normal * s.bent;
        let all = Samples {
            points: seen.iter().map(straight).collect(),
            normals: seen.iter().map(|s| s.normal).collect(),
        };
        let thinned = all.thinned(MOST_POINTS);
        let noise = self.part.tolerances.noise().max(self.part.tolerances.rounding());
        let (surface, inliers) =
            fitted(&Fit { surface: *nominal, outward }, &thinned, self.alignment.sigma.max(noise))?;
        let distances: Vec<f64> = inliers.points.iter().map(|p| surface.signed_distance(p)).collect();
        let rms = (distances.iter().map(|d| d * d).sum::<f64>() / distances.len().max(1) as f64).sqrt();
        // Of all vertices of the face, so many as the fit kept of those it was given.
        let kept = inliers.points.len() as f64 / thinned.points.len() as f64;
        let n_points = (kept * all.points.len() as f64).round();
        let sigma = rms.max(self.part.tolerances.rounding());
        // What it lies off its own surface, by more than noise explains, is form, and spread over it.
        let misfit = (sigma / self.part.noise.sigma()).max(1.0);
        let noise = self.part.noise.times(misfit);
        // A thinned fit knows no more than the points it was given.
        let covariance = correlated_covariance(&surface, &inliers, inliers.points.len(), &[noise], |_| 0.0);
        let center = centroid(&inliers.points);
        let mut feature = Feature {
            face,
            nominal: *nominal,
            measured: surface,
            n_points: n_points as usize,
            center,
            rms,
            quantities: Vec::new(),
            form: form::of(&surface, &all.points, sigma, self.part, self.alignment.vertices_per_sample),
        };
        if !covariance.is_empty() {
            feature.quantities = self.quantities(&feature, &inliers, &covariance, outward);
        }
        Some(feature)
    }

    fn quantities(
        &self,
        f: &Feature,
        samples: &Samples,
        covariance: &[Vec<f64>],
        outward: bool,
    ) -> Vec<Quantity> {
        let spread = Spread::new(&f.measured, samples, covariance);
        let reach = samples.points.iter().map(|p| (p - f.center).norm()).fold(0.0, f64::max);
        let mut found = self.sizes(f, &spread, reach);
        found.push(self.position(f, &spread, outward));
        found.extend(self.orientation(f, &spread, reach));
        if let Some(tolerance) = self.options.tolerance {
            for quantity in &mut found {
                quantity.verdict =
                    Some(decide(quantity.deviation, quantity.deviation_uncertainty, tolerance));
            }
        }
        found
    }

    fn sizes(&self, f: &Feature, spread: &Spread, reach: f64) -> Vec<Quantity> {
        let height = |axis: &Axis| axis.height(&f.center);
        let pairs: Vec<(&'static str, f64, f64)> = match (&f.nominal, &f.measured) {
            (Surface::Cylinder(a), Surface::Cylinder(b)) => vec![("radius", a.radius, b.radius)],
            (Surface::Sphere(a), Surface::Sphere(b)) => vec![("radius", a.radius, b.radius)],
            (Surface::Cone(a), Surface::Cone(b)) => vec![
                // Where its middle was seen: radii elsewhere follow from the angle.
                (
                    "radius",
                    a.radius + height(&a.axis) * a.half_angle.tan(),
                    b.radius + height(&b.axis) * b.half_angle.tan(),
                ),
                ("half_angle", a.half_angle, b.half_angle),
            ],
            (Surface::Torus(a), Surface::Torus(b)) => vec![
                ("major_radius", a.major_radius, b.major_radius),
                ("minor_radius", a.minor_radius, b.minor_radius),
            ],
            _ => Vec::new(),
        };
        let bent = self.alignment.bend_uncertainty * f.nominal.curvature_sum(&f.center).abs();
        let quantity = |(name, nominal, measured): (&'static str, f64, f64)| {
            let angle = name == "half_angle";
            let own = spread.of(name);
            let uncertainty = if angle { own } else { own.hypot(bent) };
            let arm = if angle { 2.0 * reach } else { 1.0 };
            Quantity {
                name,
                nominal,
                measured,
                uncertainty,
                shift: None,
                deviation: (measured - nominal) * arm,
                deviation_uncertainty: uncertainty * arm,
                verdict: None,
            }
        };
        pairs.into_iter().map(quantity).collect()
    }

    fn position(&self, f: &Feature, spread: &Spread, outward: bool) -> Quantity {
        let shift = match (&f.nominal, &f.measured) {
            (Surface::Plane(a), Surface::Plane(b)) => {
                let along = b.normal.dot(&a.normal);
                let height = b.signed_distance(&f.center) / along - a.signed_distance(&f.center);
                // Where the measured plane is over the middle of what was seen.
                a.normal.into_inner() * -height
            }
            (Surface::Sphere(a), Surface::Sphere(b)) => b.center - a.center,
            (Surface::Torus(a), Surface::Torus(b)) => b.axis.origin - a.axis.origin,
            _ => match f.nominal.axis().zip(f.measured.axis()) {
                Some((a, b)) => {
                    // Where the measured axis crosses the plane across the model's, at the middle of what was seen.
                    let foot = a.foot(&f.center);
                    let along = (foot - b.origin).dot(&a.direction) / b.direction.dot(&a.direction);
                    b.origin + b.direction.into_inner() * along - foot
                }
                None => Vec3::zeros(),
            },
        };
        let direction = match &f.nominal {
            Surface::Plane(s) => s.normal,
            _ => try_unit(shift).unwrap_or(spread.frame.x),
        };
        let sign = if outward { 1.0 } else { -1.0 };
        let measured = match &f.nominal {
            Surface::Plane(s) => sign * shift.dot(&s.normal),
            _ => shift.norm(),
        };
        let placed = self.alignment.uncertainty_at(&f.center, &direction);
        // A wall seen all round is drawn in from all sides; half a wall is moved.
        let bent =
            self.alignment.bend_uncertainty * f.nominal.curvature_sum(&f.center).abs() * spread.one_sided;
        let uncertainty = spread.offset(&direction).hypot(placed).hypot(bent);
        Quantity {
            name: "position",
            nominal: 0.0,
            measured,
            uncertainty,
            shift: Some(shift),
            deviation: measured,
            deviation_uncertainty: uncertainty,
            verdict: None,
        }
    }

    fn orientation(&self, f: &Feature, spread: &Spread, reach: f64) -> Option<Quantity> {
        let direction = |s: &Surface| match s {
            Surface::Plane(s) => Some(s.normal.into_inner()),
            other => other.axis().map(|axis| axis.direction.into_inner()),
        };
        let (a, mut b) = direction(&f.nominal).zip(direction(&f.measured))?;
        if a.dot(&b) < 0.0 {
            b = -b;
        }
        let angle = angle_between(&a, &b);
        let about = try_unit(a.cross(&b)).unwrap_or(spread.frame.x);
        let uncertainty = spread.tilt(&about).hypot(self.alignment.turn_uncertainty(&about));
        Some(Quantity {
            name: "orientation",
            nominal: 0.0,
            measured: angle,
            uncertainty,
            shift: None,
            deviation: angle * 2.0 * reach,
            deviation_uncertainty: uncertainty * 2.0 * reach,
            verdict: None,
        })
    }
}

/// The surface through samples, and those of them that belong to it.
fn fitted(start: &Fit, samples: &Samples, sigma: f64) -> Option<(Surface, Samples)> {
    const STEPS: usize = 60;
    let weights = Weights { distance_sigma: sigma, normal_sigma: 1.0, normal_weight: 0.0 };
    let size = |s: &Surface| {
        let mut sizes: Vec<f64> = samples.points.iter().map(|p| s.signed_distance(p).abs()).collect();
        stats::median(&mut sizes).unwrap_or(f64::INFINITY)
    };
    // From the model's surface; where that does not lie on them, from all points alike: the face was moved far.
    let near = refine(start, samples, &weights, STEPS);
    let lies = near.is_some_and(|fit| size(&fit.surface) < 2.0 * sigma);
    let far = if lies { None } else { least_squares(start, samples, STEPS) };
    let far = far.and_then(|fit| refine(&fit, samples, &weights, STEPS));
    // A few vertices along an edge fit surfaces that look another way.
    let faces_alike = |fit: &Fit| {
        let cosine = |p: &Point3| fit.surface.normal(p).dot(&start.surface.normal(p));
        samples.points.iter().map(cosine).sum::<f64>() > LEAST_COSINE * samples.points.len() as f64
    };
    let found = near.into_iter().chain(far).filter(faces_alike);
    let mut best = found.min_by(|a, b| size(&a.surface).total_cmp(&size(&b.surface)))?;
    let mut inliers = samples.clone();
    for _ in 0..2 {
        let spread = (size(&best.surface) * stats::MAD_TO_SIGMA).max(f64::MIN_POSITIVE);
        let limit = OUTLIER * spread.max(f64::EPSILON * start_size(samples));
        let kept = samples
            .points
            .iter()
            .zip(&samples.normals)
            .filter(|(p, _)| best.surface.signed_distance(p).abs() <= limit);
        let (points, normals) = kept.map(|(p, n)| (*p, *n)).unzip();
        inliers = Samples { points, normals };
        if inliers.points.len() < LEAST_POINTS {
            return None;
        }
        best = least_squares(&best, &inliers, STEPS).filter(faces_alike)?;
    }
    Some((best.surface, inliers))
}

/// Size that rounding of the coordinates is a share of.
fn start_size(samples: &Samples) -> f64 {
    samples.points.iter().fold(0.0, |m, p| m.max(p.coords.amax()))
}

/// Uncertainties of a fitted surface.
struct Spread<'a> {
    frame: Frame,
    names: &'static [&'static str],
    covariance: &'a [Vec<f64>],
    /// Length of the mean normal: zero of a wall seen all round, one of a plane.
    one_sided: f64,
}

impl<'a> Spread<'a> {
    fn new(surface: &Surface, samples: &Samples, covariance: &'a [Vec<f64>]) -> Self {
        let mean: Vec3 = samples.normals.iter().sum::<Vec3>() / samples.normals.len().max(1) as f64;
        Self {
            frame: parameter_frame(surface, centroid(&samples.points)),
            names: parameter_names(surface),
            covariance,
            one_sided: if surface.kind() == SurfaceKind::Plane { 0.0 } else { mean.norm() },
        }
    }

    fn of(&self, name: &str) -> f64 {
        self.along(&[(name, 1.0)])
    }

    /// Of a place along a direction.
    fn offset(&self, direction: &UnitVec3) -> f64 {
        let d = self.parts(direction);
        self.along(&[
            ("offset", d.z),
            ("offset_x", d.x),
            ("offset_y", d.y),
            ("offset_z", d.z),
            ("center_x", d.x),
            ("center_y", d.y),
            ("center_z", d.z),
        ])
    }

    /// Of a turn about a direction.
    fn tilt(&self, about: &UnitVec3) -> f64 {
        let d = self.parts(about);
        self.along(&[("tilt_x", d.x), ("tilt_y", d.y)])
    }

    fn parts(&self, direction: &UnitVec3) -> Vec3 {
        Vec3::new(direction.dot(&self.frame.x), direction.dot(&self.frame.y), direction.dot(&self.frame.z))
    }

    /// Of a sum of parameters, those that the surface does not have left out.
    fn along(&self, shares: &[(&str, f64)]) -> f64 {
        let at = |name: &str| self.names.iter().position(|n| *n == name);
        let known: Vec<(usize, f64)> =
            shares.iter().filter_map(|(name, share)| Some((at(name)?, *share))).collect();
        let sum: f64 = known
            .iter()
            .flat_map(|a| known.iter().map(move |b| (a, b)))
            .map(|(a, b)| a.1 * b.1 * self.covariance[a.0][b.0])
            .sum();
        sum.max(0.0).sqrt()
    }
}
