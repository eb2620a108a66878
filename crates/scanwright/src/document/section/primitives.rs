use super::super::number::{UNKNOWN, known_within, plain_count, short};
use super::super::page::{Block, Cell, Column, Level, Row, Section, Table};
use super::super::part::{Part, Primitive};

/// Every primitive with its place and how well its points lie on it.
pub fn section(part: &Part) -> Section {
    let unit = part.unit();
    let columns = vec![
        Column::words("Primitive"),
        Column::number("x", unit),
        Column::number("y", unit),
        Column::number("z", unit),
        Column::number("dx", ""),
        Column::number("dy", ""),
        Column::number("dz", ""),
        Column::words("Material"),
        Column::number("Area", &format!("{unit}²")),
        Column::number("Triangles", ""),
        Column::number("Residual rms", unit),
        Column::number("95 %", unit),
        Column::number("Largest", unit),
        Column::words("Remark"),
    ];
    let rows = part.primitives.iter().map(|primitive| row(part, primitive)).collect();
    let table = Table { name: "primitives", columns, rows, empty: "No region was found.".to_owned() };
    let explained = "A name such as `cylinder 5` stands for the faces that the STEP file calls `region 5 cylinder`. \
                     x, y, z is a point of the plane or of the axis, the apex or the center; dx, dy, dz is the \
                     plane's normal, out of the material, or the direction of the axis. Coordinates and directions are rounded \
                     to the second digit of their standard uncertainties. Residuals are distances of the region's inner \
                     points to the surface.";
    let blocks = vec![Block::Text(explained.to_owned()), Block::Table(table)];
    Section { title: "Primitives", anchor: "primitives", blocks }
}

fn row(part: &Part, primitive: &Primitive) -> Row {
    let point = primitive.point.or(primitive.axis_point).or(primitive.apex).or(primitive.center);
    let direction = primitive.normal.or(primitive.axis_direction);
    let offset = largest_of(primitive, &["offset", "center"]).or(part.scan.noise);
    let tilt = largest_of(primitive, &["tilt"]);
    let mut cells = vec![Cell::Text(part.name_of(primitive.id))];
    cells.extend(coordinates(point, offset));
    cells.extend(coordinates(direction, tilt));
    let rest: [Cell; 7] = [
        material(primitive).into(),
        short(primitive.area).into(),
        plain_count(primitive.triangles).into(),
        short(primitive.residual.rms).into(),
        short(primitive.residual.p95).into(),
        short(primitive.residual.max).into(),
        primitive.ambiguous.clone().unwrap_or_default().into(),
    ];
    cells.extend(rest);
    let doubtful = primitive.ambiguous.is_some() || primitive.surface_kind().is_none();
    Row { cells, level: doubtful.then_some(Level::Look), region: Some(primitive.id) }
}

/// The largest standard uncertainty of the parameters whose names begin so.
fn largest_of(primitive: &Primitive, beginnings: &[&str]) -> Option<f64> {
    let names = primitive.parameters.iter().filter(|name| beginnings.iter().any(|b| name.starts_with(b)));
    names.filter_map(|name| primitive.uncertainty_of(name)).reduce(f64::max)
}

fn coordinates(of: Option<[f64; 3]>, uncertainty: Option<f64>) -> [Cell; 3] {
    [0, 1, 2].map(|k| known_within(of.map(|coordinates| coordinates[k]), uncertainty).into())
}

fn material(primitive: &Primitive) -> &'static str {
    match (primitive.kind.as_str(), primitive.outward) {
        ("plane" | "freeform", _) | (_, None) => UNKNOWN,
        (_, Some(true)) => "inside",
        (_, Some(false)) => "outside",
    }
}
