use super::super::number::{
    UNKNOWN, deviations, percent, plain_count, short, significant, trimmed, with_uncertainty,
};
use super::super::page::{Block, Cell, Column, Level, Row, Section, Table};
use super::super::part::{Dimension, Nominal, Part, Quantity};
use super::{references, spoken};

/// Expanded by this factor, a standard uncertainty covers 95 % of a normal distribution (95.45 %).
const COVERAGE_FACTOR: f64 = 2.0;

const DISTANCES: &[&str] = &["distance", "axis_distance", "axis_to_plane", "depth", "thickness", "width"];

/// Dimensions are shown in these groups.
const GROUPS: [(&str, &str, &[&str]); 4] = [
    ("Radii and diameters", "sizes", &["radius", "diameter", "major_radius", "minor_radius"]),
    ("Angles", "angles", &[]),
    ("Distances, depths, widths and thicknesses", "distances", DISTANCES),
    ("Other dimensions", "others", &[]),
];

/// Every dimension with its uncertainty, what it rests on, and the nominal value offered.
pub fn section(part: &Part) -> Section {
    let dimensions = part.all_dimensions();
    let mut blocks = vec![Block::Text(
        "U95 is the expanded uncertainty U = 2u (coverage factor k = 2): the true value lies within ±U95 with a \
         probability of about 95 %. Values are rounded to the second digit of their U95. Arc, area and triangles are \
         what was seen of the faces behind a dimension."
            .to_owned(),
    )];
    if part.dimensions.is_none() {
        blocks.push(Block::Text(
            "This result lists no dimensions of its own; these are the sizes of its primitives. Arcs, guesses and \
             nominal values are not known."
                .to_owned(),
        ));
    }
    let mut any = false;
    for (group, (heading, name, _)) in GROUPS.iter().enumerate() {
        let members: Vec<&Dimension> = dimensions.iter().filter(|d| group_of(d) == group).collect();
        if !members.is_empty() {
            any = true;
            blocks.push(Block::Heading((*heading).to_owned()));
            blocks.push(Block::Table(table(part, name, &members)));
        }
    }
    if !any {
        blocks.push(Block::Text(
            "No dimension was found: the part is made of planes or of no surface.".to_owned(),
        ));
    }
    Section { title: "Dimensions", anchor: "dimensions", blocks }
}

/// The group of a dimension, an index into [`GROUPS`].
fn group_of(dimension: &Dimension) -> usize {
    if dimension.quantity == Quantity::Angle {
        return 1;
    }
    GROUPS.iter().position(|(_, _, kinds)| kinds.contains(&dimension.kind.as_str())).unwrap_or(3)
}

/// `members` are all lengths or all angles.
fn table(part: &Part, name: &'static str, members: &[&Dimension]) -> Table {
    let unit = if members[0].quantity == Quantity::Angle { "°" } else { part.unit() };
    let mut columns = vec![
        Column::words("Dimension"),
        Column::words("Of"),
        Column::number("Value", unit),
        Column::number("± U95", unit),
        Column::number("Arc", "°"),
        Column::number("Area", &format!("{}²", part.unit())),
        Column::number("Triangles", ""),
    ];
    let offered = members.iter().any(|dimension| dimension.nominal.is_some());
    if offered {
        columns.extend([
            Column::number("Nominal", unit),
            Column::number("Value - nominal", unit),
            Column::words("Nominal from"),
        ]);
    }
    columns.extend([Column::words("Decided by"), Column::words("Remark")]);
    let rows = members.iter().map(|dimension| row(part, dimension, offered)).collect();
    Table { name, columns, rows, empty: String::new() }
}

fn row(part: &Part, dimension: &Dimension, offered: bool) -> Row {
    let scale = if dimension.quantity == Quantity::Angle { 180.0 / std::f64::consts::PI } else { 1.0 };
    let u95 = dimension.uncertainty.map(|u| COVERAGE_FACTOR * u * scale);
    let (value, expanded) = with_uncertainty(dimension.value.map(|v| v * scale), u95);
    let evidence = dimension.evidence.clone().unwrap_or_default();
    let kind = match dimension.id {
        Some(id) => format!("{} [{id}]", spoken(&dimension.kind)),
        None => spoken(&dimension.kind),
    };
    let mut cells: Vec<Cell> = vec![
        kind.into(),
        Cell::Regions(references(part, &dimension.of)),
        value.into(),
        expanded.into(),
        evidence.arc.map_or_else(|| UNKNOWN.to_owned(), |arc| format!("{:.0}", arc.to_degrees())).into(),
        short(evidence.area).into(),
        plain_count(evidence.triangles).into(),
    ];
    if offered {
        cells.extend(nominal_cells(dimension, scale, u95));
    }
    cells.push(decided_by(part, dimension).into());
    cells.push(remark(dimension).into());
    let level = dimension.guess.as_ref().map(|_| Level::Look);
    Row { level, ..Row::new(cells) }
}

fn nominal_cells(dimension: &Dimension, scale: f64, u95: Option<f64>) -> [Cell; 3] {
    let Some(nominal) = &dimension.nominal else { return [UNKNOWN.into(), UNKNOWN.into(), UNKNOWN.into()] };
    let value = nominal.value.map(|v| v * scale);
    let difference = dimension.value.zip(nominal.value).map(|(value, nominal)| (value - nominal) * scale);
    let (difference, _) = with_uncertainty(difference, u95);
    // A nominal value is exact: its own digits, no rounding by the measurement.
    [trimmed(&significant(value, 9)).into(), signed(difference).into(), nominal.grid.clone().into()]
}

fn signed(text: String) -> String {
    let positive =
        text.starts_with(|c: char| c.is_ascii_digit()) && text.chars().any(|c| ('1'..='9').contains(&c));
    if positive { format!("+{text}") } else { text }
}

fn decided_by(part: &Part, dimension: &Dimension) -> String {
    match &dimension.nominal {
        Some(Nominal { applied: true, .. }) => "nominal, applied by --snap".to_owned(),
        _ => match part.known.iter().find(|known| known.taken && dimension.of == [known.id]) {
            Some(known) => format!("database entry {}", known.name),
            None => "measurement".to_owned(),
        },
    }
}

fn remark(dimension: &Dimension) -> String {
    let guess = dimension.guess.iter().map(|why| format!("guess: {why}"));
    let nominal = dimension.nominal.iter().flat_map(|nominal| {
        let off = nominal.z.map(|z| format!("nominal {} u away", deviations(Some(z))));
        let chance = nominal.coincidence.map(|p| format!("coincidence {} %", percent(Some(p))));
        [off, chance, nominal.why.clone()].into_iter().flatten()
    });
    guess.chain(nominal).collect::<Vec<_>>().join("; ")
}
