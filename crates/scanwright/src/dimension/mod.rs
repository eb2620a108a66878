//! Dimensions of a part: sizes of its faces and distances and angles between them, each with its standard uncertainty and
//! what it rests on.
//!
//! `sizes` are diameters, radii and angles of single faces; `distances` lie between parallel planes and axes, from the
//! largest plane of each direction, as a drawing has them from a datum; `nominal` offers the round value that each may mean.
//! Uncertainties follow from the covariances of the primitives by first-order propagation (JCGM 100:2008, 5.1.2).

mod distances;
mod known;
mod nominal;
mod sizes;
mod snap;
mod tables;

pub use nominal::{Nominal, offer};
pub use snap::snapped;

use serde::Serialize;

use crate::mesh::{Adjacency, Mesh};
use crate::segment::Segmentation;
use crate::uncertainty::Interior;

use known::Known;

/// What a dimension measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DimensionKind {
    /// Of a cylinder or sphere of which more than half was seen.
    Diameter,
    /// Of a cylinder or sphere of which less was seen.
    Radius,
    /// Of a cone, between axis and generator.
    HalfAngle,
    /// Of the spine of a torus.
    MajorRadius,
    /// Of the tube of a torus.
    MinorRadius,
    /// Of two parallel planes, the first the largest of its direction.
    Distance,
    /// Of two parallel planes with material between them.
    Thickness,
    /// Of two parallel planes with a gap between them.
    Width,
    /// From the plane that a bore opens in to its floor.
    Depth,
    /// Of two parallel axes.
    AxisDistance,
    /// From a plane to an axis parallel to it.
    AxisToPlane,
    /// Of two planes that touch, or of a plane and an axis: between their normals or directions, at most a right angle.
    Angle,
}

impl DimensionKind {
    /// Whether it is an angle, in radians; else a length.
    pub fn is_angle(self) -> bool {
        matches!(self, Self::HalfAngle | Self::Angle)
    }
}

/// What the number of a dimension is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// In the scan's unit.
    Length,
    /// In radians.
    Angle,
}

/// What was seen of the faces of a dimension.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Seen {
    /// Of the turn of a round face, radians.
    pub arc: Option<f64>,
    /// Area, of the smaller of two faces.
    pub area: f64,
    /// Triangles, of the smaller of two faces.
    pub triangles: usize,
}

/// A dimension of a part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Dimension {
    /// Its place in the list.
    pub id: u32,
    /// What it measures.
    pub kind: DimensionKind,
    /// The primitives, by number.
    pub of: Vec<u32>,
    /// Length, or angle in radians.
    pub value: f64,
    /// Its standard uncertainty.
    pub uncertainty: f64,
    /// Length or angle.
    pub quantity: Quantity,
    /// What it rests on.
    pub evidence: Seen,
    /// Why it is no more than a guess, if so.
    pub guess: Option<String>,
    /// The round value that it may mean, if one is near.
    pub nominal: Option<Nominal>,
}

/// What a scanner may be wrong by as a whole, beside what its noise shows: `offset + share * length`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Systematic {
    /// Standard uncertainty of every length, length.
    pub offset: f64,
    /// And in proportion to it.
    pub share: f64,
}

impl Systematic {
    fn of(&self, length: f64) -> f64 {
        self.offset + self.share * length.abs()
    }
}

/// All dimensions of the part: sizes in the order of the primitives, then distances and angles.
pub fn dimensions(
    mesh: &Mesh,
    adjacency: &Adjacency,
    interior: &Interior,
    segmentation: &Segmentation,
    systematic: &Systematic,
) -> Vec<Dimension> {
    let known = Known::all(mesh, interior, segmentation);
    let neighbors = distances::Neighbors::new(adjacency, segmentation);
    let mut all = sizes::of(&known);
    all.extend(distances::of(&known, &neighbors));
    for (k, dimension) in all.iter_mut().enumerate() {
        dimension.id = k as u32;
        if dimension.quantity == Quantity::Length {
            dimension.uncertainty = dimension.uncertainty.hypot(systematic.of(dimension.value));
        }
        if dimension.guess.is_none() {
            dimension.guess = weak(dimension);
        }
    }
    all
}

/// Why a number so uncertain is a guess.
fn weak(dimension: &Dimension) -> Option<String> {
    /// Half a 95 % interval over a length from which it is a guess, and an angle.
    const SHARE: f64 = 0.1;
    const ANGLE: f64 = 5.0 * std::f64::consts::PI / 180.0;
    let half = 2.0 * dimension.uncertainty;
    match dimension.quantity {
        Quantity::Length if half > SHARE * dimension.value.abs() => {
            let share = 100.0 * half / dimension.value.abs().max(f64::MIN_POSITIVE);
            Some(format!("known within {share:.0} % only"))
        }
        Quantity::Angle if half > ANGLE => {
            Some(format!("known within {:.0} degrees only", half.to_degrees()))
        }
        _ => None,
    }
}

/// A dimension before it has a number.
fn dimension(kind: DimensionKind, of: &[&Known], value: f64, variance: f64) -> Dimension {
    let least = |f: fn(&Known) -> f64| of.iter().map(|known| f(known)).fold(f64::INFINITY, f64::min);
    Dimension {
        id: 0,
        kind,
        of: of.iter().map(|known| known.id).collect(),
        value,
        uncertainty: variance.max(0.0).sqrt(),
        quantity: if kind.is_angle() { Quantity::Angle } else { Quantity::Length },
        evidence: Seen {
            arc: of.iter().filter_map(|known| known.arc).min_by(f64::total_cmp),
            area: least(|known| known.area),
            triangles: least(|known| known.n_triangles as f64) as usize,
        },
        guess: None,
        nominal: None,
    }
}
