//! The features as build123d text: one block each, with names for every length.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::body::Body;
use super::drawing::{Arc, ArcShape, Corner, Treatment, corners, is_constant, rectangle};
use super::feature::{Feature, Model, Ring, Sign};
use super::parameters::{Parameters, Quantity};
use super::sweep::{Motion, Point2};
use crate::math::{Frame, UnitVec3};
use crate::recognize::Primitive;
use crate::tolerance::Tolerances;

/// The text of one solid's parameters and features.
#[derive(Debug, Clone)]
pub(super) struct Text {
    pub(super) parameters: String,
    pub(super) features: String,
    /// Where the features' coordinates lie in the scan.
    pub(super) frame: Frame,
    /// Digits after the point of lengths.
    pub(super) digits: usize,
}

struct Writer<'a> {
    parameters: Parameters<'a>,
    main: Frame,
    tolerance: f64,
    /// Named planes by their directions.
    planes: BTreeMap<String, String>,
    text: String,
    /// The variable that holds the part.
    part: String,
    counts: BTreeMap<&'static str, usize>,
    prefix: String,
}

/// A feature seen from the part's frame.
struct Placed<'f> {
    feature: &'f Feature,
    name: String,
    /// The plane that its coordinates are in.
    plane: String,
    /// Names of the plane's three directions.
    axes: [&'static str; 3],
    /// Coordinates of the sweep's origin in it.
    shift: [f64; 3],
}

/// `part`: name of the variable; `prefix`: what the names of its parameters begin with.
pub(super) fn write(
    body: &Body,
    model: &Model,
    primitives: &[Primitive],
    tolerance: f64,
    (part, prefix): (&str, &str),
) -> Option<Text> {
    let main = main_frame(model.body.first()?);
    let mut writer = Writer {
        parameters: Parameters::new(body, primitives),
        main,
        tolerance,
        planes: BTreeMap::new(),
        text: String::new(),
        part: part.to_owned(),
        counts: BTreeMap::new(),
        prefix: prefix.to_owned(),
    };
    for (i, feature) in model.features().enumerate() {
        let is_hole = i >= model.body.len();
        let role = if is_hole {
            Role::Hole
        } else if i == 0 {
            Role::Body
        } else {
            Role::Detail
        };
        writer.feature(feature, role);
    }
    let mut planes: Vec<(String, String)> = writer.planes.into_iter().collect();
    planes.sort_by(|a, b| a.1.cmp(&b.1));
    let mut features = String::new();
    for (directions, name) in planes {
        let _ = writeln!(features, "{name} = Plane(origin=(0, 0, 0), {directions})");
    }
    features.push_str(&writer.text);
    Some(Text {
        parameters: writer.parameters.text(),
        features,
        frame: main,
        digits: writer.parameters.digits,
    })
}

/// The frame of the first feature: its motion upward, its lowest point at zero.
fn main_frame(first: &Feature) -> Frame {
    let frame = first.sweep.frame;
    let (low, high) = first.bounds();
    let local = match first.sweep.motion {
        Motion::Around => crate::math::Vec3::new(0.0, 0.0, low.y),
        Motion::Along => {
            let middle = first.rings[0].circle().map_or((low + high) * 0.5, |c| c.0);
            crate::math::Vec3::new(middle.x, middle.y, first.range.0)
        }
    };
    Frame { origin: frame.global(&local), ..frame }
}

/// What a feature is in its part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// The first, which the others are added to and cut from.
    Body,
    Hole,
    Detail,
}

impl Writer<'_> {
    fn feature(&mut self, feature: &Feature, role: Role) {
        let (is_first, is_hole) = (role == Role::Body, role == Role::Hole);
        let placed = self.placed(feature, role);
        let what = describe(feature, is_hole, self.tolerance);
        let faces = self.parameters.primitives_of(&Self::seen(feature));
        let heading = format!("{}: {what} ({faces})", placed.name.replace('_', " "));
        self.parameters.heading(heading.clone());
        let _ = writeln!(self.text, "\n# {heading}");
        let shape = self.shape(&placed);
        let part = &self.part;
        let _ = match (is_first, feature.sign) {
            (true, _) => writeln!(self.text, "{part} = {shape}"),
            (false, Sign::Add) => writeln!(self.text, "{part} += {shape}"),
            (false, Sign::Cut) => writeln!(self.text, "{part} -= {shape}"),
        };
    }

    /// Faces that the feature is known by: those its outline runs along.
    fn seen(feature: &Feature) -> Vec<usize> {
        /// Share of a wall or end that is a face.
        const SEEN: f64 = 0.02;
        let walls = feature.rings.iter().flat_map(|r| &r.segments).filter(|s| s.backed > SEEN);
        let mut faces: Vec<usize> = walls.flat_map(|s| s.faces.iter().copied()).collect();
        for end in 0..2 {
            if feature.capped[end] > SEEN {
                faces.extend(&feature.caps[end]);
            }
        }
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    fn placed<'f>(&mut self, feature: &'f Feature, role: Role) -> Placed<'f> {
        let (is_first, is_hole) = (role == Role::Body, role == Role::Hole);
        let frame = feature.sweep.frame;
        let offset = frame.origin - self.main.origin;
        let shift = [frame.x, frame.y, frame.z].map(|axis| offset.dot(&axis));
        let is_about_main = feature.sweep.motion == Motion::Around
            && frame.z.dot(&self.main.z).abs() > 1.0 - Tolerances::SAME
            && shift[0].hypot(shift[1]) <= self.tolerance;
        let word = if is_first {
            "body"
        } else {
            match (feature.sign, feature.sweep.motion, is_hole) {
                (_, _, true) if is_about_main => "bore",
                (_, _, true) => "hole",
                (Sign::Add, Motion::Around, _) => "boss",
                (Sign::Add, Motion::Along, _) if is_round(feature) => "boss",
                (Sign::Add, Motion::Along, _) => "block",
                (Sign::Cut, Motion::Around, _) => "groove",
                (Sign::Cut, Motion::Along, _) => "pocket",
            }
        };
        let count = self.counts.entry(word).or_default();
        *count += 1;
        let name = if is_first {
            format!("{}{word}", self.prefix)
        } else {
            format!("{}{word}_{count}", self.prefix)
        };
        let (plane, axes) = self.plane(&frame);
        Placed { feature, name, plane, axes, shift }
    }

    /// The plane through the part's origin along a frame, and names of its directions.
    fn plane(&mut self, frame: &Frame) -> (String, [&'static str; 3]) {
        let main = self.main;
        let local = |d: &UnitVec3| [main.x, main.y, main.z].map(|axis| snapped(d.dot(&axis)));
        let name_of = |d: &UnitVec3, other: &'static str| match local(d) {
            [1.0, 0.0, 0.0] => "x",
            [0.0, 1.0, 0.0] => "y",
            [0.0, 0.0, 1.0] => "z",
            _ => other,
        };
        let axes = [name_of(&frame.x, "u"), name_of(&frame.y, "v"), name_of(&frame.z, "w")];
        if axes == ["x", "y", "z"] {
            return ("Plane.XY".to_owned(), axes);
        }
        let tuple = |d: &UnitVec3| {
            let texts = local(d).map(|c| if c == c.round() { format!("{c:.0}") } else { format!("{c:.9}") });
            format!("({})", texts.join(", "))
        };
        let directions = format!("x_dir={}, z_dir={}", tuple(&frame.x), tuple(&frame.z));
        let next = format!("{}plane_{}", self.prefix, self.planes.len() + 1);
        (self.planes.entry(directions).or_insert(next).clone(), axes)
    }

    /// The expression of a feature's shape; lines that it needs are written first.
    fn shape(&mut self, placed: &Placed) -> String {
        match placed.feature.sweep.motion {
            Motion::Along => self.extrusion(placed),
            Motion::Around => self.revolution(placed),
        }
    }

    fn extrusion(&mut self, placed: &Placed) -> String {
        let feature = placed.feature;
        let axis = placed.axes[2];
        let ends = [0, 1].map(|end| {
            let value = [feature.range.0, feature.range.1][end] + placed.shift[2];
            let sigma = self.parameters.sigma(&feature.caps[end], Quantity::Wall);
            let (sigma, note) =
                if feature.capped[end] > 0.02 { (sigma, "") } else { (None, "reaches into the open") };
            self.parameters.length(&placed.name, axis, value, sigma, note)
        });
        let plane = if ends[0] == "0" {
            placed.plane.clone()
        } else {
            format!("{}.offset({})", placed.plane, ends[0])
        };
        let height = if ends[0] == "0" { ends[1].clone() } else { format!("{} - {}", ends[1], ends[0]) };
        if let (Some((center, radius)), 1) = (feature.rings[0].circle(), feature.rings.len()) {
            let faces = feature.rings[0].segments[0].faces.clone();
            let at = self.position(placed, center, &faces);
            let diameter = self.diameter(&placed.name, radius, &faces);
            return format!("{plane} * {at}Cylinder({diameter} / 2, {height}, align=BOTTOM)");
        }
        let sketch = self.sketch(placed);
        format!("extrude({plane} * {sketch}, amount={height})")
    }

    fn revolution(&mut self, placed: &Placed) -> String {
        let feature = placed.feature;
        let at = self.position(placed, Point2::zeros(), &feature.faces());
        if let Some(cylinder) = self.cylinder(placed) {
            return format!("{} * {at}{cylinder}", placed.plane);
        }
        let sketch = self.sketch(placed);
        let plane = if placed.plane == "Plane.XY" && at.is_empty() {
            String::new()
        } else {
            format!("{} * {at}", placed.plane)
        };
        if feature.is_whole {
            return format!("{plane}revolve(Plane.XZ * {sketch}, Axis.Z)");
        }
        let start = feature.range.0.to_degrees();
        let turn = (feature.range.1 - feature.range.0).to_degrees();
        /// Degrees that are written as none.
        const WRITTEN: f64 = 1e-6;
        let start = if start.abs() < WRITTEN { String::new() } else { format!("Rot(0, 0, {start:.6}) * ") };
        let plane = if plane.is_empty() && !start.is_empty() { "Plane.XY * ".to_owned() } else { plane };
        format!("{plane}{start}revolve(Plane.XZ * {sketch}, Axis.Z, {turn:.6})")
    }

    /// A whole turn of a rectangle that begins at the axis.
    fn cylinder(&mut self, placed: &Placed) -> Option<String> {
        let feature = placed.feature;
        if !feature.is_whole || feature.rings.len() != 1 {
            return None;
        }
        let (low, high) = rectangle(&corners(&feature.rings[0], self.tolerance))?;
        if low.x > 0.0 {
            return None;
        }
        let wall = feature.rings[0].segments.iter().find(|s| s.from.x > 0.0 && is_constant(s, 0))?;
        let diameter = self.diameter(&placed.name, high.x, &wall.faces);
        let ends = [low.y, high.y].map(|z| {
            let end = feature.rings[0]
                .segments
                .iter()
                .find(|s| is_constant(s, 1) && (s.middle.y - z).abs() <= self.tolerance);
            let (faces, backed) = end.map_or((Vec::new(), 0.0), |s| (s.faces.clone(), s.backed));
            let sigma = self.parameters.sigma(&faces, Quantity::Wall);
            let (sigma, note) = if backed > 0.02 { (sigma, "") } else { (None, "reaches into the open") };
            self.parameters.length(&placed.name, placed.axes[2], z + placed.shift[2], sigma, note)
        });
        let (start, height) = if ends[0] == "0" {
            (String::new(), ends[1].clone())
        } else {
            (format!("Pos(0, 0, {}) * ", ends[0]), format!("{} - {}", ends[1], ends[0]))
        };
        Some(format!("{start}Cylinder({diameter} / 2, {height}, align=BOTTOM)"))
    }

    /// `Pos(...) * ` of a middle of the profile's plane across the motion; nothing at the origin.
    fn position(&mut self, placed: &Placed, center: Point2, faces: &[usize]) -> String {
        let sigma = self.parameters.sigma(faces, Quantity::Center);
        let [x, y] = [0, 1].map(|i| {
            let value = center[i] + placed.shift[i];
            self.parameters.length(&placed.name, placed.axes[i], value, sigma, "")
        });
        if x == "0" && y == "0" { String::new() } else { format!("Pos({x}, {y}) * ") }
    }

    fn diameter(&mut self, name: &str, radius: f64, faces: &[usize]) -> String {
        let sigma = self.parameters.sigma(faces, Quantity::Radius).map(|s| 2.0 * s);
        self.parameters.length(name, "diameter", 2.0 * radius, sigma, "")
    }

    /// The expression of a feature's profile; lines that it needs are written first.
    fn sketch(&mut self, placed: &Placed) -> String {
        let name = format!("{}_outline", placed.name);
        let outer = self.ring(placed, &placed.feature.rings[0]);
        let _ = writeln!(self.text, "{name} = {}", outer.0);
        self.treat(&name, &outer.1);
        for ring in &placed.feature.rings[1..] {
            let inner = self.ring(placed, ring);
            if inner.1.is_empty() {
                let _ = writeln!(self.text, "{name} -= {}", inner.0);
                continue;
            }
            let _ = writeln!(self.text, "{name}_cut = {}", inner.0);
            self.treat(&format!("{name}_cut"), &inner.1);
            let _ = writeln!(self.text, "{name} -= {name}_cut");
        }
        name
    }

    fn treat(&mut self, name: &str, treatments: &[String]) {
        for treatment in treatments {
            let (verb, rest) = treatment.split_once(' ').unwrap_or((treatment, ""));
            let _ = writeln!(self.text, "{name} = {verb}(corner({name}, {rest}");
        }
    }

    /// A ring's expression, and what is done to its corners: `verb x, y), size)`.
    fn ring(&mut self, placed: &Placed, ring: &Ring) -> (String, Vec<String>) {
        let shift = profile_shift(placed);
        if let Some((center, radius)) = ring.circle() {
            let faces = &ring.segments[0].faces;
            let at =
                [0, 1].map(|i| self.coordinate(placed, i, center[i] + shift[i], faces, Quantity::Center));
            let diameter = self.diameter(&placed.name, radius, faces);
            return (format!("Pos({}, {}) * Circle({diameter} / 2)", at[0], at[1]), Vec::new());
        }
        let corners = corners(ring, self.tolerance);
        let named: Vec<String> = corners
            .iter()
            .map(|c| {
                let at = [0, 1]
                    .map(|i| self.coordinate(placed, i, c.at[i] + shift[i], &c.faces[i], Quantity::Wall));
                format!("{}, {}", at[0], at[1])
            })
            .collect();
        let treatments =
            corners.iter().zip(&named).filter_map(|(c, at)| self.treatment(placed, c, at)).collect();
        (self.outline(placed, &corners, &named), treatments)
    }

    fn treatment(&mut self, placed: &Placed, corner: &Corner, at: &str) -> Option<String> {
        match &corner.treatment {
            Treatment::Sharp => None,
            Treatment::Fillet { radius, faces } => {
                let sigma = self.parameters.sigma(faces, Quantity::Radius);
                let size = self.parameters.length(&placed.name, "fillet", *radius, sigma, "");
                Some(format!("fillet {at}), {size})"))
            }
            Treatment::Chamfer { length, faces } => {
                let sigma = self.parameters.sigma(faces, Quantity::Wall);
                let size = self.parameters.length(&placed.name, "chamfer", *length, sigma, "");
                Some(format!("chamfer {at}), {size})"))
            }
        }
    }

    /// A coordinate of the profile: across or along the axis of a turned one.
    fn coordinate(
        &mut self,
        placed: &Placed,
        i: usize,
        value: f64,
        faces: &[usize],
        quantity: Quantity,
    ) -> String {
        let sigma = self.parameters.sigma(faces, quantity);
        match (placed.feature.sweep.motion, i) {
            (Motion::Along, _) => self.parameters.length(&placed.name, placed.axes[i], value, sigma, ""),
            (Motion::Around, 0) => {
                let diameter =
                    self.parameters.length(&placed.name, "diameter", 2.0 * value, sigma.map(|s| 2.0 * s), "");
                if diameter == "0" { diameter } else { format!("{diameter} / 2") }
            }
            (Motion::Around, _) => self.parameters.length(&placed.name, placed.axes[2], value, sigma, ""),
        }
    }

    fn arc(&mut self, placed: &Placed, arc: &Arc, from: &str, to: &str) -> String {
        let sigma = self.parameters.sigma(&arc.faces, Quantity::Radius);
        match arc.shape {
            ArcShape::Half if arc.radius < 0.0 => format!("half_circle({from}, {to}, left=False)"),
            ArcShape::Half => format!("half_circle({from}, {to})"),
            ArcShape::Through(at) => {
                let shift = profile_shift(placed);
                let at = [0, 1]
                    .map(|i| self.coordinate(placed, i, at[i] + shift[i], &arc.faces, Quantity::Center));
                format!("ThreePointArc({from}, ({}, {}), {to})", at[0], at[1])
            }
            ArcShape::Radius => {
                let radius = self.parameters.length(&placed.name, "radius", arc.radius.abs(), sigma, "");
                let sign = if arc.radius < 0.0 { "-" } else { "" };
                let large = if arc.is_large { ", large=True" } else { "" };
                format!("arc({from}, {to}, {sign}{radius}{large})")
            }
        }
    }

    /// `face(...)` of lines and arcs between named corners.
    fn outline(&mut self, placed: &Placed, corners: &[Corner], named: &[String]) -> String {
        let n = corners.len();
        let mut pieces: Vec<String> = Vec::new();
        let mut run: Vec<String> = Vec::new();
        for i in 0..n {
            let (from, to) = (format!("({})", named[i]), format!("({})", named[(i + 1) % n]));
            let Some(arc) = &corners[i].arc else {
                if run.is_empty() {
                    run.push(from);
                }
                run.push(to);
                continue;
            };
            if !run.is_empty() {
                pieces.push(format!("Polyline({})", std::mem::take(&mut run).join(", ")));
            }
            pieces.push(self.arc(placed, arc, &from, &to));
        }
        if !run.is_empty() {
            pieces.push(format!("Polyline({})", run.join(", ")));
        }
        let joined = format!("face({})", pieces.join(", "));
        /// Characters of a line.
        const WIDE: usize = 100;
        if joined.len() <= WIDE {
            return joined;
        }
        let broken: Vec<String> = pieces.iter().map(|p| broken(p, WIDE)).collect();
        format!("face(\n    {},\n)", broken.join(",\n    "))
    }
}

/// A long polyline with one corner per line, other pieces as they are.
fn broken(piece: &str, wide: usize) -> String {
    if piece.len() <= wide || !piece.starts_with("Polyline") {
        return piece.to_owned();
    }
    let inner = piece.replace("), (", "),\n        (");
    let inner = inner.replacen("Polyline((", "Polyline(\n        (", 1);
    match inner.strip_suffix(')') {
        Some(rest) => format!("{rest},\n    )"),
        None => inner,
    }
}

/// Coordinates of the sweep's origin in the plane of its profile.
fn profile_shift(placed: &Placed) -> Point2 {
    match placed.feature.sweep.motion {
        Motion::Along => Point2::new(placed.shift[0], placed.shift[1]),
        Motion::Around => Point2::new(0.0, placed.shift[2]),
    }
}

fn is_round(feature: &Feature) -> bool {
    feature.rings.len() == 1 && feature.rings[0].circle().is_some()
}

fn describe(feature: &Feature, is_hole: bool, tolerance: f64) -> &'static str {
    if is_hole {
        let corners = corners(&feature.rings[0], tolerance);
        let is_straight = feature.rings.len() == 1 && rectangle(&corners).is_some_and(|r| r.0.x == 0.0);
        let ends = feature.rings[0].segments.iter().filter(|s| is_constant(s, 1) && s.backed > 0.2);
        return match (is_straight, ends.count()) {
            (true, 0) => "drilled through",
            (true, _) => "drilled",
            (false, _) => "drilled and widened",
        };
    }
    match (feature.sweep.motion, feature.sign, is_hole) {
        (Motion::Around, Sign::Add, _) => "turned",
        (Motion::Along, Sign::Add, _) => "extruded",
        (Motion::Around, Sign::Cut, _) => "turned away",
        (Motion::Along, Sign::Cut, _) => "cut out along a direction",
    }
}

/// A direction's component, exact where it is one of an axis.
fn snapped(c: f64) -> f64 {
    if (c - c.round()).abs() < Tolerances::SAME { c.round() + 0.0 } else { c }
}
