use std::path::Path;

use scanwright::io::{self, ScanFile};

use crate::args::Unit;
use crate::exit::Failure;

/// Reads a scan, or says in one line why not.
pub fn read(path: &Path) -> Result<ScanFile, Failure> {
    io::read_mesh_file(path).map_err(|error| Failure::input(path, error))
}

/// The unit of a scan's coordinates and who said so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// Name, as `--units` takes it where it can.
    pub name: &'static str,
    /// Length in millimetres.
    pub millimetres: f64,
    /// Who said so.
    pub source: UnitSource,
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
    if let Some(unit) = flag {
        return Units { name: unit.name(), millimetres: unit.millimetres(), source: UnitSource::Flag };
    }
    let source = if declared.is_some() { UnitSource::File } else { UnitSource::Assumed };
    let unit = declared.unwrap_or(io::Unit::Millimeter);
    Units { name: unit_name(unit), millimetres: unit.millimeters(), source }
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
