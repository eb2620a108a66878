//! The XML of a model part: unit, objects and what is built of them.

use super::super::error::{Place, ReadError, one_line, quoted};
use super::super::polygons::Polygons;
use super::super::text::{Item, coordinate, parse};
use super::super::{Unit, check_numbering};
use crate::math::Point3;
use crate::mesh::Mesh;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;
use std::io::BufRead;

/// Row vectors: `p' = p * m` with the translation in the last row, as 3MF writes it.
pub(super) type Transform = [f64; 12];

pub(super) const IDENTITY: Transform = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// A use of an object.
#[derive(Debug, Clone)]
pub(super) struct Instance {
    /// Another model part, when the object is not of this one.
    pub path: Option<String>,
    pub object: u32,
    pub transform: Transform,
}

#[derive(Debug, Default)]
pub(super) struct Object {
    pub mesh: Mesh,
    pub components: Vec<Instance>,
    /// Printing supports are no part of what was scanned.
    pub is_support: bool,
}

#[derive(Debug, Default)]
pub(super) struct Model {
    pub unit: Option<Unit>,
    pub objects: BTreeMap<u32, Object>,
    pub items: Vec<Instance>,
}

/// Parses the part `name`.
pub(super) fn parse_model(source: &mut dyn BufRead, name: &str) -> Result<Model, ReadError> {
    let mut reader = Reader::from_reader(source);
    let mut parser = Parser { name, at: 0, prefix: None, model: Model::default(), open: None };
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        parser.at = reader.buffer_position();
        let event = reader.read_event_into(&mut buffer).map_err(|error| parser.not_xml(&error))?;
        match event {
            Event::Start(element) => parser.start(&element)?,
            Event::Empty(element) => {
                parser.start(&element)?;
                parser.end(element.name().into_inner());
            }
            Event::End(element) => parser.end(element.name().into_inner()),
            Event::Eof => return parser.finish(),
            _ => {}
        }
    }
}

struct Parser<'a> {
    name: &'a str,
    at: u64,
    /// Prefix of the core namespace, with its colon: that of the root element. Extensions use other prefixes.
    prefix: Option<String>,
    model: Model,
    open: Option<(u32, Object, Polygons)>,
}

impl Parser<'_> {
    fn place(&self) -> Place {
        Place::Part(one_line(&self.name), self.at)
    }

    fn not_xml(&self, error: &dyn std::fmt::Display) -> ReadError {
        self.value("the XML", one_line(error), "well-formed UTF-8")
    }

    fn value(&self, element: &str, value: String, expected: &'static str) -> ReadError {
        ReadError::Value { place: self.place(), element: element.to_owned(), value, expected }
    }

    fn finish(self) -> Result<Model, ReadError> {
        match (&self.prefix, &self.open) {
            (None, _) => Err(self.value("the root element", "missing".to_owned(), "'model'")),
            (_, Some((id, ..))) => {
                let element = format!("object {id}");
                Err(ReadError::Truncated { place: self.place(), element })
            }
            _ => Ok(self.model),
        }
    }

    fn start(&mut self, element: &BytesStart<'_>) -> Result<(), ReadError> {
        let qualified = element.name().into_inner();
        let Some(prefix) = &self.prefix else {
            return self.start_model(qualified, element);
        };
        match qualified.strip_prefix(prefix.as_str()) {
            Some("object") => self.start_object(element),
            Some("vertex") => self.vertex(element),
            Some("triangle") => self.triangle(element),
            Some("component") => {
                let instance = self.instance(element)?;
                if let Some((_, object, _)) = &mut self.open {
                    object.components.push(instance);
                }
                Ok(())
            }
            Some("item") => {
                let instance = self.instance(element)?;
                self.model.items.push(instance);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn end(&mut self, qualified: &str) {
        let local = self.prefix.as_deref().and_then(|prefix| qualified.strip_prefix(prefix));
        if local == Some("object")
            && let Some((id, mut object, polygons)) = self.open.take()
        {
            object.mesh.triangles = polygons.triangles;
            self.model.objects.insert(id, object);
        }
    }

    fn start_model(&mut self, qualified: &str, element: &BytesStart<'_>) -> Result<(), ReadError> {
        let Some(prefix) = qualified.strip_suffix("model") else {
            return Err(self.value("the root element", quoted(qualified.as_bytes()), "'model'"));
        };
        self.prefix = Some(prefix.to_owned());
        self.model.unit = Some(match attribute(element, "unit").as_deref() {
            None | Some("millimeter") => Unit::Millimeter,
            Some("micron") => Unit::Micron,
            Some("centimeter") => Unit::Centimeter,
            Some("inch") => Unit::Inch,
            Some("foot") => Unit::Foot,
            Some("meter") => Unit::Meter,
            Some(other) => {
                let expected = "micron, millimeter, centimeter, inch, foot or meter";
                return Err(self.value("the unit", quoted(other.as_bytes()), expected));
            }
        });
        Ok(())
    }

    fn start_object(&mut self, element: &BytesStart<'_>) -> Result<(), ReadError> {
        let id = self.whole(element, "id", "the object's id")?;
        if self.open.is_some() || self.model.objects.contains_key(&id) {
            return Err(self.value("the object's id", format!("{id} again or inside an object"), "unique"));
        }
        let kind = attribute(element, "type");
        let is_support = matches!(kind.as_deref(), Some("support" | "solidsupport"));
        self.open = Some((id, Object { is_support, ..Object::default() }, Polygons::new(0, 0)));
        Ok(())
    }

    fn vertex(&mut self, element: &BytesStart<'_>) -> Result<(), ReadError> {
        let Some((_, object, _)) = &self.open else { return Ok(()) };
        let item = Item { kind: "vertex", index: object.mesh.vertices.len() };
        let words = attributes(element, ["x", "y", "z"]);
        let mut xyz = [0.0; 3];
        for (axis, x) in xyz.iter_mut().enumerate() {
            *x = coordinate(words[axis].as_deref().map(str::as_bytes), axis, item, || self.place())?;
        }
        check_numbering(item.index as u64, "vertices")?;
        if let Some((_, object, _)) = &mut self.open {
            object.mesh.vertices.push(Point3::from(xyz));
        }
        Ok(())
    }

    fn triangle(&mut self, element: &BytesStart<'_>) -> Result<(), ReadError> {
        let (name, at) = (self.name, self.at);
        let place = || Place::Part(one_line(&name), at);
        let Some((_, object, polygons)) = &mut self.open else { return Ok(()) };
        polygons.set_n_vertices(object.mesh.vertices.len());
        let item = Item { kind: "triangle", index: polygons.triangles.len() };
        for word in attributes(element, ["v1", "v2", "v3"]) {
            let Some(vertex) = word.as_deref().and_then(|word| parse(word.as_bytes())) else {
                return Err(ReadError::Value {
                    place: place(),
                    element: format!("a corner of {item}"),
                    value: word.map_or_else(|| "missing".to_owned(), |word| quoted(word.as_bytes())),
                    expected: "a whole number",
                });
            };
            polygons.corner(vertex, item, place)?;
        }
        polygons.finish(item, place)
    }

    fn instance(&self, element: &BytesStart<'_>) -> Result<Instance, ReadError> {
        let object = self.whole(element, "objectid", "the id of the object used")?;
        let transform = match attribute(element, "transform") {
            None => IDENTITY,
            Some(text) => self.transform(&text)?,
        };
        Ok(Instance { path: attribute(element, "path"), object, transform })
    }

    fn transform(&self, text: &str) -> Result<Transform, ReadError> {
        let mut numbers = text.split_ascii_whitespace().map(str::parse::<f64>);
        let mut transform = IDENTITY;
        for m in &mut transform {
            match numbers.next() {
                Some(Ok(x)) if x.is_finite() => *m = x,
                _ => return Err(self.value("a transform", quoted(text.as_bytes()), "twelve finite numbers")),
            }
        }
        Ok(transform)
    }

    fn whole(&self, element: &BytesStart<'_>, name: &str, what: &str) -> Result<u32, ReadError> {
        let text = attribute(element, name);
        text.as_deref().and_then(|text| parse(text.as_bytes())).ok_or_else(|| {
            let value = text.map_or_else(|| "missing".to_owned(), |text| quoted(text.as_bytes()));
            self.value(what, value, "a whole number")
        })
    }
}

/// Attributes by local name; `path` has the prefix of an extension.
fn attributes<'e, const N: usize>(
    element: &'e BytesStart<'_>,
    names: [&str; N],
) -> [Option<std::borrow::Cow<'e, str>>; N] {
    let mut found = [const { None }; N];
    // The check for duplicates takes quadratic time.
    for attribute in element.attributes().with_checks(false).filter_map(Result::ok) {
        if let Some(i) = names.iter().position(|name| *name == attribute.key.local_name().into_inner()) {
            found[i] = Some(attribute.value);
        }
    }
    found
}

fn attribute(element: &BytesStart<'_>, name: &str) -> Option<String> {
    let [value] = attributes(element, [name]);
    value.map(|value| value.trim().to_owned())
}

/// The part that the package's relationships name as its model.
pub(super) fn parse_relationships(source: &mut dyn BufRead) -> Option<String> {
    let mut reader = Reader::from_reader(source);
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        match reader.read_event_into(&mut buffer).ok()? {
            Event::Start(element) | Event::Empty(element)
                if element.local_name().into_inner() == "Relationship"
                    && attribute(&element, "Type").is_some_and(|kind| kind.ends_with("/3dmodel")) =>
            {
                return attribute(&element, "Target");
            }
            Event::Eof => return None,
            _ => {}
        }
    }
}
