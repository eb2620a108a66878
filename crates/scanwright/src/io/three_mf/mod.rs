//! 3MF: a zip archive of XML, with units, objects, components and build items.
//!
//! What the archive unpacks to is counted as it comes out and capped. Copies made by build items and components are
//! capped as if the file had spelled them out.

mod model;
mod package;

use super::error::{ReadError, quoted};
use super::{Unit, check_numbering, is_coordinate};
use crate::math::Point3;
use crate::mesh::Mesh;
use model::{IDENTITY, Instance, Model, Object, Transform, parse_model, parse_relationships};
use package::{Package, archive_error};
use std::collections::{BTreeMap, BTreeSet};

/// Components nested deeper are refused; assemblies have three or four levels.
const DEEPEST: usize = 32;
/// Bytes of the shortest vertex or triangle in XML, `<vertex x="0" y="0" z="0"/>`.
const SMALLEST_ELEMENT: u64 = 27;

/// Whether the file begins as zip archives do.
pub(super) fn is_zip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

/// Reads all build items into one mesh.
pub(super) fn read(bytes: &[u8]) -> Result<(Mesh, Option<Unit>), ReadError> {
    let mut package = Package::open(bytes)?;
    let root = root_model(&mut package)?;
    let mut models = BTreeMap::new();
    load(&mut package, &root, &mut models)?;
    let unit = models[&root].unit;
    let limit = package.budget.limit / SMALLEST_ELEMENT;
    let mut assembly = Assembly { models: &models, mesh: Mesh::default(), sizes: BTreeMap::new() };
    let items = items(&models[&root]);
    let mut size = 0_u64;
    for item in &items {
        size = size.saturating_add(assembly.size(&root, item, 0)?);
    }
    if limit < size {
        return Err(package.budget.error());
    }
    for item in &items {
        assembly.place(&root, item, &IDENTITY)?;
    }
    Ok((assembly.mesh, unit))
}

fn root_model(package: &mut Package<'_>) -> Result<String, ReadError> {
    let target = match package.find("_rels/.rels") {
        Some(name) => package.read(&name, |source| Ok(parse_relationships(source)))?,
        None => None,
    };
    target
        .and_then(|path| package.find(&path))
        .or_else(|| package.first_model())
        .ok_or_else(|| archive_error(&"it has no model part; is it a 3MF?"))
}

/// Parses the model part `name` and those that it refers to.
fn load(
    package: &mut Package<'_>,
    name: &str,
    models: &mut BTreeMap<String, Model>,
) -> Result<(), ReadError> {
    let mut wanted = vec![name.to_owned()];
    while let Some(name) = wanted.pop() {
        if models.contains_key(&name) {
            continue;
        }
        let mut model = package.read(&name, |source| parse_model(source, &name))?;
        let objects = model.objects.values_mut().flat_map(|object| &mut object.components);
        for instance in objects.chain(&mut model.items) {
            if let Some(path) = &mut instance.path {
                *path = package
                    .find(path)
                    .ok_or_else(|| archive_error(&format!("part {} is missing", quoted(path.as_bytes()))))?;
                wanted.push(path.clone());
            }
        }
        models.insert(name, model);
    }
    Ok(())
}

/// The build items; when there are none, the objects that are no component of another.
fn items(model: &Model) -> Vec<Instance> {
    if !model.items.is_empty() {
        return model.items.clone();
    }
    let components = model.objects.values().flat_map(|object| &object.components);
    let used: BTreeSet<u32> = components.filter(|c| c.path.is_none()).map(|c| c.object).collect();
    let whole = model.objects.keys().filter(|id| !used.contains(id));
    whole.map(|&object| Instance { path: None, object, transform: IDENTITY }).collect()
}

struct Assembly<'a> {
    models: &'a BTreeMap<String, Model>,
    mesh: Mesh,
    /// Vertices and triangles of each object with all its components; `None` while it is being counted.
    sizes: BTreeMap<(String, u32), Option<u64>>,
}

impl<'a> Assembly<'a> {
    fn find<'b>(&self, part: &'b str, instance: &'b Instance) -> Result<(&'b str, &'a Object), ReadError> {
        let part = instance.path.as_deref().unwrap_or(part);
        let object = self.models.get(part).and_then(|model| model.objects.get(&instance.object));
        let missing = || {
            archive_error(&format!(
                "object {} of part {} is missing",
                instance.object,
                quoted(part.as_bytes())
            ))
        };
        Ok((part, object.ok_or_else(missing)?))
    }

    fn size(&mut self, part: &str, instance: &Instance, depth: usize) -> Result<u64, ReadError> {
        let (part, object) = self.find(part, instance)?;
        let key = (part.to_owned(), instance.object);
        match self.sizes.get(&key) {
            Some(Some(size)) => return Ok(*size),
            None if depth < DEEPEST => {}
            _ => {
                let reason = format!("object {} contains itself or is nested too deep", instance.object);
                return Err(archive_error(&reason));
            }
        }
        self.sizes.insert(key.clone(), None);
        let mut size = 0_u64;
        if !object.is_support {
            size = (object.mesh.vertices.len() + object.mesh.triangles.len()) as u64;
            for component in &object.components {
                size = size.saturating_add(self.size(part, component, depth + 1)?);
            }
        }
        self.sizes.insert(key, Some(size));
        Ok(size)
    }

    fn place(&mut self, part: &str, instance: &Instance, outer: &Transform) -> Result<(), ReadError> {
        let (part, object) = self.find(part, instance)?;
        // Empty objects could be nested into more visits than there are triangles.
        if self.sizes.get(&(part.to_owned(), instance.object)) == Some(&Some(0)) {
            return Ok(());
        }
        let transform = compose(&instance.transform, outer);
        self.append(&object.mesh, &transform, instance.object)?;
        for component in &object.components {
            self.place(part, component, &transform)?;
        }
        Ok(())
    }

    fn append(&mut self, mesh: &Mesh, transform: &Transform, object: u32) -> Result<(), ReadError> {
        let base = self.mesh.vertices.len();
        check_numbering((base + mesh.vertices.len()) as u64, "vertices")?;
        for vertex in &mesh.vertices {
            let moved = apply(transform, vertex);
            if !moved.iter().all(|x| is_coordinate(*x)) {
                let reason = format!("a transform moves object {object} to where numbers end");
                return Err(archive_error(&reason));
            }
            self.mesh.vertices.push(moved);
        }
        let mirrored = determinant(transform) < 0.0;
        self.mesh.triangles.extend(mesh.triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|v| base as u32 + v);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
        Ok(())
    }
}

fn apply(m: &Transform, p: &Point3) -> Point3 {
    Point3::from(std::array::from_fn(|j| p.x * m[j] + p.y * m[3 + j] + p.z * m[6 + j] + m[9 + j]))
}

/// First `inner`, then `outer`.
fn compose(inner: &Transform, outer: &Transform) -> Transform {
    std::array::from_fn(|i| {
        let (row, j) = (i / 3, i % 3);
        let linear: f64 = (0..3).map(|k| inner[3 * row + k] * outer[3 * k + j]).sum();
        if row == 3 { linear + outer[9 + j] } else { linear }
    })
}

fn determinant(m: &Transform) -> f64 {
    m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6])
        + m[2] * (m[3] * m[7] - m[4] * m[6])
}
