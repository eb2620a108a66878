//! Closes the holes of a labelled scan by extending the surfaces around them.

mod chart;
mod extend;
mod fill;
mod membrane;
mod mouth;
mod network;
mod patch;
mod sheet;
mod shell;
mod shoulder;
mod undercut;

use super::LabelledMesh;
use crate::condition::Support;
use crate::mesh::{Adjacency, Mesh, VertId};
use crate::segment::{RegionId, Segmentation};
use crate::surface::Plane;
use crate::tolerance::Tolerances;
use shell::{Hole, Shell};

/// A scan after closing.
#[derive(Debug, Clone, PartialEq)]
pub struct Closed {
    /// The mesh with what was added; closed when `open` is empty.
    pub labelled: LabelledMesh,
    /// Holes that nothing closes.
    pub open: Vec<OpenHole>,
    /// Regions of the scan that are two ends of one surface: the one that stays (its surface now fits both), the one
    /// that has no triangles left.
    pub merged: Vec<(RegionId, RegionId)>,
    /// Regions with assumed triangles, ascending.
    pub assumed_faces: Vec<AssumedFace>,
}

/// A hole that was left open.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenHole {
    /// Its rim, vertices of the closed mesh in order; the hole on the left, seen from outside.
    pub rim: Vec<VertId>,
    /// Why it was not closed.
    pub reason: String,
}

/// Why a region has triangles that were not scanned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Assumption {
    /// A scanned surface was extended into what the scanner did not see.
    Extended,
    /// The bottom on the table.
    Support,
    /// A flat end that nothing shows.
    Cap,
}

/// A region with assumed triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AssumedFace {
    /// The region.
    pub region: RegionId,
    /// Why.
    pub assumption: Assumption,
    /// Area of its assumed triangles.
    pub area: f64,
}

/// Regions made here, and what they stand for.
#[derive(Debug, Default)]
struct Made {
    support: Vec<u32>,
    caps: Vec<u32>,
}

/// Closes `mesh` (oriented, manifold, without the table) by extending the surfaces of `segmentation`.
pub fn close(
    mesh: &Mesh,
    segmentation: &Segmentation,
    support: Option<&Support>,
    tolerances: &Tolerances,
) -> Closed {
    let spacing = spacing_of(mesh, tolerances);
    let mut shell = Shell::new(mesh, segmentation, spacing);
    let mut made = Made::default();
    let mut holes = shell.holes();
    bridge_bores(&mut shell, &mut holes);
    join_on_planes(&mut shell, &mut holes);
    made.caps.extend(network::close_crossings(&mut shell, &mut holes));
    if let Some(support) = support {
        close_on_support(&mut shell, &mut holes, &support.plane, &mut made);
    }
    shoulder::join_at_planes(&mut shell, &mut holes);
    made.caps.extend(shoulder::assume_shoulders(&mut shell, &mut holes));
    fill_windows(&mut shell, &mut holes);
    cap_mouths(&mut shell, &mut holes, &mut made);
    let mut open = fill_rest(&mut shell, holes);
    shell.part_doubled_edges();
    if open.is_empty() {
        open = fill_pinched(&mut shell);
    }
    shell.absorb_islands();
    for label in made.support.clone() {
        made.support.extend(shell.part_region(label));
    }
    finish(shell, open, &made)
}

/// The spacing that was measured, or else that of the mesh.
fn spacing_of(mesh: &Mesh, tolerances: &Tolerances) -> f64 {
    let measured = tolerances.spacing();
    if measured.is_finite() && measured > 0.0 {
        return measured;
    }
    (mesh.total_area() / mesh.vertices.len().max(1) as f64).sqrt().max(f64::MIN_POSITIVE)
}

/// Joins the two mouths of every bore (or shaft) that face each other.
fn bridge_bores(shell: &mut Shell, holes: &mut Vec<Hole>) {
    while let Some((i, j, label)) = mouth::facing_pair(shell, holes) {
        let filled = fill::fill_on_surface(shell, &[&holes[i].rim, &holes[j].rim], label);
        if !filled {
            // Not to be found again.
            break;
        }
        holes.remove(i.max(j));
        holes.remove(i.min(j));
    }
}

/// How near the table a loop must lie, in spacings, to be taken for the part's contact with it: the skirt between part
/// and table that segmentation drops is up to three wide, teeth of the rim as much again.
const NEAR_SUPPORT: f64 = 8.0;

/// Ends on the table what stands on it: with contact lines parted from what was hidden above them, else as loops are.
fn close_on_support(shell: &mut Shell, holes: &mut Vec<Hole>, table: &Plane, made: &mut Made) {
    let near = NEAR_SUPPORT * shell.spacing;
    let lines: Vec<_> = holes.iter().map(|hole| undercut::lines(shell, hole, table, near)).collect();
    let parted: Vec<usize> = (0..holes.len()).filter(|i| !lines[*i].is_empty()).collect();
    if !parted.is_empty() {
        let (mut trial, mut contacts, mut windows) = (shell.clone(), holes.clone(), Vec::new());
        for &i in &parted {
            let (contact, above) = undercut::parts(&mut trial, &holes[i], &lines[i]);
            contacts[i] = contact;
            windows.extend(above);
        }
        if let Some((label, closed)) = end_on_table(&mut trial, &contacts, table)
            && parted.iter().all(|i| closed.contains(i))
        {
            windows.splice(0..0, without(contacts, &closed));
            (*shell, *holes) = (trial, windows);
            made.support.push(label);
            return;
        }
    }
    if let Some((label, closed)) = end_on_table(shell, holes, table) {
        *holes = without(std::mem::take(holes), &closed);
        made.support.push(label);
    }
}

fn without(holes: Vec<Hole>, gone: &[usize]) -> Vec<Hole> {
    holes.into_iter().enumerate().filter(|(i, _)| !gone.contains(i)).map(|(_, hole)| hole).collect()
}

/// Extends the holes that stand on the table to it and closes them there. Returns the label of the bottom, and which
/// holes were closed; `None`, changing nothing, when none stands there.
fn end_on_table(shell: &mut Shell, holes: &[Hole], table: &Plane) -> Option<(u32, Vec<usize>)> {
    let mut group: Vec<(usize, Vec<u32>)> = Vec::new();
    for (i, hole) in holes.iter().enumerate() {
        if is_pinhole(shell, hole) {
            continue;
        }
        if let Some(mouth) = mouth::mouth(shell, hole).filter(|mouth| mouth.arrives_at(shell, table)) {
            group.push((i, vec![mouth.label; hole.rim.len()]));
        } else if sheet::surrounds(shell, hole, table, NEAR_SUPPORT * shell.spacing) {
            group.push((i, hole.labels.clone()));
        }
    }
    let bottom = Plane { point: table.point, normal: -table.normal };
    while !group.is_empty() {
        let chosen: Vec<&Hole> = group.iter().map(|(i, _)| &holes[*i]).collect();
        let walls: Vec<Vec<u32>> = group.iter().map(|(_, walls)| walls.clone()).collect();
        let label = shell.add_plane(bottom);
        if extend::extend_and_cap(shell, &chosen, &walls, &bottom, label) {
            return Some((label, group.into_iter().map(|(i, _)| i).collect()));
        }
        shell.primitives.pop();
        // The shortest loop is the least certain to stand on the table.
        group.pop();
    }
    None
}

/// Whether a hole lies inside one region and is smaller than any opening that a scan can show: data that is missing, not
/// a way down to the table.
fn is_pinhole(shell: &Shell, hole: &Hole) -> bool {
    /// In spacings: length of the rim of a round opening two spacings wide.
    const RIM: f64 = 6.3;
    let at = |v: u32| shell.mesh.vertices[v as usize];
    let next = hole.rim.iter().cycle().skip(1);
    let length: f64 = hole.rim.iter().zip(next).map(|(a, b)| (at(*b) - at(*a)).norm()).sum();
    hole.labels.windows(2).all(|pair| pair[0] == pair[1]) && length <= RIM * shell.spacing
}

/// Fills the rings between loops that lie on one plane, such as a shoulder that is seen in places.
fn join_on_planes(shell: &mut Shell, holes: &mut Vec<Hole>) {
    for (label, members) in sheet::shared_planes(shell, holes) {
        if members.iter().any(|&i| holes[i].rim.is_empty()) {
            continue;
        }
        let rims: Vec<&[u32]> = members.iter().map(|&i| holes[i].rim.as_slice()).collect();
        if fill::fill_on_surface(shell, &rims, label) {
            for i in members {
                holes[i].rim.clear();
            }
        }
    }
    holes.retain(|hole| !hole.rim.is_empty());
}

/// Fills every loop that bounds a part of one of its surfaces.
fn fill_windows(shell: &mut Shell, holes: &mut Vec<Hole>) {
    holes.retain(|hole| {
        !sheet::candidates(shell, hole)
            .into_iter()
            .any(|label| fill::fill_on_surface(shell, &[&hole.rim], label))
    });
}

/// A cap lies this far beyond the deepest vertex of the rim, in spacings: on it, walls would have no height.
const CAP_OFFSET: f64 = 0.5;

/// Ends every bore (or shaft) whose other end is not seen with a plane across it.
fn cap_mouths(shell: &mut Shell, holes: &mut Vec<Hole>, made: &mut Made) {
    holes.retain(|hole| {
        let Some(mouth) = mouth::mouth(shell, hole) else { return true };
        let depth = mouth.depth + CAP_OFFSET * shell.spacing;
        let normal = mouth.direction;
        let normal = if shell.primitives[mouth.label as usize].outward { normal } else { -normal };
        let plane = Plane { point: mouth.origin + mouth.direction.into_inner() * depth, normal };
        let label = shell.add_plane(plane);
        let walls = vec![mouth.label; hole.rim.len()];
        if extend::extend_and_cap(shell, &[hole], &[walls], &plane, label) {
            made.caps.push(label);
            return false;
        }
        shell.primitives.pop();
        true
    });
}

/// Membranes over what is left; what is too long for one stays open.
fn fill_rest(shell: &mut Shell, holes: Vec<Hole>) -> Vec<OpenHole> {
    let mut open = Vec::new();
    for hole in holes {
        if !patch::fill_patch(shell, &[&hole]) && !membrane::fill_with_membrane(shell, &hole) {
            let reason = format!("its rim of {} edges bounds no extension of its surfaces", hole.rim.len());
            open.push(OpenHole { rim: hole.rim, reason });
        }
    }
    open
}

/// Fills what is open where fillings met each other: rims that show only when edges with more than two triangles are
/// parted. Returns what no round closes.
fn fill_pinched(shell: &mut Shell) -> Vec<OpenHole> {
    const ROUNDS: usize = 4;
    for _ in 0..ROUNDS {
        let holes = shell.holes();
        if holes.is_empty() {
            break;
        }
        let open = fill_rest(shell, holes);
        shell.part_doubled_edges();
        if !open.is_empty() {
            return open;
        }
    }
    Vec::new()
}

fn finish(mut shell: Shell, mut open: Vec<OpenHole>, made: &Made) -> Closed {
    let adjacency = Adjacency::new(&shell.mesh);
    let is_open = adjacency.across.iter().flatten().any(Option::is_none);
    if is_open && open.is_empty() {
        let rest = shell.holes();
        open.extend(
            rest.into_iter().map(|hole| OpenHole {
                rim: hole.rim,
                reason: "the mesh around it is not manifold".to_owned(),
            }),
        );
    }
    let mut areas = vec![0.0; shell.primitives.len()];
    for t in 0..shell.labels.len() {
        if shell.assumed[t] {
            areas[shell.labels[t] as usize] += shell.mesh.area(t);
        }
    }
    let assumption = |label: u32| {
        if made.support.contains(&label) {
            Assumption::Support
        } else if made.caps.contains(&label) {
            Assumption::Cap
        } else {
            Assumption::Extended
        }
    };
    let assumed_faces = (0..areas.len() as u32)
        .filter(|&label| areas[label as usize] > 0.0)
        .map(|label| AssumedFace {
            region: RegionId(label),
            assumption: assumption(label),
            area: areas[label as usize],
        })
        .collect();
    let labels = shell.labels.iter().copied().map(RegionId).collect();
    let labelled =
        LabelledMesh { mesh: shell.mesh, labels, primitives: shell.primitives, assumed: shell.assumed };
    let merged = shell.merged.iter().map(|&(a, b)| (RegionId(a), RegionId(b))).collect();
    Closed { labelled, open, merged, assumed_faces }
}
