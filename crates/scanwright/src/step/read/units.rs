//! Units of a representation's context.

use super::StepReadError;
use super::part21::{Exchange, Fields, Instance, Value};

/// What a context says its numbers mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Units {
    /// Length of the unit in millimetres, when it is told.
    pub(super) millimetres: Option<f64>,
    /// Plane angle of the unit in radians; radians unless told otherwise.
    pub(super) radians: f64,
}

impl Default for Units {
    fn default() -> Self {
        Self { millimetres: None, radians: 1.0 }
    }
}

/// Most units that one is derived from in turn.
const LONGEST_CHAIN: usize = 8;

/// The units of the context `id`.
pub(super) fn of_context(exchange: &Exchange, id: u64) -> Result<Units, StepReadError> {
    let context = exchange.get(id)?;
    let mut units = Units::default();
    if !context.is("GLOBAL_UNIT_ASSIGNED_CONTEXT") {
        return Ok(units);
    }
    // A context that is nothing else inherits the identifier and the type.
    let fields = context.fields("GLOBAL_UNIT_ASSIGNED_CONTEXT", 2);
    for id in fields.references(0)? {
        let unit = exchange.get(id)?;
        if unit.is("LENGTH_UNIT") {
            units.millimetres = Some(size(exchange, &unit, LONGEST_CHAIN)? * 1000.0);
        } else if unit.is("PLANE_ANGLE_UNIT") {
            units.radians = size(exchange, &unit, LONGEST_CHAIN)?;
        }
    }
    Ok(units)
}

/// The unit in metres or radians.
fn size(exchange: &Exchange, unit: &Instance, chain: usize) -> Result<f64, StepReadError> {
    if chain == 0 {
        return Err(StepReadError::Cycle(unit.id));
    }
    if unit.is("SI_UNIT") {
        let fields = unit.fields("SI_UNIT", 1);
        let size = fields.word(0).map_or(Some(1.0), prefix);
        return size.ok_or_else(|| unit.wrong("has an unknown prefix", "a prefix of the SI"));
    }
    if !unit.is("CONVERSION_BASED_UNIT") {
        return Err(unit.wrong(format!("is {}", unit.kind()), "a unit of the SI or one based on it"));
    }
    let measure = exchange.get(unit.fields("CONVERSION_BASED_UNIT", 1).reference(1)?)?;
    let fields = measure_fields(&measure);
    let (value, base) = (fields.real(0)?, exchange.get(fields.reference(1)?)?);
    let size = value * size(exchange, &base, chain - 1)?;
    if size.is_finite() && size > 0.0 {
        Ok(size)
    } else {
        Err(unit.wrong(format!("is {value} of its base"), "a positive size"))
    }
}

/// Value and unit of a measure, simple or complex.
fn measure_fields<'a, 'i>(measure: &'i Instance<'a>) -> Fields<'a, 'i> {
    let simple = measure.all_fields();
    match simple.get(0) {
        Some(Value::Typed(_) | Value::Real(_) | Value::Integer(_)) => simple,
        _ => measure.fields("MEASURE_WITH_UNIT", 0),
    }
}

fn prefix(word: &str) -> Option<f64> {
    let powers = [
        ("EXA", 18),
        ("PETA", 15),
        ("TERA", 12),
        ("GIGA", 9),
        ("MEGA", 6),
        ("KILO", 3),
        ("HECTO", 2),
        ("DECA", 1),
        ("DECI", -1),
        ("CENTI", -2),
        ("MILLI", -3),
        ("MICRO", -6),
        ("NANO", -9),
        ("PICO", -12),
    ];
    // Division keeps the negative powers exact to the last bit that a decimal has.
    let power = |n: i32| if n < 0 { 1.0 / 10.0_f64.powi(-n) } else { 10.0_f64.powi(n) };
    powers.iter().find(|(name, _)| *name == word).map(|(_, n)| power(*n))
}
