//! Writing meshes as PLY, binary little endian.

use crate::mesh::Mesh;

/// Coordinates are cut to `f32`, as scanners write them; a label or color applies to a face.
///
/// `labels`: the property's name and one value per triangle. `colors`: red, green, blue, one per triangle.
pub fn write_ply(mesh: &Mesh, labels: Option<(&str, &[i32])>, colors: Option<&[[u8; 3]]>) -> Vec<u8> {
    let n_triangles = mesh.triangles.len();
    assert!(labels.is_none_or(|(_, labels)| labels.len() == n_triangles), "one label per triangle");
    assert!(colors.is_none_or(|colors| colors.len() == n_triangles), "one color per triangle");
    let mut bytes = header(mesh, labels.map(|(name, _)| name), colors.is_some()).into_bytes();
    bytes.reserve(12 * mesh.vertices.len() + (13 + 4 + 3) * n_triangles);
    for vertex in &mesh.vertices {
        for x in vertex.iter() {
            bytes.extend_from_slice(&(*x as f32).to_le_bytes());
        }
    }
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        bytes.push(3);
        for v in triangle {
            bytes.extend_from_slice(&v.to_le_bytes());
        }
        if let Some((_, labels)) = labels {
            bytes.extend_from_slice(&labels[t].to_le_bytes());
        }
        if let Some(colors) = colors {
            bytes.extend_from_slice(&colors[t]);
        }
    }
    bytes
}

/// A mesh with a number and a color per vertex: `name` is the number's property, NaN where there is none.
pub fn write_ply_values(mesh: &Mesh, name: &str, values: &[f64], colors: &[[u8; 3]]) -> Vec<u8> {
    let n = mesh.vertices.len();
    assert!(values.len() == n && colors.len() == n, "one value and one color per vertex");
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {n}\n\
         property float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float {name}\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.triangles.len(),
    )
    .into_bytes();
    bytes.reserve(19 * n + 13 * mesh.triangles.len());
    for ((vertex, color), value) in mesh.vertices.iter().zip(colors).zip(values) {
        for x in vertex.iter() {
            bytes.extend_from_slice(&(*x as f32).to_le_bytes());
        }
        bytes.extend_from_slice(color);
        bytes.extend_from_slice(&(*value as f32).to_le_bytes());
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        for v in triangle {
            bytes.extend_from_slice(&v.to_le_bytes());
        }
    }
    bytes
}

fn header(mesh: &Mesh, label: Option<&str>, colored: bool) -> String {
    let label = label.map_or_else(String::new, |name| format!("property int {name}\n"));
    let colors = if colored { "property uchar red\nproperty uchar green\nproperty uchar blue\n" } else { "" };
    format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\n{label}{colors}end_header\n",
        mesh.vertices.len(),
        mesh.triangles.len(),
    )
}
