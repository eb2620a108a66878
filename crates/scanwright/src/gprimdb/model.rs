//! One model: its mesh, and the truth about it.

use nalgebra::{Quaternion, Rotation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

use super::manifest::Manifest;
use super::mesher::{self, Triangulation};
use super::noise::Noise;
use super::shape::{Class, Shape};
use crate::math::{Point3, Vec3};
use crate::mesh::Mesh;
use crate::random::Rng;
use crate::surface::Surface;

/// Which part of an experiment a model belongs to. All copies of a shape belong to the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Split {
    /// Seven tenths of the shapes.
    Train,
    /// A seventh or so, to choose parameters on.
    Validate,
    /// A seventh or so, for the figures that are reported.
    Test,
}

/// A generated mesh with its truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// What is known of it.
    pub truth: Truth,
    /// The mesh, with noise.
    pub mesh: Mesh,
    /// One per vertex: where it lies on the surface, without noise.
    pub clean: Vec<Point3>,
    /// One per vertex: unit normal there, out of the material.
    pub normals: Vec<Vec3>,
}

impl Truth {
    /// The parameter of a name.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }
}

impl Model {
    /// A number that changes with every bit of the mesh: FNV-1a, a word at a time.
    pub fn checksum(&self) -> u64 {
        let coordinates = self.mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_bits);
        let corners = self.mesh.triangles.iter().flatten().map(|v| u64::from(*v));
        coordinates
            .chain(corners)
            .fold(0xcbf2_9ce4_8422_2325, |h, word| (h ^ word).wrapping_mul(0x0100_0000_01b3))
    }
}

/// What is known of a model. Lengths in millimetres, angles in radians.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Unique in its database.
    pub name: String,
    /// What it is an example of.
    pub class: Class,
    /// The shape it is a copy of: unique in its database.
    pub group: u32,
    /// Which part of an experiment its shape belongs to.
    pub split: Split,
    /// Whether only a part of the surface is there.
    pub partial: bool,
    /// Parameters of the surface where the model lies, by name: `x, y, z` of a point of it or its centre,
    /// `axis_x, axis_y, axis_z`, then its radii and half-angle. Empty for none of the five types.
    pub parameters: Vec<(String, f64)>,
    /// Whether the surface's natural normal points out of the material.
    pub outward: bool,
    /// Share of the complete surface that is there, holes not counted.
    pub coverage: f64,
    /// Area of the surface that is there, holes not counted.
    pub area: f64,
    /// Edges along the square root of the area.
    pub resolution: u32,
    /// How it is triangulated.
    pub triangulation: Triangulation,
    /// Its noise.
    pub noise: Noise,
    /// Edge length, millimetres.
    pub edge: f64,
}

/// Where a model of a manifest comes from.
struct Source {
    class: Class,
    /// Number of the shape within its class, and in the database.
    shape: u32,
    group: u32,
    copy: u32,
}

impl Manifest {
    /// Model `index` of [`Manifest::n_models`]. Models do not depend on one another.
    ///
    /// # Panics
    /// When there are fewer models.
    pub fn model(&self, index: usize) -> Model {
        let source = self.source(index).expect("the manifest has that many models");
        let task = |what: &str, index: u64| Rng::for_task(self.seed, &format!("gprimdb {what}"), index);
        let mut of_shape = task(source.class.name(), u64::from(source.shape));
        let partial = source.class != Class::Plane && of_shape.uniform() < self.partial;
        let shape = Shape::draw(source.class, partial, &self.ranges, &mut of_shape);
        let mut rng = task("copy", index as u64);
        let resolution = self.resolutions[rng.below(self.resolutions.len())];
        let triangulation = self.triangulations[rng.below(self.triangulations.len())];
        let noise = self.noises[rng.below(self.noises.len())];
        let meshed = mesher::mesh(&shape, triangulation, resolution, &mut rng);
        let clean_normals: Vec<Vec3> = meshed.places.iter().map(|[u, v]| shape.normal(*u, *v)).collect();
        let moved = noise.moved(&meshed.mesh, &clean_normals, meshed.edge, &mut rng);
        let pose = if self.posed { Pose::draw(&mut rng) } else { Pose::none() };
        let surface = shape.surface().map(|s| s.transformed(&pose.rotation, 1.0, &pose.translation));
        let truth = Truth {
            name: format!("{}-{:04}-{:02}", source.class.name(), source.shape, source.copy),
            class: source.class,
            group: source.group,
            split: split(&mut task("split", u64::from(source.group))),
            partial,
            parameters: surface.as_ref().map_or_else(Vec::new, parameters),
            outward: pose.outward,
            coverage: shape.coverage,
            area: shape.area(),
            resolution,
            triangulation,
            noise,
            edge: meshed.edge,
        };
        pose.model(truth, meshed.mesh, &moved, &clean_normals)
    }

    fn source(&self, index: usize) -> Option<Source> {
        let copies = self.copies as usize;
        let mut group = index / copies;
        let mut before = 0;
        for count in &self.shapes {
            if group < count.count as usize {
                return Some(Source {
                    class: count.class,
                    shape: group as u32,
                    group: before + group as u32,
                    copy: (index % copies) as u32,
                });
            }
            group -= count.count as usize;
            before += count.count;
        }
        None
    }
}

fn split(rng: &mut Rng) -> Split {
    let at = rng.uniform();
    if at < 0.7 {
        Split::Train
    } else if at < 0.85 {
        Split::Validate
    } else {
        Split::Test
    }
}

/// Parameters by name.
fn parameters(surface: &Surface) -> Vec<(String, f64)> {
    let axis = |axis: &crate::math::Axis| {
        let (o, d) = (axis.origin, axis.direction);
        vec![("x", o.x), ("y", o.y), ("z", o.z), ("axis_x", d.x), ("axis_y", d.y), ("axis_z", d.z)]
    };
    let named: Vec<(&str, f64)> = match surface {
        Surface::Plane(s) => axis(&crate::math::Axis { origin: s.point, direction: s.normal }),
        Surface::Cylinder(s) => [axis(&s.axis), vec![("radius", s.radius)]].concat(),
        Surface::Cone(s) => {
            [axis(&s.axis), vec![("radius", s.radius), ("half_angle", s.half_angle)]].concat()
        }
        Surface::Sphere(s) => {
            vec![("x", s.center.x), ("y", s.center.y), ("z", s.center.z), ("radius", s.radius)]
        }
        Surface::Torus(s) => {
            let radii = vec![("major_radius", s.major_radius), ("minor_radius", s.minor_radius)];
            [axis(&s.axis), radii].concat()
        }
    };
    named.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// Where a model lies, and which side of it is material.
struct Pose {
    rotation: Rotation3<f64>,
    translation: Vec3,
    outward: bool,
}

impl Pose {
    fn none() -> Self {
        Self { rotation: Rotation3::identity(), translation: Vec3::zeros(), outward: true }
    }

    fn draw(rng: &mut Rng) -> Self {
        /// Millimetres from the origin, along each axis.
        const REACH: f64 = 200.0;
        // Four normals are a rotation drawn evenly.
        let quaternion = Quaternion::new(rng.normal(), rng.normal(), rng.normal(), rng.normal());
        let rotation = UnitQuaternion::new_normalize(quaternion).to_rotation_matrix();
        let mut offset = || REACH * (2.0 * rng.uniform() - 1.0);
        let translation = Vec3::new(offset(), offset(), offset());
        Self { rotation, translation, outward: rng.uniform() < 0.5 }
    }

    fn model(&self, truth: Truth, mesh: Mesh, moved: &[Point3], normals: &[Vec3]) -> Model {
        let place = |p: &Point3| self.rotation * p + self.translation;
        let side = if self.outward { 1.0 } else { -1.0 };
        let turned = |mut triangle: [u32; 3]| {
            if !self.outward {
                triangle.swap(1, 2);
            }
            triangle
        };
        Model {
            truth,
            clean: mesh.vertices.iter().map(place).collect(),
            normals: normals.iter().map(|n| self.rotation * n * side).collect(),
            mesh: Mesh {
                vertices: moved.iter().map(place).collect(),
                triangles: mesh.triangles.into_iter().map(turned).collect(),
            },
        }
    }
}
