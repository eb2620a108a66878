use std::collections::BTreeMap;

use serde::Serialize;

use crate::fit;
use crate::mesh::Adjacency;
use crate::pipeline::Reconstruction;
use crate::recognize::{Primitive, Residual, Sufficiency};

use super::{Context, Geometry, Place, place};

/// One primitive of a report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PrimitiveReport {
    /// Number of the primitive: its place in the list, and its triangles' label in `segments.ply`.
    pub id: u32,
    /// Type and parameters.
    #[serde(flatten)]
    pub geometry: Geometry,
    /// Whether the surface's natural normal points out of the material.
    pub outward: bool,
    /// Distances of the region's interior points to the surface.
    pub residual: Residual,
    /// Names of the parameters whose covariance follows: motions of the surface about its middle, then its shape.
    pub parameters: Vec<&'static str>,
    /// Standard uncertainties: square roots of the covariance's diagonal.
    pub uncertainty: Vec<f64>,
    /// Covariance of the parameters; empty when freeform.
    pub covariance: Vec<Vec<f64>>,
    /// Triangles of the scan.
    pub triangles: usize,
    /// Their area.
    pub area: f64,
    /// Where it is.
    pub place: Option<Place>,
    /// Regions that share a border, by id.
    pub neighbors: Vec<Neighbor>,
    /// Why the type is not certain, if it is not.
    pub ambiguous: Option<String>,
    /// Whether its sizes are known as well as was asked; absent when nothing was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sufficiency: Option<Sufficiency>,
}

/// A region beside another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Neighbor {
    /// Its id.
    pub id: u32,
    /// Length of the common border.
    pub length: f64,
}

/// The primitives of a run, in the order of their ids.
pub(super) fn primitives(result: &Reconstruction, context: &Context) -> Vec<PrimitiveReport> {
    let segmentation = &result.segmentation;
    let n_regions = segmentation.primitives.len();
    let mut areas = vec![0.0; n_regions];
    for (t, label) in segmentation.labels.iter().enumerate() {
        if let Some(region) = label {
            areas[region.0 as usize] += result.mesh.area(t);
        }
    }
    let mut counts = vec![0; n_regions];
    for region in result.labels_of_scan(context.n_triangles).into_iter().flatten() {
        counts[region.0 as usize] += 1;
    }
    let sufficiency = context.options.target.map(|target| result.sufficiency(target)).unwrap_or_default();
    let borders = border_lengths(result);
    let places = place::places(result);
    let report = |i: usize| {
        let primitive = &segmentation.primitives[i];
        let of_pair =
            |(&(a, b), &length): (&(u32, u32), &f64)| (a == i as u32).then_some(Neighbor { id: b, length });
        PrimitiveReport {
            id: i as u32,
            geometry: Geometry::of(primitive.surface.as_ref()),
            outward: primitive.outward,
            residual: primitive.residual,
            parameters: parameters(primitive),
            uncertainty: deviations(&primitive.covariance),
            covariance: primitive.covariance.clone(),
            triangles: counts[i],
            area: areas[i],
            place: places[i],
            neighbors: borders.iter().filter_map(of_pair).collect(),
            ambiguous: primitive.ambiguous.clone(),
            sufficiency: sufficiency.get(i).copied().flatten(),
        }
    };
    (0..n_regions).map(report).collect()
}

fn parameters(primitive: &Primitive) -> Vec<&'static str> {
    let known = primitive.surface.as_ref().filter(|_| !primitive.covariance.is_empty());
    known.map_or(Vec::new(), |surface| fit::parameter_names(surface).to_vec())
}

/// Square roots of the diagonal.
fn deviations(covariance: &[Vec<f64>]) -> Vec<f64> {
    covariance.iter().enumerate().map(|(k, row)| row[k].max(0.0).sqrt()).collect()
}

/// Length of the border of every ordered pair of regions that touch.
fn border_lengths(result: &Reconstruction) -> BTreeMap<(u32, u32), f64> {
    let (mesh, labels) = (&result.mesh, &result.segmentation.labels);
    let adjacency = Adjacency::new(mesh);
    let mut lengths = BTreeMap::new();
    for (t, across) in adjacency.across.iter().enumerate() {
        let corners = mesh.corners(t);
        for k in 0..3 {
            let (Some(here), Some(u)) = (labels[t], across[k]) else { continue };
            let Some(there) = labels[u as usize] else { continue };
            if here != there {
                let length = (corners[(k + 1) % 3] - corners[k]).norm();
                *lengths.entry((here.0, there.0)).or_insert(0.0) += length;
            }
        }
    }
    lengths
}
