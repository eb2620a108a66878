use super::super::number::{UNKNOWN, deviations, short, significant};
use super::super::page::{Block, Cell, Column, Row, Section, Table};
use super::super::part::{Part, Relation};
use super::{references, spoken};

/// What was found to belong together, and what was refused.
pub fn section(part: &Part) -> Section {
    let blocks = match &part.relations {
        None => vec![Block::Text("This result lists no relations.".to_owned())],
        Some(relations) => listed(part, relations),
    };
    Section { title: "Relations", anchor: "relations", blocks }
}

fn listed(part: &Part, relations: &[Relation]) -> Vec<Block> {
    let explained = "z is how far the measured surfaces are from the relation in standard uncertainties, with what real \
                     parts deviate from their design; z of the scan alone leaves that out. Shift and turn are the \
                     largest moves that the relation asked of a surface. Before and after are root mean square \
                     distances of its points.";
    let (accepted, refused): (Vec<&Relation>, Vec<&Relation>) = relations.iter().partition(|r| r.accepted);
    let enforced = table(part, "relations", &accepted, false);
    let mut blocks = vec![Block::Text(explained.to_owned()), Block::Table(enforced)];
    if !refused.is_empty() {
        blocks.push(Block::Heading("Refused".to_owned()));
        blocks.push(Block::Table(table(part, "relations refused", &refused, true)));
    }
    blocks
}

/// The kind of a relation, with its angle if it has one.
fn what(relation: &Relation) -> String {
    match relation.angle {
        Some(angle) => format!("{} {:.0}°", spoken(&relation.kind), angle.to_degrees()),
        None => spoken(&relation.kind),
    }
}

fn table(part: &Part, name: &'static str, relations: &[&Relation], refused: bool) -> Table {
    let unit = part.unit();
    let mut columns = vec![
        Column::words("Relation"),
        Column::words("Of"),
        Column::number("z", ""),
        Column::number("z of the scan alone", ""),
        Column::number("Shift", unit),
        Column::number("Turn", "°"),
        Column::number("Rms before", unit),
        Column::number("Rms after", unit),
    ];
    if refused {
        columns.push(Column::words("Why not"));
    }
    let row = |relation: &&Relation| {
        // Of equal angles the shift is one too.
        let of_angles = relation.kind.contains("angle");
        let (shift, turn) = if of_angles {
            (None, relation.turn.into_iter().chain(relation.shift).reduce(f64::max))
        } else {
            (relation.shift, relation.turn)
        };
        let mut cells: Vec<Cell> = vec![
            what(relation).into(),
            Cell::Regions(references(part, &relation.of)),
            deviations(relation.z).into(),
            deviations(relation.z_statistical).into(),
            short(shift).into(),
            short(turn.map(f64::to_degrees)).into(),
            significant(relation.before, 4).into(),
            significant(relation.after, 4).into(),
        ];
        if refused {
            cells.push(relation.reason.clone().unwrap_or_else(|| UNKNOWN.to_owned()).into());
        }
        Row::new(cells)
    };
    let rows = relations.iter().map(row).collect();
    Table { name, columns, rows, empty: "None was found.".to_owned() }
}
