//! Shells, faces, loops and edges as the file has them.

use super::StepReadError;
use super::part21::{Exchange, Instance};

/// A face in the shell of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FaceUse {
    pub(super) id: u64,
    /// Whether the shell uses it the other way round.
    pub(super) reversed: bool,
}

/// A face before its geometry is read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FaceText {
    pub(super) name: String,
    /// None: plane through its corners.
    pub(super) surface: Option<u64>,
    /// Whether the face's normal is that of its surface.
    pub(super) same_sense: bool,
    pub(super) bounds: Vec<Bound>,
}

/// A loop, in the sense in which it bounds the face.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Bound {
    /// Edges and whether they are used forwards.
    Edges(Vec<(u64, bool)>),
    /// Points, joined by lines.
    Points(Vec<u64>),
    /// One vertex.
    Vertex,
}

/// An edge before its curve is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EdgeText {
    /// The points of both ends.
    pub(super) ends: [u64; 2],
    /// None: a line.
    pub(super) curve: Option<u64>,
    pub(super) same_sense: bool,
}

/// Most levels of an oriented thing being of an oriented thing.
const LONGEST_CHAIN: usize = 8;

/// The faces of a solid or surface model; what is wrong with single shells goes to `unread`.
pub(super) fn faces(
    exchange: &Exchange,
    item: u64,
    unread: &mut Vec<String>,
) -> Result<Vec<FaceUse>, StepReadError> {
    let shape = exchange.get(item)?;
    let shells = if shape.is("SHELL_BASED_SURFACE_MODEL") {
        shape.fields("SHELL_BASED_SURFACE_MODEL", 1).references(0)?
    } else if shape.is("FACE_BASED_SURFACE_MODEL") {
        shape.fields("FACE_BASED_SURFACE_MODEL", 1).references(0)?
    } else {
        let mut shells = vec![shape.fields("MANIFOLD_SOLID_BREP", 1).reference(0)?];
        if shape.is("BREP_WITH_VOIDS") {
            shells.extend(shape.fields("BREP_WITH_VOIDS", 2).references(0)?);
        }
        shells
    };
    let mut faces = Vec::new();
    for shell in shells {
        match shell_faces(exchange, shell) {
            Ok(found) => faces.extend(found),
            Err(error) => unread.push(format!("shell #{shell} is left out: {error}")),
        }
    }
    Ok(faces)
}

fn shell_faces(exchange: &Exchange, id: u64) -> Result<Vec<FaceUse>, StepReadError> {
    let (shell, reversed) = oriented(exchange, id, "SHELL")?;
    let kinds = ["CLOSED_SHELL", "OPEN_SHELL", "CONNECTED_FACE_SET"];
    if !kinds.iter().any(|kind| shell.is(kind)) {
        return Err(shell.unsupported());
    }
    let ids = shell.fields("CONNECTED_FACE_SET", 1).references(0)?;
    Ok(ids.into_iter().map(|id| FaceUse { id, reversed }).collect())
}

/// The thing behind `ORIENTED_...`, and whether an odd number of them turn it round.
fn oriented<'a>(exchange: &Exchange<'a>, id: u64, what: &str) -> Result<(Instance<'a>, bool), StepReadError> {
    let (mut entity, mut reversed) = (exchange.get(id)?, false);
    for _ in 0..LONGEST_CHAIN {
        let leaf = entity.leaves.iter().find(|l| l.name.starts_with("ORIENTED_") && l.name.ends_with(what));
        let Some(name) = leaf.map(|l| l.name) else { return Ok((entity, reversed)) };
        // Name, the inherited attributes (derived), the thing, the sense.
        let fields = entity.fields(name, 2);
        reversed ^= !fields.flag(1)?;
        entity = exchange.get(fields.reference(0)?)?;
    }
    Err(StepReadError::Cycle(id))
}

/// Reads a face.
pub(super) fn face(exchange: &Exchange, use_: FaceUse) -> Result<(FaceText, bool), StepReadError> {
    let (entity, turned) = oriented(exchange, use_.id, "FACE")?;
    let reversed = turned != use_.reversed;
    let is_face = ["ADVANCED_FACE", "FACE_SURFACE", "FACE"].iter().any(|kind| entity.is(kind));
    if !is_face {
        return Err(entity.unsupported());
    }
    let (surface, same_sense) = if entity.is("FACE") && entity.leaves.len() == 1 {
        (None, true)
    } else {
        let fields = entity.fields("FACE_SURFACE", 2);
        (Some(fields.reference(0)?), fields.flag(1)?)
    };
    let bounds = entity.fields("FACE", 1).references(0)?;
    let bounds = bounds.into_iter().map(|id| bound(exchange, id)).collect::<Result<Vec<_>, _>>()?;
    Ok((FaceText { name: entity.name(), surface, same_sense, bounds }, reversed))
}

fn bound(exchange: &Exchange, id: u64) -> Result<Bound, StepReadError> {
    let entity = exchange.get(id)?;
    if !(entity.is("FACE_BOUND") || entity.is("FACE_OUTER_BOUND")) {
        return Err(entity.wrong(format!("is {}", entity.kind()), "FACE_BOUND"));
    }
    let fields = entity.fields("FACE_BOUND", 1);
    let (run, forward) = (exchange.get(fields.reference(0)?)?, fields.flag(1)?);
    if run.is("VERTEX_LOOP") {
        return Ok(Bound::Vertex);
    }
    if run.is("POLY_LOOP") {
        let mut points = run.fields("POLY_LOOP", 1).references(0)?;
        if !forward {
            points.reverse();
        }
        return Ok(Bound::Points(points));
    }
    if !run.is("EDGE_LOOP") {
        return Err(run.unsupported());
    }
    let list = if run.leaves.len() == 1 { run.fields("", 1) } else { run.fields("PATH", 0) };
    let mut edges =
        list.references(0)?.into_iter().map(|id| edge_use(exchange, id)).collect::<Result<Vec<_>, _>>()?;
    if !forward {
        edges.reverse();
        for (_, sense) in &mut edges {
            *sense = !*sense;
        }
    }
    Ok(Bound::Edges(edges))
}

fn edge_use(exchange: &Exchange, id: u64) -> Result<(u64, bool), StepReadError> {
    let (mut entity, mut forward) = (exchange.get(id)?, true);
    for _ in 0..LONGEST_CHAIN {
        if !entity.is("ORIENTED_EDGE") {
            return Ok((entity.id, forward));
        }
        let fields = match entity.leaves.len() {
            1 => entity.fields("", 3),
            _ => entity.fields("ORIENTED_EDGE", 0),
        };
        forward ^= !fields.flag(1)?;
        entity = exchange.get(fields.reference(0)?)?;
    }
    Err(StepReadError::Cycle(id))
}

/// Reads an edge.
pub(super) fn edge(exchange: &Exchange, id: u64) -> Result<EdgeText, StepReadError> {
    let entity = exchange.get(id)?;
    if !(entity.is("EDGE_CURVE") || entity.is("EDGE")) {
        return Err(entity.unsupported());
    }
    let fields = entity.fields("EDGE", 1);
    let end = |i: usize| {
        let vertex = exchange.get(fields.reference(i)?)?;
        if !vertex.is("VERTEX_POINT") {
            return Err(vertex.wrong(format!("is {}", vertex.kind()), "VERTEX_POINT"));
        }
        let fields = vertex.fields("VERTEX_POINT", 1);
        fields.reference(0)
    };
    let ends = [end(0)?, end(1)?];
    if !entity.is("EDGE_CURVE") {
        return Ok(EdgeText { ends, curve: None, same_sense: true });
    }
    let geometry = entity.fields("EDGE_CURVE", 3);
    Ok(EdgeText { ends, curve: geometry.optional(0), same_sense: geometry.flag(1)? })
}
