//! What goes into pictures: which meshes, in which colors, from where.

use scanwright::align::{Alignment, Part as ScanPart, Target};
use scanwright::check::Check;
use scanwright::math::{Point3, UnitVec3, Vec3};
use scanwright::mesh::Mesh;
use scanwright::pipeline::{Reconstruction, Segmented};
use scanwright::recognize::Primitive;
use scanwright::render::{Camera, Color, Diverging, Image, Sheet, View, of_kind, of_region, picture};
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
    let up = result.support.as_ref().map_or(Vec3::z_axis(), |s| s.plane.normal);
    let (part_of_scan, _, _) = result.mesh.submesh(|t| !on_table(result, t));
    let from_above = scan(result, &part_of_scan, Table::Near);
    let from_below = scan(result, &part_of_scan, Table::Hidden);
    let made = !result.model.mesh.triangles.is_empty();
    let part = if made { solid(result) } else { regions(result) };
    let title = if made { "part" } else { "regions" };
    let rows = [[(&from_above, "scan"), (&part, title)], [(&from_below, ""), (&part, "")]];
    draw(&rows, up, &part_of_scan.vertices, &legend(result))
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
    draw(&[[(&part, "")]; 2], up.unwrap_or(Vec3::z_axis()), &mesh.vertices, &legend)
}

/// A number and a color per vertex of the scan: its deviation, in shares of `scale`; grey where there is none.
pub fn deviations(
    segmented: &Segmented,
    part: &ScanPart,
    check: &Check,
    scale: f64,
) -> (Vec<f64>, Vec<[u8; 3]>) {
    let n = segmented.mesh.vertices.len();
    let (mut values, mut colors) = (vec![f64::NAN; n], vec![Color::NONE.0; n]);
    for (sighting, &v) in check.sightings.of_vertex.iter().zip(&part.scan_vertex) {
        if let Some(sighting) = sighting {
            values[v as usize] = sighting.distance;
            colors[v as usize] = of_share(sighting.distance / scale).0;
        }
    }
    (values, colors)
}

/// The scan's deviations beside the model's faces, from two sides: faces in the color of their mean, those that were not
/// seen and those that are not there in their own.
pub fn of_check(part: &ScanPart, target: &Target, alignment: &Alignment, check: &Check, scale: f64) -> Image {
    let mesh = part.mesh.moved(&alignment.pose);
    let of_triangle = |triangle: &[u32; 3]| {
        let seen: Vec<f64> = triangle
            .iter()
            .filter_map(|&v| check.sightings.of_vertex[v as usize])
            .map(|s| s.distance)
            .collect();
        let mean = seen.iter().sum::<f64>() / seen.len().max(1) as f64;
        if seen.is_empty() { Color::NONE } else { of_share(mean / scale) }
    };
    let n = mesh.triangles.len();
    let scan = Part { colors: mesh.triangles.iter().map(of_triangle).collect(), groups: vec![0; n], mesh };
    let of_face = |f: &u32| {
        let face = &check.faces[*f as usize];
        match (face.state(), face.spread) {
            ("absent", _) => Color::ABSENT,
            ("unobserved" | "partly", _) | (_, None) => Color::UNSEEN,
            (_, Some(spread)) => of_share(spread.mean / scale),
        }
    };
    let model = &target.model;
    let faces = Part {
        mesh: model.mesh.clone(),
        colors: model.face_of.iter().map(of_face).collect(),
        groups: model.face_of.clone(),
    };
    let mut legend = vec![
        (of_share(-1.0), format!("{:.3}", -scale)),
        (of_share(0.0), "0".to_owned()),
        (of_share(1.0), format!("+{scale:.3}")),
        (Color::NONE, "on no face".to_owned()),
        (Color::UNSEEN, "not seen, or less than half".to_owned()),
    ];
    if check.faces.iter().any(scanwright::check::FaceCheck::is_absent) {
        legend.push((Color::ABSENT, "not there".to_owned()));
    }
    let rows = [[(&scan, "scan"), (&faces, "model: means of faces")], [(&scan, ""), (&faces, "")]];
    draw(&rows, Vec3::z_axis(), &faces.mesh.vertices, &legend)
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

/// One row per side, above each other or, when a row is one view only, beside each other.
fn draw<const N: usize>(
    rows: &[[(&Part, &str); N]; 2],
    up: UnitVec3,
    frame: &[Point3],
    legend: &[(Color, String)],
) -> Image {
    let mut views = Vec::new();
    for (row, (azimuth, elevation)) in rows.iter().zip(SIDES_DEG) {
        let camera = Camera::around(up, azimuth.to_radians(), elevation.to_radians());
        views.extend(row.iter().map(|(part, title)| View {
            mesh: &part.mesh,
            colors: &part.colors,
            groups: &part.groups,
            camera,
            title,
        }));
    }
    let height = if N == 1 { SIZE.1 * 2 / 3 } else { SIZE.1 };
    picture(&views, &Sheet { width: SIZE.0, height, frame, legend })
}

/// How much of the table is drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Table {
    /// What is near the part.
    Near,
    /// Nothing: seen from below it would hide the part.
    Hidden,
}

/// How far around the part the table is drawn, as a share of the part's diagonal.
const TABLE_SHARE: f64 = 0.06;

fn on_table(result: &Reconstruction, t: usize) -> bool {
    result.support.as_ref().is_some_and(|s| s.on_table[t])
}

/// The scan in grey. `part`: what is not the table's.
fn scan(result: &Reconstruction, part: &Mesh, table: Table) -> Part {
    let rim = Vec3::repeat(TABLE_SHARE * part.diagonal());
    let bounds = part.bounds();
    let near = |t: usize| {
        let center = result.mesh.triangle_center(t);
        bounds.is_some_and(|(lo, hi)| center >= lo - rim && center <= hi + rim)
    };
    let drawn = |t: usize| !on_table(result, t) || (table == Table::Near && near(t));
    let (mesh, old, _) = result.mesh.submesh(drawn);
    let of_table: Vec<bool> = old.iter().map(|&t| on_table(result, t as usize)).collect();
    Part {
        mesh,
        colors: of_table.iter().map(|table| if *table { Color::TABLE } else { Color::SCAN }).collect(),
        groups: of_table.iter().map(|table| u32::from(*table)).collect(),
    }
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
    let (mesh, old, _) = result.mesh.submesh(|t| !on_table(result, t));
    let labels: Vec<_> = old.iter().map(|&t| result.segmentation.labels[t as usize]).collect();
    Part {
        mesh,
        colors: labels.iter().map(|l| l.map_or(Color::NONE, |r| of_kind(kind_of(result, r)))).collect(),
        groups: labels.iter().map(|l| l.map_or(NO_REGION, |r| r.0)).collect(),
    }
}

fn kind_of(result: &Reconstruction, region: RegionId) -> Option<SurfaceKind> {
    let scanned = &result.segmentation.primitives;
    let primitives = if result.model.primitives.is_empty() { scanned } else { &result.model.primitives };
    primitives.get(region.0 as usize).and_then(Primitive::kind)
}

fn legend(result: &Reconstruction) -> Vec<(Color, String)> {
    let kinds: Vec<_> = result.segmentation.primitives.iter().map(Primitive::kind).collect();
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
        (n > 0).then(|| (of_kind(kind), counted(n, kind)))
    })
    .collect()
}

/// A number of surfaces of a type, for people.
pub fn counted(n: usize, kind: Option<SurfaceKind>) -> String {
    match (kind, n) {
        (None, _) => format!("{n} freeform"),
        (Some(kind), 1) => format!("1 {}", kind.name()),
        (Some(SurfaceKind::Torus), _) => format!("{n} tori"),
        (Some(kind), _) => format!("{n} {}s", kind.name()),
    }
}

/// The color of a deviation, as a share of the end of the scale; what is beyond has the color of the end.
fn of_share(share: f64) -> Color {
    Diverging { limit: 1.0 }.color(share.clamp(-1.0, 1.0))
}
