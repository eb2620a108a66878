//! What a database holds, as text: the same manifest gives the same bytes.

use serde::{Deserialize, Serialize};

use super::mesher::Triangulation;
use super::noise::Noise;
use super::shape::Class;

/// The recipe of a database.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Seed of all draws.
    pub seed: u64,
    /// Share of the shapes that are partial, 0 to 1; planes are never.
    pub partial: f64,
    /// Copies of each shape that differ in resolution, triangulation, noise, pose and side.
    pub copies: u32,
    /// Edge lengths to draw from, as numbers of edges along the square root of the area.
    pub resolutions: Vec<u32>,
    /// Triangulations to draw from.
    pub triangulations: Vec<Triangulation>,
    /// Noise to draw from.
    pub noises: Vec<Noise>,
    /// Whether models are turned, moved, and turned inside out; else they stand at the origin.
    pub posed: bool,
    /// Number of shapes per class.
    pub shapes: Vec<ClassCount>,
    /// Ranges of the parameters.
    pub ranges: Ranges,
}

/// How many shapes of a class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassCount {
    /// The class.
    pub class: Class,
    /// Number of shapes.
    pub count: u32,
}

/// Ranges of the parameters: lengths in millimetres, angles in degrees, for people write manifests. Lengths and ratios are
/// drawn uniformly in their logarithm, angles uniformly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ranges {
    /// Width of planes.
    pub plane_width: [f64; 2],
    /// Length over width of planes.
    pub plane_aspect: [f64; 2],
    /// Radius of spheres, cylinders, and cones at their base.
    pub radius: [f64; 2],
    /// Height over radius of cylinders.
    pub cylinder_height: [f64; 2],
    /// Half-angle of cones.
    pub half_angle_deg: [f64; 2],
    /// Part of a cone's height that is cut off at its tip.
    pub truncation: [f64; 2],
    /// Radius of a torus's tube.
    pub minor_radius: [f64; 2],
    /// Major over minor radius.
    pub torus_ratio: [f64; 2],
    /// Sweep of partial cylinders, cones and tori.
    pub sweep_deg: [f64; 2],
    /// Half-angle of caps of spheres.
    pub cap_deg: [f64; 2],
    /// Arc of a partial torus's tube.
    pub tube_arc_deg: [f64; 2],
}

impl Default for Ranges {
    fn default() -> Self {
        Self {
            plane_width: [5.0, 200.0],
            plane_aspect: [1.0, 8.0],
            radius: [1.0, 100.0],
            cylinder_height: [0.2, 10.0],
            half_angle_deg: [2.0, 80.0],
            truncation: [0.0, 0.95],
            minor_radius: [0.5, 40.0],
            torus_ratio: [1.1, 20.0],
            sweep_deg: [20.0, 360.0],
            cap_deg: [15.0, 90.0],
            tube_arc_deg: [45.0, 360.0],
        }
    }
}

/// Lengths and ratios that a manifest may ask for.
const LENGTHS: (f64, f64) = (1e-3, 1e4);
/// Models that a manifest may ask for.
const MOST_MODELS: u64 = 10_000_000;

/// Ready-made manifests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tier {
    /// What the thesis's database is known to hold: structured grids without noise, 200 models per class, about half of
    /// them partial, but for planes.
    Faithful,
    /// 20 000 models of every resolution, triangulation and noise, with a class of other surfaces.
    Hard,
    /// What normals cannot tell apart: cones of less than 2 degrees, small pieces of spheres and of tori thin as wire.
    Ambiguous,
}

impl Manifest {
    /// A ready-made manifest.
    pub fn of_tier(tier: Tier) -> Self {
        let counts = |classes: &[Class], count| {
            classes.iter().map(|&class| ClassCount { class, count }).collect::<Vec<_>>()
        };
        let faithful = Self {
            seed: 2015,
            partial: 0.5,
            copies: 1,
            resolutions: vec![32, 64],
            triangulations: vec![Triangulation::Grid],
            noises: vec![Noise::None],
            posed: true,
            shapes: counts(&Class::PRIMITIVES, 200),
            // From ten degrees on a cone's normals part from a cylinder's.
            ranges: Ranges { half_angle_deg: [10.0, 80.0], sweep_deg: [60.0, 330.0], ..Ranges::default() },
        };
        match tier {
            Tier::Faithful => faithful,
            Tier::Hard => Self {
                copies: 5,
                resolutions: vec![8, 16, 32, 64, 128],
                triangulations: Triangulation::ALL.to_vec(),
                noises: Noise::all(),
                shapes: [counts(&Class::PRIMITIVES, 700), counts(&Class::OTHERS, 100)].concat(),
                ranges: Ranges::default(),
                ..faithful
            },
            Tier::Ambiguous => Self {
                shapes: counts(&[Class::Cone, Class::Sphere, Class::Torus], 100),
                partial: 1.0,
                ranges: Ranges {
                    half_angle_deg: [0.2, 2.0],
                    cap_deg: [3.0, 10.0],
                    torus_ratio: [15.0, 40.0],
                    ..Ranges::default()
                },
                ..faithful
            },
        }
    }

    /// Number of models.
    pub fn n_models(&self) -> usize {
        self.shapes.iter().map(|s| s.count as usize).sum::<usize>() * self.copies as usize
    }

    /// What is wrong with it, if anything: the field and why.
    pub fn problem(&self) -> Option<String> {
        let ranges = &self.ranges;
        let lengths = [
            ("plane_width", ranges.plane_width),
            ("plane_aspect", ranges.plane_aspect),
            ("radius", ranges.radius),
            ("cylinder_height", ranges.cylinder_height),
            ("minor_radius", ranges.minor_radius),
            ("torus_ratio", ranges.torus_ratio),
        ];
        let angles = [
            ("half_angle_deg", ranges.half_angle_deg, 89.0),
            ("sweep_deg", ranges.sweep_deg, 360.0),
            ("cap_deg", ranges.cap_deg, 180.0),
            ("tube_arc_deg", ranges.tube_arc_deg, 360.0),
        ];
        let bad_length =
            lengths.iter().find(|(_, [low, high])| !(LENGTHS.0 <= *low && low <= high && *high <= LENGTHS.1));
        let bad_angle =
            angles.iter().find(|(_, [low, high], most)| !(0.0 < *low && low <= high && high <= most));
        let [low, high] = ranges.truncation;
        if let Some((name, _)) = bad_length {
            return Some(format!(
                "ranges.{name}: two numbers from {:e} to {:e}, the smaller first, are needed",
                LENGTHS.0, LENGTHS.1
            ));
        }
        if let Some((name, _, most)) = bad_angle {
            return Some(format!(
                "ranges.{name}: two angles above 0 and up to {most}, the smaller first, are needed"
            ));
        }
        if !(0.0 <= low && low <= high && high < 1.0) {
            return Some("ranges.truncation: two shares from 0 and below 1 are needed".into());
        }
        if ranges.torus_ratio[0] <= 1.0 {
            return Some("ranges.torus_ratio: a ring is needed, with ratios above 1".into());
        }
        if !(0.0..=1.0).contains(&self.partial) {
            return Some("partial: a share from 0 to 1 is needed".into());
        }
        let n =
            self.shapes.iter().map(|s| u64::from(s.count)).sum::<u64>().saturating_mul(self.copies.into());
        if !(1..=MOST_MODELS).contains(&n) {
            return Some(format!("copies, shapes: 1 to {MOST_MODELS} models are needed, not {n}"));
        }
        let mut classes: Vec<Class> = self.shapes.iter().map(|s| s.class).collect();
        classes.sort_unstable();
        if let Some(twice) = classes.windows(2).find(|pair| pair[0] == pair[1]) {
            return Some(format!("shapes: {} is there twice", twice[0].name()));
        }
        if let Some(problem) = self.noises.iter().find_map(|noise| noise.problem()) {
            return Some(format!("noises: {problem}"));
        }
        if self.resolutions.iter().any(|r| !(2..=1024).contains(r)) || self.resolutions.is_empty() {
            return Some("resolutions: numbers from 2 to 1024 are needed".into());
        }
        if self.triangulations.is_empty() || self.noises.is_empty() {
            return Some("triangulations, noises: at least one of each is needed".into());
        }
        None
    }
}
