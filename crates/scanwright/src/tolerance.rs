//! The lengths and angles that decisions are made with: the only home of thresholds.
//!
//! Three kinds are kept apart: what rounding has cost (`rounding`), what the scanner did (`spacing`, `noise`,
//! `normal_noise`, `edge_rounding`), and what the user allows (`gap`, `angle`).

/// Measured facts of one scan, from which [`Tolerances`] are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Largest absolute coordinate, length.
    pub largest_coordinate: f64,
    /// Diagonal of the bounding box, length.
    pub diagonal: f64,
    /// Mean distance of neighbouring vertices, `sqrt(area / n_vertices)`, length.
    pub spacing: f64,
    /// Standard deviation of the white noise along the normal, length.
    pub noise: f64,
    /// Per-axis standard deviation of triangle normals, radians.
    pub normal_noise: f64,
    /// Standard deviation of the scanner's spot, read from the rounding of sharp edges, length; zero only if unknown.
    pub edge_rounding: f64,
}

/// Thresholds of one model. Made once, in `pipeline`, and passed to every stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    measured: Measured,
    gap: f64,
}

impl Tolerances {
    /// Relative precision of a coordinate stored as `f32`, as most scan files do.
    pub const REL_ROUNDING: f64 = 1.2e-7;
    /// Default largest gap of a solid, as a share of the vertex spacing: far below what the scan can show.
    const GAP_PER_SPACING: f64 = 0.05;

    /// Relative difference up to which numbers that were made equal are still so after arithmetic: a million roundings.
    pub const SAME: f64 = 1e-9;

    /// Radians: standard deviation of a real face's direction from the one its design means, by how it was made: what a
    /// milled or printed face keeps over its size (0.05 degrees). However well a direction was seen, it says no more.
    pub const FORM_ANGLE: f64 = 0.05 * std::f64::consts::PI / 180.0;

    /// Tolerances for a scan with these measured facts; `gap` overrides the largest gap of the solid.
    pub fn new(measured: Measured, gap: Option<f64>) -> Self {
        let rounding = Self::REL_ROUNDING * measured.largest_coordinate;
        // A gap below the rounding of the input could never be met: ten roundings leave room for arithmetic.
        let gap = gap
            .unwrap_or(Self::GAP_PER_SPACING * measured.spacing)
            .max(10.0 * rounding)
            .max(f64::MIN_POSITIVE);
        Self { measured, gap }
    }

    /// The measured facts.
    pub fn measured(&self) -> &Measured {
        &self.measured
    }

    /// Length: what rounding of the file's coordinates may have moved a point. Computed, never set.
    pub fn rounding(&self) -> f64 {
        Self::REL_ROUNDING * self.measured.largest_coordinate
    }

    /// Length: diagonal of the scan's bounding box.
    pub fn diagonal(&self) -> f64 {
        self.measured.diagonal
    }

    /// Length: mean distance of neighbouring vertices.
    pub fn spacing(&self) -> f64 {
        self.measured.spacing
    }

    /// Length: standard deviation of the white noise along the normal.
    pub fn noise(&self) -> f64 {
        self.measured.noise
    }

    /// Radians: per-axis standard deviation of triangle normals.
    pub fn normal_noise(&self) -> f64 {
        self.measured.normal_noise
    }

    /// Length: standard deviation of the scanner's spot; zero when no sharp edge showed it.
    pub fn edge_rounding(&self) -> f64 {
        self.measured.edge_rounding
    }

    /// Length: largest gap that the exported solid may have. Written into STEP.
    pub fn gap(&self) -> f64 {
        self.gap
    }
}
