//! Solids from labelled meshes whose right answer is known.

use scanwright::brep::{Built, LabelledMesh, build, check};
use scanwright::math::{Point3, UnitVec3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::recognize::{Primitive, Residual};
use scanwright::segment::RegionId;
use scanwright::surface::{Plane, Surface};
use scanwright::tolerance::{Measured, Tolerances};

/// Cells along each side of the box.
const CELLS: i32 = 12;

/// A cube of unit cells with its corner at `origin`, a label per side: x low, x high, y low and so on.
fn cube(origin: [i32; 3], cells: i32) -> (Vec<Point3>, Vec<[u32; 3]>, Vec<u32>) {
    let mut vertices: Vec<[i32; 3]> = Vec::new();
    let (mut triangles, mut labels) = (Vec::new(), Vec::new());
    let mut id = |p: [i32; 3]| {
        vertices.iter().position(|q| *q == p).unwrap_or_else(|| {
            vertices.push(p);
            vertices.len() - 1
        }) as u32
    };
    for side in 0..6 {
        let (axis, high) = (side / 2, side % 2 == 1);
        for i in 0..cells {
            for j in 0..cells {
                let mut corner = |di: i32, dj: i32| {
                    let mut p = origin;
                    p[axis] += if high { cells } else { 0 };
                    p[(axis + 1) % 3] += i + di;
                    p[(axis + 2) % 3] += j + dj;
                    id(p)
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                triangles.extend(if high { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
                labels.extend([side as u32; 2]);
            }
        }
    }
    let points = vertices.iter().map(|p| Point3::new(p[0].into(), p[1].into(), p[2].into())).collect();
    (points, triangles, labels)
}

fn plane(point: Point3, normal: Vec3) -> Primitive {
    Primitive {
        surface: Some(Surface::Plane(Plane { point, normal: UnitVec3::new_normalize(normal) })),
        outward: true,
        residual: Residual::default(),
        covariance: Vec::new(),
        ambiguous: None,
    }
}

fn planes_of_cube(size: f64) -> Vec<Primitive> {
    (0..6)
        .map(|side| {
            let (mut point, mut normal) = (Point3::origin(), Vec3::zeros());
            point[side / 2] = if side % 2 == 1 { size } else { 0.0 };
            normal[side / 2] = if side % 2 == 1 { 1.0 } else { -1.0 };
            plane(point, normal)
        })
        .collect()
}

fn built(
    vertices: Vec<Point3>,
    triangles: Vec<[u32; 3]>,
    labels: &[u32],
    primitives: Vec<Primitive>,
) -> (Built, f64) {
    let mesh = Mesh { vertices, triangles };
    let measured = Measured {
        largest_coordinate: mesh.largest_coordinate(),
        diagonal: mesh.diagonal(),
        spacing: 1.0,
        noise: 0.0,
        normal_noise: 0.0,
        edge_rounding: 0.0,
    };
    let tolerances = Tolerances::new(measured, None);
    let assumed = vec![false; labels.len()];
    let labels = labels.iter().map(|l| RegionId(*l)).collect();
    (build(&LabelledMesh { mesh, labels, primitives, assumed }, &tolerances), tolerances.gap())
}

/// Counts of the only solid, which has no problems.
fn counts(built: &Built, gap: f64) -> (usize, usize, usize) {
    assert_eq!(built.solids.len(), 1, "{:?}", built.issues);
    let solid = &built.solids[0];
    let problems = check(solid, gap);
    assert!(problems.is_empty(), "{problems:?}");
    (solid.faces.len(), solid.edges.len(), solid.vertices.len())
}

#[test]
fn a_cube_is_a_cube() {
    let (vertices, triangles, labels) = cube([0; 3], CELLS);
    let (built, gap) = built(vertices, triangles, &labels, planes_of_cube(CELLS.into()));
    assert_eq!(counts(&built, gap), (6, 12, 8));
    assert!(built.issues.is_empty(), "{:?}", built.issues);
}

#[test]
fn what_encloses_next_to_nothing_is_no_solid() {
    let (mut vertices, mut triangles, mut labels) = cube([0; 3], CELLS);
    let (more, crumbs, sides) = cube([30, 0, 0], 2);
    let shift = vertices.len() as u32;
    vertices.extend(more);
    triangles.extend(crumbs.iter().map(|t| t.map(|v| v + shift)));
    labels.extend(sides.iter().map(|s| s + 6));
    let mut primitives = planes_of_cube(CELLS.into());
    primitives.extend(planes_of_cube(2.0).into_iter().map(|mut p| {
        if let Some(Surface::Plane(plane)) = &mut p.surface {
            plane.point.x += 30.0;
        }
        p
    }));
    let (built, gap) = built(vertices, triangles, &labels, primitives);
    assert_eq!(counts(&built, gap), (6, 12, 8));
}

#[test]
fn a_face_without_the_right_surface_becomes_a_spline() {
    let (vertices, triangles, labels) = cube([0; 3], CELLS);
    let mut primitives = planes_of_cube(CELLS.into());
    // Parallel to the sides it should meet.
    primitives[5] = plane(Point3::new(6.0, 6.0, 12.0), Vec3::x());
    let (built, gap) = built(vertices, triangles, &labels, primitives);
    assert_eq!(built.solids.len(), 1);
    let solid = &built.solids[0];
    let problems = check(solid, solid.gap.max(gap));
    assert!(problems.is_empty(), "{problems:?}");
    let splines = solid.faces.iter().filter(|f| solid.geometry(f).kind().is_none());
    assert_eq!(splines.map(|f| f.region).collect::<Vec<_>>(), [RegionId(5)]);
}
