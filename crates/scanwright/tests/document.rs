//! Documents: well formed, whole in one file, the same numbers in every format, nothing from a file run as markup.

use std::collections::BTreeSet;

use quick_xml::Reader;
use quick_xml::events::Event;
use scanwright::document::{self, Format, Input, Part, PartError, ScanInput, Scene};
use scanwright::math::Point3;
use scanwright::mesh::Mesh;
use scanwright::par;
use scanwright::prior::PriorModel;
use serde_json::{Value, json};

const HOSTILE: &str = "</style><script>alert(1)</script>\" onload='x' &amp; | `=1+1` \u{202e}gpj";

#[test]
fn pages_are_well_formed_and_refer_to_nothing_outside() {
    for name in ["bracket", HOSTILE] {
        let page = page_of(&result(name), name, &scene(&result(name)));
        let tags = tags(&page);
        assert!(tags.iter().any(|tag| tag.name == "img"), "there are pictures");
        assert!(!tags.iter().any(|tag| ["script", "link", "iframe", "object", "base"].contains(&&*tag.name)));
        let ids: BTreeSet<&str> = tags.iter().filter_map(|tag| tag.attribute("id")).collect();
        for tag in &tags {
            for (attribute, value) in &tag.attributes {
                assert!(!attribute.starts_with("on"), "{} has {attribute}", tag.name);
                match attribute.as_str() {
                    "src" => assert!(value.starts_with("data:image/png;base64,"), "{value:.40}"),
                    "href" => {
                        let target = value.strip_prefix('#').unwrap_or_else(|| panic!("leads out: {value}"));
                        assert!(ids.contains(target), "leads nowhere: {value}");
                    }
                    _ => {}
                }
            }
        }
        for outside in ["http:", "https:", "url(", "@import", "srcset"] {
            assert!(!page.contains(outside), "{outside}");
        }
    }
}

#[test]
fn names_from_files_are_text_in_every_format() {
    let part = result(HOSTILE);
    let page = page_of(&part, HOSTILE, &Scene::empty());
    let text: String = texts(&page);
    // Nothing is lost but the marks that turn the reading direction, which become blanks.
    let shown = HOSTILE.replace('\u{202e}', " ");
    assert!(text.contains(&shown), "the name is not shown as it is");
    assert!(!page.contains("<script"));
    let markdown = write(&part, HOSTILE, Format::Markdown);
    assert!(!markdown.contains("</style><script>"), "markup in Markdown:\n{markdown}");
    assert!(!markdown.contains(" | `=1"), "a cell breaks in two");
    let csv = write(&part, "=cmd()", Format::Csv);
    assert!(csv.starts_with("document,'=cmd(),"), "{csv}");
}

#[test]
fn the_same_numbers_stand_in_every_format() {
    let part = result("bracket");
    let page = texts(&page_of(&part, "bracket", &Scene::empty()));
    let markdown = write(&part, "bracket", Format::Markdown);
    let csv = write(&part, "bracket", Format::Csv);
    // Radius 5.98341 with u = 0.0061: U95 = 0.0122; half angle 0.5 with u = 0.001 rad: 28.648 and 0.11 degrees.
    for number in ["5.983", "0.012", "28.65", "0.11", "-0.017", "342"] {
        for (format, text) in [("HTML", &page), ("Markdown", &markdown), ("CSV", &csv)] {
            assert!(text.contains(number), "{format} lacks {number}");
        }
    }
    // In CSV a table is what a search for its name gives.
    let sizes: Vec<&str> = csv.lines().filter(|line| line.starts_with("sizes,")).collect();
    assert_eq!(sizes.len(), 3, "{sizes:?}");
    assert!(sizes[0].contains("Value (mm),± U95 (mm)"), "{}", sizes[0]);
    assert!(sizes[1].starts_with("sizes,radius [1],cylinder 1,5.983,0.012,342,"), "{}", sizes[1]);
    let columns = |line: &str| csv_cells(line).len();
    assert!(sizes.iter().all(|line| columns(line) == columns(sizes[0])), "{sizes:?}");
}

#[test]
fn the_verdict_follows_the_result() {
    let headline = |change: &dyn Fn(&mut Value)| {
        let mut value = result_json("bracket");
        change(&mut value);
        let markdown = write(&read(&value), "bracket", Format::Markdown);
        markdown.lines().find(|line| line.starts_with("**")).unwrap().to_owned()
    };
    let good = headline(&|value| value["warnings"] = json!([]));
    assert_eq!(good, "**Closed, valid solid, all faces analytic** (ok)");
    let freeform = headline(&|_| ());
    assert_eq!(freeform, "**Closed, valid solid, but 1 region is not analytic** (look)");
    let open = headline(&|value| value["solids"][0]["closed"] = json!(false));
    assert_eq!(open, "**The shell is open: not a solid yet** (fails)");
    let refused = headline(&|value| value["solids"][0]["problems"] = json!(["a loop crosses itself"]));
    assert_eq!(refused, "**Closed, but not valid: 1 problem in our own check** (fails)");
    let none = headline(&|value| value["solids"] = json!([]));
    assert_eq!(none, "**No solid was made** (fails)");
}

#[test]
fn guesses_refusals_and_weak_places_are_said() {
    let markdown = write(&result("bracket"), "bracket", Format::Markdown);
    for needed in [
        "radius is a guess: only 41 degrees of wall seen",
        "1 is a guess",
        "scan about 63° more of its arc",
        "moves its points by more than the noise",
        "not seen: extended into what the scanner did not see",
        "nominal, applied by --snap",
        "| level | plane 0 |",
        "| zero | plane 0, plane 3, cylinder 1 |",
    ] {
        assert!(markdown.contains(needed), "{needed} is not said:\n{markdown}");
    }
}

#[test]
fn a_result_of_an_older_version_is_read() {
    let mut value = result_json("bracket");
    let object = value.as_object_mut().unwrap();
    for key in ["dimensions", "relations", "settings", "units", "warnings", "deviation"] {
        object.remove(key);
    }
    object["scan"].as_object_mut().unwrap().remove("source");
    let markdown = write(&read(&value), "bracket", Format::Markdown);
    // The radius is that of the primitive, its uncertainty twice that of the parameter.
    assert!(markdown.contains("| radius | cylinder 1 | 5.983 | 0.012 |"), "{markdown}");
    assert!(markdown.contains("lists no relations"));
    let least = read(&json!({ "schema": "scanwright/result/1" }));
    assert!(write(&least, "", Format::Html).contains("No solid was made"));
}

#[test]
fn what_is_no_result_is_refused_with_its_place() {
    let cases = [
        ("", "line 1: "),
        ("{\n\"schema\": \"scanwright/result/1\",\n\"primitives\": 3}", "line 3: "),
        ("{\"schema\": \"other/2\"}", "schema is \"other/2\""),
        ("[]", "line 1: "),
    ];
    for (text, expected) in cases {
        let error = Part::read(text).map(|_| ()).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{text:?}: {error}");
    }
    let mut value = result_json("bracket");
    value["primitives"][2]["id"] = json!(0);
    assert!(matches!(Part::read(&value.to_string()), Err(PartError::RepeatedId { id: 0 })));
}

#[test]
fn numbers_of_any_size_do_not_break_a_page() {
    for number in [0.0, -0.0, 1e300, -1e300, 1e-300, f64::MAX, f64::MIN_POSITIVE] {
        let mut value = result_json("bracket");
        replace_numbers(&mut value, number);
        // Counts stay counts, and ids ids: those are integers in the file.
        let part = read(&value);
        let page = page_of(&part, "bracket", &scene(&part));
        tags(&page);
    }
}

#[test]
fn pages_do_not_depend_on_the_number_of_threads() {
    let part = result("bracket");
    let draw = |threads| par::with_threads(Some(threads), || page_of(&part, "bracket", &scene(&part)));
    let one = draw(1);
    assert_eq!(one, draw(2));
    assert_eq!(one, draw(1));
}

#[test]
fn weak_places_are_marked_where_they_are() {
    let part = result("bracket");
    let page = page_of(&part, "bracket", &scene(&part));
    let tags = tags(&page);
    let weak: Vec<&str> =
        tags.iter().filter_map(|tag| tag.attribute("alt")).filter(|a| a.starts_with("Where")).collect();
    // Region 0 is the wall whose face was assumed, 2 the one without a surface; 1 is nowhere in this scan.
    assert!(weak.iter().any(|alt| alt.starts_with("Where plane 0 is")), "{weak:?}");
    assert!(weak.iter().any(|alt| alt.starts_with("Where freeform 2 is")), "{weak:?}");
    let without = page_of(&part, "bracket", &Scene::empty());
    assert!(!without.contains("data:image"));
    assert!(without.contains("neither the scan nor the model was given"));
}

#[test]
fn labels_that_were_not_kept_are_found_by_the_surfaces() {
    let part = result("bracket");
    let (mesh, mut labels) = corner_of_two_walls();
    // What has no surface and no place cannot be found again: it goes to the plane that it lies on.
    labels.iter_mut().filter(|label| **label == Some(2)).for_each(|label| *label = Some(0));
    let model = model(&mesh);
    let found = Scene::of_files(&part, Some(ScanInput { mesh: &mesh, labels: None }), Some(&model));
    let given = Scene::of_files(&part, Some(ScanInput { mesh: &mesh, labels: Some(&labels) }), Some(&model));
    let picture = |scene: &Scene| {
        let page = page_of(&part, "bracket", scene);
        page.split("alt=\"Where plane 3").next().unwrap().rsplit("src=\"").next().unwrap().to_owned()
    };
    assert!(picture(&found) == picture(&given), "other triangles are marked");
}

#[test]
fn scans_follow_to_the_datums() {
    let (mesh, labels) = corner_of_two_walls();
    let model = model(&mesh);
    let page = |part: &Part, scan: &Mesh| {
        let scan = ScanInput { mesh: scan, labels: Some(&labels) };
        page_of(part, "bracket", &Scene::of_files(part, Some(scan), Some(&model)))
    };
    // A quarter turn about x and a way along y, from which the datums bring the scan back.
    let mut moved = mesh.clone();
    for p in &mut moved.vertices {
        *p = Point3::new(p.x, 5.0 - p.z, p.y);
    }
    let mut value = result_json("bracket");
    value["placement"]["aligned_from_scan"] =
        json!([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 5.0], [0.0, 0.0, 0.0, 1.0]]);
    let pictures = |page: &str| {
        page.split("<img src=").skip(1).map(|p| p.split('"').nth(1).unwrap().to_owned()).collect::<Vec<_>>()
    };
    let (still, followed) =
        (pictures(&page(&result("bracket"), &mesh)), pictures(&page(&read(&value), &moved)));
    assert!(still == followed, "the scan is elsewhere");
    assert!(still != pictures(&page(&result("bracket"), &moved)), "pictures do not show where the scan is");
}

fn page_of(part: &Part, name: &str, scene: &Scene) -> String {
    document::write(&Input { part, name, scene, dots_per_inch: 40 }, Format::Html)
}

fn write(part: &Part, name: &str, format: Format) -> String {
    document::write(&Input { part, name, scene: &Scene::empty(), dots_per_inch: 40 }, format)
}

fn result(name: &str) -> Part {
    read(&result_json(name))
}

fn read(value: &Value) -> Part {
    Part::read(&value.to_string()).unwrap_or_else(|error| panic!("{error}"))
}

/// A result with one of everything; `name`: of the scan's file and of what else has a name.
fn result_json(name: &str) -> Value {
    let wall = |id: u32, normal: [f64; 3], low: [f64; 3], high: [f64; 3]| {
        json!({
            "id": id, "type": "plane", "point": [0.0, 0.0, 0.0], "normal": normal, "outward": true,
            "residual": { "rms": 0.01, "p95": 0.02, "max": 0.03 },
            "parameters": ["offset", "tilt_x", "tilt_y"], "uncertainty": [0.002, 0.0001, 0.0001],
            "triangles": 128, "area": 64.0, "ambiguous": null,
            "place": { "middle": [4.0, 4.0, 4.0], "low": low, "high": high, "facing": normal },
        })
    };
    let mut weak_wall = wall(3, [0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [8.0, 0.0, 8.0]);
    weak_wall["ambiguous"] = json!(name);
    json!({
        "schema": "scanwright/result/1", "version": "0.1.0",
        "units": { "name": "mm", "millimetres": 1.0, "source": "assumed" },
        "settings": { "seed": 1, "gap": 0.001, "target": null, "odd": { name: name } },
        "scan": {
            "source": { "file": name, "bytes": 1234, "sha256": "ab".repeat(32) },
            "triangles": 256, "vertices": 162, "area": 128.0, "area_explained": 128.0, "diagonal": 12.0,
            "spacing": 1.0, "noise": 0.01,
        },
        "primitives": [
            wall(0, [0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [8.0, 8.0, 0.0]),
            {
                "id": 1, "type": "cylinder", "axis_point": [1.0, 2.0, 3.0], "axis_direction": [0.0, 0.0, 1.0],
                "radius": 5.983_41, "outward": false,
                "parameters": ["offset_x", "offset_y", "tilt_x", "tilt_y", "radius"],
                "uncertainty": [0.01, 0.01, 0.001, 0.001, 0.0061],
                "sufficiency": { "uncertainty": 0.0061, "missing": { "arc": 1.1 } },
            },
            { "id": 2, "type": "freeform" },
            weak_wall,
        ],
        "dimensions": [
            {
                "id": 1, "kind": "radius", "of": [1], "value": 5.983_41, "uncertainty": 0.0061, "quantity": "length",
                "evidence": { "arc": 5.969, "area": 211.3, "triangles": 8123 }, "guess": null,
                "nominal": {
                    "value": 6.0, "grid": "1 mm", "z": -2.7, "coincidence": 0.024, "applied": true, "why": name,
                },
            },
            {
                "id": 2, "kind": "radius", "of": [1], "value": 18.4, "uncertainty": 0.1, "quantity": "length",
                "evidence": { "arc": null, "area": 3.0, "triangles": 12 },
                "guess": "only 41 degrees of wall seen", "nominal": null,
            },
            { "id": 3, "kind": "half_angle", "of": [1], "value": 0.5, "uncertainty": 0.001, "quantity": "angle" },
            { "id": 4, "kind": "unheard_of", "of": [0, 77], "value": 3.0, "uncertainty": null },
        ],
        "relations": [
            {
                "kind": "parallel", "of": [0, 3], "z": 0.7, "z_statistical": 1.1, "shift": 0.002, "turn": 0.0003,
                "before": 0.010, "after": 0.011, "accepted": true, "reason": null,
            },
            {
                "kind": "coaxial", "of": [1, 3], "z": 7.1, "accepted": false,
                "reason": "moves its points by more than the noise",
            },
        ],
        "solids": [{
            "closed": true, "n_faces": 9, "n_edges": 20, "n_vertices": 14, "n_assumed": 1, "volume": 48.2,
            "largest_gap": 0.0004, "problems": [],
        }],
        "deviation": {
            "rms": 0.011, "p95": 0.021, "max": 0.09, "within_three_noise": 0.97,
            "histogram": {
                "limit": 0.03, "limit_from": "noise", "counts": [1, 5, 9, 4], "below": 1, "above": 2,
            },
        },
        "warnings": [
            { "code": "W_UNITS_ASSUMED", "primitive": null, "text": "lengths were taken as millimetres" },
            {
                "code": "W_ASSUMED_FACE", "primitive": 0,
                "text": "extended into what the scanner did not see",
            },
            { "code": "W_FREEFORM", "primitive": 2, "text": name },
            { "code": "W_NEW", "primitive": 99, "text": name },
        ],
        "placement": { "aligned_from_scan": [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]], "level": 0, "zero": [0, 3, 1] },
    })
}

/// Every real number but those that the reader checks as counts.
fn replace_numbers(value: &mut Value, by: f64) {
    match value {
        Value::Number(number) if number.is_f64() => *value = json!(by),
        Value::Array(values) => values.iter_mut().for_each(|value| replace_numbers(value, by)),
        Value::Object(object) => object.values_mut().for_each(|value| replace_numbers(value, by)),
        _ => {}
    }
}

/// The walls z = 0 and y = 0, 8 by 8, that meet in an edge: regions 0 and 3, but a quarter of the first is region 2.
fn corner_of_two_walls() -> (Mesh, Vec<Option<u32>>) {
    let (mut mesh, mut labels) = (Mesh::default(), Vec::new());
    for wall in 0..2 {
        let first = mesh.vertices.len() as u32;
        for (i, j) in (0..9).flat_map(|i| (0..9).map(move |j| (f64::from(i), f64::from(j)))) {
            mesh.vertices.push(if wall == 0 { Point3::new(i, j, 0.0) } else { Point3::new(j, 0.0, i) });
        }
        for (i, j) in (0..8).flat_map(|i| (0..8).map(move |j| (i, j))) {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| first + 9 * i + j);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
            let region = if wall == 1 {
                3
            } else if i > 5 && j > 5 {
                2
            } else {
                0
            };
            labels.extend([Some(region); 2]);
        }
    }
    (mesh, labels)
}

/// The walls a little off, as a model of two faces that STEP would name.
fn model(scan: &Mesh) -> PriorModel {
    let mut model = PriorModel::from_mesh(scan.clone());
    for vertex in &mut model.mesh.vertices {
        vertex.z -= 0.015;
    }
    let face = |name: &str| scanwright::prior::PriorFace { name: name.to_owned(), ..model.faces[0].clone() };
    model.faces = vec![face("region 0 plane assumed"), face("region 3 plane")];
    model.face_of = (0..model.mesh.triangles.len()).map(|t| u32::from(t >= 128)).collect();
    model
}

fn scene(part: &Part) -> Scene {
    let (mesh, labels) = corner_of_two_walls();
    let model = model(&mesh);
    Scene::of_files(part, Some(ScanInput { mesh: &mesh, labels: Some(&labels) }), Some(&model))
}

struct Tag {
    name: String,
    attributes: Vec<(String, String)>,
}

impl Tag {
    fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(attribute, _)| attribute == name).map(|(_, value)| value.as_str())
    }
}

/// The elements of a page, which is checked as strictly as XML: every one closed, every attribute quoted.
fn tags(page: &str) -> Vec<Tag> {
    let (mut tags, mut open) = (Vec::new(), Vec::new());
    let mut reader = Reader::from_str(page);
    loop {
        let event =
            reader.read_event().unwrap_or_else(|error| panic!("{error} at {}", reader.error_position()));
        match event {
            Event::Start(element) => {
                open.push(element.name().as_ref().to_owned());
                tags.push(tag(&element));
            }
            Event::Empty(element) => tags.push(tag(&element)),
            Event::End(element) => assert_eq!(open.pop().as_deref(), Some(element.name().as_ref())),
            Event::Eof => break,
            _ => {}
        }
    }
    assert!(open.is_empty(), "open at the end: {open:?}");
    tags
}

fn tag(element: &quick_xml::events::BytesStart) -> Tag {
    let attributes = element.attributes().map(|attribute| {
        let attribute = attribute.unwrap_or_else(|error| panic!("{error}"));
        let value = quick_xml::escape::unescape(&attribute.value).unwrap().into_owned();
        (attribute.key.as_ref().to_owned(), value)
    });
    let attributes = attributes.collect();
    Tag { name: element.name().as_ref().to_owned(), attributes }
}

/// What a page says, without its markup.
fn texts(page: &str) -> String {
    let body = page.split("</style>").last().unwrap();
    let mut text = String::new();
    for piece in body.split('<') {
        text.push_str(piece.split_once('>').map_or("", |(_, text)| text));
        text.push(' ');
    }
    let entities = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&amp;", "&")];
    entities.into_iter().fold(text, |text, (entity, c)| text.replace(entity, c))
}

/// Cells of a line of CSV without line breaks in them.
fn csv_cells(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    for c in line.trim_end().chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            c => cells.last_mut().unwrap().push(c),
        }
    }
    cells
}
