//! The parameters of a script: names, values, and what is known about them.

use std::fmt::Write as _;

use super::body::Body;
use crate::recognize::Primitive;
use crate::surface::{Surface, SurfaceKind};

/// Which length of a face a parameter is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    /// Where a plane is along its normal, where a shaft's or bore's wall is beside its axis.
    Wall,
    /// The radius of a round face, of a torus that of its tube.
    Radius,
    /// Where the middle of a round face is.
    Center,
}

/// One line of the parameter block.
#[derive(Debug, Clone)]
struct Parameter {
    name: String,
    value: f64,
    /// Standard uncertainty.
    sigma: Option<f64>,
    note: String,
}

/// Parameters in the order they were named, and headings between them.
#[derive(Debug, Clone)]
pub(super) struct Parameters<'a> {
    body: &'a Body<'a>,
    primitives: &'a [Primitive],
    /// Digits after the point of every length.
    pub(super) digits: usize,
    lines: Vec<Line>,
}

#[derive(Debug, Clone)]
enum Line {
    Heading(String),
    Parameter(Parameter),
}

impl<'a> Parameters<'a> {
    pub(super) fn new(body: &'a Body<'a>, primitives: &'a [Primitive]) -> Self {
        /// Digits that a length as long as the part has: beyond what any scan shows, and what tangencies need.
        const SIGNIFICANT: f64 = 6.0;
        let size = (body.bounds.1 - body.bounds.0).norm();
        let digits = (SIGNIFICANT - 1.0 - size.log10().floor()).clamp(0.0, 15.0) as usize;
        Self { body, primitives, digits, lines: Vec::new() }
    }

    pub(super) fn heading(&mut self, text: String) {
        self.lines.push(Line::Heading(text));
    }

    /// The name of a length with this value among those of `prefix` and `kind`, a new one if there is none; a plain zero
    /// where it is zero.
    pub(super) fn length(
        &mut self,
        prefix: &str,
        kind: &str,
        value: f64,
        sigma: Option<f64>,
        note: &str,
    ) -> String {
        let rounded = self.rounded(value);
        if rounded == 0.0 {
            return "0".to_owned();
        }
        let stem = format!("{prefix}_{kind}");
        let mut n_of_kind = 0;
        for line in &self.lines {
            let Line::Parameter(known) = line else { continue };
            let Some(rest) = known.name.strip_prefix(&stem) else { continue };
            if !rest.is_empty() && rest.parse::<usize>().is_err() {
                continue;
            }
            n_of_kind += 1;
            if known.value == rounded {
                return known.name.clone();
            }
        }
        let name = if n_of_kind == 0 { stem } else { format!("{stem}{}", n_of_kind + 1) };
        self.lines.push(Line::Parameter(Parameter {
            name: name.clone(),
            value: rounded,
            sigma,
            note: note.to_owned(),
        }));
        name
    }

    /// A value as it is written.
    pub(super) fn rounded(&self, value: f64) -> f64 {
        self.number(value).parse().unwrap_or(value)
    }

    /// A number as it is written.
    pub(super) fn number(&self, value: f64) -> String {
        let text = format!("{value:.*}", self.digits);
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        if text == "-0" || text.is_empty() { "0".to_owned() } else { text.to_owned() }
    }

    /// The least standard uncertainty of a quantity among faces; `None` where none is known.
    pub(super) fn sigma(&self, faces: &[usize], quantity: Quantity) -> Option<f64> {
        faces.iter().filter_map(|f| self.sigma_of_face(*f, quantity)).min_by(f64::total_cmp)
    }

    fn sigma_of_face(&self, face: usize, quantity: Quantity) -> Option<f64> {
        let primitive = self.primitives.get(self.body.solid.faces[face].region.0 as usize)?;
        let kind = primitive.surface.as_ref().map(Surface::kind)?;
        let place = match (quantity, kind) {
            (Quantity::Wall, SurfaceKind::Plane) | (Quantity::Center, SurfaceKind::Cylinder) => 0,
            (Quantity::Wall | Quantity::Radius, SurfaceKind::Cylinder) => 4,
            (Quantity::Radius, SurfaceKind::Sphere) => 3,
            (Quantity::Radius, SurfaceKind::Torus) => 6,
            (Quantity::Center, SurfaceKind::Sphere | SurfaceKind::Torus) => 2,
            _ => return None,
        };
        let variance = *primitive.covariance.get(place)?.get(place)?;
        (variance.is_finite() && variance > 0.0).then(|| variance.sqrt())
    }

    /// The ids of the primitives under faces, for people.
    pub(super) fn primitives_of(&self, faces: &[usize]) -> String {
        let mut ids: Vec<u32> = faces.iter().map(|f| self.body.solid.faces[*f].region.0).collect();
        ids.sort_unstable();
        ids.dedup();
        let texts: Vec<String> = ids.iter().map(u32::to_string).collect();
        let word = if ids.len() == 1 { "primitive" } else { "primitives" };
        format!("{word} {}", texts.join(" "))
    }

    /// The block as it is written.
    pub(super) fn text(&self) -> String {
        let mut out = String::new();
        for line in &self.lines {
            match line {
                Line::Heading(text) => {
                    let _ = writeln!(out, "\n# {text}");
                }
                Line::Parameter(p) => {
                    let _ = write!(out, "{} = {}", p.name, self.number(p.value));
                    let mut notes = Vec::new();
                    if let Some(sigma) = p.sigma {
                        notes.push(format!("+- {}", significant(sigma)));
                        notes.extend(nominal(p.value, sigma).map(|n| format!("nominal {n}")));
                    }
                    if !p.note.is_empty() {
                        notes.push(p.note.clone());
                    }
                    if !notes.is_empty() {
                        let _ = write!(out, "  # {}", notes.join(", "));
                    }
                    out.push('\n');
                }
            }
        }
        out
    }
}

/// Two significant digits.
fn significant(x: f64) -> String {
    let digits = (1.0 - x.log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{x:.digits$}")
}

/// The round number that a value means, if one is within its uncertainty and could not be there by chance: the value is
/// known within a twentieth of the steps between such numbers.
fn nominal(value: f64, sigma: f64) -> Option<String> {
    /// Steps of drawings, coarsest first, and how far apart their multiples are.
    const STEPS: [(f64, usize); 6] = [(5.0, 0), (1.0, 0), (0.5, 1), (0.25, 2), (0.1, 1), (0.05, 2)];
    const KNOWN: f64 = 20.0;
    const WITHIN: f64 = 2.0;
    STEPS.iter().find_map(|&(step, digits)| {
        let near = (value / step).round() * step;
        let is_meant = near != 0.0 && sigma <= step / KNOWN && (value - near).abs() <= WITHIN * sigma;
        is_meant.then(|| format!("{near:.digits$}"))
    })
}

#[cfg(test)]
mod tests {
    use super::nominal;

    #[test]
    fn round_numbers_are_named_only_when_they_are_known() {
        assert_eq!(nominal(12.034, 0.02).as_deref(), Some("12"));
        assert_eq!(nominal(12.034, 0.01), None);
        assert_eq!(nominal(12.498, 0.004).as_deref(), Some("12.5"));
        assert_eq!(nominal(12.1, 0.2), None);
        assert_eq!(nominal(0.001, 0.01), None);
    }
}
