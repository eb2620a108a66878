use super::super::page::{Block, Section};
use super::super::part::Part;
use super::super::pictures::Pictures;

/// The scan beside the part.
pub fn section(part: &Part, pictures: &Pictures) -> Section {
    let mut blocks = Vec::new();
    if let Some(figures) = &pictures.overview {
        blocks.push(Block::Figures(figures.clone()));
    }
    if let Some(missing) = &pictures.missing {
        blocks.push(Block::Text(missing.clone()));
    }
    if !pictures.unread.is_empty() {
        blocks.push(Block::Text(
            "Of the model, the following could not be read and is not in the pictures:".to_owned(),
        ));
        blocks.push(Block::List(pictures.unread.clone()));
    }
    if let Some(support) = &part.support {
        let n =
            support.triangles.map_or_else(|| "An unknown number of".to_owned(), super::super::number::count);
        blocks.push(Block::Text(format!(
            "{n} triangles of a supporting table were recognized and taken away."
        )));
    }
    Section { title: "Scan and part", anchor: "part", blocks }
}
