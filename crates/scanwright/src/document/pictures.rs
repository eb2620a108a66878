//! The pictures of a document.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::page::{Figure, Figures};
use super::part::Part;
use super::scene::{ModelView, ScanView, Scene};
use super::section::{WeakPlace, Weakness, weak_places};
use super::{Input, unseen};
use crate::deviation::Histogram;
use crate::math::{Point3, UnitVec3, Vec3};
use crate::mesh::Mesh;
use crate::recognize::Residual;
use crate::render::{Camera, Color, Diverging, Drawable, Paint, Panel, of_kind, panel, visible_samples};
use crate::surface::SurfaceKind;

/// Weak places that get a picture.
pub(super) const MOST_PLACES: usize = 24;

/// Sizes of pictures on the page, inches.
const OVERVIEW: (f64, f64) = (3.8, 2.7);
const DEVIATION: (f64, f64) = (2.6, 2.05);
const WEAK: (f64, f64) = (2.5, 1.95);

/// The two sides of the overview, azimuth and elevation in degrees: together five of the six faces of a box.
const SIDES_DEG: [(f64, f64); 2] = [(-58.0, 28.0), (128.0, -22.0)];
/// The views of the deviation: all round from above and from below.
const VIEWS_DEG: [(f64, f64); 6] =
    [(-60.0, 30.0), (60.0, 30.0), (180.0, 30.0), (-120.0, -30.0), (0.0, -30.0), (120.0, -30.0)];
/// Elevations, in degrees, and number of azimuths from which weak places are looked at.
const ELEVATIONS_DEG: [f64; 4] = [25.0, -25.0, 55.0, -55.0];
const N_AZIMUTHS: usize = 8;

/// What could be drawn.
#[derive(Debug, Clone, Default)]
pub(super) struct Pictures {
    pub overview: Option<Figures>,
    pub deviation: Option<Figures>,
    /// Of the distances in the pictures, for results that have none.
    pub histogram: Option<Histogram>,
    /// One per weak place.
    pub weak: Vec<Option<Figure>>,
    /// What is missing and how to get it.
    pub missing: Option<String>,
    /// What of the model could not be read.
    pub unread: Vec<String>,
}

impl Pictures {
    /// Draws what the scene allows.
    pub fn draw(input: &Input) -> Self {
        let part = input.part;
        let (scene, reach) = with_unseen(part, input.scene);
        let scene = &scene;
        let scan = scene.scan.as_ref().filter(|scan| !scan.mesh.triangles.is_empty());
        let groups = scan.map(groups_of).unwrap_or_default();
        let scan = scan.map(|scan| Drawn::new(&scan.mesh, &groups));
        let model = scene.model.as_ref().map(|model| Drawn::new(&model.mesh, &model.face_of));
        let histogram = scene.distances.as_ref().map(|distances| {
            let p95 = Residual::from_distances(distances).p95;
            Histogram::new(distances, p95, part.scan.noise.unwrap_or(0.0))
        });
        Self {
            overview: overview(input, scene, scan.as_ref(), model.as_ref()),
            deviation: scan.as_ref().and_then(|scan| deviation(input, scene, scan, histogram.as_ref())),
            weak: weak(input, scene, scan.as_ref(), model.as_ref(), reach),
            missing: missing(scene),
            unread: scene.unread.clone(),
            histogram,
        }
    }
}

/// Standard deviations of the noise, spacings and standard deviations of the scanner's spot within which a surface that
/// was seen lies from the scan: at a right angle the spot rounds an edge by about its own size.
const REACH_SIGMAS: f64 = 4.0;
const REACH_SPACINGS: f64 = 1.0;
const REACH_SPOTS: f64 = 1.0;

/// The scene with what nobody saw of extended faces as faces of their own, and how far from the scan that begins.
fn with_unseen(part: &Part, scene: &Scene) -> (Scene, f64) {
    let extended: BTreeSet<u32> = part.warnings_of("W_ASSUMED_FACE").filter_map(|w| w.primitive).collect();
    let lengths = [
        (REACH_SIGMAS, part.scan.noise),
        (REACH_SPACINGS, part.scan.spacing),
        (REACH_SPOTS, part.scan.edge_rounding),
    ];
    let reach = lengths.into_iter().map(|(times, length)| times * length.unwrap_or(0.0)).fold(0.0, f64::max);
    let mut scene = scene.clone();
    if let (Some(model), Some(scan)) = (&scene.model, &scene.scan) {
        scene.model = Some(unseen::separated(model, &scan.mesh, &extended, reach));
    }
    (scene, reach)
}

fn missing(scene: &Scene) -> Option<String> {
    let how = "scanwright report PART.json --scan SCAN --model PART.step -o report.html";
    let what = match (&scene.scan, &scene.model) {
        (Some(_), Some(_)) => return None,
        (None, None) => "Pictures are missing: neither the scan nor the model was given.",
        (None, Some(_)) => {
            "Pictures of the scan, its deviation and weak places are missing: the scan was not given."
        }
        (Some(_), None) => {
            "Pictures of the part, the deviation and assumed faces are missing: no model was given, or none was made."
        }
    };
    Some(format!("{what} `{how}` draws them, and so does `scanwright convert --report report.html`."))
}

/// A mesh with what its triangles belong to: of the part faces, of the scan what [`groups_of`] gives.
struct Drawn<'a> {
    mesh: &'a Mesh,
    groups: &'a [u32],
    drawable: Drawable<'a>,
}

impl<'a> Drawn<'a> {
    fn new(mesh: &'a Mesh, groups: &'a [u32]) -> Self {
        Self { mesh, groups, drawable: Drawable::new(mesh, groups) }
    }
}

/// Group 0 is no region, group `id + 1` that of a primitive.
fn groups_of(scan: &ScanView) -> Vec<u32> {
    scan.labels.iter().map(|label| label.map_or(0, |id| id.saturating_add(1))).collect()
}

fn camera(up: UnitVec3, (azimuth, elevation): (f64, f64)) -> Camera {
    Camera::around(up, azimuth.to_radians(), elevation.to_radians())
}

/// The axes of the scan that a camera is on the side of, such as `+x -z`.
fn side(camera: &Camera) -> String {
    const LEAST: f64 = 0.3;
    let eye = camera.towards_eye();
    let axes = ["x", "y", "z"].into_iter().zip(eye.iter());
    let words = axes.filter(|(_, c)| c.abs() >= LEAST);
    words.map(|(axis, c)| format!("{}{axis}", if *c > 0.0 { "+" } else { "-" })).collect::<Vec<_>>().join(" ")
}

fn figure(image: &crate::render::Image, caption: String, alt: String) -> Figure {
    Figure { png: image.to_png(), size: (image.width, image.height), caption, alt }
}

fn overview(input: &Input, scene: &Scene, scan: Option<&Drawn>, model: Option<&Drawn>) -> Option<Figures> {
    let scan = scan.map(|scan| (&scan.drawable, vec![Color::SCAN; scan.groups.len()]));
    let model = model.zip(scene.model.as_ref()).map(|(drawn, view)| {
        let colors: Vec<Color> = view.face_of.iter().map(|face| color_of(view, *face)).collect();
        (&drawn.drawable, colors)
    });
    let mut figures = Vec::new();
    for angles in SIDES_DEG {
        let camera = camera(scene.up, angles);
        for (what, drawn) in [("Scan", &scan), ("Part", &model)] {
            let Some((drawable, colors)) = drawn else { continue };
            let image = panel(
                drawable,
                &Paint::Triangles(colors),
                &plain(pixels(input, OVERVIEW), scene.frame(), camera),
            );
            let from = side(&camera);
            let alt = format!("{what}, seen from {from}");
            figures.push(figure(&image, format!("{what}, from {from}"), alt));
        }
    }
    let columns = 2;
    let legend = if scene.model.is_some() { type_legend(input.part, scene) } else { Vec::new() };
    (!figures.is_empty()).then_some(Figures { columns, figures, legend })
}

fn pixels(input: &Input, inches: (f64, f64)) -> (usize, usize) {
    let pixels = |inches: f64| ((inches * input.dots_per_inch as f64).round() as usize).max(1);
    (pixels(inches.0), pixels(inches.1))
}

fn plain(size: (usize, usize), frame: &[Point3], camera: Camera) -> Panel<'_> {
    Panel { width: size.0, height: size.1, frame, camera, marked: &[] }
}

fn color_of(model: &ModelView, face: u32) -> Color {
    let Some(face) = model.faces.get(face as usize) else { return Color::NONE };
    let color = match (face.region, face.kind) {
        // A mesh without names and surfaces.
        (None, None) => Color::PLAIN,
        (_, kind) => of_kind(kind),
    };
    if face.assumed { color.pale() } else { color }
}

/// The types that occur, with the number of regions of each.
fn type_legend(part: &Part, scene: &Scene) -> Vec<(String, String)> {
    let kinds = SurfaceKind::ALL.into_iter().map(Some).chain([None]);
    let mut legend: Vec<(String, String)> = kinds
        .filter_map(|kind| {
            let n = part.primitives.iter().filter(|p| p.surface_kind() == kind).count();
            let name = kind.map_or("freeform", SurfaceKind::name);
            (n > 0).then(|| (of_kind(kind).hex(), format!("{name} ({n})")))
        })
        .collect();
    if scene.model.as_ref().is_some_and(|model| model.faces.iter().any(|face| face.assumed)) {
        legend.push((of_kind(Some(SurfaceKind::Plane)).pale().hex(), "pale: not seen".to_owned()));
    }
    legend
}

fn deviation(input: &Input, scene: &Scene, scan: &Drawn, drawn_from: Option<&Histogram>) -> Option<Figures> {
    let distances = scene.distances.as_ref()?;
    // The scale that the result recorded, so that its histogram and the pictures agree.
    let recorded = input.part.deviation.as_ref().and_then(|deviation| deviation.histogram.as_ref());
    let limit = recorded.or(drawn_from)?.limit;
    let scale = Diverging { limit };
    // Lines between regions would hide the colors along them.
    let groups = vec![0; scan.groups.len()];
    let drawable = Drawable::new(scan.mesh, &groups);
    let draw = |angles: &(f64, f64)| {
        let camera = camera(scene.up, *angles);
        let paint = Paint::Values { values: distances, scale };
        let image = panel(&drawable, &paint, &plain(pixels(input, DEVIATION), scene.frame(), camera));
        let from = side(&camera);
        let alt = format!("Deviation of the scan from the part, seen from {from}");
        figure(&image, format!("From {from}"), alt)
    };
    Some(Figures { columns: 3, figures: VIEWS_DEG.iter().map(draw).collect(), legend: Vec::new() })
}

/// One per weak place; those on the part where they are about what nobody saw. `reach`: see [`with_unseen`].
fn weak(
    input: &Input,
    scene: &Scene,
    scan: Option<&Drawn>,
    model: Option<&Drawn>,
    reach: f64,
) -> Vec<Option<Figure>> {
    let places = weak_places(input.part);
    let cameras = cameras(scene.up);
    let stage = |drawn: &Drawn| {
        let n = drawn.groups.iter().max().map_or(0, |most| (*most as usize).min(drawn.groups.len()) + 1);
        visible_samples(&drawn.drawable, n, &cameras, scene.frame())
    };
    let unseen = |place: &WeakPlace| place.has(Weakness::Unseen);
    let shown = &places[..places.len().min(MOST_PLACES)];
    let (any_scan, any_model) = (shown.iter().any(|p| !unseen(p)), shown.iter().any(unseen));
    let scan = scan.map(|scan| (scan, if any_scan || model.is_none() { stage(scan) } else { Vec::new() }));
    let model = model.map(|model| (model, if any_model { stage(model) } else { Vec::new() }));
    let draw = |place: &WeakPlace| {
        let on_model = || {
            let (drawn, visible) = model.as_ref()?;
            let (groups, told_apart) = faces_of(scene.model.as_ref()?, place.id?);
            let mut figure = place_figure(input, scene, (drawn, visible), &groups, place, &cameras)?;
            if !told_apart && scan.is_some() {
                let reach = super::number::short(Some(reach));
                let unit = input.part.unit();
                let _ =
                    write!(figure.caption, "; all of it: what was not seen is narrower than {reach} {unit}");
            }
            Some(figure)
        };
        let on_scan = || {
            let (drawn, visible) = scan.as_ref()?;
            let group = place.id.map_or(0, |id| id.saturating_add(1));
            place_figure(input, scene, (drawn, visible), &[group], place, &cameras)
        };
        if unseen(place) { on_model().or_else(on_scan) } else { on_scan() }
    };
    let mut figures: Vec<Option<Figure>> = shown.iter().map(draw).collect();
    figures.resize(places.len(), None);
    figures
}

/// The faces of a region that nobody saw, or all of them when nothing of it is told apart as unseen, and which it is.
fn faces_of(model: &ModelView, id: u32) -> (Vec<u32>, bool) {
    let of_region = |assumed: bool| {
        let faces = model.faces.iter().enumerate();
        let found = faces.filter(move |(_, face)| face.region == Some(id) && (face.assumed || !assumed));
        found.map(|(k, _)| k as u32).collect::<Vec<_>>()
    };
    let assumed = of_region(true);
    if assumed.is_empty() { (of_region(false), false) } else { (assumed, true) }
}

/// The cameras that weak places are looked for from.
fn cameras(up: UnitVec3) -> Vec<Camera> {
    let around = |elevation: f64| {
        (0..N_AZIMUTHS).map(move |k| {
            let azimuth = -58.0 + 360.0 * k as f64 / N_AZIMUTHS as f64;
            camera(up, (azimuth, elevation))
        })
    };
    ELEVATIONS_DEG.into_iter().flat_map(around).collect()
}

/// The place in magenta on a plain mesh, from where most of it is seen.
fn place_figure(
    input: &Input,
    scene: &Scene,
    (drawn, visible): (&Drawn, &[Vec<usize>]),
    groups: &[u32],
    place: &WeakPlace,
    cameras: &[Camera],
) -> Option<Figure> {
    let marked: Vec<bool> = drawn.groups.iter().map(|group| groups.contains(group)).collect();
    if !marked.contains(&true) {
        return None;
    }
    let seen = |counts: &Vec<usize>| -> usize {
        groups.iter().filter_map(|group| counts.get(*group as usize)).sum()
    };
    // Of equal views the first, which looks from above.
    let best = (0..cameras.len()).rev().max_by_key(|k| visible.get(*k).map_or(0, seen))?;
    let hidden = visible.get(best).map_or(0, seen) == 0;
    let camera = cameras[best];
    let color = |marked: &bool| if *marked { Color::MARK } else { Color::PLAIN };
    let colors: Vec<Color> = marked.iter().map(color).collect();
    let (width, height) = pixels(input, WEAK);
    let view = Panel { width, height, frame: scene.frame(), camera, marked: &marked };
    let image = panel(&drawn.drawable, &Paint::Triangles(&colors), &view);
    let name = place.id.map_or_else(|| "what belongs to no region".to_owned(), |id| input.part.name_of(id));
    let from = side(&camera);
    let caption = if hidden {
        format!("Hidden from every side tried; from {from}")
    } else {
        format!("From {from}{}", direction(&camera.towards_eye()))
    };
    Some(figure(&image, caption, format!("Where {name} is, seen from {from}")))
}

/// The direction to the eye, for a scanner to come from.
fn direction(eye: &Vec3) -> String {
    let [x, y, z] = [eye.x, eye.y, eye.z].map(|c| format!("{c:.2}").replace("-0.00", "0.00"));
    format!(" (direction {x}, {y}, {z})")
}
