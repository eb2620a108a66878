//! Cuts faces that run round their surface, so that no face needs a seam.
//!
//! A cylinder or cone whose face winds round the axis, or covers almost all of it, is cut in two by a plane through the
//! axis; a tube that winds round its spine by the plane through the centre across the axis; a sphere wider than a cap
//! by two planes. The cut is made in the labels: its line is then an ordinary edge between two faces, the intersection
//! of the surface and the auxiliary plane. Of several angles the one that stays farthest from corners is taken;
//! without that, coaxial neighbours cut at one angle would leave edges of no length.
//! Cost O(triangles * angles).

use super::LabelledMesh;
use super::halfedge::HalfEdges;
use crate::math::{Axis, Frame, Point3, UnitVec3, Vec3, try_unit};
use crate::mesh::Mesh;
use crate::segment::RegionId;
use crate::surface::{Plane, Surface};

/// Angles tried for a cut through the axis.
const N_ANGLES: usize = 36;
/// Planes that may cut one component.
const MAX_CUTS: u32 = 3;
/// Bins of the coverage histogram.
const N_BINS: usize = 72;
/// Share of the turn from which a face is cut although none of its loops winds.
const COVERED: f64 = 0.9;
/// In spacings: how far the border of the mesh may lie from the edge that the surfaces give.
const GRAZE: f64 = 2.5;
/// Half opening, radians, of the widest sphere cap that is left whole.
const WIDEST_CAP: f64 = 75.0 * std::f64::consts::PI / 180.0;

/// A connected set of triangles that becomes one face.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    /// Its label: the index of its region, or the one of all facets.
    pub region: u32,
    /// The region that its face belongs to: of a facet the one it was cut out of.
    pub origin: RegionId,
    /// Whether it is one triangle of the mesh, to be a flat face by itself.
    pub facet: bool,
    /// Its surface; `None` when freeform or a facet.
    pub surface: Option<Surface>,
    /// The surface that it was cut for, also when a B-spline takes its place.
    pub chart: Option<Surface>,
    /// The cuts that made it.
    pub cuts: Vec<Cut>,
    /// Its triangles.
    pub triangles: Vec<u32>,
}

/// An auxiliary plane and the side of it that a patch lies on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut {
    pub plane: Plane,
    pub above: bool,
}

/// The patches of a labelled mesh and the patch of each triangle. Triangles labelled `facets` are patches of their own.
pub(super) fn patches(
    closed: &LabelledMesh,
    half_edges: &HalfEdges,
    labels: &[u32],
    surfaces: &[Option<Surface>],
    facets: u32,
    spacing: f64,
) -> (Vec<Patch>, Vec<u32>) {
    let mesh = &closed.mesh;
    let apart = |t: usize| if labels[t] == facets { facets + t as u32 } else { labels[t] };
    let (component, n) = half_edges.components(apart);
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); n];
    for (t, c) in component.iter().enumerate() {
        members[*c as usize].push(t as u32);
    }
    let mut work = Cutter {
        mesh,
        half_edges,
        key: component,
        planes: vec![Vec::new(); n],
        corners: corners(mesh, half_edges, labels),
        spacing,
    };
    for (c, triangles) in members.iter().enumerate() {
        let label = labels[triangles[0] as usize];
        if label == facets {
            continue;
        }
        match &surfaces[label as usize] {
            Some(surface) => work.cut(c, triangles, surface),
            None => work.cut_freeform(c, triangles),
        }
    }
    let origin = |t: usize| if labels[t] == facets { closed.labels[t] } else { RegionId(labels[t]) };
    collect(&work, labels, surfaces, facets, origin, &members, spacing)
}

struct Cutter<'a> {
    mesh: &'a Mesh,
    half_edges: &'a HalfEdges,
    /// The component of each triangle, before cutting.
    key: Vec<u32>,
    /// The planes that cut each component.
    planes: Vec<Vec<Plane>>,
    /// Vertices where three or more labels meet, and where cuts already meet borders.
    corners: Vec<Point3>,
    spacing: f64,
}

fn corners(mesh: &Mesh, half_edges: &HalfEdges, labels: &[u32]) -> Vec<Point3> {
    (0..mesh.vertices.len() as u32)
        .filter(|v| {
            let leaving = half_edges.leaving(*v);
            let borders = leaving.iter().filter(|h| {
                half_edges
                    .twin(**h)
                    .is_none_or(|g| labels[HalfEdges::triangle(g)] != labels[HalfEdges::triangle(**h)])
            });
            borders.count() > 2
        })
        .map(|v| mesh.vertices[v as usize])
        .collect()
}

impl Cutter<'_> {
    fn cut(&mut self, c: usize, triangles: &[u32], surface: &Surface) {
        let border = self.border(c as u32, triangles);
        match surface {
            Surface::Plane(_) => {}
            Surface::Cylinder(_) | Surface::Cone(_) => {
                let axis = surface.axis().expect("a cylinder or cone has an axis");
                self.cut_round(c, triangles, &border, &axis);
            }
            Surface::Torus(torus) => {
                self.cut_round(c, triangles, &border, &torus.axis);
                let about_spine =
                    |p: &Point3| torus.axis.height(p).atan2(torus.axis.radial(p).norm() - torus.major_radius);
                if self.goes_round(triangles, &border, about_spine) {
                    let plane = Plane { point: torus.axis.origin, normal: torus.axis.direction };
                    self.add(c, &border, plane);
                }
            }
            Surface::Sphere(sphere) => {
                let sum = triangles.iter().fold(Vec3::zeros(), |s, t| s + self.mesh.cross(*t as usize));
                let outward = triangles.iter().fold(Vec3::zeros(), |s, t| {
                    let center = self.mesh.triangle_center(*t as usize);
                    s + (center - sphere.center) * self.mesh.area(*t as usize)
                });
                let pole = try_unit(outward).or_else(|| try_unit(sum)).unwrap_or_else(Vec3::z_axis);
                let widest = triangles
                    .iter()
                    .map(|t| {
                        crate::math::angle_between(
                            &(self.mesh.triangle_center(*t as usize) - sphere.center),
                            &pole,
                        )
                    })
                    .fold(0.0, f64::max);
                if widest > WIDEST_CAP {
                    let axis = Axis { origin: sphere.center, direction: pole };
                    let first = self.best_plane(&border, &axis);
                    let second = Plane {
                        point: sphere.center,
                        normal: UnitVec3::new_normalize(pole.cross(&first.normal)),
                    };
                    self.add(c, &border, first);
                    self.add(c, &border, second);
                }
            }
        }
    }

    /// Cuts a freeform component across its principal axes until the pieces are heights over planes.
    fn cut_freeform(&mut self, c: usize, triangles: &[u32]) {
        let border = self.border(c as u32, triangles);
        let centers: Vec<Point3> = triangles.iter().map(|t| self.mesh.triangle_center(*t as usize)).collect();
        let center = crate::math::centroid(&centers);
        let axes = crate::math::principal_axes(&centers, center);
        for (_, direction) in axes.iter().rev() {
            let folded = self.pieces(c, triangles).iter().any(|piece| {
                let frame = super::freeform::base_frame(self.mesh, piece);
                super::freeform::folded_share(self.mesh, piece, &frame) > super::freeform::MAX_FOLDED
            });
            if !folded {
                break;
            }
            self.add(c, &border, Plane { point: center, normal: *direction });
        }
    }

    /// The triangles of a component, by the sides of its planes so far.
    fn pieces(&self, c: usize, triangles: &[u32]) -> Vec<Vec<u32>> {
        let mut pieces = vec![Vec::new(); 1 << self.planes[c].len()];
        for t in triangles {
            let center = self.mesh.triangle_center(*t as usize);
            let sides = self.planes[c].iter().enumerate();
            let piece: usize = sides.map(|(i, p)| usize::from(p.signed_distance(&center) > 0.0) << i).sum();
            pieces[piece].push(*t);
        }
        pieces.retain(|p| !p.is_empty());
        pieces
    }

    fn cut_round(&mut self, c: usize, triangles: &[u32], border: &[u32], axis: &Axis) {
        let frame = Frame::from_z(axis.origin, axis.direction);
        let angle = |p: &Point3| {
            let local = frame.local(p);
            local.y.atan2(local.x)
        };
        if self.goes_round(triangles, border, angle) {
            let plane = self.best_plane(border, axis);
            self.add(c, border, plane);
        }
    }

    /// Border half-edges of a component.
    fn border(&self, c: u32, triangles: &[u32]) -> Vec<u32> {
        triangles
            .iter()
            .flat_map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .filter(|h| self.half_edges.twin(*h).is_none_or(|g| self.key[HalfEdges::triangle(g)] != c))
            .collect()
    }

    /// Whether a loop of the border winds in `angle`, or the triangles cover nearly the whole turn.
    fn goes_round(&self, triangles: &[u32], border: &[u32], angle: impl Fn(&Point3) -> f64) -> bool {
        let tau = std::f64::consts::TAU;
        let mut covered = [false; N_BINS];
        for t in triangles {
            for p in self.mesh.corners(*t as usize) {
                let bin = (angle(&p).rem_euclid(tau) / tau * N_BINS as f64) as usize;
                covered[bin.min(N_BINS - 1)] = true;
            }
        }
        if covered.iter().filter(|b| **b).count() as f64 > COVERED * N_BINS as f64 {
            return true;
        }
        let at = |v: u32| angle(&self.mesh.vertices[v as usize]);
        self.loops(border).iter().any(|run| {
            let turn: f64 = run
                .iter()
                .map(|h| {
                    let step = at(self.half_edges.to(*h)) - at(self.half_edges.from(*h));
                    step - tau * (step / tau).round()
                })
                .sum();
            turn.abs() > 0.5 * tau
        })
    }

    /// The border's loops, as runs of half-edges.
    fn loops(&self, border: &[u32]) -> Vec<Vec<u32>> {
        let mut seen = vec![false; border.len()];
        let place = |h: u32| border.binary_search(&h).ok();
        let mut loops = Vec::new();
        for i in 0..border.len() {
            if seen[i] {
                continue;
            }
            let (mut run, mut h) = (Vec::new(), border[i]);
            while let Some(j) = place(h).filter(|j| !seen[*j]) {
                seen[j] = true;
                run.push(h);
                let Some(next) = self.next_on_border(h, &place) else { break };
                h = next;
            }
            loops.push(run);
        }
        loops
    }

    fn next_on_border(&self, h: u32, place: &impl Fn(u32) -> Option<usize>) -> Option<u32> {
        let mut next = HalfEdges::next(h);
        for _ in 0..self.half_edges.leaving(self.half_edges.to(h)).len() {
            if place(next).is_some() {
                return Some(next);
            }
            next = HalfEdges::next(self.half_edges.twin(next)?);
        }
        None
    }

    /// The plane through the axis whose crossings with the border stay farthest from corners, fewest crossings first.
    ///
    /// Crossings are counted beside the plane too: where it only grazes the border of the mesh, it may miss the edge
    /// that the surfaces give.
    fn best_plane(&self, border: &[u32], axis: &Axis) -> Plane {
        let frame = Frame::from_z(axis.origin, axis.direction);
        let points: Vec<(Point3, Point3)> = border
            .iter()
            .map(|h| {
                (
                    self.mesh.vertices[self.half_edges.from(*h) as usize],
                    self.mesh.vertices[self.half_edges.to(*h) as usize],
                )
            })
            .collect();
        let (low, high) = bounds(&points);
        let near: Vec<&Point3> = self.corners.iter().filter(|p| **p >= low && **p <= high).collect();
        let mut best: Option<(usize, f64, Plane)> = None;
        for i in 0..N_ANGLES {
            let (sin, cos) = (std::f64::consts::PI * i as f64 / N_ANGLES as f64).sin_cos();
            let normal = UnitVec3::new_normalize(frame.x.into_inner() * cos + frame.y.into_inner() * sin);
            let plane = Plane { point: axis.origin, normal };
            let crossed = |offset: f64| {
                let above = move |p: &Point3| plane.signed_distance(p) > offset;
                points.iter().filter(move |(a, b)| above(a) != above(b)).map(|(a, _)| *a)
            };
            let graze = GRAZE * self.spacing;
            let count = [-graze, graze].map(|offset| crossed(offset).count()).into_iter().max();
            let crossings: Vec<Point3> = crossed(0.0).collect();
            let count = crossings.len().max(count.unwrap_or(0));
            let clearance = crossings
                .iter()
                .flat_map(|p| near.iter().map(move |q| (p - **q).norm_squared()))
                .fold(f64::INFINITY, f64::min);
            let better = best.as_ref().is_none_or(|(n, c, _)| count < *n || (count == *n && clearance > *c));
            if better {
                best = Some((count, clearance, plane));
            }
        }
        best.expect("at least one angle is tried").2
    }

    fn add(&mut self, c: usize, border: &[u32], plane: Plane) {
        for h in border {
            let a = self.mesh.vertices[self.half_edges.from(*h) as usize];
            let b = self.mesh.vertices[self.half_edges.to(*h) as usize];
            if (plane.signed_distance(&a) > 0.0) != (plane.signed_distance(&b) > 0.0) {
                self.corners.push(a);
            }
        }
        self.planes[c].push(plane);
    }
}

fn bounds(points: &[(Point3, Point3)]) -> (Point3, Point3) {
    let start = points.first().map_or_else(Point3::origin, |p| p.0);
    points.iter().fold((start, start), |(low, high), (a, b)| (low.inf(a).inf(b), high.sup(a).sup(b)))
}

/// Applies the cuts and gathers connected patches.
fn collect(
    work: &Cutter,
    labels: &[u32],
    surfaces: &[Option<Surface>],
    facets: u32,
    origin: impl Fn(usize) -> RegionId,
    members: &[Vec<u32>],
    spacing: f64,
) -> (Vec<Patch>, Vec<u32>) {
    let mut side: Vec<u32> = work.key.iter().map(|c| c << MAX_CUTS).collect();
    for (c, triangles) in members.iter().enumerate() {
        for t in triangles {
            let center = work.mesh.triangle_center(*t as usize);
            for (i, plane) in work.planes[c].iter().enumerate() {
                side[*t as usize] |= u32::from(plane.signed_distance(&center) > 0.0) << i;
            }
        }
        if !work.planes[c].is_empty() {
            smooth_cut(work, &mut side, triangles);
        }
    }
    absorb_slivers(work, &mut side, spacing);
    let (component, n) = work.half_edges.components(|t| side[t]);
    let mut patches: Vec<Patch> = Vec::with_capacity(n);
    for t in 0..labels.len() {
        let id = component[t] as usize;
        if id == patches.len() {
            let c = work.key[t] as usize;
            let cuts = work.planes[c].iter().enumerate();
            let cuts = cuts.map(|(i, plane)| Cut { plane: *plane, above: side[t] >> i & 1 == 1 }).collect();
            let surface = surfaces[labels[t] as usize];
            patches.push(Patch {
                region: labels[t],
                origin: origin(t),
                facet: labels[t] == facets,
                surface,
                chart: surface,
                cuts,
                triangles: Vec::new(),
            });
        }
        patches[id].triangles.push(t as u32);
    }
    (patches, component)
}

/// Straightens the zig-zag of a cut inside its component.
fn smooth_cut(work: &Cutter, side: &mut [u32], triangles: &[u32]) {
    let mut queue: Vec<u32> = triangles.iter().rev().copied().collect();
    while let Some(t) = queue.pop() {
        let t = t as usize;
        let neighbours = work.half_edges.neighbours(t);
        let same = |u: &usize| work.key[*u] == work.key[t];
        let own = neighbours.iter().flatten().filter(|u| same(u) && side[**u] == side[t]).count();
        let mut others =
            neighbours.iter().flatten().filter(|u| same(u) && side[**u] != side[t]).map(|u| side[*u]);
        let flip = match (others.next(), others.next()) {
            (Some(a), Some(b)) if a == b && own <= 1 => Some(a),
            _ => None,
        };
        if let Some(value) = flip {
            side[t] = value;
            queue.extend(neighbours.iter().flatten().filter(|u| same(u)).map(|u| *u as u32));
        }
    }
}

/// Pieces of a cut component below a few squared spacings go back to the other side.
fn absorb_slivers(work: &Cutter, side: &mut [u32], spacing: f64) {
    /// In squared spacings: smaller pieces come from the cut grazing a border.
    const SLIVER: f64 = 6.0;
    let (component, n) = work.half_edges.components(|t| side[t]);
    let mut area = vec![0.0; n];
    for (t, c) in component.iter().enumerate() {
        area[*c as usize] += work.mesh.area(t);
    }
    let mut target = vec![None; n];
    for t in 0..side.len() {
        let c = component[t] as usize;
        if work.planes[work.key[t] as usize].is_empty()
            || area[c] >= SLIVER * spacing * spacing
            || target[c].is_some()
        {
            continue;
        }
        let inside = work.half_edges.neighbours(t).into_iter().flatten();
        target[c] = inside
            .filter(|u| work.key[*u] == work.key[t] && component[*u] as usize != c)
            .map(|u| side[u])
            .next();
    }
    for t in 0..side.len() {
        if let Some(value) = target[component[t] as usize] {
            side[t] = value;
        }
    }
}
