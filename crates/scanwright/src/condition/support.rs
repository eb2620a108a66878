//! The table under the part: found, told from the part's own planes, and cut off.
//!
//! A table is seen only around the part, so the scan ends on it: candidate planes grow from points of the open
//! boundary, each by repeated least squares over the vertices near it. A candidate is the table when, with its normal
//! as the triangles have it (out of the material), the rest of the scan stands *on* it; a face of the part has its
//! part *behind* it, which is what keeps a flat plate that is its own largest plane. It must also carry the
//! outermost boundary loop and a fair share of the area.
//! Removed are the triangles at the plane's height and, of the fillet-like skirt that fusion leaves between table and
//! part, what is nearer in height and tilt to the table than to a wall.
//! Outlines are the boundary loops that the cut leaves, projected to the plane.
//!
//! Cost: O(n) with a bounded number of candidates. It fails when the table is curved or seen in several planes, and
//! it takes a flange for a table when only its upper side was scanned, with all else on that side.

use crate::math::{Point3, UnitVec3, Vec3, centroid, principal_axes, stats};
use crate::mesh::{Adjacency, Mesh, VertId, boundary_loops, connected};
use crate::par;
use crate::surface::Plane;
use crate::tolerance::Tolerances;

use super::Support;
use super::patch::rings;

/// Boundary vertices that candidates grow from: the table's rim is most of the boundary, so most are on it.
const MAX_SEEDS: usize = 96;
/// Vertices that a candidate is judged by.
const MAX_JUDGES: usize = 20_000;
/// Rings around a seed that start a plane: about 150 vertices, whose plane is off by some spacings at the far end of
/// a table and no more.
const SEED_RINGS: usize = 7;
/// Distances, in spacings, within which vertices join the plane, one per refit.
const REFIT_REACH: [f64; 5] = [3.0, 2.0, 1.5, 1.0, 1.0];
/// Largest tilt of a vertex normal that joins a plane, as cosine: noisy normals of a plane stay within 37 degrees.
const NORMAL_COSINE: f64 = 0.8;
/// Largest angle between a candidate and the user's `up`: 30 degrees, a hint and not a measurement.
const UP_COSINE: f64 = 0.866;
/// Least share of the vertices on the table.
const MIN_TABLE_SHARE: f64 = 0.08;
/// Least share of the vertices well above it: without them there is no part.
const MIN_PART_SHARE: f64 = 0.01;
/// Largest share of the vertices below it.
const MAX_BELOW_SHARE: f64 = 0.01;
/// Least share of the outermost boundary loop that lies on the table: the rest is shadow of the part.
const MIN_RIM_SHARE: f64 = 0.5;
/// Standard deviations of the table's own scatter that are still its height.
const TABLE_SIGMAS: f64 = 3.0;
/// Distance, in spacings, that counts as clearly off the plane: beyond noise and skirt.
const CLEARANCE: f64 = 1.5;
/// Rings of the skirt around what is at the table's height.
const SKIRT_RINGS: usize = 3;
/// Largest mean height of a piece of table, as a share of the height that noise may reach: correlated noise moves
/// whole pieces by one deviation, a third of it.
const MAX_MEAN_SHARE: f64 = 0.5;
/// Height, in units of what noise may reach, that a piece of the part must exceed somewhere.
const ISLAND_NOISES: f64 = 2.0;
/// Cosine of the tilt up to which the skirt goes with the table: halfway to a vertical wall.
const SKIRT_COSINE: f64 = 0.707;
/// Height of the middle of the skirt in deviations of the spot: blur draws a square concave corner in by
/// `b / sqrt(pi)` on each side.
const SKIRT_SPOTS: f64 = 0.564;
/// Side, in spacings, of the square as large as a piece of table that its surroundings lift as a whole: they reach
/// over about three spacings from each side.
const NARROW: f64 = 7.0;
/// Mean lift of such a piece as a share of the lift at its border.
const MEAN_LIFT: f64 = 0.5;
/// Rounding of edges, in spacings, below which they say nothing about the skirt.
const SHARP_EDGE: f64 = 0.2;
/// Spot in spacings when no sharp edge showed it.
const UNKNOWN_SPOT: f64 = 1.0;
/// Rings over which normals are averaged before tilt is judged: noise of triangle normals reaches 0.3 radians.
const SMOOTHING_PASSES: usize = 3;
/// Least share of an outline's vertices that lie low: the rest is where the wall's foot was in shadow.
const MIN_LOW_SHARE: f64 = 0.5;
/// Height in spacings that is low for an outline.
const OUTLINE_REACH: f64 = 3.0;
/// Least area of an outline in squared spacings; less is a crumb.
const MIN_OUTLINE_AREA: f64 = 9.0;

/// The table that the part stands on, if there is one.
///
/// `up` restricts the search to tables that face that way (within 30 degrees).
pub fn find_support(
    mesh: &Mesh,
    adjacency: &Adjacency,
    tolerances: &Tolerances,
    up: Option<UnitVec3>,
) -> Option<Support> {
    let spacing = tolerances.spacing();
    let loops = boundary_loops(mesh, adjacency);
    let rim = loops.iter().max_by(|a, b| extent(mesh, a).total_cmp(&extent(mesh, b)))?;
    let normals = smooth_normals(mesh, adjacency);
    let plane = candidates(mesh, adjacency, &normals, rim, spacing, up)
        .into_iter()
        .filter(|plane| is_table(mesh, plane, rim, tolerances))
        .map(|plane| (n_near(mesh, &normals, &plane, spacing), plane))
        .max_by_key(|(n, _)| *n)?
        .1;
    let (plane, scatter) = refined(mesh, &normals, plane, spacing)?;
    let on_table = table_triangles(mesh, adjacency, &normals, &plane, scatter, tolerances);
    if on_table.iter().all(|t| *t) {
        return None;
    }
    let outlines = outlines(mesh, &plane, &on_table, spacing);
    Some(Support { plane, on_table, outlines })
}

/// Diagonal of the bounding box of a loop.
fn extent(mesh: &Mesh, vertices: &[VertId]) -> f64 {
    let points = vertices.iter().map(|&v| mesh.vertices[v as usize]);
    let bounds = points.fold(None, |bounds, p| match bounds {
        None => Some((p, p)),
        Some((lo, hi)) => Some((p.inf(&lo), p.sup(&hi))),
    });
    bounds.map_or(0.0, |(lo, hi): (Point3, Point3)| (hi - lo).norm())
}

/// Vertex normals averaged over a few rings.
fn smooth_normals(mesh: &Mesh, adjacency: &Adjacency) -> Vec<Vec3> {
    let mut normals = mesh.vertex_normals();
    for _ in 0..SMOOTHING_PASSES {
        normals = par::map_indices(normals.len(), |v| {
            let ring = adjacency.vertex_vertices.row(v);
            let sum = ring.iter().fold(normals[v], |sum, &w| sum + normals[w as usize]);
            sum.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
        });
    }
    normals
}

/// Every `n / limit`-th index below `n`.
fn spread(n: usize, limit: usize) -> impl Iterator<Item = usize> {
    let count = n.min(limit);
    (0..count).map(move |i| (i as u64 * n as u64 / count as u64) as usize)
}

/// Planes grown from the rim, normals out of the material.
fn candidates(
    mesh: &Mesh,
    adjacency: &Adjacency,
    normals: &[Vec3],
    rim: &[VertId],
    spacing: f64,
    up: Option<UnitVec3>,
) -> Vec<Plane> {
    let seeds: Vec<VertId> = spread(rim.len(), MAX_SEEDS).map(|i| rim[i]).collect();
    let judges: Vec<usize> = spread(mesh.vertices.len(), MAX_JUDGES).collect();
    let planes = par::map(&seeds, |&seed| {
        let start = rings(adjacency, seed, SEED_RINGS, |_| true);
        let mut plane = fit(mesh, normals, start.iter().map(|&v| v as usize))?;
        for reach in REFIT_REACH {
            let near = judges.iter().copied().filter(|&v| joins(mesh, normals, &plane, reach * spacing, v));
            plane = fit(mesh, normals, near)?;
        }
        Some(plane)
    });
    let faces_up = |plane: &Plane| up.is_none_or(|up| plane.normal.dot(&up) > UP_COSINE);
    planes.into_iter().flatten().filter(faces_up).collect()
}

fn joins(mesh: &Mesh, normals: &[Vec3], plane: &Plane, reach: f64, vertex: usize) -> bool {
    plane.signed_distance(&mesh.vertices[vertex]).abs() < reach
        && plane.normal.dot(&normals[vertex]) > NORMAL_COSINE
}

/// Least-squares plane through vertices, its normal as theirs.
fn fit(mesh: &Mesh, normals: &[Vec3], vertices: impl Iterator<Item = usize> + Clone) -> Option<Plane> {
    let points: Vec<Point3> = vertices.clone().map(|v| mesh.vertices[v]).collect();
    if points.len() < 3 {
        return None;
    }
    let center = centroid(&points);
    let [(_, normal), (width, _), _] = principal_axes(&points, center);
    let sum = vertices.fold(Vec3::zeros(), |sum, v| sum + normals[v]);
    let normal = if normal.dot(&sum) < 0.0 { -normal } else { normal };
    (width > 0.0).then_some(Plane { point: center, normal })
}

fn n_near(mesh: &Mesh, normals: &[Vec3], plane: &Plane, spacing: f64) -> usize {
    spread(mesh.vertices.len(), MAX_JUDGES).filter(|&v| joins(mesh, normals, plane, spacing, v)).count()
}

/// Whether the scan stands on the plane and ends on it.
fn is_table(mesh: &Mesh, plane: &Plane, rim: &[VertId], tolerances: &Tolerances) -> bool {
    let clear = CLEARANCE * tolerances.spacing() + TABLE_SIGMAS * tolerances.noise();
    let (mut n, mut on, mut above, mut below) = (0, 0, 0, 0);
    for v in spread(mesh.vertices.len(), MAX_JUDGES) {
        let height = plane.signed_distance(&mesh.vertices[v]);
        n += 1;
        if height > clear {
            above += 1;
        } else if height < -clear {
            below += 1;
        } else {
            on += 1;
        }
    }
    let at_least = |count: usize, share: f64| count as f64 >= share * f64::from(n);
    let on_rim = rim.iter().filter(|&&v| plane.signed_distance(&mesh.vertices[v as usize]).abs() < clear);
    at_least(on, MIN_TABLE_SHARE)
        && at_least(above, MIN_PART_SHARE)
        && !at_least(below, MAX_BELOW_SHARE)
        && on_rim.count() as f64 >= MIN_RIM_SHARE * rim.len() as f64
}

/// The plane refitted to all its vertices, and their scatter about it.
fn refined(mesh: &Mesh, normals: &[Vec3], plane: Plane, spacing: f64) -> Option<(Plane, f64)> {
    let (mut plane, mut reach, mut scatter) = (plane, spacing, 0.0);
    for _ in 0..3 {
        let near: Vec<usize> =
            (0..mesh.vertices.len()).filter(|&v| joins(mesh, normals, &plane, reach, v)).collect();
        plane = fit(mesh, normals, near.iter().copied())?;
        let heights: Vec<f64> = near.iter().map(|&v| plane.signed_distance(&mesh.vertices[v])).collect();
        scatter = stats::sigma_about_zero(&heights)?;
        reach = (TABLE_SIGMAS * scatter).min(spacing);
    }
    Some((plane, scatter))
}

/// Triangles of the table and of its share of the skirt.
fn table_triangles(
    mesh: &Mesh,
    adjacency: &Adjacency,
    normals: &[Vec3],
    plane: &Plane,
    scatter: f64,
    tolerances: &Tolerances,
) -> Vec<bool> {
    let heights: Vec<f64> = mesh.vertices.iter().map(|p| plane.signed_distance(p)).collect();
    let noise = TABLE_SIGMAS * scatter.max(tolerances.noise());
    // Fusion joins part and table by about a spacing even where it leaves edges sharp.
    let spot = if tolerances.edge_rounding() > SHARP_EDGE * tolerances.spacing() {
        tolerances.edge_rounding()
    } else {
        UNKNOWN_SPOT * tolerances.spacing()
    };
    let faces_up = |v: usize| plane.normal.dot(&normals[v]) > SKIRT_COSINE;
    // A step of the part just above the table has the skirt's height but not its tilt: the profile of a blurred
    // square corner rises nearly in proportion to the tangent of its tilt.
    let skirt_height = |v: usize| {
        let cosine = plane.normal.dot(&normals[v]).clamp(SKIRT_COSINE, 1.0);
        noise + SKIRT_SPOTS * spot * (1.0 - cosine * cosine).sqrt() / cosine
    };
    let mut low: Vec<bool> = heights.iter().enumerate().map(|(v, h)| *h < noise && faces_up(v)).collect();
    for _ in 0..SKIRT_RINGS {
        low = par::map_indices(low.len(), |v| {
            let touches = || adjacency.vertex_vertices.row(v).iter().any(|&w| low[w as usize]);
            low[v] || (heights[v] < skirt_height(v) && faces_up(v) && touches())
        });
    }
    let on_table: Vec<bool> = mesh.triangles.iter().map(|t| t.iter().all(|&v| low[v as usize])).collect();
    let lift = MEAN_LIFT * SKIRT_SPOTS * spot;
    let narrow = (NARROW * tolerances.spacing()).powi(2);
    without_islands(mesh, adjacency, &heights, noise, (narrow, lift), on_table)
}

/// Gives crumbs of noise back: pieces of table whose mean is off the table belong to a step of the part, and pieces
/// of part that rise nowhere above the noise are table. What the scan shows of the table through a narrow bore is fused
/// with the wall all round and lifted by it: pieces of an area below `narrow.0` may be higher by `narrow.1`.
fn without_islands(
    mesh: &Mesh,
    adjacency: &Adjacency,
    heights: &[f64],
    noise: f64,
    narrow: (f64, f64),
    mut on_table: Vec<bool>,
) -> Vec<bool> {
    let across = |t: u32| adjacency.across[t as usize].into_iter().flatten();
    for (kind, island) in connected(on_table.len(), |t| Some(on_table[t as usize]), across) {
        let (mut sum, mut highest) = (0.0, f64::MIN);
        for &t in &island {
            let corners = mesh.triangles[t as usize].map(|v| heights[v as usize]);
            sum += corners.iter().sum::<f64>() / 3.0;
            highest = corners.iter().fold(highest, |m, h| m.max(*h));
        }
        let wrong = if kind {
            let area: f64 = island.iter().map(|t| mesh.area(*t as usize)).sum();
            let lift = if area < narrow.0 { narrow.1 } else { 0.0 };
            sum / island.len() as f64 > MAX_MEAN_SHARE * noise + lift
        } else {
            highest < ISLAND_NOISES * noise
        };
        if wrong {
            for t in island {
                on_table[t as usize] = !kind;
            }
        }
    }
    on_table
}

/// Projected boundary loops that the cut leaves near the table.
fn outlines(mesh: &Mesh, plane: &Plane, on_table: &[bool], spacing: f64) -> Vec<Vec<Point3>> {
    let (part, ..) = mesh.submesh(|t| !on_table[t]);
    let reach = OUTLINE_REACH * spacing;
    let project = |&v: &VertId| {
        let p = part.vertices[v as usize];
        p - plane.normal.into_inner() * plane.signed_distance(&p)
    };
    boundary_loops(&part, &Adjacency::new(&part))
        .into_iter()
        .filter(|vertices| {
            let low = |v: &&VertId| plane.signed_distance(&part.vertices[**v as usize]) < reach;
            vertices.iter().filter(low).count() as f64 >= MIN_LOW_SHARE * vertices.len() as f64
        })
        .map(|vertices| vertices.iter().map(project).collect())
        .filter(|outline: &Vec<Point3>| area(outline) > MIN_OUTLINE_AREA * spacing * spacing)
        .collect()
}

/// Area of a flat closed polygon.
fn area(outline: &[Point3]) -> f64 {
    let Some(first) = outline.first() else { return 0.0 };
    let sum = outline.windows(2).fold(Vec3::zeros(), |sum, w| sum + (w[0] - first).cross(&(w[1] - first)));
    0.5 * sum.norm()
}
