//! What the vertices of each face say of it as a whole.

use super::{Coverage, Feature, GUARD, Options, Sighting, Sightings, Verdict};
use crate::align::{Alignment, Part, Target};
use crate::math::{Point3, stats};

/// Distances of points from a model, positive outside, length.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Spread {
    /// Points.
    pub n_points: usize,
    /// Mean.
    pub mean: f64,
    /// Root mean square.
    pub rms: f64,
    /// 95th percentile of the magnitudes.
    pub p95: f64,
    /// Ends of the middle 99.7 %.
    pub range: [f64; 2],
}

impl Spread {
    fn of(mut distances: Vec<f64>) -> Self {
        const TAIL: f64 = 0.0015;
        let n = distances.len();
        if n == 0 {
            return Self::default();
        }
        let mean = distances.iter().sum::<f64>() / n as f64;
        let rms = (distances.iter().map(|d| d * d).sum::<f64>() / n as f64).sqrt();
        let mut sizes: Vec<f64> = distances.iter().map(|d| d.abs()).collect();
        let p95 = stats::quantile(&mut sizes, 0.95).unwrap_or(0.0);
        let mut end = |q| stats::quantile(&mut distances, q).unwrap_or(0.0);
        let range = [end(TAIL), end(1.0 - TAIL)];
        Self { n_points: n, mean, rms, p95, range }
    }
}

/// A face of the model and what was seen of it.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceCheck {
    /// Its place in the model's list.
    pub face: u32,
    /// How much of it was seen.
    pub coverage: Coverage,
    /// Distances of its vertices; `None` when none shows it clear of its edges.
    pub spread: Option<Spread>,
    /// The largest distance of a mean over a cell of vertices, and the standard uncertainty of such a mean.
    pub profile: Option<[f64; 2]>,
    /// What holds of all of it; `None` without a tolerance. What was not seen never passes.
    pub verdict: Option<Verdict>,
}

impl FaceCheck {
    /// Share of a face that must be seen for what was seen to stand for it.
    pub const ENOUGH: f64 = 0.5;

    /// One word: `seen`, `partly` (less than half), `unobserved`, or `absent`: the scan shows that it is not there.
    pub fn state(&self) -> &'static str {
        const NOTHING: f64 = 0.02;
        if self.is_absent() {
            "absent"
        } else if self.coverage.seen < NOTHING {
            "unobserved"
        } else if self.coverage.seen < Self::ENOUGH {
            "partly"
        } else {
            "seen"
        }
    }

    /// Whether most of it was not seen and the scan shows why.
    pub fn is_absent(&self) -> bool {
        const SEEN: f64 = 0.3;
        const SHOWN: f64 = 0.4;
        self.coverage.seen < SEEN && self.coverage.absent > SHOWN * (1.0 - self.coverage.seen)
    }
}

/// All vertices on the model that are clear of edges.
pub(super) fn overall(sightings: &Sightings) -> Spread {
    let inner = sightings.of_vertex.iter().flatten().filter(|s| !s.at_border);
    Spread::of(inner.map(|s| s.distance).collect())
}

/// One per face.
pub(super) fn of_faces(
    target: &Target,
    part: &Part,
    alignment: &Alignment,
    sightings: &Sightings,
    coverage: Vec<Coverage>,
    features: &[Feature],
    options: &Options,
) -> Vec<FaceCheck> {
    let seen = sightings.by_face(target.model.faces.len());
    let of_face = |(f, (coverage, seen)): (usize, (Coverage, Vec<Sighting>))| {
        let spread = (!seen.is_empty()).then(|| Spread::of(seen.iter().map(|s| s.distance).collect()));
        let noise = features.iter().find(|x| x.face == f as u32).map_or(alignment.sigma, |x| x.rms);
        let profile = profile(&seen, part.tolerances.spacing(), noise, alignment);
        let mut face = FaceCheck { face: f as u32, coverage, spread, profile: None, verdict: None };
        face.profile = profile.as_ref().map(|p| [p.largest, p.uncertainty]);
        face.verdict = options.tolerance.map(|tolerance| verdict(&face, profile.as_ref(), tolerance));
        face
    };
    coverage.into_iter().zip(seen).enumerate().map(of_face).collect()
}

/// Means of a face's distances over cells.
struct Profile {
    largest: f64,
    /// Of such a mean, noise and placement.
    uncertainty: f64,
    /// How much noise alone raises the largest of so many.
    raised: f64,
}

fn profile(seen: &[Sighting], spacing: f64, noise: f64, alignment: &Alignment) -> Option<Profile> {
    const CELL: f64 = 6.0;
    const LEAST: usize = 12;
    let cell = |p: &Point3| [p.x, p.y, p.z].map(|x| (x / (CELL * spacing)).floor() as i64);
    let mut keyed: Vec<([i64; 3], &Sighting)> = seen.iter().map(|s| (cell(&s.foot), s)).collect();
    keyed.sort_by_key(|a| a.0);
    let cells: Vec<&[([i64; 3], &Sighting)]> = keyed.chunk_by(|a, b| a.0 == b.0).collect();
    let full: Vec<_> = cells.iter().filter(|c| c.len() >= LEAST).collect();
    // A small face is one cell.
    let cells: Vec<&[_]> =
        if full.is_empty() { vec![&keyed[..]] } else { full.into_iter().copied().collect() };
    let mean = |c: &&[([i64; 3], &Sighting)]| c.iter().map(|s| s.1.distance).sum::<f64>() / c.len() as f64;
    let worst =
        cells.iter().filter(|c| !c.is_empty()).max_by(|a, b| mean(a).abs().total_cmp(&mean(b).abs()))?;
    let (place, normal) = (worst[0].1.foot, worst[0].1.normal);
    let own = noise * (alignment.vertices_per_sample / worst.len() as f64).min(1.0).sqrt();
    let uncertainty = own.hypot(alignment.uncertainty_at(&place, &normal));
    let raised = own * (2.0 * (cells.len() as f64).ln()).sqrt();
    Some(Profile { largest: mean(worst), uncertainty, raised })
}

fn verdict(face: &FaceCheck, profile: Option<&Profile>, tolerance: f64) -> Verdict {
    if face.is_absent() {
        return Verdict::Fail;
    }
    let Some(profile) = profile else { return Verdict::Undecided };
    let size = profile.largest.abs();
    let guard = GUARD * profile.uncertainty;
    if size - guard - profile.raised > tolerance {
        Verdict::Fail
    } else if size + guard <= tolerance && face.coverage.seen >= FaceCheck::ENOUGH {
        Verdict::Pass
    } else {
        Verdict::Undecided
    }
}
