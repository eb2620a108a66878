//! One file from several: each part's own entities, renumbered, and a product that places them.
//!
//! Nothing of a part is interpreted but its references, its root products and their representations, so nothing is lost:
//! geometry, names, colours and notes are written as they were read. ISO 10303-44 for the product structure.

use std::collections::BTreeMap;

use super::entities::{Entities, references};
use super::product::{context, header, product, quoted};
use super::read::StepReadError;
use super::read::part21::Exchange;
use super::read::structure::{Root, roots};
use super::{Schema, StepOptions};
use crate::math::{Frame, Point3, UnitVec3, Vec3};

/// A part of an assembly, where it is.
#[derive(Debug, Clone)]
pub struct Component<'a> {
    /// Name of the occurrence.
    pub name: String,
    /// The part's file. Components with the same bytes are occurrences of one part.
    pub text: &'a [u8],
    /// Where the part's coordinates lie in the assembly: its origin and its axes, in the assembly's unit.
    pub frame: Frame,
}

/// Why an assembly was not written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name}: {reason}")]
pub struct AssemblyError {
    /// Name of the component whose file is at fault.
    pub name: String,
    /// What is wrong with it.
    pub reason: StepReadError,
}

/// The Part 21 text of an assembly of `components`; `options` name it and give the unit of the frames.
///
/// Parts keep their own units and contexts. Bytes beyond ASCII in a part's strings stay as they are.
pub fn write_assembly(components: &[Component], options: &StepOptions) -> Result<Vec<u8>, AssemblyError> {
    let mut body = Vec::new();
    let mut parts: Vec<(&[u8], Vec<Placeable>)> = Vec::new();
    let mut next = 1;
    for component in components {
        if parts.iter().all(|(text, _)| *text != component.text) {
            let copied = copy(component.text, &mut next, &mut body)
                .map_err(|reason| AssemblyError { name: component.name.clone(), reason })?;
            parts.push((component.text, copied));
        }
    }
    let mut entities = Entities::starting_at(next as usize);
    let schema = schema(components);
    let options = &StepOptions { schema, ..options.clone() };
    let (definition, shape) = product(&mut entities, options);
    let context = context(&mut entities, 0.0, options);
    let origin = entities.placement(&Frame::from_z(Point3::origin(), Vec3::z_axis()));
    let mut items = vec![origin];
    let mut placed: Vec<(usize, &Component, &Placeable)> = Vec::new();
    for component in components {
        let part = parts.iter().find(|(text, _)| *text == component.text);
        for root in part.map_or(&[][..], |(_, roots)| roots) {
            let place = entities.placement(&moved(&component.frame, &root.frame, root.millimetres, options));
            items.push(place);
            placed.push((place, component, root));
        }
    }
    let whole = entities.add(&format!(
        "SHAPE_REPRESENTATION({},{},#{context})",
        quoted(&options.name),
        references(&items)
    ));
    entities.add(&format!("SHAPE_DEFINITION_REPRESENTATION(#{shape},#{whole})"));
    for (i, (place, component, root)) in placed.iter().enumerate() {
        occurrence(&mut entities, i + 1, (definition, whole, *place), component, root);
    }
    let mut text = header(options, schema).into_bytes();
    text.extend(b"DATA;\n");
    text.extend(body);
    text.extend(entities.text().into_bytes());
    text.extend(b"\nENDSEC;\nEND-ISO-10303-21;\n");
    Ok(text)
}

/// A root of a part in the numbers of the assembly.
struct Placeable {
    definition: usize,
    representation: usize,
    /// The placement that the assembly moves, and what it is.
    item: usize,
    frame: Frame,
    millimetres: Option<f64>,
}

/// Where a part's placement goes. Its coordinates are in the part's own unit, the result in the assembly's.
fn moved(component: &Frame, item: &Frame, millimetres: Option<f64>, options: &StepOptions) -> Frame {
    let ratio = millimetres.map_or(1.0, |mm| mm / options.unit.millimetres());
    let turned = |d: &UnitVec3| {
        let x =
            component.x.into_inner() * d.x + component.y.into_inner() * d.y + component.z.into_inner() * d.z;
        UnitVec3::new_normalize(x)
    };
    Frame {
        origin: component.global(&(item.origin.coords * ratio)),
        x: turned(&item.x),
        y: turned(&item.y),
        z: turned(&item.z),
    }
}

fn occurrence(
    entities: &mut Entities,
    number: usize,
    (assembly, whole, place): (usize, usize, usize),
    component: &Component,
    root: &Placeable,
) {
    let name = quoted(&component.name);
    let transformation = entities.add(&format!("ITEM_DEFINED_TRANSFORMATION('','',#{},#{place})", root.item));
    let relation = entities.add(&format!(
        "(REPRESENTATION_RELATIONSHIP('','',#{},#{whole})\
         REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{transformation})SHAPE_REPRESENTATION_RELATIONSHIP())",
        root.representation
    ));
    let usage = entities.add(&format!(
        "NEXT_ASSEMBLY_USAGE_OCCURRENCE('{number}',{name},'',#{assembly},#{},$)",
        root.definition
    ));
    let shape =
        entities.add(&format!("PRODUCT_DEFINITION_SHAPE('Placement','Placement of an item',#{usage})"));
    entities.add(&format!("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{shape})"));
}

/// Copies the entities of a part, renumbered from `next` on; its roots under their new numbers.
fn copy(text: &[u8], next: &mut u64, body: &mut Vec<u8>) -> Result<Vec<Placeable>, StepReadError> {
    let exchange = Exchange::parse(text)?;
    let roots = roots(&exchange)?;
    let numbers: BTreeMap<u64, u64> = exchange.ids().zip(*next..).collect();
    *next += numbers.len() as u64;
    let mut placeables = Vec::new();
    let mut inserted: BTreeMap<u64, u64> = BTreeMap::new();
    for Root { definition, representation, placement, millimetres } in roots {
        let known = placement.map(|(id, frame)| (numbers[&id], frame));
        let (item, frame) = known.unwrap_or_else(|| {
            let frame = Frame::from_z(Point3::origin(), Vec3::z_axis());
            let mut own = Entities::starting_at(*next as usize);
            let item = own.placement(&frame) as u64;
            body.extend(own.text().into_bytes());
            body.push(b'\n');
            *next = item + 1;
            inserted.insert(representation, item);
            (item, frame)
        });
        placeables.push(Placeable {
            definition: numbers[&definition] as usize,
            representation: numbers[&representation] as usize,
            item: item as usize,
            frame,
            millimetres,
        });
    }
    for (old, new) in &numbers {
        body.extend(format!("#{new}=").into_bytes());
        let entity = exchange.body(*old).expect("its number was just listed");
        renumbered(*old, entity, &numbers, inserted.get(old), body)?;
        body.extend(b";\n");
    }
    Ok(placeables)
}

/// Appends an entity with new references; those in strings and comments are none. `item`: put first into its list of
/// items.
fn renumbered(
    id: u64,
    entity: &[u8],
    numbers: &BTreeMap<u64, u64>,
    item: Option<&u64>,
    out: &mut Vec<u8>,
) -> Result<(), StepReadError> {
    let (mut at, mut n_lists) = (0, 0);
    while at < entity.len() {
        let rest = &entity[at..];
        let run = match rest[0] {
            quote @ (b'\'' | b'"') => {
                rest[1..].iter().position(|b| *b == quote).map_or(rest.len(), |n| n + 2)
            }
            b'/' if rest.starts_with(b"/*") => {
                rest.windows(2).skip(2).position(|w| w == b"*/").map_or(rest.len(), |n| n + 4)
            }
            b'#' => {
                let digits = rest[1..].iter().take_while(|b| b.is_ascii_digit()).count();
                let old = std::str::from_utf8(&rest[1..=digits]).ok().and_then(|d| d.parse().ok());
                let old: u64 = old.ok_or(StepReadError::Entity {
                    id,
                    found: "has a # without a number".into(),
                    expected: "a reference",
                })?;
                let new = numbers.get(&old).ok_or(StepReadError::Missing(old))?;
                out.extend(format!("#{new}").into_bytes());
                at += 1 + digits;
                continue;
            }
            b'(' => {
                n_lists += 1;
                out.push(b'(');
                // The second list is that of the items: NAME('',(items),context).
                if let Some(item) = item.filter(|_| n_lists == 2) {
                    let is_empty = rest[1..].iter().find(|b| !b.is_ascii_whitespace()) == Some(&b')');
                    out.extend(format!("#{item}{}", if is_empty { "" } else { "," }).into_bytes());
                }
                at += 1;
                continue;
            }
            _ => 1,
        };
        out.extend(&rest[..run]);
        at += run;
    }
    Ok(())
}

/// The newest protocol that any part names; nothing older reads all of them.
fn schema(components: &[Component]) -> Schema {
    let names = |word: &str| {
        components.iter().any(|c| {
            let head = &c.text[..c.text.len().min(HEADER)];
            head.windows(word.len()).any(|w| w == word.as_bytes())
        })
    };
    /// Bytes in which the name of the protocol stands.
    const HEADER: usize = 4096;
    if names("AUTOMOTIVE_DESIGN") && !names("AP242") { Schema::Ap214 } else { Schema::Ap242 }
}

#[cfg(test)]
mod tests {
    use super::renumbered;
    use std::collections::BTreeMap;

    #[test]
    fn references_are_renumbered_and_text_is_not() {
        let numbers = BTreeMap::from([(1, 11), (12, 7)]);
        let mut out = Vec::new();
        renumbered(3, b"NOTE('see #1''s #12',(#1,#12)/* #1 */)", &numbers, None, &mut out).unwrap();
        assert_eq!(out, b"NOTE('see #1''s #12',(#11,#7)/* #1 */)");
        assert!(renumbered(3, b"NOTE(#2)", &numbers, None, &mut Vec::new()).is_err());
        let mut out = Vec::new();
        renumbered(3, b"SHAPE_REPRESENTATION('',(#1),#12)", &numbers, Some(&99), &mut out).unwrap();
        assert_eq!(out, b"SHAPE_REPRESENTATION('',(#99,#11),#7)");
    }
}
