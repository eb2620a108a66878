//! What goes into pictures: which meshes, in which colors, from where.

use scanwright::math::{Point3, UnitVec3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::pipeline::Reconstruction;
use scanwright::render::{Camera, Color, Image, Sheet, View, of_kind, of_region, picture};
use scanwright::segment::RegionId;
use scanwright::surface::SurfaceKind;

/// Size of a picture with two rows, pixels.
const SIZE: (usize, usize) = (1600, 1200);
/// The two sides: azimuth and elevation in degrees. Together they show five of the six faces of a box.
const SIDES_DEG: [(f64, f64); 2] = [(-58.0, 28.0), (128.0, -22.0)];
/// Group of triangles without a region; no region has that number.
const NO_REGION: u32 = u32::MAX - 1;

/// The scan beside the part, from two sides. Without a solid the regions of the scan stand for the part.
pub fn of_reconstruction(result: &Reconstruction) -> Image {
    let on_table = |t: usize| result.support.as_ref().is_some_and(|s| s.on_table[t]);
    let up = result.support.as_ref().map_or(Vec3::z_axis(), |s| s.plane.normal);
    let scan = Part {
        colors: (0..result.mesh.triangles.len())
            .map(|t| if on_table(t) { Color::TABLE } else { Color::SCAN })
            .collect(),
        groups: (0..result.mesh.triangles.len()).map(|t| u32::from(on_table(t))).collect(),
        mesh: result.mesh.clone(),
    };
    let part = if result.model.mesh.triangles.is_empty() { regions(result) } else { solid(result) };
    let legend = legend(result);
    let (table_free, _, _) = result.mesh.submesh(|t| !on_table(t));
    let frame = if table_free.vertices.is_empty() { &result.mesh.vertices } else { &table_free.vertices };
    let titles = ["scan", if result.model.mesh.triangles.is_empty() { "regions" } else { "part" }];
    draw(&[(&scan, titles[0]), (&part, titles[1])], up, frame, &legend)
}

/// One mesh from two sides.
pub fn of_mesh(mesh: &Mesh, labels: Option<&[Option<u32>]>, look: &Look, up: Option<UnitVec3>) -> Image {
    let color = |label: Option<u32>| match (look, label) {
        (_, None) => Color::NONE,
        (Look::Region, Some(id)) => of_region(id as usize),
        (Look::Type(kinds), Some(id)) => kinds.get(id as usize).map_or(Color::NONE, |kind| of_kind(*kind)),
    };
    let n = mesh.triangles.len();
    let part = Part {
        colors: labels
            .map_or_else(|| vec![Color::SCAN; n], |labels| labels.iter().map(|l| color(*l)).collect()),
        groups: labels
            .map_or_else(|| vec![0; n], |labels| labels.iter().map(|l| l.unwrap_or(NO_REGION)).collect()),
        mesh: mesh.clone(),
    };
    let legend = match look {
        Look::Type(kinds) => kind_legend(kinds),
        Look::Region => Vec::new(),
    };
    draw(&[(&part, "")], up.unwrap_or(Vec3::z_axis()), &mesh.vertices, &legend)
}

/// What colors mean.
pub enum Look {
    /// The region.
    Region,
    /// The type of the region's surface: one per region, `None` for freeform.
    Type(Vec<Option<SurfaceKind>>),
}

struct Part {
    mesh: Mesh,
    colors: Vec<Color>,
    groups: Vec<u32>,
}

fn draw(parts: &[(&Part, &str)], up: UnitVec3, frame: &[Point3], legend: &[(Color, String)]) -> Image {
    let mut views = Vec::new();
    for (azimuth, elevation) in SIDES_DEG {
        let camera = Camera::around(up, azimuth.to_radians(), elevation.to_radians());
        for (part, title) in parts {
            let title = if views.len() < parts.len() { title } else { "" };
            views.push(View {
                mesh: &part.mesh,
                colors: &part.colors,
                groups: &part.groups,
                camera,
                title,
            });
        }
    }
    let height = if parts.len() == 1 { SIZE.1 * 2 / 3 } else { SIZE.1 };
    picture(&views, &Sheet { width: SIZE.0, height, frame, legend })
}

/// The solid's faces, in the colors of their types; assumed faces pale.
fn solid(result: &Reconstruction) -> Part {
    let model = &result.model;
    let of_face = |(region, assumed): (&RegionId, &bool)| {
        let color = of_kind(kind_of(result, *region));
        if *assumed { color.pale() } else { color }
    };
    Part {
        mesh: model.mesh.clone(),
        colors: model.regions.iter().zip(&model.assumed).map(of_face).collect(),
        groups: model.regions.iter().map(|r| r.0).collect(),
    }
}

/// The scan's triangles without the table, in the colors of their regions' types.
fn regions(result: &Reconstruction) -> Part {
    let on_table = |t: usize| result.support.as_ref().is_some_and(|s| s.on_table[t]);
    let (mesh, old, _) = result.mesh.submesh(|t| !on_table(t));
    let labels: Vec<_> = old.iter().map(|&t| result.segmentation.labels[t as usize]).collect();
    Part {
        mesh,
        colors: labels.iter().map(|l| l.map_or(Color::NONE, |r| of_kind(kind_of(result, r)))).collect(),
        groups: labels.iter().map(|l| l.map_or(NO_REGION, |r| r.0)).collect(),
    }
}

fn kind_of(result: &Reconstruction, region: RegionId) -> Option<SurfaceKind> {
    result.segmentation.primitives.get(region.0 as usize).and_then(|p| p.kind())
}

fn legend(result: &Reconstruction) -> Vec<(Color, String)> {
    let kinds: Vec<_> = result.segmentation.primitives.iter().map(|p| p.kind()).collect();
    let mut legend = kind_legend(&kinds);
    if result.model.assumed.contains(&true) {
        legend.push((of_kind(Some(SurfaceKind::Plane)).pale(), "assumed".to_owned()));
    }
    legend
}

/// The types that occur, with how many there are of each.
fn kind_legend(kinds: &[Option<SurfaceKind>]) -> Vec<(Color, String)> {
    let all = SurfaceKind::ALL.into_iter().map(Some).chain([None]);
    all.filter_map(|kind| {
        let n = kinds.iter().filter(|k| **k == kind).count();
        let name = kind.map_or("freeform", SurfaceKind::name);
        (n > 0).then(|| (of_kind(kind), format!("{n} {name}")))
    })
    .collect()
}
