//! How much of each face was seen, and what the scan shows where it was not.
//!
//! A place of the model is seen when a vertex of the scan shows its face within one and a half vertex spacings. A face
//! that was not seen may be hidden, or may not be there: it is gone when the scan shows air where its material should
//! be, and filled when the scan shows a surface of its own before it. Near the rim of a hole in the scan neither is
//! known.

use super::Sightings;
use crate::align::{Alignment, Part, Target};
use crate::deviation::{Feature, Nearest};
use crate::math::{Point3, Vec3};
use crate::mesh::Adjacency;
use crate::par;

/// What was seen of a face.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Coverage {
    /// Area of the face in the model.
    pub area: f64,
    /// Share of it that was seen.
    pub seen: f64,
    /// Share of it where the scan shows that it is not there.
    pub absent: f64,
}

/// A place on a face with the area it stands for.
#[derive(Debug, Clone, Copy)]
struct Place {
    face: u32,
    point: Point3,
    normal: Vec3,
    area: f64,
}

/// Vertex spacings within which a vertex shows a place.
const REACH: f64 = 1.5;

/// One per face.
pub(super) fn of_faces(
    target: &Target,
    part: &Part,
    alignment: &Alignment,
    sightings: &Sightings,
) -> Vec<Coverage> {
    let spacing = part.tolerances.spacing();
    let places = places(target, spacing);
    let seen = Seen::new(sightings, REACH * spacing);
    let is_seen = par::map(&places, |place| seen.shows(place));
    let mut faces = vec![Coverage::default(); target.model.faces.len()];
    for (place, seen) in places.iter().zip(&is_seen) {
        let face = &mut faces[place.face as usize];
        face.area += place.area;
        face.seen += if *seen { place.area } else { 0.0 };
    }
    let hidden = chosen(&places, &is_seen, &faces);
    if let Some(sides) = (!hidden.is_empty()).then(|| Sides::new(part, sightings)).flatten() {
        let back = alignment.pose.inverse();
        let absent = par::map(&hidden, |(place, area)| {
            let (point, normal) = (back.point(&place.point), back.rotation * place.normal);
            if sides.is_absent(&point, &normal, spacing) { *area } else { 0.0 }
        });
        for ((place, _), area) in hidden.iter().zip(absent) {
            faces[place.face as usize].absent += area;
        }
    }
    for face in &mut faces {
        let area = face.area.max(f64::MIN_POSITIVE);
        (face.seen, face.absent) = (face.seen / area, face.absent / area);
    }
    faces
}

/// Places spread over the faces: two spacings apart on large ones, at least some hundreds on small ones.
fn places(target: &Target, spacing: f64) -> Vec<Place> {
    const LEAST: f64 = 300.0;
    const MOST: f64 = 10_000.0;
    let mesh = &target.model.mesh;
    let mut areas = vec![0.0; target.model.faces.len()];
    for t in 0..mesh.triangles.len() {
        areas[target.model.face_of[t] as usize] += mesh.area(t);
    }
    let mut places = Vec::new();
    for t in 0..mesh.triangles.len() {
        let face = target.model.face_of[t];
        let area = areas[face as usize];
        let pitch = (2.0 * spacing).min((area / LEAST).sqrt()).max((area / MOST).sqrt());
        let [a, b, c] = mesh.corners(t);
        let Some(normal) = mesh.cross(t).try_normalize(0.0) else { continue };
        let cut = |way: Vec3| ((way.norm() / pitch).ceil() as usize).clamp(1, 200);
        // Long thin triangles are cut along their length only.
        let (n, m) = (cut(b - a), cut(c - a).max(cut(c - b)));
        let share = mesh.area(t) / (n * m) as f64;
        for i in 0..n {
            for j in 0..m {
                let u = (i as f64 + 0.5) / n as f64;
                // Strips of equal area from the corner c: their middle is where half the strip's area is.
                let v = 1.0 - ((j as f64 + 0.5) / m as f64).sqrt();
                let base = a + (b - a) * u;
                places.push(Place { face, point: base + (c - base) * v, normal, area: share });
            }
        }
    }
    places
}

/// What vertices show, sorted into cells for look-up.
struct Seen {
    size: f64,
    cells: Vec<(u32, [i64; 3], Point3)>,
}

impl Seen {
    fn new(sightings: &Sightings, size: f64) -> Self {
        let all = sightings.of_vertex.iter().flatten();
        let mut cells: Vec<_> = all.map(|s| (s.face, cell(&s.foot, size), s.foot)).collect();
        cells.sort_unstable_by_key(|a| (a.0, a.1));
        Self { size, cells }
    }

    fn shows(&self, place: &Place) -> bool {
        let [x, y, z] = cell(&place.point, self.size);
        (-1..=1).any(|dx| {
            (-1..=1).any(|dy| {
                let first = (place.face, [x + dx, y + dy, z - 1]);
                let last = [x + dx, y + dy, z + 1];
                let from = self.cells.partition_point(|c| (c.0, c.1) < first);
                let mut row = self.cells[from..].iter().take_while(|c| c.0 == place.face && c.1 <= last);
                row.any(|c| (c.2 - place.point).norm_squared() < self.size * self.size)
            })
        })
    }
}

fn cell(point: &Point3, size: f64) -> [i64; 3] {
    [point.x, point.y, point.z].map(|x| (x / size).floor() as i64)
}

/// Some of the places not seen, of faces of which a tenth or more was not, with the area each stands for.
fn chosen(places: &[Place], is_seen: &[bool], faces: &[Coverage]) -> Vec<(Place, f64)> {
    const UNSEEN: f64 = 0.1;
    const MOST: usize = 200;
    let mut of_face: Vec<Vec<Place>> = vec![Vec::new(); faces.len()];
    for (place, seen) in places.iter().zip(is_seen) {
        let face = &faces[place.face as usize];
        if !seen && face.seen < (1.0 - UNSEEN) * face.area {
            of_face[place.face as usize].push(*place);
        }
    }
    let thinned = of_face.into_iter().flat_map(|places| {
        let area: f64 = places.iter().map(|p| p.area).sum();
        let n = places.len().min(MOST);
        (0..n).map(move |i| (places[i * places.len() / n], area / n as f64)).collect::<Vec<_>>()
    });
    thinned.collect()
}

/// Which side of the scan's surface a place is on.
struct Sides<'a> {
    part: &'a Part,
    adjacency: Adjacency,
    nearest: Nearest,
    /// One per vertex: whether the model explains it.
    explained: Vec<bool>,
}

impl<'a> Sides<'a> {
    fn new(part: &'a Part, sightings: &Sightings) -> Option<Self> {
        /// Spacings from the model up to which a vertex shows what the model has there.
        const NEAR: f64 = 1.0;
        let near = NEAR * part.tolerances.spacing();
        let explained =
            sightings.of_vertex.iter().map(|s| s.is_some_and(|s| s.distance.abs() < near)).collect();
        let nearest = Nearest::new(&part.mesh)?;
        Some(Self { part, adjacency: Adjacency::new(&part.mesh), nearest, explained })
    }

    /// Whether the scan shows air behind a face's place, or a surface that the model does not have before it.
    fn is_absent(&self, point: &Point3, normal: &Vec3, spacing: f64) -> bool {
        /// Spacings behind and before the face at which the scan is asked.
        const DEPTH: f64 = 2.0;
        let behind = point - normal * (DEPTH * spacing);
        let before = point + normal * (DEPTH * spacing);
        let air = self.side(&behind).is_some_and(|(distance, _)| distance > 0.5 * DEPTH * spacing);
        let buried = self.side(&before).is_some_and(|(distance, explained)| distance < 0.0 && !explained);
        air || buried
    }

    /// Distance from the scan's surface, positive before it, and whether the model explains what is nearest; `None`
    /// where that is the rim of a hole.
    fn side(&self, point: &Point3) -> Option<(f64, bool)> {
        let found = self.nearest.find(point, f64::INFINITY, |_| true)?;
        let t = found.triangle as usize;
        let corners = self.part.mesh.triangles[t];
        let rim = match found.feature {
            Feature::Inside => false,
            Feature::Edge(k) => self.adjacency.across[t][k].is_none(),
            Feature::Corner(k) => self.adjacency.on_boundary[corners[k] as usize],
        };
        let explained = corners.iter().all(|&v| self.explained[v as usize]);
        (!rim).then(|| (found.signed_distance(point), explained))
    }
}
