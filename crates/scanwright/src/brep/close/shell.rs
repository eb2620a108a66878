//! The growing mesh: labelled triangles, their open rims, and what is added to them.

use crate::math::Point3;
use crate::mesh::{Adjacency, Mesh};
use crate::recognize::{Primitive, Residual};
use crate::segment::Segmentation;
use crate::surface::{Plane, Surface};
use std::collections::BTreeMap;

/// A labelled mesh under repair.
#[derive(Debug, Clone)]
pub(super) struct Shell {
    pub mesh: Mesh,
    pub labels: Vec<u32>,
    pub assumed: Vec<bool>,
    pub primitives: Vec<Primitive>,
    pub spacing: f64,
    /// Regions that turned out to be one: the one that stays, the one that went.
    pub merged: Vec<(u32, u32)>,
}

/// Invented islands smaller than this, in squared spacings, are no faces: two by two spacings.
const ISLAND: f64 = 4.0;

/// One open loop. The hole lies on its left, seen from outside.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Hole {
    /// Vertices in order.
    pub rim: Vec<u32>,
    /// Label of the triangle behind the edge from each vertex to the next.
    pub labels: Vec<u32>,
}

impl Hole {
    /// The label of most edges, and its share of them.
    pub fn main_label(&self) -> (u32, f64) {
        let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
        for &label in &self.labels {
            *counts.entry(label).or_default() += 1;
        }
        let best = counts.iter().max_by_key(|(label, count)| (**count, u32::MAX - **label));
        best.map_or((0, 0.0), |(label, count)| (*label, *count as f64 / self.labels.len() as f64))
    }

    /// The distinct labels, ascending.
    pub fn distinct_labels(&self) -> Vec<u32> {
        let mut labels = self.labels.clone();
        labels.sort_unstable();
        labels.dedup();
        labels
    }
}

impl Shell {
    /// The mesh with every triangle labelled: what the segmentation left open takes the label that reaches it first.
    /// Teeth (triangles that hang by one edge) are pulled, vertices where two rims touch are doubled.
    pub fn new(mesh: &Mesh, segmentation: &Segmentation, spacing: f64) -> Self {
        let mut primitives = segmentation.primitives.clone();
        let labels = flooded(mesh, segmentation, &mut primitives);
        let assumed = vec![false; mesh.triangles.len()];
        let mut shell = Self { mesh: mesh.clone(), labels, assumed, primitives, spacing, merged: Vec::new() };
        shell.pull_teeth();
        shell
    }

    pub fn point(&self, vertex: u32) -> Point3 {
        self.mesh.vertices[vertex as usize]
    }

    pub fn points(&self, vertices: &[u32]) -> Vec<Point3> {
        vertices.iter().map(|&v| self.point(v)).collect()
    }

    pub fn add_vertex(&mut self, point: Point3) -> u32 {
        self.mesh.vertices.push(point);
        (self.mesh.vertices.len() - 1) as u32
    }

    /// Adds an invented triangle.
    pub fn add_triangle(&mut self, corners: [u32; 3], label: u32) {
        self.mesh.triangles.push(corners);
        self.labels.push(label);
        self.assumed.push(true);
    }

    /// A new region on an assumed plane.
    pub fn add_plane(&mut self, plane: Plane) -> u32 {
        self.primitives.push(Primitive {
            surface: Some(Surface::Plane(plane)),
            outward: true,
            residual: Residual::default(),
            covariance: Vec::new(),
            ambiguous: None,
        });
        (self.primitives.len() - 1) as u32
    }

    pub fn surface(&self, label: u32) -> Option<&Surface> {
        self.primitives.get(label as usize)?.surface.as_ref()
    }

    fn keep(&mut self, keep: &[bool]) {
        let mut flags = keep.iter();
        self.mesh.triangles.retain(|_| *flags.next().expect("one flag per triangle"));
        let mut flags = keep.iter();
        self.labels.retain(|_| *flags.next().expect("one flag per triangle"));
        let mut flags = keep.iter();
        self.assumed.retain(|_| *flags.next().expect("one flag per triangle"));
    }

    fn pull_teeth(&mut self) {
        // Each round can bare another tooth; what is left after these is a strip, not teeth.
        const ROUNDS: usize = 4;
        for _ in 0..ROUNDS {
            let adjacency = Adjacency::new(&self.mesh);
            let keep: Vec<bool> =
                adjacency.across.iter().map(|a| a.iter().filter(|x| x.is_none()).count() < 2).collect();
            if keep.iter().all(|k| *k) || !keep.contains(&true) {
                return;
            }
            self.keep(&keep);
        }
    }

    /// All open loops, longest first; doubles vertices at which loops touch.
    pub fn holes(&mut self) -> Vec<Hole> {
        let adjacency = Adjacency::new(&self.mesh);
        let mut done = vec![[false; 3]; self.mesh.triangles.len()];
        let mut visited = vec![false; self.mesh.vertices.len()];
        let mut holes = Vec::new();
        for t in 0..done.len() {
            for k in 0..3 {
                if adjacency.across[t][k].is_none() && !done[t][k] {
                    holes.extend(self.walk(&adjacency, (t, k), &mut done, &mut visited));
                }
            }
        }
        holes.sort_by(|a, b| b.rim.len().cmp(&a.rim.len()).then(a.rim.cmp(&b.rim)));
        holes
    }

    /// The loop through edge `start`; `None` when the surroundings are not oriented and the walk does not return.
    fn walk(
        &mut self,
        adjacency: &Adjacency,
        start: (usize, usize),
        done: &mut [[bool; 3]],
        visited: &mut Vec<bool>,
    ) -> Option<Hole> {
        let (mut rim, mut labels) = (Vec::new(), Vec::new());
        let (mut t, mut k) = start;
        loop {
            if done[t][k] {
                break;
            }
            done[t][k] = true;
            labels.push(self.labels[t]);
            // Turn about the edge's head until the next open edge.
            let mut head = self.mesh.triangles[t][(k + 1) % 3];
            let mut fan = vec![t];
            let (mut u, mut l) = (t, (k + 1) % 3);
            while let Some(next) = adjacency.across[u][l] {
                let next = next as usize;
                let found = (0..3).find(|&m| self.mesh.triangles[next][m] == head)?;
                if adjacency.across[next][(found + 2) % 3] != Some(u as u32) || fan.len() > done.len() {
                    return None;
                }
                (u, l) = (next, found);
                fan.push(u);
            }
            if visited[head as usize] {
                let copy = self.add_vertex(self.point(head));
                visited.push(true);
                for &f in &fan {
                    for corner in &mut self.mesh.triangles[f] {
                        if *corner == head {
                            *corner = copy;
                        }
                    }
                }
                head = copy;
            }
            visited[head as usize] = true;
            rim.push(head);
            (t, k) = (u, l);
        }
        if (t, k) != start || rim.len() < 3 {
            return None;
        }
        // rim[i] is the head of edge i. Reversed, the edge from rim[i] to rim[i - 1] is edge i.
        rim.reverse();
        labels.reverse();
        drop_short_arcs(&mut labels);
        Some(Hole { rim, labels })
    }
}

/// Arcs of a rim no longer than this many edges are noise of the labels, unless a label has no others and several of
/// them: they take the label before them.
const SHORT_ARC: usize = 2;
/// Loops with fewer edges than this have short arcs for a reason.
const MIN_CLEANED: usize = 12;

fn drop_short_arcs(labels: &mut [u32]) {
    let n = labels.len();
    let Some(start) = (0..n).find(|&i| labels[i] != labels[(i + n - 1) % n]).filter(|_| n >= MIN_CLEANED)
    else {
        return;
    };
    let arc = |labels: &[u32], at: usize| {
        (at..n).take_while(|&i| labels[(start + i) % n] == labels[(start + at) % n]).count()
    };
    // Labels that are long enough somewhere, or often enough, to be there at all.
    let mut total: BTreeMap<u32, usize> = BTreeMap::new();
    let mut longest: BTreeMap<u32, usize> = BTreeMap::new();
    let mut at = 0;
    while at < n {
        let (label, length) = (labels[(start + at) % n], arc(labels, at));
        *total.entry(label).or_default() += length;
        let best = longest.entry(label).or_default();
        *best = length.max(*best);
        at += length;
    }
    let is_noise = |label: u32, length: usize| {
        length <= SHORT_ARC && (longest[&label] > SHORT_ARC || total[&label] <= SHORT_ARC)
    };
    let (mut at, mut before) = (0, labels[(start + n - 1) % n]);
    while at < n {
        let (label, length) = (labels[(start + at) % n], arc(labels, at));
        if is_noise(label, length) {
            for i in at..at + length {
                labels[(start + i) % n] = before;
            }
        } else {
            before = label;
        }
        at += length;
    }
}

/// Labels of all triangles; adds a region without surface when there is none to spread.
fn flooded(mesh: &Mesh, segmentation: &Segmentation, primitives: &mut Vec<Primitive>) -> Vec<u32> {
    let n = mesh.triangles.len();
    let mut labels: Vec<Option<u32>> = (0..n)
        .map(|t| segmentation.labels.get(t).copied().flatten().map(|r| r.0))
        .map(|label| label.filter(|&l| (l as usize) < primitives.len()))
        .collect();
    if labels.iter().all(Option::is_some) {
        return labels.into_iter().flatten().collect();
    }
    let adjacency = Adjacency::new(mesh);
    let mut front: Vec<u32> = (0..n as u32).filter(|&t| labels[t as usize].is_some()).collect();
    while !front.is_empty() {
        let mut next = Vec::new();
        for t in front {
            for u in adjacency.across[t as usize].into_iter().flatten() {
                if labels[u as usize].is_none() {
                    labels[u as usize] = labels[t as usize];
                    next.push(u);
                }
            }
        }
        front = next;
    }
    if labels.iter().any(Option::is_none) {
        primitives.push(Primitive {
            surface: None,
            outward: true,
            residual: Residual::default(),
            covariance: Vec::new(),
            ambiguous: Some("no surface was found".to_owned()),
        });
    }
    let rest = primitives.len() as u32 - 1;
    labels.into_iter().map(|l| l.unwrap_or(rest)).collect()
}

impl Shell {
    /// Gives all triangles of region `b` to region `a`.
    pub fn merge_regions(&mut self, a: u32, b: u32) {
        self.merged.push((a, b));
        for label in &mut self.labels {
            if *label == b {
                *label = a;
            }
        }
    }

    /// Components of equal label: that of each triangle, and how many there are.
    fn components(&self, adjacency: &Adjacency) -> (Vec<usize>, usize) {
        let mut component = vec![usize::MAX; self.labels.len()];
        let mut n_components = 0;
        for start in 0..component.len() {
            if component[start] != usize::MAX {
                continue;
            }
            component[start] = n_components;
            let mut stack = vec![start];
            while let Some(t) = stack.pop() {
                for u in adjacency.across[t].into_iter().flatten().map(|u| u as usize) {
                    if component[u] == usize::MAX && self.labels[u] == self.labels[t] {
                        component[u] = n_components;
                        stack.push(u);
                    }
                }
            }
            n_components += 1;
        }
        (component, n_components)
    }

    /// Gives invented islands of a few triangles to the neighbour they border on most.
    pub fn absorb_islands(&mut self) {
        let adjacency = Adjacency::new(&self.mesh);
        let (component, n) = self.components(&adjacency);
        let mut areas = vec![0.0; n];
        let mut is_invented = vec![true; n];
        let mut borders: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); n];
        for t in 0..component.len() {
            let c = component[t];
            areas[c] += self.mesh.area(t);
            is_invented[c] &= self.assumed[t];
            for k in 0..3 {
                let Some(u) = adjacency.across[t][k].filter(|&u| component[u as usize] != c) else {
                    continue;
                };
                let ends = [0, 1].map(|e| self.point(self.mesh.triangles[t][(k + e) % 3]));
                *borders[c].entry(self.labels[u as usize]).or_default() += (ends[1] - ends[0]).norm();
            }
        }
        let limit = ISLAND * self.spacing * self.spacing;
        for (t, &c) in component.iter().enumerate() {
            let widest = borders[c].iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)));
            if let Some((&label, _)) = widest.filter(|_| is_invented[c] && areas[c] < limit) {
                self.labels[t] = label;
            }
        }
    }

    /// Gives every connected part of region `label` but the first a region of its own; returns these.
    pub fn part_region(&mut self, label: u32) -> Vec<u32> {
        let adjacency = Adjacency::new(&self.mesh);
        let (component, n) = self.components(&adjacency);
        let mut names: Vec<Option<u32>> = vec![None; n];
        let mut made = Vec::new();
        let mut is_first = true;
        for t in (0..component.len()).filter(|&t| self.labels[t] == label).collect::<Vec<_>>() {
            let name = *names[component[t]].get_or_insert_with(|| {
                if std::mem::replace(&mut is_first, false) {
                    return label;
                }
                self.primitives.push(self.primitives[label as usize].clone());
                made.push(self.primitives.len() as u32 - 1);
                self.primitives.len() as u32 - 1
            });
            self.labels[t] = name;
        }
        made
    }

    /// Where a filling joins two vertices of the rim that the scan joins too, the edge has more than two triangles:
    /// the filling's edge gets a vertex of its own in the middle.
    pub fn part_doubled_edges(&mut self) {
        let mut edges: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(3 * self.labels.len());
        for (t, triangle) in self.mesh.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                edges.push((a.min(b), a.max(b), self.assumed[t], t as u32));
            }
        }
        edges.sort_unstable();
        let mut broken = Vec::new();
        for group in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            let invented: Vec<u32> = group.iter().filter(|e| e.2).map(|e| e.3).collect();
            if group.len() > 2 && invented.len() >= 2 {
                broken.push((group[0].0, group[0].1, invented));
            }
        }
        for (a, b, triangles) in broken {
            // Two triangles of one filling were added one soon after the other; with more fillings, pairs of them.
            for pair in triangles.chunks_exact(2) {
                let middle = self.add_vertex(nalgebra::center(&self.point(a), &self.point(b)));
                for &t in pair {
                    self.split_edge(t as usize, (a, b), middle);
                }
            }
        }
    }

    fn split_edge(&mut self, triangle: usize, (a, b): (u32, u32), middle: u32) {
        let corners = self.mesh.triangles[triangle];
        let found = (0..3).find(|&k| {
            let edge = (corners[k], corners[(k + 1) % 3]);
            edge == (a, b) || edge == (b, a)
        });
        let Some(k) = found else { return };
        let (from, to, far) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
        self.mesh.triangles[triangle] = [from, middle, far];
        self.mesh.triangles.push([middle, to, far]);
        self.labels.push(self.labels[triangle]);
        self.assumed.push(self.assumed[triangle]);
    }
}
