//! The three ways a document is written.

mod base64;
mod csv;
mod html;
mod markdown;

pub(super) use csv::csv;
pub(super) use html::{escaped, html};
pub(super) use markdown::markdown;
