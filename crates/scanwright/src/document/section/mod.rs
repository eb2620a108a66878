//! The sections of a document, in the order in which they are read.

mod deviation;
mod dimensions;
mod frame;
mod overview;
mod primitives;
mod relations;
mod reproduce;
mod substitutes;
mod verdict;
mod weak;

pub(super) use weak::{WeakPlace, Weakness, weak_places};

use super::Input;
use super::page::{Reference, Section};
use super::part::Part;
use super::pictures::Pictures;

/// All sections.
pub(super) fn all(input: &Input, pictures: &Pictures) -> Vec<Section> {
    let part = input.part;
    let places = weak_places(part);
    let mut sections = vec![
        verdict::section(part, &places),
        overview::section(part, pictures),
        dimensions::section(part),
        primitives::section(part),
        relations::section(part),
        deviation::section(part, pictures),
        weak::section(part, &places, pictures),
        substitutes::section(part),
    ];
    sections.extend(frame::section(part));
    sections.push(reproduce::section(part));
    sections
}

/// Regions by their ids.
fn references(part: &Part, ids: &[u32]) -> Vec<Reference> {
    ids.iter().map(|&id| reference(part, id)).collect()
}

fn reference(part: &Part, id: u32) -> Reference {
    Reference { id, name: part.name_of(id), listed: part.primitive(id).is_some() }
}

/// A stable name such as `axis_distance` for people.
fn spoken(name: &str) -> String {
    name.replace('_', " ")
}
