//! Error of the normals that denoising leaves.

use anyhow::Context as _;
use scanwright::condition::measure;
use scanwright::denoise::{DenoiseMethod, Denoised, Neighbors, Sun2007, Weighting, denoise};
use scanwright::math::{Vec3, angle_between};
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::random::Rng;
use scanwright::tolerance::Tolerances;
use scanwright::{io, par};

use crate::table::Table;
use crate::{Context, bodies};

/// Standard deviations of the noise, mean edge lengths: those of the thesis's figures, and that of a good scanner.
const LEVELS: [f64; 4] = [0.1, 0.25, 0.4, 0.8];
/// Draws of the noise; figures are means over them.
const N_DRAWS: u64 = 3;
/// Meshes of `--real`.
const REAL: [&str; 2] = ["fandisk.obj", "rocker-arm.obj"];

/// Figures 3.2 to 3.7: mean angle, in degrees, between the normals of the triangles of the clean mesh and of the denoised
/// one; in brackets those of the filtered normals that the vertices were moved after. White noise along the vertex normal.
pub fn denoising(context: &Context) -> anyhow::Result<Table> {
    let methods = methods();
    let mut headings = vec!["mesh", "noise", "noisy"];
    headings.extend(methods.iter().map(|m| m.0));
    let mut table = Table::new(&headings);
    for (name, clean) in meshes(context)? {
        for level in LEVELS {
            let draws: Vec<Vec<[f64; 2]>> =
                (0..N_DRAWS).map(|draw| errors(&clean, level, draw, &methods)).collect();
            let mean =
                |m: usize, which: usize| draws.iter().map(|d| d[m][which]).sum::<f64>() / N_DRAWS as f64;
            let mut row = vec![name.clone(), level.to_string(), format!("{:.2}", mean(0, 0))];
            row.extend((1..=methods.len()).map(|m| format!("{:.2} ({:.2})", mean(m, 0), mean(m, 1))));
            table.row(row);
        }
    }
    table.write(&context.output, "denoising")?;
    Ok(table)
}

fn methods() -> Vec<(&'static str, DenoiseMethod)> {
    let sun =
        |neighbors, weighting| DenoiseMethod::Sun2007(Sun2007 { neighbors, weighting, ..Sun2007::default() });
    let [adaptive, _, bilateral, guided] = DenoiseMethod::all_defaults();
    vec![
        ("Sun 2007, vertices", sun(Neighbors::Vertex, Weighting::Threshold)),
        ("Sun 2007, edges", sun(Neighbors::Edge, Weighting::Threshold)),
        ("random walk", sun(Neighbors::Vertex, Weighting::RandomWalk { steps: 1 })),
        ("bilateral", bilateral),
        ("guided", guided),
        ("default", adaptive),
    ]
}

/// Clean meshes by name.
fn meshes(context: &Context) -> anyhow::Result<Vec<(String, Mesh)>> {
    let mut meshes = vec![
        ("part (generated)".to_owned(), bodies::part()),
        ("wavy (generated)".to_owned(), bodies::wavy()),
    ];
    for file in context.real.iter().flat_map(|folder| REAL.map(|name| folder.join(name))) {
        let scan = io::read_mesh_file(&file).with_context(|| file.display().to_string())?;
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        meshes.push((name.into_owned(), scan.mesh));
    }
    Ok(meshes)
}

/// Error of the noisy mesh, then of each method: of the mesh, and of the filtered normals.
fn errors(clean: &Mesh, level: f64, draw: u64, methods: &[(&str, DenoiseMethod)]) -> Vec<[f64; 2]> {
    let mesh = with_noise(clean, level * mean_edge(clean), draw);
    let adjacency = Adjacency::new(&mesh);
    let tolerances = Tolerances::new(measure(&mesh, &adjacency), None);
    let truth = clean.triangle_normals();
    let raw = mean_angle_deg(&truth, &mesh.triangle_normals());
    let of = |(_, method): &(&str, DenoiseMethod)| {
        let Denoised { triangle_normals, vertices } = denoise(&mesh, &adjacency, &tolerances, method);
        let moved = Mesh { vertices, triangles: mesh.triangles.clone() };
        [mean_angle_deg(&truth, &moved.triangle_normals()), mean_angle_deg(&truth, &triangle_normals)]
    };
    std::iter::once([raw, raw]).chain(par::map(methods, of)).collect()
}

fn with_noise(mesh: &Mesh, sigma: f64, draw: u64) -> Mesh {
    let mut rng = Rng::for_task(1, "denoising", draw);
    let moved = mesh.vertices.iter().zip(mesh.vertex_normals()).map(|(p, n)| p + n * (sigma * rng.normal()));
    Mesh { vertices: moved.collect(), triangles: mesh.triangles.clone() }
}

fn mean_edge(mesh: &Mesh) -> f64 {
    let edges = (0..mesh.triangles.len()).flat_map(|t| {
        let [a, b, c] = mesh.corners(t);
        [(b - a).norm(), (c - b).norm(), (a - c).norm()]
    });
    edges.sum::<f64>() / (3 * mesh.triangles.len()).max(1) as f64
}

fn mean_angle_deg(a: &[Vec3], b: &[Vec3]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| angle_between(a, b)).sum();
    (sum / a.len().max(1) as f64).to_degrees()
}
