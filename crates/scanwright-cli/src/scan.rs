use std::path::Path;

use scanwright::io::{self, ReadError, ScanFile};
use scanwright::step::LengthUnit;

use crate::args::Unit;
use crate::exit::Failure;

/// Reads a scan, or says in one line why not.
pub fn read(path: &Path) -> Result<ScanFile, Failure> {
    io::read_mesh_file(path).map_err(|error| match error {
        // The path is said already.
        ReadError::File { source, .. } => Failure::input(path, format!("cannot be read: {source}")),
        other => Failure::input(path, other),
    })
}

/// The unit of a scan's coordinates and who said so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// The unit.
    pub unit: io::Unit,
    /// Who said so.
    pub source: UnitSource,
}

impl Units {
    /// Abbreviation.
    pub fn name(self) -> &'static str {
        unit_name(self.unit)
    }

    /// The unit as STEP knows it.
    pub fn in_step(self) -> LengthUnit {
        match self.unit {
            io::Unit::Micron => LengthUnit::Micrometre,
            io::Unit::Millimeter => LengthUnit::Millimetre,
            io::Unit::Centimeter => LengthUnit::Centimetre,
            io::Unit::Meter => LengthUnit::Metre,
            io::Unit::Inch => LengthUnit::Inch,
            io::Unit::Foot => LengthUnit::Foot,
        }
    }
}

/// Who said what the unit is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitSource {
    /// The command line.
    Flag,
    /// The file.
    File,
    /// Nobody.
    Assumed,
}

impl UnitSource {
    /// Name for files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flag => "flag",
            Self::File => "file",
            Self::Assumed => "assumed",
        }
    }
}

/// The unit: the flag's, else the file's, else millimetres.
pub fn units(flag: Option<Unit>, declared: Option<io::Unit>) -> Units {
    let of_flag = flag.map(|flag| match flag {
        Unit::Mm => io::Unit::Millimeter,
        Unit::Cm => io::Unit::Centimeter,
        Unit::M => io::Unit::Meter,
        Unit::In => io::Unit::Inch,
    });
    let source = match (of_flag, declared) {
        (Some(_), _) => UnitSource::Flag,
        (None, Some(_)) => UnitSource::File,
        (None, None) => UnitSource::Assumed,
    };
    Units { unit: of_flag.or(declared).unwrap_or(io::Unit::Millimeter), source }
}

/// Abbreviation of a unit.
pub fn unit_name(unit: io::Unit) -> &'static str {
    match unit {
        io::Unit::Micron => "um",
        io::Unit::Millimeter => "mm",
        io::Unit::Centimeter => "cm",
        io::Unit::Inch => "in",
        io::Unit::Foot => "ft",
        io::Unit::Meter => "m",
    }
}

/// Name of a format, for people.
pub fn format_name(format: io::Format) -> &'static str {
    match format {
        io::Format::StlBinary => "binary STL",
        io::Format::StlAscii => "text STL",
        io::Format::Ply => "PLY",
        io::Format::Obj => "OBJ",
        io::Format::Off => "OFF",
        io::Format::ThreeMf => "3MF",
    }
}
