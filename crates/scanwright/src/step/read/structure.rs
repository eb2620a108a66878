//! Which shapes a file holds, and where its assemblies put them.
//!
//! A representation holds items in one space. Representations of one space are tied by plain relationships; a
//! component is tied to its assembly by a relationship with a transformation, or is an item of it as `MAPPED_ITEM`.
//! ISO 10303-43 (representations) and -44 (product structure).

use std::collections::{BTreeMap, BTreeSet};

use super::StepReadError;
use super::part21::{Exchange, Instance};
use super::placement::{Motion, frame, motion};
use super::units::{self, Units};
use crate::math::Frame;

/// Most placed components: an assembly of assemblies can stand for any number.
const MOST_VISITS: usize = 100_000;
/// Most levels of assemblies within assemblies.
const DEEPEST: usize = 64;

/// A shape where an assembly puts it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Placed {
    /// The solid or the surface model.
    pub(super) item: u64,
    /// Units of its coordinates.
    pub(super) units: Units,
    /// From its coordinates to those of the file's first root.
    pub(super) motion: Motion,
    /// Name of the product, or of the occurrence where the product has none.
    pub(super) name: String,
}

/// All shapes, and what could not be followed.
#[derive(Debug, Default)]
pub(super) struct Structure {
    pub(super) placed: Vec<Placed>,
    /// Units of the first root.
    pub(super) units: Units,
    pub(super) unread: Vec<String>,
}

/// A component of a representation.
#[derive(Debug, Clone)]
struct Child {
    representation: u64,
    /// From the component's placement to that of the assembly, each in its own units.
    from: Option<u64>,
    to: Option<u64>,
    name: Option<String>,
}

/// Finds the shapes of a file, depth first in the order of its entities.
pub(super) fn read(exchange: &Exchange) -> Result<Structure, StepReadError> {
    let mut walk = Walk::new(exchange);
    walk.relationships();
    let roots = walk.roots();
    // A shape is held a second time by representations for checks and notes, which no product has.
    let (of_products, others): (Vec<u64>, Vec<u64>) =
        roots.into_iter().partition(|r| walk.space(*r).iter().any(|r| walk.names.contains_key(r)));
    let mut first = None;
    for root in of_products.into_iter().chain(others) {
        walk.known = walk.structure.placed.iter().map(|p| p.item).collect();
        if walk.space(root).iter().any(|r| walk.names.contains_key(r)) {
            walk.known.clear();
        }
        let units = walk.units(root);
        let file_units = *first.get_or_insert(units);
        let into_file = ratio(&units, &file_units);
        let mut path = vec![];
        walk.visit(root, &Motion::scaling(into_file), None, &mut path)?;
    }
    walk.structure.units = first.unwrap_or_default();
    Ok(walk.structure)
}

/// A product that no assembly of the file holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::step) struct Root {
    pub(in crate::step) definition: u64,
    pub(in crate::step) representation: u64,
    /// The first placement among the items of the representation.
    pub(in crate::step) placement: Option<(u64, Frame)>,
    /// Length of its unit.
    pub(in crate::step) millimetres: Option<f64>,
}

/// The products of a file that are components of none.
pub(in crate::step) fn roots(exchange: &Exchange) -> Result<Vec<Root>, StepReadError> {
    let mut walk = Walk::new(exchange);
    walk.relationships();
    let mut roots = Vec::new();
    for (definition, representations) in &walk.of_definition {
        let is_component = |r: &u64| walk.space(*r).iter().any(|r| walk.is_child.contains(r));
        // One of several representations of a product is enough to place it.
        let Some(representation) = representations.first().copied().filter(|r| !is_component(r)) else {
            continue;
        };
        let items = exchange.get(representation)?.fields("REPRESENTATION", 0).references(1)?;
        let placement =
            items.into_iter().find(|i| exchange.get(*i).is_ok_and(|e| e.is("AXIS2_PLACEMENT_3D")));
        let placement = placement.map(|id| frame(exchange, id).map(|frame| (id, frame))).transpose()?;
        let millimetres = walk.units(representation).millimetres;
        roots.push(Root { definition: *definition, representation, placement, millimetres });
    }
    if roots.is_empty() {
        Err(StepReadError::NoFaces { first: Some("no product has a shape".into()) })
    } else {
        Ok(roots)
    }
}

/// Items that are read.
const SHAPES: &[&str] = &[
    "MANIFOLD_SOLID_BREP",
    "BREP_WITH_VOIDS",
    "FACETED_BREP",
    "SHELL_BASED_SURFACE_MODEL",
    "FACE_BASED_SURFACE_MODEL",
];

/// Items that hold shape and are not read.
const UNSUPPORTED: &[&str] = &[
    "SOLID_REPLICA",
    "SWEPT_AREA_SOLID",
    "EXTRUDED_AREA_SOLID",
    "REVOLVED_AREA_SOLID",
    "CSG_SOLID",
    "BOOLEAN_RESULT",
    "GEOMETRIC_SET",
    "TESSELLATED_SOLID",
    "TESSELLATED_SHELL",
    "TRIANGULATED_FACE",
    "COMPLEX_TRIANGULATED_FACE",
];

fn ratio(from: &Units, to: &Units) -> f64 {
    match (from.millimetres, to.millimetres) {
        (Some(from), Some(to)) => from / to,
        _ => 1.0,
    }
}

struct Walk<'a, 'x> {
    exchange: &'x Exchange<'a>,
    structure: Structure,
    /// Representations of the same space.
    same: BTreeMap<u64, Vec<u64>>,
    children: BTreeMap<u64, Vec<Child>>,
    is_child: BTreeSet<u64>,
    /// Names of products by representation.
    names: BTreeMap<u64, String>,
    /// Representations of assemblies by product definition.
    of_definition: BTreeMap<u64, Vec<u64>>,
    n_visits: usize,
    /// Shapes that are not placed again.
    known: BTreeSet<u64>,
}

impl<'a, 'x> Walk<'a, 'x> {
    fn new(exchange: &'x Exchange<'a>) -> Self {
        let mut walk = Self {
            exchange,
            structure: Structure::default(),
            same: BTreeMap::new(),
            children: BTreeMap::new(),
            is_child: BTreeSet::new(),
            names: BTreeMap::new(),
            of_definition: BTreeMap::new(),
            n_visits: 0,
            known: BTreeSet::new(),
        };
        for id in exchange.all("SHAPE_DEFINITION_REPRESENTATION") {
            // Many of these describe notes; those that do not lead to a product are none of ours.
            let Some((definition, representation)) = walk.definition(*id) else { continue };
            walk.of_definition.entry(definition).or_default().push(representation);
            if let Some(name) = product_name(exchange, definition) {
                walk.names.insert(representation, name);
            }
        }
        walk
    }

    /// Product definition and representation of a `SHAPE_DEFINITION_REPRESENTATION`.
    fn definition(&self, id: u64) -> Option<(u64, u64)> {
        let entity = self.exchange.get(id).ok()?;
        let fields = entity.fields("PROPERTY_DEFINITION_REPRESENTATION", 0);
        let shape = self.exchange.get(fields.optional(0)?).ok()?;
        let definition = shape.fields("PROPERTY_DEFINITION", 0).optional(2)?;
        let of_product = self.exchange.get(definition).ok()?;
        if !of_product.leaves.iter().any(|leaf| leaf.name.starts_with("PRODUCT_DEFINITION")) {
            return None;
        }
        Some((definition, fields.optional(1)?))
    }

    fn relationships(&mut self) {
        let exchange = self.exchange;
        let occurrences = self.occurrences();
        let types = ["SHAPE_REPRESENTATION_RELATIONSHIP", "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"];
        let ids: BTreeSet<u64> = types.iter().flat_map(|t| exchange.all(t)).copied().collect();
        for id in ids {
            let result = exchange.get(id).and_then(|entity| self.relationship(&entity, &occurrences));
            if let Err(error) = result {
                self.structure.unread.push(format!("a placement is left out: {error}"));
            }
        }
        for id in exchange.all("MAPPED_ITEM") {
            if let Ok(Some(child)) = exchange.get(*id).and_then(|item| self.mapped(&item)) {
                self.is_child.insert(child.representation);
            }
        }
    }

    /// Occurrence of every relationship that places one: assembly's definition and name.
    fn occurrences(&self) -> BTreeMap<u64, (u64, String)> {
        let mut found = BTreeMap::new();
        for id in self.exchange.all("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION") {
            let Ok(entity) = self.exchange.get(*id) else { continue };
            let (Some(relation), Some(shape)) =
                (entity.all_fields().optional(0), entity.all_fields().optional(1))
            else {
                continue;
            };
            let usage =
                self.exchange.get(shape).ok().and_then(|s| s.fields("PROPERTY_DEFINITION", 0).optional(2));
            let Some(usage) = usage.and_then(|u| self.exchange.get(u).ok()) else { continue };
            let fields = usage.fields("PRODUCT_DEFINITION_RELATIONSHIP", 0);
            if let Some(assembly) = fields.optional(3) {
                let name = fields.text(1).filter(|n| !n.is_empty()).or_else(|| fields.text(0));
                found.insert(relation, (assembly, name.unwrap_or_default()));
            }
        }
        found
    }

    fn relationship(
        &mut self,
        entity: &Instance,
        occurrences: &BTreeMap<u64, (u64, String)>,
    ) -> Result<(), StepReadError> {
        let fields = entity.fields("REPRESENTATION_RELATIONSHIP", 0);
        let (first, second) = (fields.reference(2)?, fields.reference(3)?);
        if !entity.is("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION") {
            self.same.entry(first).or_default().push(second);
            self.same.entry(second).or_default().push(first);
            return Ok(());
        }
        let with = entity.fields("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION", 4).reference(0)?;
        let transformation = self.exchange.get(with)?;
        let occurrence = occurrences.get(&entity.id);
        // The component comes first, says the standard's use; some writers turn it round, and the occurrence tells.
        let holds = |rep: u64| {
            let of = occurrence.and_then(|(assembly, _)| self.of_definition.get(assembly));
            of.is_some_and(|reps| reps.contains(&rep))
        };
        let reversed = holds(first) && !holds(second);
        let (child, parent) = if reversed { (second, first) } else { (first, second) };
        let (from, to) = if transformation.is("ITEM_DEFINED_TRANSFORMATION") {
            let fields = transformation.fields("ITEM_DEFINED_TRANSFORMATION", 0);
            let (one, two) = (fields.reference(2)?, fields.reference(3)?);
            if reversed { (Some(two), Some(one)) } else { (Some(one), Some(two)) }
        } else {
            (None, Some(transformation.id))
        };
        let name = occurrence.map(|(_, name)| name.clone());
        self.children.entry(parent).or_default().push(Child { representation: child, from, to, name });
        self.is_child.insert(child);
        Ok(())
    }

    fn mapped(&self, item: &Instance) -> Result<Option<Child>, StepReadError> {
        let fields = item.fields("MAPPED_ITEM", 1);
        let map = self.exchange.get(fields.reference(0)?)?;
        let source = map.fields("REPRESENTATION_MAP", 0);
        let representation = source.reference(1)?;
        let (from, to) = (source.optional(0), fields.optional(1));
        // Views and notes are mapped from and to things that are no placements.
        let places =
            |id: Option<u64>| id.is_none_or(|id| self.exchange.get(id).is_ok_and(|e| is_placement(&e)));
        let holds_shape = self.exchange.get(representation).is_ok_and(|r| is_shape_representation(&r));
        Ok((holds_shape && places(from) && places(to)).then_some(Child {
            representation,
            from,
            to,
            name: None,
        }))
    }

    /// Representations that nothing places, one for each space, ascending; then shapes that stand alone.
    fn roots(&mut self) -> Vec<u64> {
        let shape_types = self.exchange.types().filter(|t| t.ends_with("SHAPE_REPRESENTATION"));
        let all: BTreeSet<u64> = shape_types
            .filter(|t| *t != "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION")
            .flat_map(|t| self.exchange.all(t))
            .copied()
            .collect();
        let mut seen = BTreeSet::new();
        let mut roots = Vec::new();
        for id in &all {
            if seen.contains(id) {
                continue;
            }
            let space = self.space(*id);
            if !space.iter().any(|r| self.is_child.contains(r)) {
                roots.push(*id);
            }
            seen.extend(space);
        }
        // A cycle has no root: its first member is entered, and the walk says where it closes.
        if roots.is_empty() {
            roots.extend(all.first());
        }
        roots
    }

    /// All representations of the space of `id`, ascending.
    fn space(&self, id: u64) -> BTreeSet<u64> {
        let (mut found, mut open) = (BTreeSet::from([id]), vec![id]);
        while let Some(next) = open.pop() {
            for other in self.same.get(&next).into_iter().flatten() {
                if found.insert(*other) {
                    open.push(*other);
                }
            }
        }
        found
    }

    fn units(&self, representation: u64) -> Units {
        let context =
            self.exchange.get(representation).and_then(|r| r.fields("REPRESENTATION", 0).reference(2));
        context.and_then(|c| units::of_context(self.exchange, c)).unwrap_or_default()
    }

    fn visit(
        &mut self,
        representation: u64,
        motion: &Motion,
        name: Option<&str>,
        path: &mut Vec<u64>,
    ) -> Result<(), StepReadError> {
        if path.contains(&representation) || path.len() >= DEEPEST {
            return Err(StepReadError::Cycle(representation));
        }
        self.n_visits += 1;
        if self.n_visits > MOST_VISITS {
            return Err(StepReadError::TooLarge {
                id: representation,
                most: MOST_VISITS,
                what: "placed components",
            });
        }
        path.push(representation);
        let space = self.space(representation);
        let named = space.iter().find_map(|r| self.names.get(r)).filter(|n| !n.is_empty()).cloned();
        let name = named.as_deref().or(name).map(str::to_owned);
        for id in &space {
            let units = self.units(*id);
            let mut children = self.items(*id, &units, motion, name.as_deref());
            children.extend(self.children.get(id).cloned().unwrap_or_default());
            for child in &children {
                let child_name = child.name.as_deref().filter(|n| !n.is_empty()).or(name.as_deref());
                match self.placement(child, &units) {
                    Ok(step) => {
                        self.visit(child.representation, &motion.after(&step), child_name, path)?;
                    }
                    Err(error) => self.structure.unread.push(format!("a component is left out: {error}")),
                }
            }
        }
        path.pop();
        Ok(())
    }

    /// From the child's coordinates to those of a representation with `units`.
    fn placement(&self, child: &Child, units: &Units) -> Result<Motion, StepReadError> {
        let read = |id: Option<u64>| id.map_or(Ok(Motion::identity()), |id| motion(self.exchange, id));
        let (from, to) = (read(child.from)?, read(child.to)?);
        let back = from.inverse().ok_or(StepReadError::Entity {
            id: child.from.unwrap_or(child.representation),
            found: "is a transformation that nothing undoes".into(),
            expected: "a placement",
        })?;
        let into = Motion::scaling(ratio(&self.units(child.representation), units));
        let whole = to.after(&into).after(&back);
        if whole.is_finite() {
            return Ok(whole);
        }
        Err(StepReadError::Entity {
            id: child.to.unwrap_or(child.representation),
            found: "is beyond all numbers".into(),
            expected: "a placement",
        })
    }

    /// Notes the shapes among the items of a representation; its mapped items.
    fn items(&mut self, id: u64, units: &Units, motion: &Motion, name: Option<&str>) -> Vec<Child> {
        let list = self.exchange.get(id).and_then(|rep| rep.fields("REPRESENTATION", 0).references(1));
        let mut children = Vec::new();
        for item in list.unwrap_or_default() {
            if self.known.contains(&item) {
                continue;
            }
            let entity = match self.exchange.get(item) {
                Ok(entity) => entity,
                Err(error) => {
                    self.structure.unread.push(format!("an item of #{id} is left out: {error}"));
                    continue;
                }
            };
            if SHAPES.iter().any(|s| entity.is(s)) {
                let name = name.unwrap_or_default().to_owned();
                self.structure.placed.push(Placed { item, units: *units, motion: *motion, name });
            } else if entity.is("MAPPED_ITEM") {
                match self.mapped(&entity) {
                    Ok(child) => children.extend(child),
                    Err(error) => self.structure.unread.push(format!("a mapped item is left out: {error}")),
                }
            } else if UNSUPPORTED.iter().any(|s| entity.is(s)) {
                self.structure.unread.push(format!("a shape is left out: {}", entity.unsupported()));
            }
        }
        children
    }
}

fn is_placement(entity: &Instance) -> bool {
    ["AXIS2_PLACEMENT_3D", "CARTESIAN_TRANSFORMATION_OPERATOR_3D"].iter().any(|t| entity.is(t))
}

fn is_shape_representation(entity: &Instance) -> bool {
    entity.leaves.iter().any(|leaf| leaf.name.ends_with("SHAPE_REPRESENTATION"))
}

/// Name of the product that a definition is of, or its number where it has no name.
fn product_name(exchange: &Exchange, definition: u64) -> Option<String> {
    let definition = exchange.get(definition).ok()?;
    let formation = exchange.get(definition.fields("PRODUCT_DEFINITION", 0).optional(2)?).ok()?;
    let product = exchange.get(formation.fields("PRODUCT_DEFINITION_FORMATION", 0).optional(2)?).ok()?;
    let fields = product.fields("PRODUCT", 0);
    fields.text(1).filter(|name| !name.is_empty()).or_else(|| fields.text(0))
}
