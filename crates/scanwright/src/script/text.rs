//! The whole file: what it is and what it lacks, parameters, features, and the comparison at the end.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::python::Text;
use super::{ScriptOptions, ScriptPart};
use crate::math::UnitVec3;

/// Lines of what is missing that are written out.
const MOST_LINES: usize = 40;

pub(super) fn whole(parts: &[(ScriptPart, Option<Text>)], options: &ScriptOptions) -> String {
    let mut out = String::new();
    head(&mut out, parts, options);
    if parts.iter().all(|p| p.1.is_none()) {
        out.push_str(
            "\nraise SystemExit(\"no feature explains this solid; its STEP file is all there is\")\n",
        );
        return out;
    }
    out.push_str(HELPERS);
    out.push_str("\n# ---------------------------------------------------------------- parameters\n");
    let unit = &options.unit;
    let _ = writeln!(
        out,
        "# Lengths in {unit}; +- is the standard uncertainty, nominal a round number within it."
    );
    for text in parts.iter().filter_map(|p| p.1.as_ref()) {
        out.push_str(&text.parameters);
    }
    out.push_str("\n# ------------------------------------------------------------------ features\n");
    let mut names = Vec::new();
    for (i, (part, text)) in parts.iter().enumerate() {
        let Some(text) = text else { continue };
        let prefix = if parts.len() == 1 { String::new() } else { format!("p{}_", i + 1) };
        out.push_str(&text.features);
        placing(&mut out, text, &prefix);
        comparison(&mut out, part, &prefix, unit);
        names.push(format!("{prefix}part"));
    }
    if parts.len() > 1 {
        let _ = writeln!(out, "\npart = Compound(children=[{}])", names.join(", "));
    }
    out.push_str(TAIL);
    out
}

fn head(out: &mut String, parts: &[(ScriptPart, Option<Text>)], options: &ScriptOptions) {
    let name: String = options.name.chars().filter(|c| !c.is_control() && *c != '"' && *c != '\\').collect();
    let _ = writeln!(
        out,
        "\"\"\"{name}, rebuilt from its features. Written by scanwright; needs build123d.\"\"\""
    );
    for (i, (part, _)) in parts.iter().enumerate() {
        let of = if parts.len() == 1 { String::new() } else { format!(" of solid {}", i + 1) };
        let _ = writeln!(out, "#\n# Expressed{of}: {}.", part.text());
        if part.volume > 0.0 {
            let share = 100.0 * part.differing_volume / part.volume;
            let _ = writeln!(out, "# Of the solid's volume {share:.2} % is expected to differ.");
        }
        let mut groups: BTreeMap<&str, Vec<u32>> = BTreeMap::new();
        for missing in &part.missing {
            groups.entry(&missing.text).or_default().push(missing.primitive);
        }
        for (n, (text, mut ids)) in groups.into_iter().enumerate() {
            if n >= MOST_LINES {
                break;
            }
            ids.sort_unstable();
            ids.dedup();
            let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
            let word = if ids.len() == 1 { "primitive" } else { "primitives" };
            let _ = writeln!(out, "# Not expressed: {word} {} ({text}).", ids.join(" "));
        }
    }
}

/// From the part's own frame to where it lies in the scan.
fn placing(out: &mut String, text: &Text, prefix: &str) {
    let frame = text.frame;
    let direction = |d: &UnitVec3| format!("({:.12}, {:.12}, {:.12})", d.x + 0.0, d.y + 0.0, d.z + 0.0);
    let digits = text.digits;
    let o = frame.origin;
    let _ = writeln!(
        out,
        "\n# Where the part lies in the scan.\n{prefix}part = Plane(\n    origin=({:.digits$}, {:.digits$}, {:.digits$}),\n    \
         x_dir={},\n    z_dir={},\n) * {prefix}part",
        o.x,
        o.y,
        o.z,
        direction(&frame.x),
        direction(&frame.z),
    );
}

fn comparison(out: &mut String, part: &ScriptPart, prefix: &str, unit: &str) {
    let _ = writeln!(
        out,
        "\n{prefix}solid_volume = {:.9e}  # of the solid in the STEP file, {unit}^3\n\
         print(f\"{prefix}part: volume {{{prefix}part.volume:.6g}} {unit}^3, solid {{{prefix}solid_volume:.6g}} {unit}^3, \"\n      \
         f\"difference {{100 * ({prefix}part.volume / {prefix}solid_volume - 1):+.3f}} %\")",
        part.volume
    );
}

const HELPERS: &str = r#"
import sys
from math import sqrt

from build123d import (
    Align, Axis, Circle, Compound, Cylinder, Plane, Polyline, Pos, Rot, ThreePointArc, Vector,
    chamfer, export_step, extrude, fillet, make_face, revolve,
)

BOTTOM = (Align.CENTER, Align.CENTER, Align.MIN)


def face(*curves):
    """The face within curves that close."""
    return make_face([edge for curve in curves for edge in curve.edges()])


def arc(start, end, radius, large=False):
    """The arc of a radius from start to end, turning left; right if the radius is negative."""
    a, b = Vector(*start), Vector(*end)
    half = (b - a) * 0.5
    depth = sqrt(max(radius**2 - half.length**2, 0))
    rise = abs(radius) + depth if large else abs(radius) - depth
    across = Vector(half.Y, -half.X).normalized() * (rise if radius > 0 else -rise)
    return ThreePointArc(a, a + half + across, b)


def half_circle(start, end, left=True):
    """Half a circle from start to end, turning left or right."""
    a, b = Vector(*start), Vector(*end)
    half = (b - a) * 0.5
    across = Vector(half.Y, -half.X)
    return ThreePointArc(a, a + half + (across if left else -across), b)


def corner(sketch, x, y):
    """The corner of a sketch nearest to a point."""
    return sketch.vertices().sort_by_distance((x, y, 0))[0]

"#;

const TAIL: &str = r"
if len(sys.argv) > 1:
    export_step(part, sys.argv[1])
";
