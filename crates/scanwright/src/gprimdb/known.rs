//! What a database knows of the primitives of a scan.

use serde::Serialize;

use super::{Class, Database, DatabaseError};
use crate::fit::parameter_names;
use crate::recognize::Primitive;
use crate::surface::Surface;

/// The sizes of a primitive, with their standard uncertainties.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Its type.
    pub class: Class,
    /// By name, in the order of [`Class::sizes`].
    pub sizes: Vec<(String, f64)>,
    /// One per size.
    pub uncertainties: Vec<f64>,
}

impl Measured {
    /// Those of a fitted primitive; `None` for planes and freeform regions, which have none, and without uncertainties.
    pub fn of(primitive: &Primitive) -> Option<Self> {
        let surface = primitive.surface.as_ref()?;
        let class = Class::PRIMITIVES.into_iter().find(|class| class.kind() == Some(surface.kind()))?;
        let names = parameter_names(surface);
        let mut measured = Self { class, sizes: Vec::new(), uncertainties: Vec::new() };
        for name in class.sizes() {
            let place = names.iter().position(|n| n == name)?;
            measured.sizes.push(((*name).to_owned(), size(surface, name)?));
            measured.uncertainties.push(primitive.covariance.get(place)?[place].max(0.0).sqrt());
        }
        (!measured.sizes.is_empty()).then_some(measured)
    }
}

/// A primitive of a scan that agrees with something stored.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Known {
    /// Number of the primitive: its place among all.
    pub id: u32,
    /// Name of the nearest entry; what was added comes before what was generated.
    pub name: String,
    /// Its sizes by name.
    pub sizes: Vec<(String, f64)>,
    /// Root mean square difference to the measured sizes, standard uncertainties.
    pub deviations: f64,
    /// Number of other entries that agree too.
    pub others: usize,
    /// Whether the primitive took the stored sizes.
    pub taken: bool,
}

impl Database {
    /// The primitives whose type is stored with sizes that agree within the uncertainties of both: see
    /// [`Database::query`].
    pub fn known(&self, primitives: &[Primitive]) -> Result<Vec<Known>, DatabaseError> {
        let mut known = Vec::new();
        for (k, primitive) in primitives.iter().enumerate() {
            let Some(measured) = Measured::of(primitive) else { continue };
            let mut found = self.query(measured.class, &measured.sizes, &measured.uncertainties)?.into_iter();
            if let Some(nearest) = found.next() {
                known.push(Known {
                    id: k as u32,
                    name: nearest.name,
                    sizes: nearest.sizes,
                    deviations: nearest.deviations,
                    others: found.count(),
                    taken: false,
                });
            }
        }
        Ok(known)
    }
}

/// Gives primitives the sizes that they are known by; where they are stays as measured.
pub fn take(known: &mut [Known], primitives: &mut [Primitive]) {
    for known in known {
        let Some(surface) = primitives[known.id as usize].surface.as_mut() else { continue };
        for (name, value) in &known.sizes {
            if let Some(size) = size_mut(surface, name) {
                *size = *value;
                known.taken = true;
            }
        }
    }
}

fn size(surface: &Surface, name: &str) -> Option<f64> {
    let mut surface = *surface;
    size_mut(&mut surface, name).copied()
}

fn size_mut<'a>(surface: &'a mut Surface, name: &str) -> Option<&'a mut f64> {
    match (surface, name) {
        (Surface::Cylinder(s), "radius") => Some(&mut s.radius),
        (Surface::Sphere(s), "radius") => Some(&mut s.radius),
        (Surface::Cone(s), "half_angle") => Some(&mut s.half_angle),
        (Surface::Torus(s), "major_radius") => Some(&mut s.major_radius),
        (Surface::Torus(s), "minor_radius") => Some(&mut s.minor_radius),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::samples::{Patch, sample};

    #[test]
    fn every_size_of_every_class_is_one_of_its_surface() {
        let axis = crate::math::Axis {
            origin: crate::math::Point3::origin(),
            direction: crate::math::Vec3::z_axis(),
        };
        let surfaces = [
            Surface::Cylinder(crate::surface::Cylinder { axis, radius: 3.0 }),
            Surface::Cone(crate::surface::Cone { axis, radius: 3.0, half_angle: 0.4 }),
            Surface::Sphere(crate::surface::Sphere { center: axis.origin, radius: 3.0 }),
            Surface::Torus(crate::surface::Torus { axis, major_radius: 9.0, minor_radius: 2.0 }),
        ];
        for surface in surfaces {
            let points = sample(&surface, Patch { u: (0.0, 6.0), v: (-1.0, 1.0) }, 500, 0.01, 1);
            let samples = crate::fit::Samples {
                points: points.iter().map(|p| p.0).collect(),
                normals: points.iter().map(|p| p.1.into_inner()).collect(),
            };
            let fit = crate::fit::Fit { surface, outward: true };
            let primitive = Primitive::with_evidence(fit, &samples, 500);
            let measured = Measured::of(&primitive).expect("it has sizes");
            assert_eq!(measured.sizes.len(), measured.class.sizes().len());
            assert!(measured.uncertainties.iter().all(|u| *u > 0.0 && *u < 0.1), "{measured:?}");
            let stored: Vec<(String, f64)> =
                measured.sizes.iter().map(|(n, s)| (n.clone(), s * 1.001)).collect();
            let mut known = [Known {
                id: 0,
                name: "it".into(),
                sizes: stored.clone(),
                deviations: 0.1,
                others: 0,
                taken: false,
            }];
            let mut primitives = [primitive];
            take(&mut known, &mut primitives);
            assert!(known[0].taken);
            assert_eq!(Measured::of(&primitives[0]).map(|m| m.sizes), Some(stored));
        }
        assert_eq!(Class::PRIMITIVES.len(), surfaces.len() + 1, "all but planes");
    }
}
