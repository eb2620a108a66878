//! From chains to points: which fields each chain lies on, where the corners are, which corners are one.

use super::chains::{Chain, Topology};
use super::meet::{Field, PARALLEL, contact_field, meet};
use super::split::Patch;
use crate::math::{Point3, Vec3, angle_between};
use crate::mesh::{Mesh, VertId};
use crate::surface::Surface;

/// Angle, radians, between the surfaces at a chain below which they may be tangent.
const MAYBE_TANGENT: f64 = 30.0 * std::f64::consts::PI / 180.0;
/// Angle, radians, that may be left at the contact for the pair to count as tangent.
pub(super) const TANGENT: f64 = 6.0 * std::f64::consts::PI / 180.0;
/// Residual, in spacings, that the contact of a tangent pair may have.
pub(super) const TANGENT_RESIDUAL: f64 = 0.4;
/// Move, in spacings, from the mesh chain to the contact.
const TANGENT_MOVE: f64 = 2.5;
/// Farthest, in spacings, that a corner may move from the mesh.
pub(super) const CORNER_REACH: f64 = 6.0;
/// Longest chain, in mesh edges, whose ends may be one corner.
const MERGE_EDGES: usize = 6;
/// Samples of a chain that decide whether it is tangent.
const N_PROBES: usize = 7;

/// What a chain lies on, and its course on the mesh.
#[derive(Debug, Clone)]
pub(super) struct Course {
    /// The real surfaces: at most two.
    pub fields: Vec<Field>,
    /// The mesh chain, ends included; smoothed unless it is a cut.
    pub points: Vec<Point3>,
    /// Whether it is where a plane cuts one surface.
    pub cut: bool,
    /// Whether its edge is the straight one of a facet.
    pub straight: bool,
}

impl Course {
    /// How far off its surfaces the middle of the course stays when it is moved onto them.
    pub(super) fn apart(&self, spacing: f64) -> f64 {
        meet(&self.points[self.points.len() / 2], &self.fields, CORNER_REACH * spacing, PARALLEL).residual
    }
}

/// A corner of the solid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub point: Point3,
    pub residual: f64,
    pub moved: f64,
}

/// Course of every chain.
pub(super) fn courses(mesh: &Mesh, topology: &Topology, patches: &[Patch], spacing: f64) -> Vec<Course> {
    crate::par::map(&topology.chains, |chain| {
        let mut points: Vec<Point3> = chain.vertices.iter().map(|v| mesh.vertices[*v as usize]).collect();
        // A cut wanders beside its plane and not off its surface, where a chain across a narrow groove is as round as
        // a zig-zag: smoothed, it would lie nearer to the other side of the tube.
        let cut = is_cut(chain, patches);
        if !cut {
            smooth(&mut points);
        }
        let fields = chain_fields(chain, patches, &points, spacing);
        let sides = [Some(chain.left), chain.right];
        let straight = sides.into_iter().flatten().any(|p| patches[p as usize].facet);
        Course { fields, points, cut, straight }
    })
}

/// Whether the chain is where a plane cuts the surface of one region.
fn is_cut(chain: &Chain, patches: &[Patch]) -> bool {
    let left = &patches[chain.left as usize];
    let right = chain.right.map(|r| &patches[r as usize]);
    left.surface.is_some() && right.is_some_and(|right| left.region == right.region)
}

/// Fairs a chain of mesh vertices between its ends.
fn smooth(points: &mut [Point3]) {
    /// Passes of the 1-2-1 mean: reaches about three edges, the length of a zig-zag of noisy labels.
    const PASSES: usize = 8;
    for _ in 0..PASSES {
        let before = points.to_vec();
        for i in 1..points.len().saturating_sub(1) {
            points[i] =
                Point3::from((before[i - 1].coords + before[i].coords * 2.0 + before[i + 1].coords) * 0.25);
        }
    }
}

fn chain_fields(chain: &Chain, patches: &[Patch], points: &[Point3], spacing: f64) -> Vec<Field> {
    let left = &patches[chain.left as usize];
    let Some(right) = chain.right.map(|r| &patches[r as usize]) else {
        return left.surface.map(Field::Surface).into_iter().collect();
    };
    if left.region == right.region {
        let mut fields: Vec<Field> = left.surface.map(Field::Surface).into_iter().collect();
        fields.extend(separating_plane(left, right, points));
        return fields;
    }
    match (left.surface, right.surface) {
        (Some(a), Some(b)) => {
            let mut fields = vec![Field::Surface(a), Field::Surface(b)];
            fields.extend(tangent_field(&a, &b, points, spacing));
            fields
        }
        (Some(s), None) | (None, Some(s)) => vec![Field::Surface(s)],
        (None, None) => Vec::new(),
    }
}

/// The cut between two patches of one region that the chain lies nearest to.
fn separating_plane(left: &Patch, right: &Patch, points: &[Point3]) -> Option<Field> {
    let differing =
        left.cuts.iter().zip(&right.cuts).filter(|(a, b)| a.above != b.above).map(|(a, _)| a.plane);
    let off =
        |plane: &crate::surface::Plane| points.iter().map(|p| plane.signed_distance(p).abs()).sum::<f64>();
    differing.min_by(|a, b| off(a).total_cmp(&off(b))).map(Field::Plane)
}

/// The contact equation, when the two surfaces touch along the chain.
fn tangent_field(a: &Surface, b: &Surface, points: &[Point3], spacing: f64) -> Option<Field> {
    let n = points.len();
    let probes: Vec<Point3> = (0..N_PROBES).map(|i| points[(n - 1) * (i + 1) / (N_PROBES + 1)]).collect();
    let angle = |p: &Point3| {
        let angle = angle_between(&a.normal(p), &b.normal(p));
        angle.min(std::f64::consts::PI - angle)
    };
    let mean = |f: &dyn Fn(&Point3) -> f64, at: &[Point3]| at.iter().map(f).sum::<f64>() / at.len() as f64;
    if mean(&angle, &probes) > MAYBE_TANGENT {
        return None;
    }
    let middle = points[n / 2];
    let along =
        if n > 2 { points[(n / 2 + 1).min(n - 1)] - points[n / 2 - 1] } else { points[1] - points[0] };
    let extra = contact_field(a, b, &middle, &along)?;
    let fields = [Field::Surface(*a), Field::Surface(*b), extra];
    let met: Vec<_> = probes.iter().map(|p| meet(p, &fields, CORNER_REACH * spacing, PARALLEL)).collect();
    let at: Vec<Point3> = met.iter().map(|m| m.point).collect();
    let residual = met.iter().map(|m| m.residual).sum::<f64>() / N_PROBES as f64;
    let moved = met.iter().map(|m| m.moved).sum::<f64>() / N_PROBES as f64;
    let tangent = mean(&angle, &at) < TANGENT
        && residual < TANGENT_RESIDUAL * spacing
        && moved < TANGENT_MOVE * spacing;
    tangent.then_some(extra)
}

/// One group of junctions per corner: the group of every mesh vertex that is a junction, and its corner.
#[derive(Debug, Clone)]
pub(super) struct Corners {
    /// Per mesh vertex: its corner, if it is a junction.
    pub corner_of: Vec<Option<u32>>,
    /// The corners.
    pub corners: Vec<Corner>,
}

impl Corners {
    /// Whether a chain is so short that its ends may be one corner, and all surfaces there pass through one point between
    /// them.
    pub(super) fn may_be_one(
        &self,
        chain: &Chain,
        topology: &Topology,
        courses: &[Course],
        spacing: f64,
        reach: f64,
    ) -> bool {
        /// In spacings: largest distance of the point from a surface.
        const RESIDUAL: f64 = 0.1;
        if chain.vertices.len() > MERGE_EDGES + 1 {
            return false;
        }
        let ends = [chain.start(), chain.end()].map(|v| self.corner_of[v as usize]);
        if ends[0] == ends[1] {
            return false;
        }
        let [Some(a), Some(b)] = ends.map(|c| c.map(|c| self.corners[c as usize].point)) else {
            return false;
        };
        if (b - a).norm() > reach {
            return false;
        }
        let beside = |chain: &Chain| {
            [chain.start(), chain.end()].iter().any(|v| ends.contains(&self.corner_of[*v as usize]))
        };
        let chains: Vec<usize> =
            (0..topology.chains.len()).filter(|i| beside(&topology.chains[*i])).collect();
        let fields = distinct_fields(&chains, courses);
        let met = meet(&nalgebra::center(&a, &b), &fields, CORNER_REACH * spacing, PARALLEL);
        met.residual < RESIDUAL * spacing && met.moved < (b - a).norm()
    }
}

/// Solves the corners, joining those that come out too close or in reversed order. `fixed`: where some vertices go;
/// `shared`: junctions that are one corner.
pub(super) fn corners(
    mesh: &Mesh,
    topology: &Topology,
    courses: &[Course],
    fixed: &[(VertId, Point3)],
    shared: &[[VertId; 2]],
    spacing: f64,
) -> Corners {
    /// In spacings: corners closer than this are one.
    const MERGE_DISTANCE: f64 = 0.4;
    /// In spacings: corners in reversed order are one up to this distance.
    const REVERSED_DISTANCE: f64 = 4.0;
    /// Joining can bring new neighbours together; it ends after a few rounds.
    const MAX_ROUNDS: usize = 4;
    let mut group: Vec<VertId> = (0..mesh.vertices.len() as u32).collect();
    let mut on_facet = vec![false; mesh.vertices.len()];
    for (chain, _) in topology.chains.iter().zip(courses).filter(|(_, course)| course.straight) {
        chain.vertices.iter().for_each(|v| on_facet[*v as usize] = true);
    }
    for [a, b] in shared {
        let (a, b) = (root(&mut group, *a), root(&mut group, *b));
        group[a.max(b) as usize] = a.min(b);
    }
    let mut solved = solve(mesh, topology, courses, &mut group, fixed, spacing);
    for _ in 0..MAX_ROUNDS {
        let mut merged = false;
        for (chain, course) in topology.chains.iter().zip(courses) {
            let (a, b) = (root(&mut group, chain.start()), root(&mut group, chain.end()));
            // Facets would collapse with their corners.
            let kept_apart = on_facet[chain.start() as usize] && on_facet[chain.end() as usize];
            if a == b || kept_apart || chain.vertices.len() > MERGE_EDGES + 1 {
                continue;
            }
            let corner = |v: VertId| solved.corner_of[v as usize].map(|c| solved.corners[c as usize].point);
            let (Some(p), Some(q)) = (corner(chain.start()), corner(chain.end())) else { continue };
            let course_direction: Vec3 = course.points[course.points.len() - 1] - course.points[0];
            let reversed =
                (q - p).dot(&course_direction) <= 0.0 && (q - p).norm() < REVERSED_DISTANCE * spacing;
            if (q - p).norm() < MERGE_DISTANCE * spacing || reversed {
                group[a.max(b) as usize] = a.min(b);
                merged = true;
            }
        }
        if !merged {
            break;
        }
        solved = solve(mesh, topology, courses, &mut group, fixed, spacing);
    }
    solved
}

fn root(group: &mut [VertId], v: VertId) -> VertId {
    let mut v = v;
    while group[v as usize] != v {
        group[v as usize] = group[group[v as usize] as usize];
        v = group[v as usize];
    }
    v
}

fn solve(
    mesh: &Mesh,
    topology: &Topology,
    courses: &[Course],
    group: &mut [VertId],
    fixed: &[(VertId, Point3)],
    spacing: f64,
) -> Corners {
    let mut corner_of = vec![None; mesh.vertices.len()];
    let mut members: Vec<Vec<VertId>> = Vec::new();
    let mut incident: Vec<Vec<usize>> = Vec::new();
    for (i, chain) in topology.chains.iter().enumerate() {
        for v in [chain.start(), chain.end()] {
            let r = root(group, v) as usize;
            let id = *corner_of[r].get_or_insert_with(|| {
                members.push(Vec::new());
                incident.push(Vec::new());
                members.len() as u32 - 1
            });
            corner_of[v as usize] = Some(id);
            if !members[id as usize].contains(&v) {
                members[id as usize].push(v);
            }
            incident[id as usize].push(i);
        }
    }
    let mut corners = crate::par::map_indices(members.len(), |c| {
        let sum = members[c].iter().fold(Vec3::zeros(), |s, v| s + mesh.vertices[*v as usize].coords);
        let start = Point3::from(sum / members[c].len() as f64);
        let fields = distinct_fields(&incident[c], courses);
        let met = meet(&start, &fields, CORNER_REACH * spacing, PARALLEL);
        Corner { point: met.point, residual: met.residual, moved: met.moved }
    });
    for (v, point) in fixed {
        if let Some(c) = corner_of[*v as usize] {
            let moved = (point - mesh.vertices[*v as usize]).norm();
            corners[c as usize] = Corner { point: *point, residual: 0.0, moved };
        }
    }
    Corners { corner_of, corners }
}

/// The fields of several chains, each surface once.
fn distinct_fields(chains: &[usize], courses: &[Course]) -> Vec<Field> {
    let mut fields: Vec<Field> = Vec::new();
    for field in chains.iter().flat_map(|c| &courses[*c].fields) {
        let known = fields.iter().any(|f| match (f, field) {
            (Field::Surface(a), Field::Surface(b)) => a == b,
            (Field::Plane(a), Field::Plane(b)) => a == b,
            _ => false,
        });
        if !known {
            fields.push(*field);
        }
    }
    fields
}

/// Points of a chain's edge between its corners, both included, in order.
///
/// A course between two surfaces is trimmed at both ends, where the mesh is rounded; all are stretched to the corners,
/// resampled and moved onto the fields. Samples that run back past a corner are dropped.
pub(super) fn edge_samples(
    course: &Course,
    start: &Point3,
    end: &Point3,
    n: usize,
    spacing: f64,
) -> Vec<Point3> {
    /// Course points dropped at each end: a corner of the mesh is rounded over about this many edges.
    const TRIM: usize = 2;
    /// Relative singular value below which a crossing is left to the mesh: about nine degrees between the normals.
    const FLAT: f64 = 0.08;
    let inner = course.points.len().saturating_sub(2);
    let trim = if course.cut { 0 } else { TRIM.min(inner / 3) };
    let mut path = vec![*start];
    path.extend(&course.points[1 + trim..course.points.len() - 1 - trim]);
    path.push(*end);
    let onto = |points: &[Point3]| -> Vec<Point3> {
        let inner = &points[1..points.len() - 1];
        let mut moved = vec![*start];
        moved.extend(inner.iter().map(|p| meet(p, &course.fields, CORNER_REACH * spacing, FLAT).point));
        moved.push(*end);
        moved
    };
    let rough = drop_reversals(&onto(&resample(&drop_reversals(&path, spacing), n)), spacing);
    // Once more from even steps: dropped samples leave gaps, and a spline wants its points evenly spread.
    drop_reversals(&onto(&resample(&rough, n)), spacing)
}

/// Leaves out inner points from which the path would turn back.
fn drop_reversals(points: &[Point3], spacing: f64) -> Vec<Point3> {
    /// Cosine of the turn that counts as running back: a path sampled at a fifth of its turn stays far from it.
    const BACK: f64 = -0.2;
    let mut kept: Vec<Point3> = points.to_vec();
    /// In spacings: shorter steps have no direction of their own.
    const NO_STEP: f64 = 1e-3;
    let min_step = NO_STEP * spacing;
    loop {
        let n = kept.len();
        let bad = (1..n.saturating_sub(1)).find(|&i| {
            let (before, after) = (kept[i] - kept[i - 1], kept[i + 1] - kept[i]);
            let (a, b) = (before.norm(), after.norm());
            a <= min_step || b <= min_step || before.dot(&after) < BACK * a * b
        });
        let Some(i) = bad else { return kept };
        kept.remove(i);
    }
}

/// `n + 1` points at equal steps along a polyline.
pub(super) fn resample(path: &[Point3], n: usize) -> Vec<Point3> {
    let mut lengths = vec![0.0];
    for pair in path.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let total = lengths[lengths.len() - 1];
    let mut points = Vec::with_capacity(n + 1);
    let mut i = 0;
    for k in 0..=n {
        let at = total * k as f64 / n as f64;
        while i + 2 < path.len() && lengths[i + 1] < at {
            i += 1;
        }
        let width = lengths[i + 1] - lengths[i];
        let share = if width > 0.0 { ((at - lengths[i]) / width).clamp(0.0, 1.0) } else { 0.0 };
        points.push(path[i] + (path[i + 1] - path[i]) * share);
    }
    points
}
