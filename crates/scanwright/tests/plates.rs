//! A plate with two bores and a boss, as it was designed and as it was made: the models and scans of alignment and check.

use scanwright::align::Part;
use scanwright::condition;
use scanwright::math::{Axis, Point3, Pose, UnitVec3, Vec3};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::pipeline::{self, Options};
use scanwright::prior::{PriorFace, PriorModel};
use scanwright::progress::Progress;
use scanwright::random::Rng;
use scanwright::segment::Segmentation;
use scanwright::surface::{Cylinder, Plane, Surface};
use scanwright::tolerance::Tolerances;
use scanwright::uncertainty::{self, Interior};

use crate::scanned::{box_distance, scan, with_noise};

/// What may differ between a plate's model and the plate.
#[derive(Debug, Clone, Copy)]
pub struct Plate {
    /// Radius and place of the large bore.
    pub bore: f64,
    pub bore_at: [f64; 2],
    /// Height of the upper face.
    pub top: f64,
    /// Whether there is a boss, and a second one that no model knows.
    pub boss: bool,
    pub extra: bool,
}

impl Default for Plate {
    fn default() -> Self {
        Self { bore: 5.0, bore_at: [-15.0, 5.0], top: 10.0, boss: true, extra: false }
    }
}

const SMALL_BORE: ([f64; 2], f64) = ([12.0, -9.0], 3.0);
/// Its place, radius and height.
pub const BOSS: ([f64; 2], f64, f64) = ([12.0, 7.0], 6.0, 16.0);
const EXTRA: ([f64; 2], f64, f64) = ([-14.0, -11.0], 5.0, 15.0);
/// Half its length and width.
const HALF: [f64; 2] = [30.0, 20.0];

impl Plate {
    /// Distance from it, negative inside.
    pub fn distance(&self, p: &Point3) -> f64 {
        self.distance_with_boss(p, BOSS.2)
    }

    fn distance_with_boss(&self, p: &Point3, boss_height: f64) -> f64 {
        let round = |[x, y]: [f64; 2]| (p.x - x).hypot(p.y - y);
        let mut inside = box_distance(p, [0.0, 0.0, self.top / 2.0], [HALF[0], HALF[1], self.top / 2.0]);
        let mut stand = |at: [f64; 2], radius: f64, height: f64| {
            let walls = (round(at) - radius).max(p.z - height).max(-p.z);
            inside = inside.min(walls);
        };
        if self.boss {
            stand(BOSS.0, BOSS.1, boss_height);
        }
        if self.extra {
            stand(EXTRA.0, EXTRA.1, EXTRA.2);
        }
        inside.max(self.bore - round(self.bore_at)).max(SMALL_BORE.1 - round(SMALL_BORE.0))
    }

    /// Its faces: large bore, small bore, boss, its top, then the six sides of the plate, the upper one last.
    pub fn faces(&self) -> Vec<PriorFace> {
        let upright = |[x, y]: [f64; 2], radius| {
            let axis = Axis { origin: Point3::new(x, y, 0.0), direction: Vec3::z_axis() };
            Surface::Cylinder(Cylinder { axis, radius })
        };
        let flat = |point: [f64; 3], normal: [f64; 3]| {
            let normal = UnitVec3::new_normalize(Vec3::from(normal));
            Surface::Plane(Plane { point: Point3::from(point), normal })
        };
        let face = |name: &str, surface, outward| PriorFace {
            name: name.to_owned(),
            surface: Some(surface),
            outward,
        };
        let [x, y] = HALF;
        let mut faces = vec![
            face("bore", upright(self.bore_at, self.bore), false),
            face("small bore", upright(SMALL_BORE.0, SMALL_BORE.1), false),
        ];
        if self.boss {
            faces.push(face("boss", upright(BOSS.0, BOSS.1), true));
            faces.push(face("boss top", flat([0.0, 0.0, BOSS.2], [0.0, 0.0, 1.0]), true));
        }
        faces.extend([
            face("left", flat([-x, 0.0, 0.0], [-1.0, 0.0, 0.0]), true),
            face("right", flat([x, 0.0, 0.0], [1.0, 0.0, 0.0]), true),
            face("front", flat([0.0, -y, 0.0], [0.0, -1.0, 0.0]), true),
            face("back", flat([0.0, y, 0.0], [0.0, 1.0, 0.0]), true),
            face("bottom", flat([0.0, 0.0, 0.0], [0.0, 0.0, -1.0]), true),
            face("top", flat([0.0, 0.0, self.top], [0.0, 0.0, 1.0]), true),
        ]);
        faces
    }

    fn bounds() -> ([f64; 3], [f64; 3]) {
        ([-32.03, -22.01, -2.02], [32.0, 22.0, 18.0])
    }

    /// A mesh whose vertices lie on it, edges cut by a vertex spacing.
    pub fn mesh(&self, spacing: f64) -> Mesh {
        self.mesh_with_boss(spacing, BOSS.2)
    }

    /// The same with another height of the boss.
    pub fn mesh_with_boss(&self, spacing: f64, boss_height: f64) -> Mesh {
        let (lo, hi) = Self::bounds();
        scan(|p| self.distance_with_boss(p, boss_height), lo, hi, spacing)
    }

    /// As a design program would give it.
    pub fn model(&self) -> PriorModel {
        let mesh = self.mesh(0.7);
        let faces = self.faces();
        let nearest = |t: usize| {
            let (center, normal) = (mesh.triangle_center(t), mesh.cross(t).normalize());
            let off = |face: &PriorFace| {
                let surface = face.surface.as_ref().expect("all have one");
                let (distance, natural) = surface.distance_and_normal(&center);
                let sign = if face.outward { 1.0 } else { -1.0 };
                distance.abs() + (natural.into_inner() * sign - normal).norm()
            };
            let best = (0..faces.len()).min_by(|&a, &b| off(&faces[a]).total_cmp(&off(&faces[b])));
            best.expect("there are faces") as u32
        };
        let face_of = (0..mesh.triangles.len()).map(nearest).collect();
        PriorModel { face_of, mesh, faces, millimetres: Some(1.0), ..PriorModel::default() }
    }
}

/// A motion drawn at random, up to two hundred lengths away.
pub fn random_pose(seed: u64) -> Pose {
    let mut rng = Rng::for_task(seed, "poses", 0);
    let quaternion = nalgebra::Quaternion::new(rng.normal(), rng.normal(), rng.normal(), rng.normal());
    let rotation = nalgebra::UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix();
    let translation = Vec3::new(rng.normal(), rng.normal(), rng.normal()) * 100.0;
    Pose { rotation, translation }
}

/// A scan with noise, placed anywhere.
pub fn scan_of(mesh: &Mesh, noise: f64, pose: &Pose, seed: u64) -> Mesh {
    with_noise(mesh, noise, seed).moved(pose)
}

/// The scan as alignment takes it.
pub fn part_of(mesh: &Mesh) -> Part {
    let segmented =
        pipeline::segment(mesh, &Options::default(), &Progress::none()).expect("a mesh with area");
    Part::new(&segmented)
}

/// The same without regions: where the start is known they are not needed, and take most of the time.
pub fn bare_part(mesh: &Mesh) -> Part {
    let adjacency = Adjacency::new(mesh);
    let tolerances = Tolerances::new(condition::measure(mesh, &adjacency), None);
    let segmentation = Segmentation { labels: vec![None; mesh.triangles.len()], primitives: Vec::new() };
    let interior = Interior::new(mesh, &adjacency, &segmentation, &tolerances);
    Part {
        noise: uncertainty::measure(mesh, &adjacency, &interior, &segmentation, &tolerances),
        normals: mesh.vertex_normals(),
        scan_vertex: (0..mesh.vertices.len() as u32).collect(),
        mesh: mesh.clone(),
        segmentation,
        tolerances,
    }
}
