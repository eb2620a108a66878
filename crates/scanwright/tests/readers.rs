//! Readers of mesh files: what they read, and what they refuse and how.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use scanwright::io::{Format, ReadError, ScanFile, Unit, read_mesh, read_ply_face_property, write_ply};
use scanwright::math::Point3;
use scanwright::mesh::Mesh;
use scanwright::random::Rng;
use std::fmt::Write as _;
use std::io::Write;

// ---------------------------------------------------------------------------------------------- what is read

#[test]
fn every_format_gives_the_same_triangles() {
    let mesh = sphere(6);
    for (name, bytes) in files(&mesh) {
        let file = read(&bytes, &name);
        assert_eq!(corners(&file.mesh), corners(&mesh), "{name}");
        assert_eq!(file.n_unused_vertices, 0, "{name}");
    }
}

#[test]
fn the_content_tells_the_format_whatever_the_name() {
    let mesh = sphere(4);
    let expected = |name: &str| match name {
        "bin.stl" => Format::StlBinary,
        "txt.stl" => Format::StlAscii,
        "m.obj" => Format::Obj,
        "m.off" => Format::Off,
        "m.3mf" => Format::ThreeMf,
        _ => Format::Ply,
    };
    for (name, bytes) in files(&mesh) {
        for other in ["scan", "scan.stl", "scan.ply", "scan.obj", "scan.xyz", ""] {
            assert_eq!(read(&bytes, other).format, expected(&name), "{name} called {other}");
        }
    }
}

#[test]
fn a_binary_stl_may_begin_with_solid() {
    let mut bytes = stl_binary(&sphere(4));
    bytes[..20].copy_from_slice(b"solid exported by us");
    assert_eq!(read(&bytes, "a.stl").format, Format::StlBinary);
}

#[test]
fn line_ends_and_byte_order_marks_do_not_matter() {
    let mesh = sphere(4);
    for (name, bytes) in text_files(&mesh) {
        let text = String::from_utf8(bytes).unwrap();
        for end in ["\r\n", "\r"] {
            let other = text.replace('\n', end);
            assert_eq!(corners(&read(other.as_bytes(), &name).mesh), corners(&mesh), "{name} {end:?}");
        }
        if !text.starts_with("ply") {
            let marked = format!("\u{feff}{text}");
            assert_eq!(corners(&read(marked.as_bytes(), &name).mesh), corners(&mesh), "{name}");
        }
    }
}

#[test]
fn ply_passes_over_what_it_does_not_need() {
    let text = "ply\nformat ascii 1.0\ncomment made by hand\nobj_info 7\nelement camera 1\nproperty list uchar float \
        f\nproperty int id\nelement vertex 4\nproperty uchar red\nproperty double z\nproperty list int short w\n\
        property int x\nproperty float y\nelement face 2\nproperty uchar flags\nproperty list int uint \
        vertex_index\nproperty list uchar float texcoord\nelement nothing 4000000000\nend_header\n2 0.5 0.5 9\n\
        7 0 0 0 0\n7 0 1 5 1 0\n\n7 0 2 5 5 1 1\n7 0.5 0 0 1\n9 4 0 1 2 3 2 0.1 0.2\n9 3 3 1 0 0\n";
    let file = read(text.as_bytes(), "a.ply");
    assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 2, 3], [3, 1, 0]]);
    assert_eq!(file.mesh.vertices[3], Point3::new(0.0, 1.0, 0.5));
    assert_eq!((file.n_polygons, file.n_unused_vertices), (1, 0));
}

#[test]
fn obj_reads_polygons_relative_indices_and_late_vertices() {
    let text = "# made by hand\nmtllib a.mtl\no part\nv 0 0 0 0.5 0.5 0.5\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\n\
        vn 0 0 1\ns off\nusemtl m\nf 1/1/1 2//1 3/1 4\nf -4 -3 -2\nf 1 2 \\\n 5\nv 0 0 1\nv 9 9 9\nl 1 2\n";
    let file = read(text.as_bytes(), "a.obj");
    assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 1, 4]]);
    assert_eq!((file.n_polygons, file.n_unused_vertices), (1, 1));
}

#[test]
fn off_reads_its_variants() {
    let body =
        "0 0 0 1 1 1 1\n1 0 0 1 1 1 1 # a corner\n\n1 1 0 1 1 1 1\n0 1 0 1 1 1 1\n4 0 1 2 3 0.5 0.5 0.5\n";
    for header in
        ["COFF 4 1 0\n", "NOFF\n4 1 0\n", "# first\nSTCNOFF\n# then\n4 1\n", "OFF 4 1 4\n", "4 1 4\n"]
    {
        let file = read(format!("{header}{body}").as_bytes(), "a.off");
        assert_eq!(file.mesh.triangles, [[0, 1, 2], [0, 2, 3]], "{header}");
    }
    for header in ["4OFF 4 1 0\n", "OFF BINARY\n4 1 0\n"] {
        let error = refuse(format!("{header}{body}").as_bytes(), "a.off");
        assert!(matches!(error, ReadError::Unsupported { .. }), "{error}");
    }
}

#[test]
fn a_3mf_gives_units_components_and_transforms() {
    let cube = xml_mesh(&cube());
    let body = format!(
        "<resources><object id=\"1\">{cube}</object><object id=\"3\" type=\"support\">{cube}</object>\
         <object id=\"2\"><components><component objectid=\"1\"/><component objectid=\"3\"/><component \
         objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 5 0 0\"/></components></object></resources><build><item \
         objectid=\"2\" transform=\"2 0 0 0 2 0 0 0 2 0 0 7\"/></build>"
    );
    let file = read(&three_mf("inch", &body), "a.3mf");
    assert_eq!(file.units, Some(Unit::Inch));
    assert_eq!(file.mesh.triangles.len(), 24);
    // Two cubes of side two, one of them mirrored and yet not turned inside out.
    assert_near(file.mesh.signed_volume(), 16.0, 1e-12, "volume");
    let (lo, hi) = file.mesh.bounds().unwrap();
    assert_eq!((lo, hi), (Point3::new(0.0, 0.0, 7.0), Point3::new(10.0, 2.0, 9.0)));
}

#[test]
fn a_3mf_may_use_prefixes_other_parts_and_no_build() {
    let object = format!("<object id=\"7\">{}</object>", xml_mesh(&cube()));
    let prefixed = object.replace("</", "</m:").replace('<', "<m:").replace("<m:/m:", "</m:");
    let extension = "<s:slice><s:vertex x=\"1e999\"/></s:slice>";
    let root = format!(
        "<m:model unit=\"micron\"><m:resources>{prefixed}{extension}</m:resources><m:build><m:item objectid=\"4\" \
         p:path=\"/3D/Other.model\"/></m:build></m:model>"
    );
    let other = format!(
        "<model><resources>{}<object id=\"4\"><components><component objectid=\"5\"/></components></object>\
         </resources></model>",
        object.replace("\"7\"", "\"5\"")
    );
    let file = read(&archive(&[("3D/Other.model", &other), ("3D/root.MODEL", &root)]), "a.3mf");
    assert_eq!((file.units, file.mesh.triangles.len()), (Some(Unit::Millimeter), 12), "first model wins");
    let rels =
        "<Relationships><Relationship Type=\"http://x/3dmodel\" Target=\"/3d/ROOT.model\"/></Relationships>";
    let parts = [("3D/Other.model", other.as_str()), ("3D/root.MODEL", &root), ("_rels/.rels", rels)];
    let file = read(&archive(&parts), "a.3mf");
    assert_eq!((file.units, file.mesh.triangles.len()), (Some(Unit::Micron), 12));
}

#[test]
fn what_is_written_is_read_back_with_its_labels() {
    let mesh = sphere(6);
    let labels: Vec<i32> = (0..mesh.triangles.len() as i32).map(|t| t / 3 - 1).collect();
    let colors: Vec<[u8; 3]> = labels.iter().map(|l| [*l as u8, 1, 255]).collect();
    let bytes = write_ply(&mesh, Some(("primitive", &labels)), Some(&colors));
    let file = read(&bytes, "segments.ply");
    assert_eq!(corners(&file.mesh), corners(&mesh));
    assert_eq!(file.mesh.triangles, mesh.triangles);
    assert_eq!(read_ply_face_property(&bytes, "primitive").unwrap(), labels);
    assert_eq!(read_ply_face_property(&bytes, "red").unwrap()[6], 1);
    assert!(read_ply_face_property(&bytes, "vertex_indices").is_err());
    assert!(read_ply_face_property(&bytes, "region").unwrap_err().to_string().contains("'region'"));
    assert!(read_ply_face_property(&stl_binary(&mesh), "primitive").is_err());
}

#[test]
fn a_polygon_gives_its_label_to_all_its_triangles() {
    let text = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
        element face 2\nproperty list uchar int vertex_indices\nproperty int primitive\nend_header\n\
        0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n4 0 1 2 3 -1\n3 0 1 4 8\n";
    assert_eq!(read_ply_face_property(text.as_bytes(), "primitive").unwrap(), [-1, -1, 8]);
}

// ------------------------------------------------------------------------------------------- what is refused

#[test]
fn points_alone_are_refused_with_what_is_needed() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
        end_header\n0 0 0\n1 1 1\n";
    let files = [
        ("a.ply", ply),
        ("a.obj", "v 0 0 0\nv 1 1 1\n"),
        ("a.off", "OFF 2 0 0\n0 0 0\n1 1 1\n"),
        ("a.xyz", "0 0 0 9\n1 1 1 9\n"),
        ("a.pts", "2\n0,0,0\n1,1,1\n"),
        ("b.pts", "# laser\ng 1 0 0\np 0 0 0\np 1 1 1\n"),
    ];
    for (name, text) in files {
        let message = refuse(text.as_bytes(), name).to_string();
        assert!(message.contains("2 points but no triangles"), "{name}: {message}");
        assert!(message.contains("mesh the points first"), "{name}: {message}");
    }
}

#[test]
fn triangle_strips_are_refused_by_name() {
    let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
        element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n3 0 0 0\n";
    let message = refuse(text.as_bytes(), "a.ply").to_string();
    assert!(message.contains("strips") && message.starts_with("line 7"), "{message}");
}

#[test]
fn errors_say_where_what_and_what_would_be_right() {
    let cases = [
        (
            "a.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\nf 1 2 3\n",
            "line 4: face 1 refers to vertex 9, should be 1 to 3",
        ),
        ("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2 -3\n", "line 3: face 1 refers to vertex -3, should be 1 to 2"),
        ("a.obj", "v 0 0 0\nv 1 O 0\n", "line 2: y of vertex 2 is 'O', should be a finite number below 1e30"),
        ("a.obj", "v 0 0 0\nf 1 1\n", "line 2: face 1 is of 2 corners, should be of three or more"),
        (
            "a.off",
            "OFF 1 1 0\n0 0\n3 0 0 0\n",
            "line 2: z of vertex 0 is missing, should be a finite number below 1e30",
        ),
        (
            "a.stl",
            "solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 NaN\n",
            "line 4: z of corner 0 of triangle 0 is 'NaN', should be a finite number below 1e30",
        ),
    ];
    for (name, text, expected) in cases {
        assert_eq!(refuse(text.as_bytes(), name).to_string(), expected);
    }
    let mut stl = stl_binary(&sphere(4));
    stl[84 + 50 + 12 + 12 + 8..][..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let expected = "byte 166: z of corner 1 of triangle 1 is 'inf', should be a finite number below 1e30";
    assert_eq!(refuse(&stl, "a.stl").to_string(), expected);
}

#[test]
fn a_file_cut_anywhere_is_refused_or_whole() {
    let mesh = sphere(3);
    for (name, bytes) in files(&mesh) {
        // Cut in its last line a text may read as whole: a shorter number is a number. OBJ has no counts at all.
        let last_line = bytes.trim_ascii_end().iter().rposition(|&b| b == b'\n').unwrap_or(bytes.len());
        let is_text = std::str::from_utf8(&bytes).is_ok();
        for length in 0..bytes.len() {
            let result = check(&bytes[..length], &name);
            if name != "m.obj" && (!is_text || length <= last_line) {
                assert!(result.is_err(), "{name} cut at {length} of {} was read", bytes.len());
            }
        }
    }
    let mut rng = Rng::for_task(1, "cut", 0);
    for (name, bytes) in files(&sphere(40)) {
        for _ in 0..50 {
            check(&bytes[..rng.below(bytes.len())], &name).ok();
        }
    }
}

#[test]
fn wrong_counts_are_refused() {
    let mesh = sphere(6);
    let (n_vertices, n_triangles) = (mesh.vertices.len() as u64, mesh.triangles.len() as u64);
    let wrong = |n: u64| [0, n + 1, n - 1, 1 << 31, u64::from(u32::MAX), u64::MAX];
    for (name, bytes) in files(&mesh) {
        let text_at = |needle: String| find(&bytes, needle.as_bytes()).unwrap();
        for (n, what) in [(n_vertices, "vertex"), (n_triangles, "face")] {
            for count in wrong(n) {
                let altered = match name.as_str() {
                    "bin.stl" => {
                        let mut altered = bytes.clone();
                        let count = u32::try_from(count).unwrap_or(u32::MAX);
                        altered[80..84].copy_from_slice(
                            &if what == "face" { count } else { u32::MAX - 1 }.to_le_bytes(),
                        );
                        altered
                    }
                    "m.off" => replace(&bytes, text_at(format!("{n} ")), n, count),
                    _ if bytes.starts_with(b"ply") => {
                        let key = format!("element {what} ");
                        replace(&bytes, text_at(key.clone()) + key.len(), n, count)
                    }
                    _ => continue,
                };
                assert!(check(&altered, &name).is_err(), "{name} with {count} for {n} of {what} was read");
            }
        }
    }
}

#[test]
fn wrong_list_lengths_are_refused() {
    for encoding in ["binary_little_endian", "binary_big_endian"] {
        let mesh = sphere(6);
        let bytes = ply(&mesh, encoding);
        let body = bytes.len() - 13 * mesh.triangles.len();
        for length in [0, 1, 2, 4, 127, 255] {
            for face in [0, 7, mesh.triangles.len() - 1] {
                let mut altered = bytes.clone();
                altered[body + 13 * face] = length;
                assert!(check(&altered, "a.ply").is_err(), "length {length} of face {face}");
            }
        }
    }
    // A length of 32 bits, negative or beyond the file.
    for length in ["-1", "2147483648", "4294967295", "99999999999999999999"] {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uint int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n{length} 0 1 2\n"
        );
        assert!(check(text.as_bytes(), "a.ply").is_err(), "{length}");
        let off = format!("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n{length} 0 1 2\n");
        assert!(check(off.as_bytes(), "a.off").is_err(), "{length}");
    }
}

#[test]
fn coordinates_that_are_no_lengths_are_refused() {
    let mesh = sphere(4);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e38, 1e31] {
        for vertex in [0, mesh.vertices.len() - 1] {
            for axis in 0..3 {
                let mut broken = mesh.clone();
                broken.vertices[vertex][axis] = bad;
                for (name, bytes) in files(&broken) {
                    let error = check(&bytes, &name).expect_err("was read");
                    assert!(error.to_string().contains("finite number"), "{name} with {bad}: {error}");
                }
            }
        }
    }
}

#[test]
fn indices_out_of_range_are_refused() {
    let mesh = sphere(4);
    let n = mesh.vertices.len() as u32;
    // As signed numbers the last two are negative.
    for bad in [n, n + 1, i32::MAX as u32, 1 << 31, u32::MAX] {
        for (t, k) in [(0, 0), (mesh.triangles.len() - 1, 2)] {
            let mut broken = mesh.clone();
            broken.triangles[t][k] = bad;
            for (name, bytes) in files_of_indices(&broken) {
                let error = check(&bytes, &name).expect_err("was read");
                assert!(error.to_string().contains("refers to vertex"), "{name} with {bad}: {error}");
            }
        }
    }
    for bad in ["0", "-99", "1.5", "", "9223372036854775807", "-9223372036854775808", "99999999999999999999"]
    {
        check(format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {bad}\n").as_bytes(), "a.obj").expect_err("was read");
    }
}

#[test]
fn a_wrong_declared_encoding_is_refused() {
    let encodings = ["ascii", "binary_little_endian", "binary_big_endian"];
    for actual in encodings {
        let bytes = ply(&sphere(6), actual);
        for declared in encodings.into_iter().filter(|declared| *declared != actual) {
            let at = find(&bytes, actual.as_bytes()).unwrap();
            let mut altered = bytes.clone();
            altered.splice(at..at + actual.len(), declared.bytes());
            check(&altered, "a.ply").expect_err(declared);
        }
    }
    // A PLY called STL is a PLY; an STL of text cannot pass for binary or the other way round.
    let text = stl_ascii(&sphere(4));
    let mut binary = stl_binary(&sphere(4));
    binary.truncate(binary.len() - 1);
    binary[..5].copy_from_slice(b"solid");
    check(&binary, "a.stl").expect_err("cut binary STL that begins with 'solid'");
    check(&text[1..], "a.stl").expect_err("text STL without its first letter");
}

#[test]
fn empty_and_one_byte_files_are_refused() {
    for name in NAMES {
        assert!(matches!(check(b"", name), Err(ReadError::Empty)), "{name}");
        for byte in 0..=255_u8 {
            check(&[byte], name).expect_err("was read");
        }
    }
}

#[test]
fn noise_is_refused() {
    let mut rng = Rng::for_task(2, "noise", 0);
    let noise: Vec<u8> = (0..10 << 20).map(|_| rng.below(256) as u8).collect();
    for name in NAMES {
        check(&noise, name).expect_err("was read");
    }
    let ply_header = "ply\nformat binary_little_endian 1.0\nelement vertex 100000\nproperty float x\nproperty float \
        y\nproperty float z\nelement face 100000\nproperty list uint int vertex_indices\nend_header\n";
    for start in
        ["solid a\n", "ply\n", ply_header, "OFF 9 9 9\n", "v ", "PK\x03\x04", "PK\x05\x06", "f 1 2 3\n"]
    {
        let bytes = [start.as_bytes(), &noise].concat();
        check(&bytes, "a").expect_err("was read");
    }
}

#[test]
fn long_lines_and_many_words_take_linear_time() {
    // Ten megabytes each: anything quadratic would take minutes.
    let n = 5 << 20;
    let corners = "1 ".repeat(n);
    let one_face = format!("v 0 0 0\nf {corners}\n");
    assert_eq!(read(one_face.as_bytes(), "a.obj").mesh.triangles.len(), n - 2);
    let texts = [
        ("a.obj", "v ".repeat(n)),
        ("a.obj", "\\\n".repeat(n)),
        ("a.obj", format!("v 0 0 0\nf {}", "\\\n".repeat(n))),
        ("a.stl", format!("solid{}", "\n ".repeat(n))),
        ("a.ply", format!("ply\n{}", "comment\n".repeat(n / 4))),
        ("a.ply", format!("ply\nformat ascii 1.0\n{}end_header\n", "element a 9\n".repeat(n / 6))),
        ("a.off", format!("OFF{}", "\n#".repeat(n))),
    ];
    for (name, text) in texts {
        check(text.as_bytes(), name).expect_err("was read");
    }
}

#[test]
fn flipped_bits_never_break_a_reader() {
    for (name, bytes) in files(&sphere(8)) {
        let mut rng = Rng::for_task(3, &name, 0);
        for _ in 0..1000 {
            let mut altered = bytes.clone();
            // One to four flips: single ones are often harmless.
            for _ in 0..=rng.below(4) {
                altered[rng.below(bytes.len())] ^= 1 << rng.below(8);
            }
            check(&altered, &name).ok();
        }
    }
}

#[test]
fn archives_made_to_exhaust_memory_are_refused() {
    let object = |id: usize, body: &str| format!("<object id=\"{id}\">{body}</object>");
    let uses = |id: usize, n: usize| {
        format!("<components>{}</components>", format!("<component objectid=\"{id}\"/>").repeat(n))
    };
    let build = |id: usize| format!("<build><item objectid=\"{id}\"/></build>");
    let model = |objects: String, id: usize| {
        three_mf("inch", &format!("<resources>{objects}</resources>{}", build(id)))
    };

    let blanks = " ".repeat(50 << 20);
    let bomb = model(blanks + &object(1, &xml_mesh(&cube())), 1);
    assert!(bomb.len() < 1 << 18);
    assert!(matches!(check(&bomb, "a.3mf"), Err(ReadError::Inflates { .. })));

    // Ten levels of ten copies each, of a cube and of nothing.
    let mesh = xml_mesh(&cube());
    for (leaf, is_empty) in [(mesh.as_str(), false), ("", true)] {
        let levels: String = (2..12).map(|id| object(id, &uses(id - 1, 10))).collect();
        let error = check(&model(object(1, leaf) + &levels, 11), "a.3mf").unwrap_err();
        let expected = if is_empty {
            matches!(error, ReadError::NoTriangles { .. })
        } else {
            matches!(error, ReadError::Inflates { .. })
        };
        assert!(expected, "{error}");
    }
    let circle = object(1, &uses(2, 2)) + &object(2, &uses(1, 2));
    let deep: String = (2..9999).map(|id| object(id, &uses(id - 1, 1))).collect();
    for (objects, id) in [(circle, 1), (object(1, &mesh) + &deep, 9998), (object(1, &mesh), 5)] {
        let error = check(&model(objects, id), "a.3mf").unwrap_err();
        assert!(matches!(error, ReadError::Archive { .. }), "{error}");
    }
}

#[test]
fn counts_of_an_archive_are_not_trusted() {
    let bytes = files(&cube()).pop().expect("the last is the 3MF").1;
    for at in 0..bytes.len() {
        for width in [1, 2, 4] {
            for value in [0, u32::MAX, 1 << 31] {
                let mut altered = bytes.clone();
                let end = bytes.len().min(at + width);
                altered[at..end].copy_from_slice(&value.to_le_bytes()[4 - (end - at)..]);
                check(&altered, "a.3mf").ok();
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn words_in_any_order_never_break_a_reader(words in prop::collection::vec(prop::sample::select(WORDS), 0..60), start in prop::sample::select(STARTS)) {
        let text = format!("{start}{}", words.join(" "));
        for name in ["a.ply", "a.obj", "a.off", "a.stl"] {
            check(text.as_bytes(), name).ok();
        }
    }

    #[test]
    fn bytes_after_a_header_never_break_a_reader(body in prop::collection::vec(any::<u8>(), 0..400), n in 0_u8..20, m in 0_u8..20, big: bool) {
        let order = if big { "big" } else { "little" };
        let header = format!("ply\nformat binary_{order}_endian 1.0\nelement vertex {n}\nproperty char x\nproperty short y\nproperty uchar z\nelement face {m}\nproperty list uchar uchar vertex_indices\nproperty list char double w\nend_header\n");
        check(&[header.as_bytes(), &body].concat(), "a.ply").ok();
    }
}

// -------------------------------------------------------------------------------------------------- formulas

const NAMES: &[&str] = &["a", "a.stl", "a.ply", "a.obj", "a.off", "a.3mf", "a.STL"];

const STARTS: &[&str] =
    &["", "ply\nformat ascii 1.0\n", "solid\n", "OFF ", "v 0 0 0\n", "ply\nformat binary_big_endian 1.0\n"];

const WORDS: &[&str] = &[
    "\n",
    "\n",
    "\n",
    "\n",
    "ply",
    "format",
    "ascii",
    "element",
    "vertex",
    "face",
    "property",
    "list",
    "uchar",
    "int",
    "float",
    "x",
    "y",
    "z",
    "vertex_indices",
    "end_header\n",
    "0",
    "1",
    "2",
    "3",
    "-1",
    "4294967295",
    "18446744073709551615",
    "nan",
    "1e300",
    "v",
    "f",
    "1/1/1",
    "-9223372036854775808",
    "\\",
    "OFF",
    "solid",
    "facet",
    "outer",
    "endloop",
    "endfacet",
    "endsolid",
    "vertex 0 0 0\n",
    "#",
    "\u{feff}",
    "\0",
    "property float x\nproperty float y\nproperty float z\n",
    "\nelement vertex 3\n",
    "\nelement face 1\n",
    "3 0 1 2\n",
];

/// Reads and holds the reader to its promises: a sound mesh of bounded size, or one line that says something.
fn check(bytes: &[u8], name: &str) -> Result<ScanFile, ReadError> {
    // STL has the largest ratio of the formats that are not packed but text of one-digit indices: 12 bytes for two.
    const LARGEST_RATIO: usize = 12;
    let result = read_mesh(bytes, name);
    match &result {
        Ok(file) => {
            let n_vertices = file.mesh.vertices.len();
            assert!(!file.mesh.triangles.is_empty());
            assert!(file.mesh.triangles.as_flattened().iter().all(|&v| (v as usize) < n_vertices));
            assert!(file.mesh.largest_coordinate() <= 1e30);
            let allocated = 24 * file.mesh.vertices.capacity() + 12 * file.mesh.triangles.capacity();
            let packed = if file.format == Format::ThreeMf { 200 } else { 1 };
            assert!(
                allocated <= packed * LARGEST_RATIO * bytes.len() + 1024,
                "{allocated} bytes of {}",
                bytes.len()
            );
        }
        Err(error) => {
            let message = error.to_string();
            assert!(10 < message.len() && message.len() < 400, "{message}");
            assert!(!message.contains('\n') && !message.ends_with('.'), "{message}");
        }
    }
    result
}

fn read(bytes: &[u8], name: &str) -> ScanFile {
    check(bytes, name).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn refuse(bytes: &[u8], name: &str) -> ReadError {
    check(bytes, name).expect_err(name)
}

fn assert_near(a: f64, b: f64, tolerance: f64, what: &str) {
    assert!((a - b).abs() <= tolerance, "{what}: {a} is not {b} within {tolerance}");
}

fn find(bytes: &[u8], needle: &[u8]) -> Option<usize> {
    bytes.windows(needle.len()).position(|window| window == needle)
}

/// `bytes` with the decimal `old` at `at` replaced.
fn replace(bytes: &[u8], at: usize, old: u64, new: u64) -> Vec<u8> {
    let mut altered = bytes.to_vec();
    altered.splice(at..at + old.to_string().len(), new.to_string().into_bytes());
    altered
}

/// Corner positions of all triangles, in order.
fn corners(mesh: &Mesh) -> Vec<[Point3; 3]> {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect()
}

fn cube() -> Mesh {
    let vertices =
        (0..8).map(|i| Point3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices, triangles }
}

/// A closed sphere of `n` bands with coordinates that `f32` and seven digits hold exactly.
fn sphere(n: u32) -> Mesh {
    let mut vertices = vec![Point3::new(0.0, 0.0, 8.0), Point3::new(0.0, 0.0, -8.0)];
    let rounded = |x: f64| (x * 1024.0).round() / 1024.0;
    for band in 1..n {
        for side in 0..n {
            let (polar, turn) = (f64::from(band) / f64::from(n), f64::from(side) / f64::from(n));
            let (sin, cos) = (std::f64::consts::PI * polar).sin_cos();
            let (y, x) = (std::f64::consts::TAU * turn).sin_cos();
            vertices.push(Point3::new(rounded(8.0 * sin * x), rounded(8.0 * sin * y), rounded(8.0 * cos)));
        }
    }
    let at = |band: u32, side: u32| 2 + (band - 1) * n + side % n;
    let mut triangles = Vec::new();
    for side in 0..n {
        triangles.push([0, at(1, side), at(1, side + 1)]);
        for band in 1..n - 1 {
            triangles.push([at(band, side), at(band + 1, side), at(band + 1, side + 1)]);
            triangles.push([at(band, side), at(band + 1, side + 1), at(band, side + 1)]);
        }
        triangles.push([1, at(n - 1, side + 1), at(n - 1, side)]);
    }
    Mesh { vertices, triangles }
}

/// `mesh` in every format; the 3MF is the last.
fn files(mesh: &Mesh) -> Vec<(String, Vec<u8>)> {
    let n = mesh.vertices.len() as u32;
    let mut files = Vec::new();
    if mesh.triangles.as_flattened().iter().all(|&v| v < n) {
        files.push(("bin.stl".to_owned(), stl_binary(mesh)));
        files.push(("txt.stl".to_owned(), stl_ascii(mesh)));
    }
    files.extend(files_of_indices(mesh));
    files
}

fn text_files(mesh: &Mesh) -> Vec<(String, Vec<u8>)> {
    files(mesh)
        .into_iter()
        .filter(|(_, bytes)| std::str::from_utf8(bytes).is_ok_and(|text| text.contains('\n')))
        .collect()
}

fn files_of_indices(mesh: &Mesh) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<(String, Vec<u8>)> = ["ascii", "binary_little_endian", "binary_big_endian"]
        .map(|encoding| (format!("{encoding}.ply"), ply(mesh, encoding)))
        .into();
    files.push(("m.obj".to_owned(), obj(mesh)));
    files.push(("m.off".to_owned(), off(mesh)));
    let body = format!(
        "<resources><object id=\"1\">{}</object></resources><build><item objectid=\"1\"/></build>",
        xml_mesh(mesh)
    );
    files.push(("m.3mf".to_owned(), three_mf("millimeter", &body)));
    files
}

fn stl_binary(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for corners in corners(mesh) {
        bytes.extend([0; 12]);
        bytes.extend(
            corners
                .iter()
                .flat_map(|p| p.coords.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect::<Vec<u8>>()),
        );
        bytes.extend([0; 2]);
    }
    bytes
}

fn stl_ascii(mesh: &Mesh) -> Vec<u8> {
    let mut text = "solid of revolution\n".to_owned();
    for corners in corners(mesh) {
        text += "  facet normal nan 0 0\n    outer loop\n";
        for p in corners {
            writeln!(text, "      vertex {} {} {:e}", p.x, p.y, p.z).unwrap();
        }
        text += "    endloop\n  endfacet\n";
    }
    (text + "endsolid of revolution\n").into_bytes()
}

fn ply(mesh: &Mesh, encoding: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    for p in &mesh.vertices {
        match encoding {
            "ascii" => writeln!(bytes, "{} {} {}", p.x, p.y, p.z).unwrap(),
            "binary_big_endian" => bytes.extend(p.coords.iter().flat_map(|x| (*x as f32).to_be_bytes())),
            _ => bytes.extend(p.coords.iter().flat_map(|x| (*x as f32).to_le_bytes())),
        }
    }
    for &triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| v as i32);
        match encoding {
            "ascii" => writeln!(bytes, "3 {a} {b} {c}").unwrap(),
            "binary_big_endian" => {
                bytes.extend([3].into_iter().chain([a, b, c].into_iter().flat_map(i32::to_be_bytes)));
            }
            _ => bytes.extend([3].into_iter().chain([a, b, c].into_iter().flat_map(i32::to_le_bytes))),
        }
    }
    bytes
}

fn obj(mesh: &Mesh) -> Vec<u8> {
    let mut text = String::new();
    for p in &mesh.vertices {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    for &triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| i64::from(v) + 1);
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

fn off(mesh: &Mesh) -> Vec<u8> {
    let mut text = format!("OFF\n{} {} 0\n", mesh.vertices.len(), mesh.triangles.len());
    for p in &mesh.vertices {
        writeln!(text, "{} {} {}", p.x, p.y, p.z).unwrap();
    }
    for &triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| v as i32);
        writeln!(text, "3 {a} {b} {c}").unwrap();
    }
    text.into_bytes()
}

fn xml_mesh(mesh: &Mesh) -> String {
    let mut text = "<mesh><vertices>".to_owned();
    for p in &mesh.vertices {
        write!(text, "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x, p.y, p.z).unwrap();
    }
    text += "</vertices><triangles>";
    for [a, b, c] in &mesh.triangles {
        write!(text, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>").unwrap();
    }
    text + "</triangles></mesh>"
}

fn three_mf(unit: &str, body: &str) -> Vec<u8> {
    let namespace = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
    let model = format!("<?xml version=\"1.0\"?><model unit=\"{unit}\" xmlns=\"{namespace}\">{body}</model>");
    archive(&[("3D/3dmodel.model", &model)])
}

fn archive(parts: &[(&str, &str)]) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, text) in parts {
        writer.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        writer.write_all(text.as_bytes()).unwrap();
    }
    writer.finish().unwrap().into_inner()
}
