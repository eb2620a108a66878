use crate::fit::{Fit, Samples, Weights};
use crate::math::{Point3, Vec3, stats};
use crate::mesh::{Adjacency, Csr, Mesh, connected};
use crate::recognize::Limits;
use crate::surface::{Plane, Surface};
use crate::tolerance::Tolerances;

use super::label::Labels;

/// The vertices of a mesh as segmentation sees them: positions, filtered normals, rings, and the scale of the noise.
#[derive(Debug)]
pub struct Field<'a> {
    /// One per vertex.
    pub points: &'a [Point3],
    /// One per vertex, out of the material.
    pub normals: &'a [Vec3],
    /// One-ring of each vertex.
    pub rings: &'a Csr,
    /// One per vertex: whether it lies on the border of the mesh.
    pub on_boundary: &'a [bool],
    /// Mean vertex distance, length.
    pub spacing: f64,
    /// Deviation of the scanner's spot, length; zero for meshes that no scanner made.
    pub blur: f64,
    /// Whether edges showed it, or it is a guess.
    pub blur_is_measured: bool,
    /// The table that the part stood on, its material below.
    pub ground: Option<Fit>,
    /// Scale of costs.
    pub weights: Weights,
    /// What the scan can show.
    pub limits: Limits,
    start_sigma: f64,
}

/// A set of vertices with their costs under one surface.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// The surface.
    pub fit: Fit,
    /// Mean cost of the samples it was fitted to.
    pub mean_cost: f64,
    /// Vertices that it may explain, with their costs.
    pub support: Vec<(u32, f32)>,
}

impl Hypothesis {
    /// The same surface with other costs.
    pub(super) fn with_support(&self, support: Vec<(u32, f32)>) -> Self {
        Self { fit: self.fit, mean_cost: self.mean_cost, support }
    }
}

impl<'a> Field<'a> {
    /// Total noise starts at this multiple of the white noise: the wavy part is not seen by the estimate.
    const TOTAL_PER_WHITE: f64 = 1.8;
    /// Floor of the noise, in spacings: interpolation between the scanner's grid points.
    const SIGMA_FLOOR: f64 = 0.08;
    /// Deviation of filtered normals, radians: near borders their bias by rounding exceeds the noise.
    const NORMAL_SIGMA: f64 = 0.10;
    /// Weight of the normal term beside the distance term.
    const NORMAL_WEIGHT: f64 = 0.5;

    /// Sigmas by which a more complex surface must part from a simpler one.
    const DEPARTURE_SIGMAS: f64 = 1.5;

    /// The field of a mesh.
    pub fn new(
        mesh: &'a Mesh,
        adjacency: &'a Adjacency,
        normals: &'a [Vec3],
        tolerances: &Tolerances,
        ground: Option<Plane>,
    ) -> Self {
        let spacing = tolerances.spacing();
        let sigma = (Self::TOTAL_PER_WHITE * tolerances.noise()).max(Self::SIGMA_FLOOR * spacing);
        Self {
            points: &mesh.vertices,
            normals,
            rings: &adjacency.vertex_vertices,
            on_boundary: &adjacency.on_boundary,
            spacing,
            blur: Self::blur(tolerances),
            blur_is_measured: tolerances.edge_rounding() > 0.0,
            ground: ground.map(|plane| Fit { surface: Surface::Plane(plane), outward: true }),
            weights: Weights {
                distance_sigma: sigma,
                normal_sigma: Self::NORMAL_SIGMA,
                normal_weight: Self::NORMAL_WEIGHT,
            },
            limits: Limits {
                min_radius: 1.6 * spacing,
                min_taper: 0.7 * spacing,
                min_departure: Self::DEPARTURE_SIGMAS * sigma,
                min_tilt: Self::min_tilt(sigma / spacing),
            },
            start_sigma: sigma,
        }
    }

    /// Where no edge was sharp enough to measure the spot it is guessed from the noise, as far as the two go together:
    /// none for a mesh without noise, half a spacing for a quiet scan, a spacing for the others.
    fn blur(tolerances: &Tolerances) -> f64 {
        /// Noise over spacing of what no scanner made, and of a quiet scan.
        const NO_SCAN: f64 = 0.01;
        const QUIET: f64 = 0.05;
        let (measured, spacing) = (tolerances.edge_rounding(), tolerances.spacing());
        let noise = tolerances.noise() / spacing;
        if measured > 0.0 || noise < NO_SCAN {
            measured
        } else if noise < QUIET {
            0.5 * spacing
        } else {
            spacing
        }
    }

    /// Tilt that neither filtered noise nor a rounded border feigns: noise over two spacings, not below what the
    /// costs can tell apart.
    fn min_tilt(sigma_per_spacing: f64) -> f64 {
        (0.6 * sigma_per_spacing).max(Self::NORMAL_SIGMA)
    }

    /// Number of vertices.
    pub fn n_vertices(&self) -> usize {
        self.points.len()
    }

    /// The table, where the scanner has rounded the edge between it and the part.
    pub fn ground_near(&self, vertex: u32) -> Option<&Fit> {
        let reach = 3.0 * (self.blur + self.weights.distance_sigma);
        self.ground.as_ref().filter(|g| g.surface.signed_distance(&self.points[vertex as usize]) < reach)
    }

    /// Cost of a vertex under a surface.
    pub fn cost(&self, fit: &Fit, vertex: u32) -> f64 {
        self.weights.cost(fit, &self.points[vertex as usize], &self.normals[vertex as usize])
    }

    /// Samples at `vertices`, at most `n` of them.
    pub fn samples(&self, vertices: &[u32], n: usize) -> Samples {
        let count = vertices.len().min(n);
        let pick = |i: usize| vertices[i * vertices.len() / count] as usize;
        Samples {
            points: (0..count).map(|i| self.points[pick(i)]).collect(),
            normals: (0..count).map(|i| self.normals[pick(i)]).collect(),
        }
    }

    /// Replaces the noise by what labelled vertices show, within bounds of the first estimate.
    pub fn adapt_noise(&mut self, labels: &Labels) {
        let mut residuals = Vec::new();
        for (v, label) in labels.of_vertex.iter().enumerate() {
            if let Some(k) = label {
                residuals.push(labels.fits[*k as usize].surface.signed_distance(&self.points[v]));
            }
        }
        if let Some(sigma) = stats::sigma_about_zero(&residuals) {
            let sigma = sigma.clamp(0.7 * self.start_sigma, 2.5 * self.start_sigma);
            self.weights.distance_sigma = sigma.max(Self::SIGMA_FLOOR * self.spacing);
            self.limits.min_departure = Self::DEPARTURE_SIGMAS * self.weights.distance_sigma;
        }
    }

    /// Vertices of `region` (sorted or not) at least `rings` rings from any vertex outside it; fewer rings when less
    /// than `at_least` would remain. Keeps the order.
    pub fn eroded(&self, region: &[u32], rings: usize, at_least: usize, scratch: &mut Scratch) -> Vec<u32> {
        let depth = self.depths(region, rings, false, scratch);
        for needed in (1..=rings).rev() {
            let kept: Vec<u32> =
                region.iter().zip(&depth).filter(|(_, d)| **d as usize >= needed).map(|(v, _)| *v).collect();
            if kept.len() >= at_least {
                return kept;
            }
        }
        region.to_vec()
    }

    /// Rings between each vertex of `region` and the outside, at most `rings`; zero at the border. Holes of the scan
    /// are a border only if `holes`, for few have rounded rims; where the table was cut away is one.
    pub fn depths(&self, region: &[u32], rings: usize, holes: bool, scratch: &mut Scratch) -> Vec<u8> {
        let inside = scratch.next_mark();
        for &v in region {
            scratch.mark[v as usize] = inside;
        }
        let mut front: Vec<u32> = Vec::new();
        for &v in region {
            let on_rim = self.on_boundary[v as usize] && (holes || self.ground_near(v).is_some());
            if on_rim || self.rings.row(v as usize).iter().any(|&u| scratch.mark[u as usize] != inside) {
                front.push(v);
            }
        }
        let mut depth_of: Vec<u8> = Vec::new();
        std::mem::swap(&mut depth_of, &mut scratch.depth);
        for &v in region {
            depth_of[v as usize] = rings as u8;
        }
        for &v in &front {
            depth_of[v as usize] = 0;
        }
        for depth in 1..rings as u8 {
            let mut next = Vec::new();
            for &v in &front {
                for &u in self.rings.row(v as usize) {
                    if scratch.mark[u as usize] == inside && depth_of[u as usize] > depth {
                        depth_of[u as usize] = depth;
                        next.push(u);
                    }
                }
            }
            front = next;
        }
        let depths = region.iter().map(|&v| depth_of[v as usize]).collect();
        std::mem::swap(&mut depth_of, &mut scratch.depth);
        depths
    }

    /// One per vertex of `region`: the vertex outside that is nearest in rings, if within `rings`.
    pub fn nearest_outside(&self, region: &[u32], rings: usize, scratch: &mut Scratch) -> Vec<Option<u32>> {
        let mark = scratch.next_mark();
        for (place, &v) in region.iter().enumerate() {
            scratch.mark[v as usize] = mark;
            scratch.place[v as usize] = place as u32;
        }
        let mut nearest: Vec<Option<u32>> = region
            .iter()
            .map(|&v| self.rings.row(v as usize).iter().copied().find(|&u| scratch.mark[u as usize] != mark))
            .collect();
        let mut front: Vec<u32> =
            region.iter().zip(&nearest).filter(|(_, u)| u.is_some()).map(|(v, _)| *v).collect();
        for _ in 1..rings {
            let mut next = Vec::new();
            for &v in &front {
                let source = nearest[scratch.place[v as usize] as usize];
                for &u in self.rings.row(v as usize) {
                    let inside = scratch.mark[u as usize] == mark;
                    if inside && nearest[scratch.place[u as usize] as usize].is_none() {
                        nearest[scratch.place[u as usize] as usize] = source;
                        next.push(u);
                    }
                }
            }
            front = next;
        }
        nearest
    }

    /// The `n` vertices nearest to `seed` in rings, nearest first.
    pub fn patch(&self, seed: u32, n: usize, scratch: &mut Scratch) -> Vec<u32> {
        let mark = scratch.next_mark();
        scratch.mark[seed as usize] = mark;
        let mut patch = vec![seed];
        let mut next = 0;
        while next < patch.len() && patch.len() < n {
            let v = patch[next];
            next += 1;
            for &u in self.rings.row(v as usize) {
                if scratch.mark[u as usize] != mark {
                    scratch.mark[u as usize] = mark;
                    patch.push(u);
                }
            }
        }
        patch.truncate(n);
        patch
    }

    /// Connected sets of vertices that share a key, each with its key; those without a key are in none.
    pub fn connected<K: PartialEq>(&self, key: impl Fn(u32) -> Option<K>) -> Vec<(K, Vec<u32>)> {
        connected(self.n_vertices(), key, |v| self.rings.row(v as usize).iter().copied())
    }

    /// `region` and all vertices within `rings` rings of it.
    pub fn dilated(&self, region: &[u32], rings: usize, scratch: &mut Scratch) -> Vec<u32> {
        let mark = scratch.next_mark();
        for &v in region {
            scratch.mark[v as usize] = mark;
        }
        let mut found = region.to_vec();
        let mut from = 0;
        for _ in 0..rings {
            let to = found.len();
            for i in from..to {
                for &u in self.rings.row(found[i] as usize) {
                    if scratch.mark[u as usize] != mark {
                        scratch.mark[u as usize] = mark;
                        found.push(u);
                    }
                }
            }
            // Members that cannot have fresh neighbours need no second look.
            from = to;
        }
        found
    }

    /// Vertices connected to `core` whose cost under `fit` is below `limit`, nearest first, with costs; stops at
    /// `n_max`.
    pub fn flood(
        &self,
        fit: &Fit,
        core: &[u32],
        limit: f64,
        n_max: usize,
        scratch: &mut Scratch,
    ) -> Vec<(u32, f32)> {
        let mark = scratch.next_mark();
        let mut found: Vec<(u32, f32)> = Vec::new();
        for &v in core {
            let cost = self.cost(fit, v);
            scratch.mark[v as usize] = mark;
            if cost < limit {
                found.push((v, cost as f32));
            }
        }
        let mut next = 0;
        while next < found.len() && found.len() < n_max {
            let v = found[next].0;
            next += 1;
            for &u in self.rings.row(v as usize) {
                if scratch.mark[u as usize] != mark {
                    scratch.mark[u as usize] = mark;
                    let cost = self.cost(fit, u);
                    if cost < limit {
                        found.push((u, cost as f32));
                    }
                }
            }
        }
        found
    }
}

/// Per-thread marks over all vertices.
#[derive(Debug)]
pub struct Scratch {
    mark: Vec<u32>,
    place: Vec<u32>,
    depth: Vec<u8>,
    last: u32,
}

impl Scratch {
    /// Scratch space for `n` vertices.
    pub fn new(n: usize) -> Self {
        Self { mark: vec![0; n], place: vec![0; n], depth: vec![0; n], last: 0 }
    }

    fn next_mark(&mut self) -> u32 {
        self.last += 1;
        self.last
    }
}
