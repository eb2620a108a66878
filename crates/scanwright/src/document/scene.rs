use std::borrow::Cow;

use super::labels;
use super::part::Part;
use crate::deviation;
use crate::math::{Point3, UnitVec3, Vec3, try_unit};
use crate::mesh::Mesh;
use crate::pipeline::Reconstruction;
use crate::prior::PriorModel;
use crate::recognize::Primitive;
use crate::surface::SurfaceKind;

/// What pictures show.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(super) scan: Option<ScanView>,
    pub(super) model: Option<ModelView>,
    /// One per vertex of the scan: signed distance from the model, positive outside.
    pub(super) distances: Option<Vec<f64>>,
    pub(super) up: UnitVec3,
    /// What of the model could not be read.
    pub(super) unread: Vec<String>,
}

/// The scan of the part, its table left out.
#[derive(Debug, Clone)]
pub(super) struct ScanView {
    pub mesh: Mesh,
    /// One per triangle: the id of its primitive.
    pub labels: Vec<Option<u32>>,
}

/// The part.
#[derive(Debug, Clone)]
pub(super) struct ModelView {
    pub mesh: Mesh,
    /// One per triangle, into `faces`.
    pub face_of: Vec<u32>,
    pub faces: Vec<Face>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Face {
    /// The id of its primitive, if it has one.
    pub region: Option<u32>,
    /// Its type; `None` when it is not analytic or nothing is known of it.
    pub kind: Option<SurfaceKind>,
    pub assumed: bool,
}

/// A scan read from a file.
#[derive(Debug, Clone, Copy)]
pub struct ScanInput<'a> {
    /// Its triangles, as read.
    pub mesh: &'a Mesh,
    /// One per triangle: the id of its primitive, when the file says so.
    pub labels: Option<&'a [Option<u32>]>,
}

impl Scene {
    /// No meshes.
    pub fn empty() -> Self {
        Self { scan: None, model: None, distances: None, up: Vec3::z_axis(), unread: Vec::new() }
    }

    /// What a run has in memory.
    pub fn of_run(result: &Reconstruction) -> Self {
        let on_table = |t: usize| result.support.as_ref().is_some_and(|support| support.on_table[t]);
        let (mesh, old, _) = result.mesh.submesh(|t| !on_table(t));
        let labels =
            old.iter().map(|t| result.segmentation.labels[*t as usize].map(|region| region.0)).collect();
        let n_vertices = mesh.vertices.len();
        let distances = result.deviation.as_ref().map(|deviation| deviation.distances.clone());
        Self {
            scan: Some(ScanView { mesh, labels }),
            model: ModelView::of_run(result),
            // The part without its table is what was measured.
            distances: distances.filter(|distances| distances.len() == n_vertices),
            up: result.support.as_ref().map_or(Vec3::z_axis(), |support| support.plane.normal),
            unread: Vec::new(),
        }
    }

    /// What files hold of the result `part`. The scan follows to the datums, and the table, if there was one, is taken from
    /// it.
    pub fn of_files(part: &Part, scan: Option<ScanInput>, model: Option<&PriorModel>) -> Self {
        let table = part
            .support
            .as_ref()
            .and_then(|support| Some((Point3::from(support.point?), try_unit(Vec3::from(support.normal?))?)));
        let scan = scan.map(|scan| {
            let mesh = aligned(part, scan.mesh);
            let labels = scan.labels.map_or_else(|| labels::of_scan(part, &mesh), <[Option<u32>]>::to_vec);
            without_table(part, &mesh, &labels, table)
        });
        let unread = model.map_or_else(Vec::new, |model| model.unread.clone());
        let model = model.filter(|model| !model.mesh.triangles.is_empty()).map(ModelView::of_prior);
        let distances = scan
            .as_ref()
            .zip(model.as_ref())
            .and_then(|(scan, model)| Some(deviation::measure(&scan.mesh.vertices, &model.mesh)?.distances));
        Self { scan, model, distances, up: table.map_or(Vec3::z_axis(), |(_, normal)| normal), unread }
    }

    /// Points that every picture shows.
    pub(super) fn frame(&self) -> &[Point3] {
        let scan = self.scan.as_ref().map(|scan| &scan.mesh);
        let mesh = scan.or(self.model.as_ref().map(|model| &model.mesh));
        mesh.map_or(&[], |mesh| &mesh.vertices)
    }
}

/// The scan in the coordinates of the result.
fn aligned<'a>(part: &Part, mesh: &'a Mesh) -> Cow<'a, Mesh> {
    let Some(rows) = part.aligned_from_scan() else { return Cow::Borrowed(mesh) };
    let mut mesh = mesh.clone();
    for vertex in &mut mesh.vertices {
        let coordinate = |k: usize| {
            let [x, y, z, shift]: [f64; 4] = rows[k];
            x * vertex.x + y * vertex.y + z * vertex.z + shift
        };
        *vertex = Point3::new(coordinate(0), coordinate(1), coordinate(2));
    }
    Cow::Owned(mesh)
}

/// Heights over the table, in standard deviations of the noise and in spacings, below which a triangle of no primitive is
/// the table's.
const TABLE_SIGMAS: f64 = 5.0;
const TABLE_SPACINGS: f64 = 1.0;

fn without_table(
    part: &Part,
    mesh: &Mesh,
    labels: &[Option<u32>],
    table: Option<(Point3, UnitVec3)>,
) -> ScanView {
    let thickness = (TABLE_SIGMAS * part.scan.noise.unwrap_or(0.0))
        .max(TABLE_SPACINGS * part.scan.spacing.unwrap_or(0.0));
    let of_table = |t: usize| {
        labels[t].is_none()
            && table.is_some_and(|(point, up)| (mesh.triangle_center(t) - point).dot(&up) < thickness)
    };
    let (mesh, old, _) = mesh.submesh(|t| !of_table(t));
    ScanView { mesh, labels: old.iter().map(|t| labels[*t as usize]).collect() }
}

impl ModelView {
    fn of_run(result: &Reconstruction) -> Option<Self> {
        let model = &result.model;
        if model.mesh.triangles.is_empty() {
            return None;
        }
        let kind = |region: u32| model.primitives.get(region as usize).and_then(Primitive::kind);
        let face = |t: usize| {
            let region = model.regions[t].0;
            Face { region: Some(region), kind: kind(region), assumed: model.assumed[t] }
        };
        let of_triangles: Vec<Face> = (0..model.mesh.triangles.len()).map(face).collect();
        let mut faces = of_triangles.clone();
        faces.sort_unstable();
        faces.dedup();
        let place = |face: &Face| faces.binary_search(face).expect("every triangle's face was listed") as u32;
        let face_of = of_triangles.iter().map(place).collect();
        Some(Self { mesh: model.mesh.clone(), face_of, faces })
    }

    fn of_prior(model: &PriorModel) -> Self {
        let faces = model.faces.iter().map(|face| {
            let (region, assumed) =
                named(&face.name).map_or((None, false), |(id, assumed)| (Some(id), assumed));
            Face { region, kind: face.surface.as_ref().map(crate::surface::Surface::kind), assumed }
        });
        Self { mesh: model.mesh.clone(), face_of: model.face_of.clone(), faces: faces.collect() }
    }
}

/// The region that a STEP file of ours names a face after, and whether the face was assumed.
fn named(name: &str) -> Option<(u32, bool)> {
    let mut words = name.split(' ');
    if words.next() != Some("region") {
        return None;
    }
    Some((words.next()?.parse().ok()?, words.next_back() == Some("assumed")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_known_by_the_names_that_step_gives_them() {
        assert_eq!(named("region 12 cylinder"), Some((12, false)));
        assert_eq!(named("region 3 plane assumed"), Some((3, true)));
        for other in ["face 1", "region", "region x plane", ""] {
            assert_eq!(named(other), None, "{other}");
        }
    }
}
