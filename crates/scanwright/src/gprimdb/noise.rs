//! What scanners and their merging do to vertices.

use serde::{Deserialize, Serialize};

use crate::math::{Point3, Vec3};
use crate::mesh::{Adjacency, Mesh};
use crate::random::Rng;

/// A kind of noise; levels are standard deviations in edge lengths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum Noise {
    /// None: vertices lie on the surface.
    None,
    /// Independent, along the normal.
    Normal {
        /// Standard deviation, edge lengths.
        level: f64,
    },
    /// Independent, in every direction.
    Isotropic {
        /// Standard deviation, edge lengths.
        level: f64,
    },
    /// Along the normal, alike over `length` edges: what merging several scans leaves.
    Correlated {
        /// Standard deviation, edge lengths.
        level: f64,
        /// Edges over which neighbours are alike.
        length: f64,
    },
    /// Along the normal, and a share of the vertices 3 to 10 edge lengths off.
    Outliers {
        /// Standard deviation of the others, edge lengths.
        level: f64,
        /// Share of the vertices.
        share: f64,
    },
}

impl Noise {
    /// Every kind at the levels of the thesis's figures.
    pub fn all() -> Vec<Self> {
        let levels = [0.1, 0.25, 0.4, 0.8];
        let mut all = vec![Self::None];
        all.extend(levels.map(|level| Self::Normal { level }));
        all.extend(levels.map(|level| Self::Isotropic { level }));
        all.extend(
            [(0.25, 2.0), (0.25, 5.0), (0.4, 3.0)].map(|(level, length)| Self::Correlated { level, length }),
        );
        all.extend([0.01, 0.05].map(|share| Self::Outliers { level: 0.1, share }));
        all
    }

    /// What is wrong with it, if anything.
    pub(super) fn problem(self) -> Option<String> {
        const MOST_LEVEL: f64 = 10.0;
        const MOST_LENGTH: f64 = 20.0;
        let (level, length, share) = match self {
            Self::None => (0.0, 1.0, 0.0),
            Self::Normal { level } | Self::Isotropic { level } => (level, 1.0, 0.0),
            Self::Correlated { level, length } => (level, length, 0.0),
            Self::Outliers { level, share } => (level, 1.0, share),
        };
        if !(0.0..=MOST_LEVEL).contains(&level) {
            return Some(format!("a level from 0 to {MOST_LEVEL} edges is needed, not {level}"));
        }
        if !(0.0..=MOST_LENGTH).contains(&length) {
            return Some(format!("a length from 0 to {MOST_LENGTH} edges is needed, not {length}"));
        }
        (!(0.0..=1.0).contains(&share)).then(|| format!("a share from 0 to 1 is needed, not {share}"))
    }

    /// The vertices of `mesh`, which lie on the surface with these unit `normals`, moved.
    pub(super) fn moved(self, mesh: &Mesh, normals: &[Vec3], edge: f64, rng: &mut Rng) -> Vec<Point3> {
        let along = |heights: Vec<f64>| -> Vec<Point3> {
            mesh.vertices.iter().zip(normals).zip(heights).map(|((p, n), h)| p + n * (h * edge)).collect()
        };
        let n = mesh.vertices.len();
        match self {
            Self::None => mesh.vertices.clone(),
            Self::Normal { level } => along((0..n).map(|_| level * rng.normal()).collect()),
            Self::Isotropic { level } => {
                let mut by = || level * edge * rng.normal();
                mesh.vertices.iter().map(|p| p + Vec3::new(by(), by(), by())).collect()
            }
            Self::Correlated { level, length } => {
                along(correlated(mesh, length, rng).into_iter().map(|h| level * h).collect())
            }
            Self::Outliers { level, share } => along(
                (0..n)
                    .map(|_| {
                        let small = level * rng.normal();
                        let (is_off, far, up) =
                            (rng.uniform() < share, 3.0 + 7.0 * rng.uniform(), rng.uniform());
                        if is_off { far.copysign(up - 0.5) } else { small }
                    })
                    .collect(),
            ),
        }
    }
}

/// A field of unit variance, alike over `length` edges: white noise, averaged over rings until it has spread that far.
fn correlated(mesh: &Mesh, length: f64, rng: &mut Rng) -> Vec<f64> {
    let rings = Adjacency::new(mesh).vertex_vertices;
    let mut field: Vec<f64> = (0..mesh.vertices.len()).map(|_| rng.normal()).collect();
    // A round of averaging with one's ring spreads a peak by a variance of about an edge squared.
    for _ in 0..(length * length).round() as usize {
        field = (0..field.len())
            .map(|v| {
                let ring = rings.row(v);
                let sum: f64 = ring.iter().map(|&u| field[u as usize]).sum();
                (field[v] + sum) / (ring.len() + 1) as f64
            })
            .collect();
    }
    let n = field.len().max(1) as f64;
    let mean = field.iter().sum::<f64>() / n;
    let deviation = (field.iter().map(|h| (h - mean).powi(2)).sum::<f64>() / n).sqrt().max(f64::MIN_POSITIVE);
    field.into_iter().map(|h| (h - mean) / deviation).collect()
}
