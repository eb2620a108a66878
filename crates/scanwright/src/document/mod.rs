//! The result as a document for people: HTML in one file, Markdown, or CSV.
//!
//! A document is composed once, of sections whose cells are finished text, and written three ways: the same numbers
//! stand everywhere. What it says comes from `PART.json` alone, read back, also when the result is still in memory; the
//! [`Scene`] adds meshes for pictures, which only HTML has. Texts that come from files are escaped where they are
//! written. There is no date in it: the same result is the same bytes.

mod chart;
mod labels;
mod number;
mod page;
mod part;
mod pictures;
mod scene;
mod section;
mod unseen;
mod write;

pub use part::{Part, PartError};
pub use scene::{ScanInput, Scene};

use page::Document;
use pictures::Pictures;

/// What a document is made of.
#[derive(Debug, Clone, Copy)]
pub struct Input<'a> {
    /// The result.
    pub part: &'a Part,
    /// Name of the part, for the title.
    pub name: &'a str,
    /// Meshes for pictures.
    pub scene: &'a Scene,
    /// Pixels of pictures per inch of an A4 page; [`DOTS_PER_INCH`] if in doubt.
    pub dots_per_inch: usize,
}

/// Sharp on paper, and pages of a few megabytes.
pub const DOTS_PER_INCH: usize = 200;

/// What a document is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// One file with its pictures in it, to read on a screen or print on A4.
    Html,
    /// Tables and text without pictures.
    Markdown,
    /// The tables one after the other (RFC 4180); the first cell of a row is the name of its table.
    Csv,
}

/// The text of the document.
pub fn write(input: &Input, format: Format) -> String {
    let pictures = match format {
        Format::Html => Pictures::draw(input),
        Format::Markdown | Format::Csv => Pictures::default(),
    };
    let made_by = match input.part.version.as_str() {
        "" => "scanwright".to_owned(),
        version => format!("scanwright {version}"),
    };
    let of = input.part.source().map_or_else(String::new, |source| format!(" of the scan {}", source.file));
    let document = Document {
        title: input.name.to_owned(),
        subtitle: format!("Reconstruction{of} by {made_by}; lengths in {}", input.part.unit()),
        sections: section::all(input, &pictures),
    };
    match format {
        Format::Html => write::html(&document),
        Format::Markdown => write::markdown(&document),
        Format::Csv => write::csv(&document),
    }
}
