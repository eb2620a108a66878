//! How long a check takes without the segmentation, on a scan refined to a million vertices:
//! `check_speed MODEL.step SCAN.ply [VERTICES]`.

use std::time::Instant;

use scanwright::align::{Measure, Options, Part, Target, align, border_width};
use scanwright::check::{self, check};
use scanwright::condition;
use scanwright::fit::Noise;
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::segment::Segmentation;
use scanwright::tolerance::Tolerances;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().collect();
    let [_, model, scan, rest @ ..] = args.as_slice() else {
        return Err("MODEL.step SCAN.ply [VERTICES]".into());
    };
    let wanted: usize = rest.first().map_or(Ok(1_000_000), |n| n.parse())?;
    let model = scanwright::step::read::read(&std::fs::read(model)?)?;
    let mut mesh = condition::condition(&scanwright::io::read_mesh_file(scan.as_ref())?.mesh).mesh;
    let tolerances = Tolerances::new(condition::measure(&mesh, &Adjacency::new(&mesh)), None);
    while mesh.vertices.len() < wanted {
        mesh = refined(&mesh);
    }
    let noise = Noise { white: tolerances.noise(), correlated: 0.0, length: tolerances.spacing() };
    let part = Part {
        normals: mesh.vertex_normals(),
        scan_vertex: (0..mesh.vertices.len() as u32).collect(),
        segmentation: Segmentation { labels: vec![None; mesh.triangles.len()], primitives: Vec::new() },
        mesh,
        tolerances,
        noise,
    };
    let start = Instant::now();
    let target =
        Target::new(&model, Measure::Surfaces, border_width(&part.tolerances)).ok_or("an empty model")?;
    let prepared = start.elapsed();
    let alignment = align(&target, &part, &Options::default())?;
    let aligned = start.elapsed();
    let found = check(&target, &part, &alignment, &check::Options { tolerance: Some(0.1) });
    let checked = start.elapsed();
    println!(
        "{} vertices, {} faces in {} triangles: prepared {prepared:.2?}, aligned {:.2?}, checked {:.2?}, all {checked:.2?}",
        part.mesh.vertices.len(),
        model.faces.len(),
        model.mesh.triangles.len(),
        aligned.checked_sub(prepared).unwrap_or_default(),
        checked.checked_sub(aligned).unwrap_or_default(),
    );
    println!("rms {:.4}, {} changes", found.overall.rms, found.changes.len());
    Ok(())
}

/// Every triangle cut into four.
fn refined(mesh: &Mesh) -> Mesh {
    let mut edges: Vec<(u32, u32)> = mesh
        .triangles
        .iter()
        .flat_map(|t| (0..3).map(|k| (t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]))))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let first = mesh.vertices.len() as u32;
    let mut vertices = mesh.vertices.clone();
    let middle =
        |&(a, b): &(u32, u32)| nalgebra::center(&mesh.vertices[a as usize], &mesh.vertices[b as usize]);
    vertices.extend(edges.iter().map(middle));
    let between = |a: u32, b: u32| {
        let place = edges.binary_search(&(a.min(b), a.max(b))).expect("every edge is listed");
        first + place as u32
    };
    let cut = |&[a, b, c]: &[u32; 3]| {
        let (ab, bc, ca) = (between(a, b), between(b, c), between(c, a));
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    let triangles = mesh.triangles.iter().flat_map(cut).collect();
    Mesh { vertices, triangles }
}
