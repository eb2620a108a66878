use super::super::chart;
use super::super::number::{counted, percent, short, trimmed};
use super::super::page::{Block, Cell, Chart, Column, Row, Section, Table};
use super::super::part::Part;
use super::super::pictures::Pictures;
use crate::deviation::{Histogram, LimitFrom};

/// Where the scan lies off the part.
pub fn section(part: &Part, pictures: &Pictures) -> Section {
    let mut blocks = Vec::new();
    let Some(deviation) = &part.deviation else {
        blocks.push(Block::Text("Without a solid there is nothing to compare the scan with.".to_owned()));
        return Section { title: "Deviation", anchor: "deviation", blocks };
    };
    let unit = part.unit();
    let numbers = [
        ("root mean square", short(deviation.rms), unit),
        ("95 % of the points within", short(deviation.p95), unit),
        ("largest", short(deviation.max), unit),
        ("within three sigma of the noise", percent(deviation.within_three_noise), "%"),
        ("sigma of the scanner's noise", short(part.scan.noise), unit),
    ];
    let row = |(what, value, unit): (&str, String, &str)| {
        Row::new(vec![what.into(), Cell::Text(value), Cell::Text(unit.to_owned())])
    };
    let columns = vec![Column::words("Deviation"), Column::number("Value", ""), Column::words("Unit")];
    let rows = numbers.into_iter().map(row).collect();
    blocks.push(Block::Text(
        "Signed distance of the scan's vertices from the solid, positive outside the material; the table is left out."
            .to_owned(),
    ));
    blocks.push(Block::Table(Table { name: "deviation", columns, rows, empty: String::new() }));
    let histogram =
        deviation.histogram.as_ref().filter(|h| chart::can_show(h)).or(pictures.histogram.as_ref());
    if let Some(histogram) = histogram {
        let svg = chart::histogram(histogram, unit);
        blocks.push(Block::Chart(Chart { svg, caption: caption(part, histogram) }));
    }
    if let Some(views) = &pictures.deviation {
        blocks.push(Block::Figures(views.clone()));
    }
    if let Some(missing) = pictures.missing.as_ref().filter(|_| pictures.deviation.is_none()) {
        blocks.push(Block::Text(missing.clone()));
    }
    Section { title: "Deviation", anchor: "deviation", blocks }
}

fn caption(part: &Part, histogram: &Histogram) -> String {
    let unit = part.unit();
    let limit = trimmed(&short(Some(histogram.limit)));
    let why = match histogram.limit_from {
        LimitFrom::Noise => "three standard deviations of the scanner's noise, rounded up",
        LimitFrom::Percentile => {
            "the 95th percentile of the deviations, rounded up, which is more than three standard deviations of the \
             scanner's noise"
        }
    };
    let beyond = histogram.below + histogram.above;
    format!(
        "One scale for the histogram and every view: it ends at ±{limit} {unit}, {why}. Blue is inside the material, \
         orange outside. {} of {} lie beyond the scale and have the dark colors of its ends.",
        counted(beyond, "point"),
        super::super::number::count(histogram.total()),
    )
}
