//! Part 21 text of solids: AP242, or AP214 on request.
//!
//! Own text from the flat B-rep, one entity per line, numbered in order of writing. One `EDGE_CURVE` per edge, always
//! with its curve; senses live in `ORIENTED_EDGE` and `same_sense`. ISO 10303-21 (clear text), 10303-42 (geometry and
//! topology), 10303-46 (colours). The uncertainty written is the largest gap the solids have.

mod assembly;
mod entities;
mod product;
pub mod read;

pub use assembly::{AssemblyError, Component, write_assembly};
pub use product::write;

/// The application protocol of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Schema {
    /// Managed model-based 3D engineering, edition 1.
    #[default]
    Ap242,
    /// Automotive design, for older readers.
    Ap214,
}

/// Unit of all lengths in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LengthUnit {
    /// Millimetre.
    #[default]
    Millimetre,
    /// Centimetre.
    Centimetre,
    /// Metre.
    Metre,
    /// Inch.
    Inch,
    /// Foot.
    Foot,
    /// Thousandth of a millimetre.
    Micrometre,
}

impl LengthUnit {
    /// Its length in millimetres.
    pub fn millimetres(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Metre => 1000.0,
            Self::Inch => 25.4,
            Self::Foot => 304.8,
            Self::Micrometre => 1e-3,
        }
    }
}

/// How a file is written.
#[derive(Debug, Clone, PartialEq)]
pub struct StepOptions {
    /// Application protocol; AP242 by default.
    pub schema: Schema,
    /// Unit of the solids' lengths; millimetre by default.
    pub unit: LengthUnit,
    /// Name of the product; "part" by default.
    pub name: String,
    /// Time stamp in the header, fixed so that the same input gives the same bytes.
    pub time_stamp: String,
    /// Whether faces are coloured by type; true by default.
    pub colors: bool,
}

impl Default for StepOptions {
    fn default() -> Self {
        Self {
            schema: Schema::default(),
            unit: LengthUnit::default(),
            name: "part".into(),
            time_stamp: "2000-01-01T00:00:00".into(),
            colors: true,
        }
    }
}
