//! Builds a solid from a raw dump of mesh, labels and surfaces; made by `tests/oracle/dump.py`.
//!
//! `cargo run --example oracle -- CASE.raw OUT.step`

use std::io::Write as _;

use scanwright::brep::{LabelledMesh, build, check, tessellate};
use scanwright::math::{Axis, Point3, UnitVec3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::recognize::{Primitive, Residual};
use scanwright::segment::RegionId;
use scanwright::step::{StepOptions, write};
use scanwright::surface::{Cone, Cylinder, Plane, Sphere, Surface, Torus};
use scanwright::tolerance::{Measured, Tolerances};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let bytes = std::fs::read(&arguments[1]).expect("the dump can be read");
    let mut reader = Reader { bytes: &bytes, at: 0 };
    let (closed, spacing) = reader.labelled_mesh();
    let tolerances = Tolerances::new(
        Measured {
            largest_coordinate: closed.mesh.largest_coordinate(),
            diagonal: closed.mesh.diagonal(),
            spacing,
            noise: 0.0,
            normal_noise: 0.0,
            edge_rounding: 0.0,
        },
        None,
    );
    let start = std::time::Instant::now();
    let built = build(&closed, &tolerances);
    let mut out = std::io::stderr();
    writeln!(out, "{} triangles in {:?}", closed.mesh.triangles.len(), start.elapsed()).expect("stderr");
    for issue in &built.issues {
        writeln!(out, "{} {:?}: {}", issue.code.name(), issue.region, issue.message).expect("stderr");
    }
    for solid in &built.solids {
        writeln!(
            out,
            "{} faces, {} edges, gap {:.2e} = {:.4} spacings, closed {}",
            solid.faces.len(),
            solid.edges.len(),
            solid.gap,
            solid.gap / spacing,
            solid.is_closed()
        )
        .expect("stderr");
        let start = std::time::Instant::now();
        for problem in check(solid, (2.0 * solid.gap).max(tolerances.gap())) {
            writeln!(out, "CHECK {problem}").expect("stderr");
        }
        let mesh = tessellate(solid).mesh;
        writeln!(
            out,
            "volume {:.6} of {:.6}, checked in {:?}",
            mesh.signed_volume(),
            closed.mesh.signed_volume(),
            start.elapsed()
        )
        .expect("stderr");
    }
    std::fs::write(&arguments[2], write(&built.solids, &StepOptions::default()))
        .expect("the output can be written");
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let slice = self.bytes[self.at..self.at + N].try_into().expect("length");
        self.at += N;
        slice
    }

    fn real(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }

    fn int(&mut self) -> i32 {
        i32::from_le_bytes(self.take())
    }

    fn point(&mut self) -> Point3 {
        Point3::new(self.real(), self.real(), self.real())
    }

    fn axis(&mut self) -> Axis {
        Axis { origin: self.point(), direction: UnitVec3::new_normalize(self.point().coords as Vec3) }
    }

    fn surface(&mut self) -> Option<Surface> {
        match self.int() {
            0 => {
                let axis = self.axis();
                Some(Surface::Plane(Plane { point: axis.origin, normal: axis.direction }))
            }
            1 => Some(Surface::Cylinder(Cylinder { axis: self.axis(), radius: self.real() })),
            2 => {
                Some(Surface::Cone(Cone { axis: self.axis(), radius: self.real(), half_angle: self.real() }))
            }
            3 => Some(Surface::Sphere(Sphere { center: self.point(), radius: self.real() })),
            4 => Some(Surface::Torus(Torus {
                axis: self.axis(),
                major_radius: self.real(),
                minor_radius: self.real(),
            })),
            _ => None,
        }
    }

    fn labelled_mesh(&mut self) -> (LabelledMesh, f64) {
        let spacing = self.real();
        let (n_vertices, n_triangles, n_surfaces) = (self.int(), self.int(), self.int());
        let vertices = (0..n_vertices).map(|_| self.point()).collect();
        let triangles: Vec<[u32; 3]> =
            (0..n_triangles).map(|_| [self.int() as u32, self.int() as u32, self.int() as u32]).collect();
        let labels = (0..n_triangles).map(|_| RegionId(self.int() as u32)).collect();
        let primitives = (0..n_surfaces)
            .map(|_| Primitive {
                surface: self.surface(),
                outward: true,
                residual: Residual::default(),
                covariance: Vec::new(),
                ambiguous: None,
            })
            .collect();
        let assumed = vec![false; triangles.len()];
        (LabelledMesh { mesh: Mesh { vertices, triangles }, labels, primitives, assumed }, spacing)
    }
}
