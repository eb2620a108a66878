//! Relations as what a reader may check: what was found, how far from it each face was, and what making it exact cost.

use serde::{Deserialize, Serialize};

use crate::tolerance::Tolerances;

/// What is equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RelationKind {
    /// Directions: normals of planes, axes of cylinders, cones and tori.
    Parallel,
    /// Two directions at a right angle.
    Perpendicular,
    /// Two directions at a multiple of 15 degrees that is no right angle.
    CommonAngle,
    /// Axes, and centres of spheres, on one line.
    Coaxial,
    /// Planes that are one.
    Coplanar,
    /// Radii of cylinders or of spheres, all bosses or all bores.
    EqualRadius,
    /// Half-angles of cones.
    EqualHalfAngle,
    /// Radii of the spines of tori.
    EqualMajorRadius,
    /// Radii of the tubes of tori.
    EqualMinorRadius,
    /// Axes that meet in a point.
    Intersecting,
    /// Axes evenly around a circle; the last may be the axis in its middle.
    CircularPattern,
    /// Axes evenly along a row.
    EqualSpacing,
    /// Four axes at the corners of a rectangle.
    RectangularPattern,
}

/// A relation that was found, or asked for, with its certificate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Relation {
    /// What is equal.
    pub kind: RelationKind,
    /// The primitives, by number; of an angle the best seen of each of the two directions.
    pub of: Vec<u32>,
    /// The common angle between the lines of two directions, radians; `None` for what has none.
    pub angle: Option<f64>,
    /// Largest deviation of a member from what became common, in standard uncertainties of both, what manufacture may
    /// deviate by among them.
    pub z: f64,
    /// The same without what manufacture may deviate by.
    pub z_statistical: f64,
    /// Largest turn of a member, radians.
    pub turn: f64,
    /// Largest motion of a member's place or change of its size, length; of half-angles, radians.
    pub shift: f64,
    /// Largest root mean square distance of a member's points before it, length.
    pub before: f64,
    /// The same after all relations.
    pub after: f64,
    /// Whether it was made exact.
    pub accepted: bool,
    /// Why not.
    pub reason: Option<String>,
}

/// A relation that a user asks for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Listed {
    /// What shall be equal.
    pub kind: RelationKind,
    /// The primitives, by number.
    pub of: Vec<u32>,
    /// Of a common angle: how large it shall be, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees: Option<f64>,
}

/// Which relations are made exact.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Relations {
    /// Those that the scan speaks for.
    #[default]
    Auto,
    /// None.
    Off,
    /// These, whether the scan speaks for them or not; a primitive whose points refuse still takes no part.
    Listed(Vec<Listed>),
}

/// What real faces deviate by from their design, by how they were made: one standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Manufacture {
    /// Of places and radii, length.
    pub length: f64,
    /// Of directions and half-angles, radians.
    pub angle: f64,
}

impl Default for Manufacture {
    /// No length, which has a unit; of angles what milled and printed faces keep.
    fn default() -> Self {
        Self { length: 0.0, angle: Tolerances::FORM_ANGLE }
    }
}
