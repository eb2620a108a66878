//! Tests of `step::read`: our own files come back, constructs of other systems have the volume they should, damaged
//! files end in errors that name the place.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use scanwright::brep::{Geometry, Solid, build, tessellate};
use scanwright::math::Point3;
use scanwright::prior::PriorModel;
use scanwright::random::Rng;
use scanwright::step::read::{StepReadError, read};
use scanwright::step::{LengthUnit, StepOptions, write};
use scanwright::surface::{Surface, SurfaceKind};

use crate::parts::{STEP, block, cap, dented, pipe, tolerances};

/// Share by which the volume of a tessellation may be off: chords turn by six degrees at most, so an area is short by a
/// share of (6 deg)^2 / 6 where the chord's share of the diagonal does not bind first.
const CHORDS: f64 = 1.8e-3;

// ---------------------------------------------------------------------------------------------------- our own files

#[test]
fn our_own_solids_come_back() {
    for part in [block([12.0, 10.0, 8.0]), pipe(14.0, 6.0, 40.0), cap(), dented()] {
        let solids = build(&part.labelled(), &tolerances(STEP)).solids;
        let model = read(write(&solids, &StepOptions::default()).as_bytes()).unwrap();
        assert_eq!(model.unread, [""; 0]);
        assert_eq!(model.millimetres, Some(1.0));
        assert_closed(&model);
        let volume: f64 = solids.iter().map(|s| tessellate(s).mesh.signed_volume()).sum();
        // The library's own triangles turn by ten degrees.
        assert_share(model.mesh.signed_volume(), volume, 6e-3);
        for (face, written) in model.faces.iter().zip(solids.iter().flat_map(|s| &s.faces)) {
            let solid = solids.iter().find(|s| s.faces.contains(written)).unwrap();
            let Geometry::Analytic(surface) = solid.geometry(written) else {
                panic!("these parts are of the five")
            };
            let read = face.surface.expect("and so is what is read");
            assert_same_surface(&read, surface, model.mesh.diagonal());
            assert_eq!(face.outward, written.same_sense, "{}", face.name);
            assert!(face.name.starts_with("region "), "{}", face.name);
        }
    }
}

#[test]
fn units_of_our_own_files_are_told() {
    let solids: Vec<Solid> = build(&block([2.0, 3.0, 4.0]).labelled(), &tolerances(STEP)).solids;
    for (unit, millimetres) in [
        (LengthUnit::Millimetre, 1.0),
        (LengthUnit::Centimetre, 10.0),
        (LengthUnit::Metre, 1000.0),
        (LengthUnit::Inch, 25.4),
        (LengthUnit::Foot, 304.8),
        (LengthUnit::Micrometre, 1e-3),
    ] {
        let text = write(&solids, &StepOptions { unit, name: "Träger".into(), ..StepOptions::default() });
        let model = read(text.as_bytes()).unwrap();
        assert_share(model.millimetres.unwrap(), millimetres, 1e-12);
        assert_share(model.mesh.signed_volume(), 24.0, 1e-9);
        assert_eq!(model.parts.len(), 1);
        assert_eq!(model.parts[0].name, "Träger");
    }
}

fn assert_same_surface(a: &Surface, b: &Surface, size: f64) {
    assert_eq!(a.kind(), b.kind());
    // Points of one lie on the other, all round.
    for i in 0..40 {
        let (sin, cos) = (f64::from(i) * 0.7).sin_cos();
        let p = Point3::new(size * cos, size * sin, size * (f64::from(i) * 0.31).sin());
        let on_a = a.project(&a.project(&p));
        assert!(b.signed_distance(&on_a).abs() < 1e-7 * size, "{a:?} is not {b:?}");
    }
}

// ------------------------------------------------------------------------------------------- files of other systems

/// Text of a file under construction.
#[derive(Default)]
struct Text(Vec<String>);

impl Text {
    fn add(&mut self, entity: impl std::fmt::Display) -> usize {
        self.0.push(format!("#{}={entity};", self.0.len() + 1));
        self.0.len()
    }

    fn point(&mut self, [x, y, z]: [f64; 3]) -> usize {
        self.add(format!("CARTESIAN_POINT('',({x:?},{y:?},{z:?}))"))
    }

    fn direction(&mut self, [x, y, z]: [f64; 3]) -> usize {
        self.add(format!("DIRECTION('',({x:?},{y:?},{z:?}))"))
    }

    fn vertex(&mut self, at: [f64; 3]) -> usize {
        let point = self.point(at);
        self.add(format!("VERTEX_POINT('',#{point})"))
    }

    fn placement(&mut self, origin: [f64; 3], z: [f64; 3], x: [f64; 3]) -> usize {
        let (origin, z, x) = (self.point(origin), self.direction(z), self.direction(x));
        self.add(format!("AXIS2_PLACEMENT_3D('',#{origin},#{z},#{x})"))
    }

    fn upright(&mut self, origin: [f64; 3]) -> usize {
        self.placement(origin, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    }

    fn circle(&mut self, placement: usize, radius: f64) -> usize {
        self.add(format!("CIRCLE('',#{placement},{radius:?})"))
    }

    fn line(&mut self, origin: [f64; 3], along: [f64; 3]) -> usize {
        let (origin, along) = (self.point(origin), self.direction(along));
        let vector = self.add(format!("VECTOR('',#{along},1.)"));
        self.add(format!("LINE('',#{origin},#{vector})"))
    }

    fn edge(&mut self, [start, end]: [usize; 2], curve: usize) -> usize {
        self.add(format!("EDGE_CURVE('',#{start},#{end},#{curve},.T.)"))
    }

    /// A face with the loops given as edges with their senses.
    fn face(&mut self, surface: usize, sense: &str, loops: &[&[(usize, bool)]]) -> usize {
        let mut bounds = Vec::new();
        for run in loops {
            let uses: Vec<String> = run
                .iter()
                .map(|(edge, forward)| {
                    let sense = if *forward { "T" } else { "F" };
                    format!("#{}", self.add(format!("ORIENTED_EDGE('',*,*,#{edge},.{sense}.)")))
                })
                .collect();
            let run = self.add(format!("EDGE_LOOP('',({}))", uses.join(",")));
            bounds.push(format!("#{}", self.add(format!("FACE_BOUND('',#{run},.T.)"))));
        }
        self.add(format!("ADVANCED_FACE('',({}),#{surface},.{sense}.)", bounds.join(",")))
    }

    fn solid(&mut self, faces: &[usize]) -> usize {
        let shell = self.add(format!("CLOSED_SHELL('',({}))", list(faces)));
        self.add(format!("MANIFOLD_SOLID_BREP('',#{shell})"))
    }

    /// Millimetres and radians.
    fn context(&mut self) -> usize {
        let length = self.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
        self.context_of(&[length])
    }

    fn context_of(&mut self, units: &[usize]) -> usize {
        self.add(format!(
            "( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT(({})) REPRESENTATION_CONTEXT('','') )",
            list(units)
        ))
    }

    fn representation(&mut self, items: &[usize], context: usize) -> usize {
        self.add(format!("ADVANCED_BREP_SHAPE_REPRESENTATION('',({}),#{context})", list(items)))
    }

    fn text(&self) -> String {
        format!("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n{}\nENDSEC;\nEND-ISO-10303-21;\n", self.0.join("\n"))
    }

    fn read(&self) -> PriorModel {
        let model = read(self.text().as_bytes()).unwrap();
        assert_eq!(model.unread, [""; 0]);
        model
    }

    /// The shape as the only one of the file, closed.
    fn closed(mut self, item: usize) -> PriorModel {
        let context = self.context();
        self.representation(&[item], context);
        let model = self.read();
        assert_closed(&model);
        model
    }
}

fn list(ids: &[usize]) -> String {
    ids.iter().map(|id| format!("#{id}")).collect::<Vec<_>>().join(",")
}

/// Bottom and top rim, seam, and the two caps of a cylinder of radius 3 from 0 to 5.
fn rims(text: &mut Text) -> ([usize; 3], [usize; 2]) {
    let (low, high) = (text.vertex([3.0, 0.0, 0.0]), text.vertex([3.0, 0.0, 5.0]));
    let (a, b) = (text.upright([0.0; 3]), text.upright([0.0, 0.0, 5.0]));
    let (low_circle, high_circle) = (text.circle(a, 3.0), text.circle(b, 3.0));
    let seam = text.line([3.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let edges = [
        text.edge([low, low], low_circle),
        text.edge([high, high], high_circle),
        text.edge([low, high], seam),
    ];
    let (bottom, top) = (text.add(format!("PLANE('',#{a})")), text.add(format!("PLANE('',#{b})")));
    let caps = [text.face(bottom, "F", &[&[(edges[0], false)]]), text.face(top, "T", &[&[(edges[1], true)]])];
    (edges, caps)
}

#[test]
fn a_full_cylinder_is_read_with_a_seam_and_without() {
    for with_seam in [true, false] {
        let mut text = Text::default();
        let ([low, high, seam], caps) = rims(&mut text);
        let axis = text.upright([0.0; 3]);
        let wall = text.add(format!("CYLINDRICAL_SURFACE('',#{axis},3.)"));
        let round: &[(usize, bool)] = &[(low, true), (seam, true), (high, false), (seam, false)];
        let side = if with_seam {
            text.face(wall, "T", &[round])
        } else {
            text.face(wall, "T", &[&[(high, false)], &[(low, true)]])
        };
        let solid = text.solid(&[caps[0], caps[1], side]);
        let model = text.closed(solid);
        assert_share(model.mesh.signed_volume(), PI * 9.0 * 5.0, CHORDS);
        assert_eq!(kinds(&model), BTreeMap::from([("cylinder", 1), ("plane", 2)]));
        assert!(model.faces[2].outward);
        let Some(Surface::Cylinder(cylinder)) = model.faces[2].surface else { panic!("no cylinder") };
        assert_eq!(cylinder.radius, 3.0);
    }
}

#[test]
fn the_same_wall_as_sweep_and_as_rational_spline_is_the_same_solid() {
    let wall_of = |kind: &str, text: &mut Text| -> usize {
        let axis = text.upright([0.0; 3]);
        match kind {
            "extrusion" => {
                let circle = text.circle(axis, 3.0);
                let up = text.direction([0.0, 0.0, 1.0]);
                let vector = text.add(format!("VECTOR('',#{up},2.)"));
                text.add(format!("SURFACE_OF_LINEAR_EXTRUSION('',#{circle},#{vector})"))
            }
            "revolution" => {
                let line = text.line([3.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
                let (origin, up) = (text.point([0.0; 3]), text.direction([0.0, 0.0, 1.0]));
                let axis = text.add(format!("AXIS1_PLACEMENT('',#{origin},#{up})"));
                text.add(format!("SURFACE_OF_REVOLUTION('',#{line},#{axis})"))
            }
            _ => rational_wall(text),
        }
    };
    for kind in ["extrusion", "revolution", "spline"] {
        let mut text = Text::default();
        let ([low, high, seam], caps) = rims(&mut text);
        let wall = wall_of(kind, &mut text);
        let side = text.face(wall, "T", &[&[(low, true), (seam, true), (high, false), (seam, false)]]);
        let solid = text.solid(&[caps[0], caps[1], side]);
        let model = text.closed(solid);
        assert_share(model.mesh.signed_volume(), PI * 9.0 * 5.0, CHORDS);
        let expected = if kind == "spline" { "freeform" } else { "cylinder" };
        assert_eq!(kinds(&model).get(expected), Some(&1), "{kind}");
    }
}

/// Nine rational poles round a circle of radius 3, at 0 and at 5.
fn rational_wall(text: &mut Text) -> usize {
    let corner = [
        (1.0, 0.0),
        (1.0, 1.0),
        (0.0, 1.0),
        (-1.0, 1.0),
        (-1.0, 0.0),
        (-1.0, -1.0),
        (0.0, -1.0),
        (1.0, -1.0),
        (1.0, 0.0),
    ];
    let (mut rows, mut weights) = (Vec::new(), Vec::new());
    for (i, (x, y)) in corner.iter().enumerate() {
        let row = [0.0, 5.0].map(|z| text.point([3.0 * x, 3.0 * y, z]));
        rows.push(format!("({})", list(&row)));
        let w = if i % 2 == 0 { 1.0 } else { 0.5_f64.sqrt() };
        weights.push(format!("({w:?},{w:?})"));
    }
    text.add(format!(
        "(BOUNDED_SURFACE()B_SPLINE_SURFACE(2,1,({}),.UNSPECIFIED.,.T.,.F.,.F.)\
         B_SPLINE_SURFACE_WITH_KNOTS((3,2,2,2,3),(2,2),(0.,0.25,0.5,0.75,1.),(0.,1.),.UNSPECIFIED.)\
         GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE(({}))REPRESENTATION_ITEM('')SURFACE())",
        rows.join(","),
        weights.join(",")
    ))
}

#[test]
fn spheres_are_read_with_a_seam_with_a_vertex_and_cut() {
    let radius = 2.0;
    let seamed = {
        let mut text = Text::default();
        let (south, north) = (text.vertex([0.0, 0.0, -radius]), text.vertex([0.0, 0.0, radius]));
        let upright = text.placement([0.0; 3], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]);
        let meridian = text.circle(upright, radius);
        let seam = text.edge([south, north], meridian);
        let axis = text.upright([0.0; 3]);
        let sphere = text.add(format!("SPHERICAL_SURFACE('',#{axis},{radius:?})"));
        let face = text.face(sphere, "T", &[&[(seam, true), (seam, false)]]);
        let solid = text.solid(&[face]);
        text.closed(solid)
    };
    let alone = {
        let mut text = Text::default();
        let pole = text.vertex([0.0, 0.0, radius]);
        let vertex_loop = text.add(format!("VERTEX_LOOP('',#{pole})"));
        let bound = text.add(format!("FACE_BOUND('',#{vertex_loop},.T.)"));
        let axis = text.upright([0.0; 3]);
        let sphere = text.add(format!("SPHERICAL_SURFACE('',#{axis},{radius:?})"));
        let face = text.add(format!("ADVANCED_FACE('',(#{bound}),#{sphere},.T.)"));
        let solid = text.solid(&[face]);
        text.closed(solid)
    };
    for model in [seamed, alone] {
        assert_share(model.mesh.signed_volume(), 4.0 / 3.0 * PI * radius.powi(3), 2.0 * CHORDS);
        assert_eq!(kinds(&model), BTreeMap::from([("sphere", 1)]));
    }
    // A cap cut at one height whose plane is across the sphere's axis, along it, and askew.
    for z in [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, 0.0, 0.8]] {
        let mut text = Text::default();
        let height = 0.5;
        let x = [z[2], 0.0, -z[0]];
        let rim_radius = (radius * radius - height * height).sqrt();
        let at = text.placement(z.map(|c| c * height), z, x);
        let start = [0, 1, 2].map(|i| z[i] * height + x[i] * rim_radius);
        let vertex = text.vertex(start);
        let circle = text.circle(at, rim_radius);
        let rim = text.edge([vertex, vertex], circle);
        let axis = text.upright([0.0; 3]);
        let sphere = text.add(format!("SPHERICAL_SURFACE('',#{axis},{radius:?})"));
        let plane = text.add(format!("PLANE('',#{at})"));
        // The larger part, below the cut.
        let faces = [text.face(sphere, "T", &[&[(rim, false)]]), text.face(plane, "T", &[&[(rim, true)]])];
        let solid = text.solid(&faces);
        let model = text.closed(solid);
        let depth: f64 = radius + height;
        assert_share(
            model.mesh.signed_volume(),
            PI * depth * depth * (3.0 * radius - depth) / 3.0,
            2.0 * CHORDS,
        );
    }
}

#[test]
fn a_full_torus_with_its_two_seams_and_half_of_one() {
    let (major, minor) = (5.0, 2.0);
    let mut text = Text::default();
    let vertex = text.vertex([major + minor, 0.0, 0.0]);
    let flat = text.upright([0.0; 3]);
    let upright = text.placement([major, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]);
    let (equator, meridian) = (text.circle(flat, major + minor), text.circle(upright, minor));
    let (round, tube) = (text.edge([vertex, vertex], equator), text.edge([vertex, vertex], meridian));
    let torus = text.add(format!("TOROIDAL_SURFACE('',#{flat},{major:?},{minor:?})"));
    let face = text.face(torus, "T", &[&[(round, true), (tube, true), (round, false), (tube, false)]]);
    let solid = text.solid(&[face]);
    let model = text.closed(solid);
    let volume = 2.0 * PI * PI * major * minor * minor;
    assert_share(model.mesh.signed_volume(), volume, 2.0 * CHORDS);

    // Half of it, between two meridian circles without a seam, and two flat ends.
    let mut text = Text::default();
    let flat = text.upright([0.0; 3]);
    let torus = text.add(format!("TOROIDAL_SURFACE('',#{flat},{major:?},{minor:?})"));
    let mut rims = Vec::new();
    let mut faces = Vec::new();
    for side in [1.0, -1.0] {
        let vertex = text.vertex([side * (major + minor), 0.0, 0.0]);
        let at = text.placement([side * major, 0.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]);
        let circle = text.circle(at, minor);
        let rim = text.edge([vertex, vertex], circle);
        let plane = text.add(format!("PLANE('',#{at})"));
        faces.push(text.face(plane, "T", &[&[(rim, true)]]));
        rims.push(rim);
    }
    faces.push(text.face(torus, "T", &[&[(rims[0], false)], &[(rims[1], false)]]));
    let solid = text.solid(&faces);
    let model = text.closed(solid);
    assert_share(model.mesh.signed_volume(), volume / 2.0, 2.0 * CHORDS);
}

#[test]
fn a_cone_in_degrees_and_inches_has_its_apex() {
    let mut text = Text::default();
    let (base, apex) = (text.vertex([1.0, 0.0, 0.0]), text.vertex([0.0, 0.0, 1.0]));
    let flat = text.upright([0.0; 3]);
    let circle = text.circle(flat, 1.0);
    let slope = text.line([1.0, 0.0, 0.0], [-1.0, 0.0, 1.0]);
    let (rim, seam) = (text.edge([base, base], circle), text.edge([base, apex], slope));
    // The radius grows along the axis, which therefore points down.
    let down = text.placement([0.0; 3], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]);
    let cone = text.add(format!("CONICAL_SURFACE('',#{down},1.,45.)"));
    let plane = text.add(format!("PLANE('',#{flat})"));
    let faces = [
        text.face(cone, "T", &[&[(rim, true), (seam, true), (seam, false)]]),
        text.face(plane, "F", &[&[(rim, false)]]),
    ];
    let solid = text.solid(&faces);
    let millimetre = text.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
    let measure = text.add(format!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#{millimetre})"));
    let inch = text.add(format!("(CONVERSION_BASED_UNIT('INCH',#{measure})LENGTH_UNIT()NAMED_UNIT(*))"));
    let radian = text.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    let measure =
        text.add(format!("PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE({:?}),#{radian})", PI / 180.0));
    let degree =
        text.add(format!("(CONVERSION_BASED_UNIT('DEGREE',#{measure})NAMED_UNIT(*)PLANE_ANGLE_UNIT())"));
    let context = text.context_of(&[inch, degree]);
    text.representation(&[solid], context);
    let model = text.read();
    assert_closed(&model);
    assert_share(model.millimetres.unwrap(), 25.4, 1e-12);
    assert_share(model.mesh.signed_volume(), PI / 3.0, CHORDS);
    let Some(Surface::Cone(found)) = model.faces[0].surface else { panic!("no cone") };
    assert_share(found.half_angle, PI / 4.0, 1e-12);
}

/// A cube of side 1 as facets; its number.
fn faceted_cube(text: &mut Text) -> usize {
    let corners: Vec<usize> =
        (0..8).map(|i| text.point([i & 1, i >> 1 & 1, i >> 2 & 1].map(f64::from))).collect();
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces: Vec<usize> = sides
        .iter()
        .map(|side| {
            let run = text.add(format!("POLY_LOOP('',({}))", list(&side.map(|i| corners[i]))));
            let bound = text.add(format!("FACE_OUTER_BOUND('',#{run},.T.)"));
            text.add(format!("FACE('',(#{bound}))"))
        })
        .collect();
    let shell = text.add(format!("CLOSED_SHELL('',({}))", list(&faces)));
    text.add(format!("FACETED_BREP('',#{shell})"))
}

#[test]
fn facets_are_read_as_planes() {
    let mut text = Text::default();
    let solid = faceted_cube(&mut text);
    let model = text.closed(solid);
    assert_share(model.mesh.signed_volume(), 1.0, 1e-12);
    assert_eq!(kinds(&model), BTreeMap::from([("plane", 6)]));
    assert_eq!(model.mesh.vertices.len(), 8);
}

/// Product, definition and shape of a name; definition and shape.
fn product(text: &mut Text, name: &str) -> (usize, usize) {
    let application = text.add("APPLICATION_CONTEXT('')");
    let context = text.add(format!("PRODUCT_CONTEXT('',#{application},'mechanical')"));
    let product = text.add(format!("PRODUCT('{name}','{name}','',(#{context}))"));
    let formation = text.add(format!("PRODUCT_DEFINITION_FORMATION('','',#{product})"));
    let design = text.add(format!("PRODUCT_DEFINITION_CONTEXT('part definition',#{application},'design')"));
    let definition = text.add(format!("PRODUCT_DEFINITION('design','',#{formation},#{design})"));
    let shape = text.add(format!("PRODUCT_DEFINITION_SHAPE('','',#{definition})"));
    (definition, shape)
}

#[test]
fn assemblies_place_their_parts_in_their_own_units() {
    for reversed in [false, true] {
        let mut text = Text::default();
        let cube = faceted_cube(&mut text);
        let millimetre = text.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
        let centimetre = text.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.CENTI.,.METRE.))");
        let (in_mm, in_cm) = (text.context_of(&[millimetre]), text.context_of(&[centimetre]));
        let origin = text.upright([0.0; 3]);
        let part = text.add(format!("FACETED_BREP_SHAPE_REPRESENTATION('',(#{origin},#{cube}),#{in_cm})"));
        let (part_definition, part_shape) = product(&mut text, "cube");
        text.add(format!("SHAPE_DEFINITION_REPRESENTATION(#{part_shape},#{part})"));
        // A quarter turn about z, 100 along x, and one about x.
        let places = [
            text.placement([100.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
            text.placement([0.0, 50.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
        ];
        let whole = text.add(format!("SHAPE_REPRESENTATION('',({}),#{in_mm})", list(&places)));
        let (whole_definition, whole_shape) = product(&mut text, "whole");
        text.add(format!("SHAPE_DEFINITION_REPRESENTATION(#{whole_shape},#{whole})"));
        for (i, place) in places.iter().enumerate() {
            let (pair, items) =
                if reversed { ([whole, part], [*place, origin]) } else { ([part, whole], [origin, *place]) };
            let transformation =
                text.add(format!("ITEM_DEFINED_TRANSFORMATION('','',#{},#{})", items[0], items[1]));
            let relation = text.add(format!(
                "(REPRESENTATION_RELATIONSHIP('','',#{},#{})\
                 REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{transformation})SHAPE_REPRESENTATION_RELATIONSHIP())",
                pair[0], pair[1]
            ));
            let usage = text.add(format!(
                "NEXT_ASSEMBLY_USAGE_OCCURRENCE('{i}','cube:{i}','',#{whole_definition},#{part_definition},$)"
            ));
            let shape = text.add(format!("PRODUCT_DEFINITION_SHAPE('','',#{usage})"));
            text.add(format!("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{shape})"));
        }
        let model = text.read();
        assert_closed(&model);
        assert_eq!(model.millimetres, Some(1.0), "the root is the assembly");
        assert_share(model.mesh.signed_volume(), 2000.0, 1e-9);
        let names: Vec<&str> = model.parts.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["cube", "cube"]);
        assert_eq!(model.parts[1].first_face, 6);
        let (low, high) = model.mesh.bounds().unwrap();
        // The first turns from x towards y: 90 to 100, 0 to 10; the second's z goes down the y axis: 40 to 50.
        assert!((low - Point3::new(0.0, 0.0, -0.0)).norm() < 1e-9, "{low}");
        assert!((high - Point3::new(100.0, 50.0, 10.0)).norm() < 1e-9, "{high}");
    }
}

#[test]
fn mapped_items_are_placed() {
    let mut text = Text::default();
    let cube = faceted_cube(&mut text);
    let context = text.context();
    let origin = text.upright([0.0; 3]);
    let part = text.add(format!("SHAPE_REPRESENTATION('',(#{origin},#{cube}),#{context})"));
    let map = text.add(format!("REPRESENTATION_MAP(#{origin},#{part})"));
    let mut items = Vec::new();
    for x in [10.0, 20.0] {
        let at = text.upright([x, 0.0, 0.0]);
        items.push(text.add(format!("MAPPED_ITEM('',#{map},#{at})")));
    }
    text.add(format!("SHAPE_REPRESENTATION('',({}),#{context})", list(&items)));
    let model = text.read();
    assert_closed(&model);
    assert_share(model.mesh.signed_volume(), 2.0, 1e-12);
    let (low, high) = model.mesh.bounds().unwrap();
    assert_eq!((low.x, high.x), (10.0, 21.0));
}

#[test]
fn a_surface_that_is_not_supported_is_told_and_the_others_are_read() {
    let mut text = Text::default();
    let ([low, high, seam], caps) = rims(&mut text);
    let axis = text.upright([0.0; 3]);
    let wall = text.add(format!("CYLINDRICAL_SURFACE('',#{axis},2.)"));
    let offset = text.add(format!("OFFSET_SURFACE('',#{wall},1.,.F.)"));
    let side = text.face(offset, "T", &[&[(low, true), (seam, true), (high, false), (seam, false)]]);
    let solid = text.solid(&[caps[0], caps[1], side]);
    let context = text.context();
    text.representation(&[solid], context);
    let model = read(text.text().as_bytes()).unwrap();
    assert_eq!(model.faces.len(), 2);
    assert_eq!(
        model.unread,
        [format!("face #{side} is left out: #{offset} is OFFSET_SURFACE, which is not supported")]
    );
}

// ------------------------------------------------------------------------------------------------------ hostile files

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let of =
        |data: &str| read(format!("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n{data}").as_bytes()).unwrap_err();
    assert_eq!(read(b"solid cube").unwrap_err(), StepReadError::NotStep);
    assert_eq!(of("#1=PLANE('',#2);\n#1=PLANE('',#2);").to_string(), "line 6: #1 is defined a second time");
    assert!(matches!(of("#1=PLANE('',#2"), StepReadError::Truncated { line: 5, .. }));
    assert!(matches!(of("#1=PLANE('',#2);"), StepReadError::Truncated { line: 5, .. }));
    assert!(matches!(of("#1=PLANE('',#2);\nENDSEC;\n"), StepReadError::NoFaces { first: None }));
    assert!(matches!(of("one=PLANE('',#2);\nENDSEC;\n"), StepReadError::Syntax { line: 5, .. }));
    assert!(matches!(of("/* #1=PLANE("), StepReadError::Truncated { line: 5, .. }));
    let told =
        of("#1=SHAPE_REPRESENTATION('',(#2),#9);\n#2=MANIFOLD_SOLID_BREP('',#3);\nENDSEC;\n").to_string();
    assert!(told.contains("#3 is referred to and not defined"), "{told}");
    let deep =
        format!("#1=SHAPE_REPRESENTATION('',{}{},#9);\nENDSEC;\n", "(".repeat(100_000), ")".repeat(100_000));
    assert!(matches!(of(&deep), StepReadError::NoFaces { .. }));
}

#[test]
fn cycles_end() {
    // Representations that place one another, curves of themselves, edges and shells of themselves.
    let cyclic = "#1=SHAPE_REPRESENTATION('',(#2),#9);\n#2=MAPPED_ITEM('',#3,#4);\n#3=REPRESENTATION_MAP(#4,#1);\n\
                  #4=AXIS2_PLACEMENT_3D('',#5,$,$);\n#5=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\n";
    let of = |data: &str| read(format!("ISO-10303-21;HEADER;ENDSEC;DATA;{data}").as_bytes()).unwrap_err();
    assert_eq!(of(cyclic), StepReadError::Cycle(1));
    let shell = "#1=SHAPE_REPRESENTATION('',(#2),#9);#2=MANIFOLD_SOLID_BREP('',#3);\
                 #3=ORIENTED_CLOSED_SHELL('',*,#3,.T.);ENDSEC;";
    assert!(of(shell).to_string().contains("#3 refers to itself"), "{}", of(shell));
    let curve = "#1=SHAPE_REPRESENTATION('',(#2),#9);#2=SHELL_BASED_SURFACE_MODEL('',(#3));#3=OPEN_SHELL('',(#4));\
                 #4=ADVANCED_FACE('',(#5),#8,.T.);#5=FACE_BOUND('',#6,.T.);#6=EDGE_LOOP('',(#7));\
                 #7=EDGE_CURVE('',#10,#10,#8,.T.);#8=TRIMMED_CURVE('',#8,(),(),.T.,.PARAMETER.);\
                 #10=VERTEX_POINT('',#11);#11=CARTESIAN_POINT('',(0.,0.,0.));ENDSEC;";
    assert!(of(curve).to_string().contains("#8 refers to itself"), "{}", of(curve));
}

#[test]
fn assemblies_that_stand_for_too_much_end() {
    // Each level maps the one below twice: 2^40 cubes.
    let mut text = Text::default();
    let cube = faceted_cube(&mut text);
    let context = text.context();
    let origin = text.upright([0.0; 3]);
    let mut below = text.add(format!("SHAPE_REPRESENTATION('',(#{cube}),#{context})"));
    for _ in 0..40 {
        let map = text.add(format!("REPRESENTATION_MAP(#{origin},#{below})"));
        let item = text.add(format!("MAPPED_ITEM('',#{map},#{origin})"));
        below = text.add(format!("SHAPE_REPRESENTATION('',(#{item},#{item}),#{context})"));
    }
    assert!(matches!(read(text.text().as_bytes()), Err(StepReadError::TooLarge { .. })));
}

#[test]
fn damaged_files_end_in_a_result_or_an_error() {
    let solids = build(&cap().labelled(), &tolerances(STEP)).solids;
    let mut seamed = Text::default();
    let ([low, high, seam], caps) = rims(&mut seamed);
    let wall = rational_wall(&mut seamed);
    let side = seamed.face(wall, "T", &[&[(low, true), (seam, true), (high, false), (seam, false)]]);
    let solid = seamed.solid(&[caps[0], caps[1], side]);
    let context = seamed.context();
    seamed.representation(&[solid], context);
    let originals = [write(&solids, &StepOptions { colors: false, ..StepOptions::default() }), seamed.text()];
    let (mut n_read, mut n_refused) = (0, 0);
    for (index, original) in originals.iter().enumerate() {
        let mut rng = Rng::for_task(5, "damage", index as u64);
        for _ in 0..110 {
            match read(&damaged(original.as_bytes(), &mut rng)) {
                Ok(model) => {
                    n_read += 1;
                    assert!(model.mesh.vertices.iter().all(|p| p.iter().all(|x| x.is_finite())));
                }
                Err(_) => n_refused += 1,
            }
        }
    }
    assert!(n_read > 50 && n_refused > 20, "{n_read} read, {n_refused} refused");
}

/// One to four changes: a byte, a number, a reference, a piece left out or repeated, the end cut off.
fn damaged(original: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for _ in 0..=rng.below(4) {
        let at = rng.below(bytes.len());
        let digit = (at..bytes.len()).find(|i| bytes[*i].is_ascii_digit()).unwrap_or(0);
        match rng.below(12) {
            0 => bytes[at] = rng.below(256) as u8,
            1 => bytes.truncate(at.max(1)),
            2 => drop(bytes.drain(at..(at + rng.below(60)).min(bytes.len()))),
            3 => {
                let piece = bytes[at..(at + rng.below(60)).min(bytes.len())].to_vec();
                bytes.splice(at..at, piece);
            }
            4 => drop(bytes.splice(digit..digit, b"999999999".iter().copied())),
            5 => drop(bytes.splice(digit..=digit, b"1.E300".iter().copied())),
            6 => drop(bytes.splice(digit..=digit, b"0.".iter().copied())),
            _ => bytes[digit] = b'0' + rng.below(10) as u8,
        }
        if bytes.is_empty() {
            bytes.push(b' ');
        }
    }
    bytes
}

// --------------------------------------------------------------------------------------------------------- helpers

/// Every side of a triangle has exactly one opposite side.
fn assert_closed(model: &PriorModel) {
    let mut sides: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for [a, b, c] in &model.mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            assert!(from != to, "a triangle with one corner twice");
            let side = sides.entry((*from.min(to), *from.max(to))).or_default();
            *side += if from < to { 1 } else { -1 };
        }
    }
    let open = sides.values().filter(|n| **n != 0).count();
    assert_eq!(open, 0, "open sides of {}", sides.len());
    assert_eq!(model.face_of.len(), model.mesh.triangles.len());
}

fn assert_share(found: f64, expected: f64, share: f64) {
    assert!((found / expected - 1.0).abs() < share, "{found}, should be {expected}");
}

fn kinds(model: &PriorModel) -> BTreeMap<&'static str, usize> {
    let mut kinds = BTreeMap::new();
    for face in &model.faces {
        *kinds.entry(face.surface.map_or("freeform", |s| SurfaceKind::name(s.kind()))).or_default() += 1;
    }
    kinds
}

#[test]
fn chords_turn_by_no_more_than_is_said() {
    // The share that the other tests allow: sin(6 deg) / (6 deg) for a circle of chords.
    let turn = TAU / 60.0;
    assert!(1.0 - turn.sin() / turn <= CHORDS + 1e-4);
}
