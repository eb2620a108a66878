//! From chains, corners and curves to flat solids.

use super::chains::Topology;
use super::check::curve_on_surface;
use super::curve::Curve;
use super::domain::Domain;
use super::freeform::Fitted;
use super::geometry::{Corners, Course, edge_samples};
use super::meet::Field;
use super::solid::{
    Edge, EdgeId, EdgeUse, Face, FaceId, Geometry, Loop, Shell, Solid, SurfaceId, Vertex, VertexId,
};
use super::split::Patch;
use crate::math::{Frame, Point3, UnitVec3, Vec3, any_perpendicular, try_unit};
use crate::mesh::Mesh;
use crate::surface::{Plane, Surface};

/// The edge of one chain.
#[derive(Debug, Clone)]
pub(super) struct ChainEdge {
    pub curve: Curve,
    /// Samples it was recognised from.
    pub samples: Vec<Point3>,
    /// Largest distance from its surfaces and corners.
    pub gap: f64,
}

/// Makes the edge of every chain whose corners differ.
pub(super) fn chain_edges(
    topology: &Topology,
    courses: &[Course],
    corners: &Corners,
    spacing: f64,
    rounding: f64,
) -> Vec<Option<ChainEdge>> {
    crate::par::map_indices(topology.chains.len(), |i| {
        let chain = &topology.chains[i];
        let corner = |v: u32| corners.corner_of[v as usize].expect("chains end at junctions");
        let (a, b) = (corner(chain.start()), corner(chain.end()));
        if a == b {
            return None;
        }
        let (start, end) = (corners.corners[a as usize].point, corners.corners[b as usize].point);
        chain_edge(&courses[i], &start, &end, spacing, rounding)
    })
}

fn chain_edge(
    course: &Course,
    start: &Point3,
    end: &Point3,
    spacing: f64,
    rounding: f64,
) -> Option<ChainEdge> {
    /// In spacings: samples this close to a line or conic are one; half of the largest default gap.
    const RECOGNISE: f64 = 0.02;
    /// Fewest and most samples of an edge: a conic needs five; beyond eighty a spline only copies noise.
    const SAMPLES: (usize, usize) = (12, 80);
    /// Steps of a facet's edge that are held against the neighbour's surface.
    const STEPS_ON_FACET: usize = 4;
    if course.straight {
        let direction = try_unit(end - start)?;
        let (curve, samples) = (Curve::Line { origin: *start, direction }, vec![*start, *end]);
        let gap = curve_gap(&curve, course, start, end, STEPS_ON_FACET);
        return Some(ChainEdge { curve, samples, gap });
    }
    let length: f64 = course.points.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    let n = ((length / spacing) as usize).clamp(SAMPLES.0, SAMPLES.1);
    let samples = edge_samples(course, start, end, n, spacing);
    let tolerance = (RECOGNISE * spacing).max(rounding);
    let mut best: Option<ChainEdge> = None;
    // A tight look first: exact surfaces give exact conics, and a loose one would take a flat arc for a line.
    for tolerance in [rounding, tolerance] {
        let curve = Curve::recognize(&samples, tolerance)?;
        let gap = curve_gap(&curve, course, start, end, samples.len());
        let simple = !matches!(curve, Curve::Spline(_));
        best = Some(ChainEdge { curve, samples: samples.clone(), gap });
        if simple {
            break;
        }
    }
    best
}

/// Largest distance of a curve from the real surfaces it belongs to and from its corners.
fn curve_gap(curve: &Curve, course: &Course, start: &Point3, end: &Point3, n: usize) -> f64 {
    let surfaces =
        course.fields.iter().filter_map(|f| if let Field::Surface(s) = f { Some(s) } else { None });
    let points = curve.sample(start, end, 2 * n);
    let off = surfaces.flat_map(|s| points.iter().map(|p| s.signed_distance(p).abs())).fold(0.0, f64::max);
    let ends = curve.distance_to_end(start).max(curve.distance_to_end(end));
    off.max(ends)
}

/// Everything that the faces are made from.
pub(super) struct Parts<'a> {
    pub mesh: &'a Mesh,
    pub patches: &'a [Patch],
    pub topology: &'a Topology,
    pub corners: &'a Corners,
    pub edges: &'a [Option<ChainEdge>],
    /// Per patch: a spline for those without an analytic surface.
    pub splines: &'a [Option<Fitted>],
    /// Per triangle.
    pub assumed: &'a [bool],
    /// Component of the mesh that each triangle belongs to, and their number.
    pub components: (&'a [u32], usize),
}

/// A solid and the patch that each of its faces was made from.
#[derive(Debug, Clone)]
pub(super) struct Made {
    pub solid: Solid,
    pub patches: Vec<usize>,
}

/// One solid per connected component of the mesh that has a face.
pub(super) fn solids(parts: &Parts) -> Vec<Made> {
    let (component, n) = parts.components;
    let mut patches: Vec<Vec<usize>> = vec![Vec::new(); n];
    for (p, patch) in parts.patches.iter().enumerate() {
        patches[component[patch.triangles[0] as usize] as usize].push(p);
    }
    patches.iter().filter_map(|patches| solid(parts, patches)).collect()
}

fn solid(parts: &Parts, patches: &[usize]) -> Option<Made> {
    let mut solid = Solid::default();
    let mut made_from = Vec::new();
    let mut vertex_of = vec![None; parts.corners.corners.len()];
    let mut edge_of = vec![None; parts.topology.chains.len()];
    let mut surface_of: Vec<(u32, usize, SurfaceId)> = Vec::new();
    let mut loops_of: Vec<Vec<&super::chains::ChainLoop>> = vec![Vec::new(); parts.patches.len()];
    for run in &parts.topology.loops {
        loops_of[run.patch as usize].push(run);
    }
    for &p in patches {
        let patch = &parts.patches[p];
        let mut loops = Vec::new();
        for run in &loops_of[p] {
            let mut uses = Vec::new();
            for &(chain, forward) in &run.uses {
                if parts.edges[chain].is_none() {
                    continue;
                }
                let edge =
                    *edge_of[chain].get_or_insert_with(|| add_edge(&mut solid, &mut vertex_of, parts, chain));
                uses.push(EdgeUse { edge, forward });
            }
            if !uses.is_empty() {
                loops.push(Loop { uses });
            }
        }
        // Only a sphere or torus encloses anything without a border.
        let whole =
            loops_of[p].is_empty() && matches!(patch.surface, Some(Surface::Sphere(_) | Surface::Torus(_)));
        if loops.is_empty() && !whole {
            continue;
        }
        let facet = if patch.facet { facet(&solid, &loops) } else { None };
        let Some(geometry) = patch
            .surface
            .or(facet.map(Surface::Plane))
            .map(Geometry::Analytic)
            .or_else(|| parts.splines[p].as_ref().map(|s| Geometry::Spline(s.surface.clone())))
        else {
            continue;
        };
        let key = if patch.surface.is_some() { (patch.region, 0) } else { (patch.region, p) };
        let known = surface_of.iter().find(|s| (s.0, s.1) == key).map(|s| s.2);
        let surface = known.unwrap_or_else(|| {
            let id = SurfaceId(solid.surfaces.len() as u32);
            let geometry = if patch.facet { geometry } else { outward_plane(geometry, parts.mesh, patch) };
            solid.surfaces.push(geometry);
            surface_of.push((key.0, key.1, id));
            id
        });
        let geometry = &solid.surfaces[surface.0 as usize];
        let face = Face {
            surface,
            frame: placement(geometry, parts.mesh, patch),
            same_sense: patch.facet
                || parts.splines[p]
                    .as_ref()
                    .map_or_else(|| same_sense(geometry, parts.mesh, patch), |s| s.outward),
            loops,
            region: patch.origin,
            assumed: 2 * patch.triangles.iter().filter(|t| parts.assumed[**t as usize]).count()
                > patch.triangles.len(),
        };
        solid.faces.push(face);
        made_from.push(p);
    }
    if solid.faces.is_empty() {
        return None;
    }
    let open = solid_has_free_edges(&solid);
    let faces = (0..solid.faces.len() as u32).map(FaceId).collect();
    solid.shells.push(Shell { faces, closed: !open });
    order_loops(&mut solid);
    solid.gap = solid.gap.max(spline_gap(&solid));
    Some(Made { solid, patches: made_from })
}

/// The plane through the corners of a facet, its normal on the side from which they run counter-clockwise.
fn facet(solid: &Solid, loops: &[Loop]) -> Option<Plane> {
    let corners: Vec<Point3> =
        loops.iter().flat_map(|l| &l.uses).map(|u| solid.point(solid.ends(*u).0)).collect();
    let [a, b, c] = corners[..] else { return None };
    Some(Plane { point: a, normal: try_unit((b - a).cross(&(c - a)))? })
}

/// Largest distance of the edges of spline faces from these; those of analytic ones are known.
fn spline_gap(solid: &Solid) -> f64 {
    let gaps = crate::par::map(&solid.faces, |face| {
        if solid.geometry(face).kind().is_some() {
            return 0.0;
        }
        let domain = Domain::new(solid, face);
        let uses = face.loops.iter().flat_map(|l| &l.uses);
        uses.map(|u| curve_on_surface::distance(solid, &domain, *u)).fold(0.0, f64::max)
    });
    gaps.into_iter().fold(0.0, f64::max)
}

fn add_edge(solid: &mut Solid, vertex_of: &mut [Option<VertexId>], parts: &Parts, chain: usize) -> EdgeId {
    let ends = [parts.topology.chains[chain].start(), parts.topology.chains[chain].end()].map(|v| {
        let corner = parts.corners.corner_of[v as usize].expect("chains end at junctions") as usize;
        *vertex_of[corner].get_or_insert_with(|| {
            solid.vertices.push(Vertex { point: parts.corners.corners[corner].point });
            VertexId(solid.vertices.len() as u32 - 1)
        })
    });
    let made = parts.edges[chain].as_ref().expect("only chains with an edge are added");
    solid.gap = solid.gap.max(made.gap);
    solid.edges.push(Edge { curve: made.curve.clone(), start: ends[0], end: ends[1] });
    EdgeId(solid.edges.len() as u32 - 1)
}

/// Whether some edge is not used once in each sense.
pub(super) fn solid_has_free_edges(solid: &Solid) -> bool {
    let mut uses = vec![(0, 0); solid.edges.len()];
    for edge_use in solid.faces.iter().flat_map(|f| &f.loops).flat_map(|l| &l.uses) {
        let count = &mut uses[edge_use.edge.0 as usize];
        if edge_use.forward { count.0 += 1 } else { count.1 += 1 }
    }
    uses.iter().any(|u| *u != (1, 1))
}

/// A plane is stored with its normal out of the material.
fn outward_plane(geometry: Geometry, mesh: &Mesh, patch: &Patch) -> Geometry {
    match geometry {
        Geometry::Analytic(Surface::Plane(plane)) if !same_sense(&geometry, mesh, patch) => {
            Geometry::Analytic(Surface::Plane(Plane { point: plane.point, normal: -plane.normal }))
        }
        other => other,
    }
}

/// Whether the natural normal points along the mesh's normals.
pub(super) fn same_sense(geometry: &Geometry, mesh: &Mesh, patch: &Patch) -> bool {
    match geometry {
        Geometry::Analytic(surface) => {
            let sum: f64 = patch
                .triangles
                .iter()
                .map(|t| mesh.cross(*t as usize).dot(&surface.normal(&mesh.triangle_center(*t as usize))))
                .sum();
            sum > 0.0
        }
        // Splines know.
        Geometry::Spline(_) => true,
    }
}

/// A frame whose seams and poles stay clear of the patch.
pub(super) fn placement(geometry: &Geometry, mesh: &Mesh, patch: &Patch) -> Frame {
    let area_sum = patch.triangles.iter().fold((Vec3::zeros(), 0.0), |(s, a), t| {
        let area = mesh.area(*t as usize);
        (s + mesh.triangle_center(*t as usize).coords * area, a + area)
    });
    let center = Point3::from(area_sum.0 / area_sum.1.max(f64::MIN_POSITIVE));
    let Geometry::Analytic(surface) = geometry else {
        return Frame::from_z(center, Vec3::z_axis());
    };
    match surface {
        Surface::Plane(plane) => {
            Frame::from_z(center - plane.normal.into_inner() * plane.signed_distance(&center), plane.normal)
        }
        Surface::Sphere(sphere) => sphere_placement(&sphere.center, mesh, patch),
        Surface::Cylinder(_) | Surface::Cone(_) | Surface::Torus(_) => {
            let axis = surface.axis().expect("it is a surface of revolution");
            let mean = patch.triangles.iter().fold(Vec3::zeros(), |s, t| {
                let radial = axis.radial(&mesh.triangle_center(*t as usize));
                s + try_unit(radial).map_or_else(Vec3::zeros, UnitVec3::into_inner) * mesh.area(*t as usize)
            });
            let origin = if matches!(surface, Surface::Torus(_)) { axis.origin } else { axis.foot(&center) };
            frame_with_x(origin, axis.direction, &-mean)
        }
    }
}

fn frame_with_x(origin: Point3, z: UnitVec3, towards: &Vec3) -> Frame {
    let x = try_unit(towards - z.into_inner() * z.dot(towards)).unwrap_or_else(|| any_perpendicular(&z));
    Frame { origin, x, y: UnitVec3::new_normalize(z.cross(&x)), z }
}

/// The axis of many tried that stays farthest from the patch, and the seam opposite the patch.
fn sphere_placement(center: &Point3, mesh: &Mesh, patch: &Patch) -> Frame {
    /// Directions tried, on a spiral over the half sphere.
    const N_DIRECTIONS: usize = 200;
    let units: Vec<Vec3> = patch
        .triangles
        .iter()
        .flat_map(|t| mesh.triangles[*t as usize])
        .map(|v| mesh.vertices[v as usize] - center)
        .filter_map(|d| try_unit(d).map(UnitVec3::into_inner))
        .collect();
    let mean = units.iter().fold(Vec3::zeros(), |s, u| s + u);
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let spiral = (0..N_DIRECTIONS).map(|i| {
        let z = (i as f64 + 0.5) / N_DIRECTIONS as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * cos, r * sin, z)
    });
    let nearest = |axis: &Vec3| units.iter().map(|u| u.dot(axis).abs()).fold(0.0, f64::max);
    let best = spiral.min_by(|a, b| nearest(a).total_cmp(&nearest(b))).expect("some direction is tried");
    frame_with_x(*center, UnitVec3::new_normalize(best), &-mean)
}

/// Puts the longest loop of each face first.
fn order_loops(solid: &mut Solid) {
    let extent: Vec<Vec<f64>> =
        solid.faces.iter().map(|face| face.loops.iter().map(|l| loop_extent(solid, l)).collect()).collect();
    for (face, extent) in solid.faces.iter_mut().zip(extent) {
        let longest = (0..extent.len()).max_by(|a, b| extent[*a].total_cmp(&extent[*b]).then(b.cmp(a)));
        if let Some(i) = longest {
            face.loops.swap(0, i);
        }
    }
}

/// Diagonal of the box round a loop: the outer loop's box holds those of the holes.
fn loop_extent(solid: &Solid, run: &Loop) -> f64 {
    let points: Vec<Point3> = run.uses.iter().flat_map(|u| use_points(solid, *u, 8)).collect();
    let first = points[0];
    let (low, high) = points.iter().fold((first, first), |(l, h), p| (l.inf(p), h.sup(p)));
    (high - low).norm()
}

/// `n + 1` points along a use, in its direction.
pub(super) fn use_points(solid: &Solid, edge_use: EdgeUse, n: usize) -> Vec<Point3> {
    let edge = solid.edge(edge_use.edge);
    let mut points = edge.curve.sample(&solid.point(edge.start), &solid.point(edge.end), n);
    if !edge_use.forward {
        points.reverse();
    }
    points
}
