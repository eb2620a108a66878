//! The file around the geometry: header, product, context, units, colours.

use std::fmt::Write;

use super::entities::{Entities, real, references};
use super::{LengthUnit, Schema, StepOptions};
use crate::brep::{Face, Solid};
use crate::surface::SurfaceKind;

/// The Part 21 text of `solids`: closed ones as solids, open ones as shells.
pub fn write(solids: &[Solid], options: &StepOptions) -> String {
    let mut entities = Entities::default();
    let (_, product) = product(&mut entities, options);
    let context = context(&mut entities, uncertainty(solids), options);
    let origin = entities
        .placement(&crate::math::Frame::from_z(crate::math::Point3::origin(), crate::math::Vec3::z_axis()));
    let (mut closed, mut open, mut colored) = (vec![origin], vec![origin], Vec::new());
    for (i, solid) in solids.iter().enumerate() {
        let faces = entities.faces(solid);
        colored.extend(solid.faces.iter().zip(&faces).map(|(f, id)| (color_of(solid, f), *id)));
        if solid.is_closed() {
            closed.push(closed_solid(&mut entities, solid, &faces, i));
        } else {
            open.push(open_shells(&mut entities, solid, &faces, i));
        }
    }
    let mut models = Vec::new();
    if closed.len() > 1 {
        models.push(
            entities
                .add(&format!("ADVANCED_BREP_SHAPE_REPRESENTATION('',{},#{context})", references(&closed))),
        );
    }
    if open.len() > 1 {
        models.push(
            entities
                .add(&format!("MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',{},#{context})", references(&open))),
        );
    }
    attach(&mut entities, product, &models, origin, context);
    if options.colors && !colored.is_empty() {
        color(&mut entities, &colored, context);
    }
    format!("{}DATA;\n{}\nENDSEC;\nEND-ISO-10303-21;\n", header(options, options.schema), entities.text())
}

pub(super) fn header(options: &StepOptions, schema: Schema) -> String {
    let schema = match schema {
        Schema::Ap242 => "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
        Schema::Ap214 => "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }",
    };
    let (name, stamp) = (quoted(&options.name), quoted(&options.time_stamp));
    let version = env!("CARGO_PKG_VERSION");
    format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('solid from a scan'),'2;1');\n\
         FILE_NAME({name},{stamp},(''),(''),'scanwright {version}','scanwright','');\n\
         FILE_SCHEMA(('{schema}'));\nENDSEC;\n"
    )
}

/// A string as Part 21 wants it: quotes doubled, anything beyond printable ASCII as `\X2\` code units.
pub(super) fn quoted(text: &str) -> String {
    let mut out = String::from("'");
    for c in text.chars() {
        match c {
            '\'' => out.push_str("''"),
            '\\' => out.push_str("\\\\"),
            ' '..='~' => out.push(c),
            _ => {
                let mut units = [0; 2];
                out.push_str("\\X2\\");
                for unit in c.encode_utf16(&mut units) {
                    let _ = write!(out, "{unit:04X}");
                }
                out.push_str("\\X0\\");
            }
        }
    }
    out.push('\'');
    out
}

/// The product and its shape; the numbers of its definition and of the shape.
pub(super) fn product(entities: &mut Entities, options: &StepOptions) -> (usize, usize) {
    let (protocol, year, name) = match options.schema {
        Schema::Ap242 => {
            ("managed model based 3d engineering", 2014, "ap242_managed_model_based_3d_engineering")
        }
        Schema::Ap214 => ("core data for automotive mechanical design processes", 2000, "automotive_design"),
    };
    let application = entities.add(&format!("APPLICATION_CONTEXT('{protocol}')"));
    entities.add(&format!(
        "APPLICATION_PROTOCOL_DEFINITION('international standard','{name}',{year},#{application})"
    ));
    let context = entities.add(&format!("PRODUCT_CONTEXT('',#{application},'mechanical')"));
    let name = quoted(&options.name);
    let product = entities.add(&format!("PRODUCT({name},{name},'',(#{context}))"));
    entities.add(&format!("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{product}))"));
    let formation = entities.add(&format!("PRODUCT_DEFINITION_FORMATION('','',#{product})"));
    let design =
        entities.add(&format!("PRODUCT_DEFINITION_CONTEXT('part definition',#{application},'design')"));
    let definition = entities.add(&format!("PRODUCT_DEFINITION('design','',#{formation},#{design})"));
    (definition, entities.add(&format!("PRODUCT_DEFINITION_SHAPE('','',#{definition})")))
}

/// Units and uncertainty (none when `gap` is zero); the number of the context.
pub(super) fn context(entities: &mut Entities, gap: f64, options: &StepOptions) -> usize {
    let si = |entities: &mut Entities, prefix: &str| {
        entities.add(&format!("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({prefix},.METRE.))"))
    };
    let of_millimetres = |entities: &mut Entities, name: &str, factor: &str| {
        let millimetre = si(entities, ".MILLI.");
        let measure = format!("LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({factor}),#{millimetre})");
        let measure = entities.add(&measure);
        let exponents = entities.add("DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)");
        let unit =
            format!("(CONVERSION_BASED_UNIT('{name}',#{measure})LENGTH_UNIT()NAMED_UNIT(#{exponents}))");
        entities.add(&unit)
    };
    let length = match options.unit {
        LengthUnit::Millimetre => si(entities, ".MILLI."),
        LengthUnit::Centimetre => si(entities, ".CENTI."),
        LengthUnit::Metre => si(entities, "$"),
        LengthUnit::Micrometre => si(entities, ".MICRO."),
        LengthUnit::Inch => of_millimetres(entities, "INCH", "25.4"),
        LengthUnit::Foot => of_millimetres(entities, "FOOT", "304.8"),
    };
    let angle = entities.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))");
    let solid_angle = entities.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())");
    if gap == 0.0 {
        return entities.add(&format!(
            "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#{length},#{angle},#{solid_angle}))\
             REPRESENTATION_CONTEXT('',''))"
        ));
    }
    let gap = real(gap);
    let uncertainty = entities.add(&format!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({gap}),#{length},'distance_accuracy_value','largest gap')"
    ));
    entities.add(&format!(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{uncertainty}))\
         GLOBAL_UNIT_ASSIGNED_CONTEXT((#{length},#{angle},#{solid_angle}))REPRESENTATION_CONTEXT('',''))"
    ))
}

/// The largest gap, at least a millionth of the size: no reader holds coordinates better than that.
fn uncertainty(solids: &[Solid]) -> f64 {
    const FLOOR: f64 = 1e-6;
    let mut points = solids.iter().flat_map(|s| &s.vertices).map(|v| v.point);
    let first = points.next().unwrap_or_else(crate::math::Point3::origin);
    let (low, high) = points.fold((first, first), |(l, h), p| (l.inf(&p), h.sup(&p)));
    let gap = solids.iter().map(|s| s.gap).fold(0.0, f64::max);
    let floor = FLOOR * (high - low).norm();
    if gap.max(floor) > 0.0 { gap.max(floor) } else { FLOOR }
}

fn closed_solid(entities: &mut Entities, solid: &Solid, faces: &[usize], index: usize) -> usize {
    let shells: Vec<usize> = solid
        .shells
        .iter()
        .map(|shell| {
            let ids: Vec<usize> = shell.faces.iter().map(|f| faces[f.0 as usize]).collect();
            entities.add(&format!("CLOSED_SHELL('',{})", references(&ids)))
        })
        .collect();
    if shells.len() == 1 {
        return entities.add(&format!("MANIFOLD_SOLID_BREP('solid {index}',#{})", shells[0]));
    }
    // A cavity's faces already look into the cavity, so its shell is used as it is.
    let voids: Vec<usize> =
        shells[1..].iter().map(|s| entities.add(&format!("ORIENTED_CLOSED_SHELL('',*,#{s},.T.)"))).collect();
    entities.add(&format!("BREP_WITH_VOIDS('solid {index}',#{},{})", shells[0], references(&voids)))
}

fn open_shells(entities: &mut Entities, solid: &Solid, faces: &[usize], index: usize) -> usize {
    let shells: Vec<usize> = solid
        .shells
        .iter()
        .map(|shell| {
            let ids: Vec<usize> = shell.faces.iter().map(|f| faces[f.0 as usize]).collect();
            entities.add(&format!("OPEN_SHELL('',{})", references(&ids)))
        })
        .collect();
    entities.add(&format!("SHELL_BASED_SURFACE_MODEL('open {index}',{})", references(&shells)))
}

/// Ties the models to the product's shape.
fn attach(entities: &mut Entities, shape: usize, models: &[usize], origin: usize, context: usize) {
    match models {
        [] => {
            let empty = entities.add(&format!("SHAPE_REPRESENTATION('',(#{origin}),#{context})"));
            entities.add(&format!("SHAPE_DEFINITION_REPRESENTATION(#{shape},#{empty})"));
        }
        [one] => {
            entities.add(&format!("SHAPE_DEFINITION_REPRESENTATION(#{shape},#{one})"));
        }
        several => {
            let base = entities.add(&format!("SHAPE_REPRESENTATION('',(#{origin}),#{context})"));
            entities.add(&format!("SHAPE_DEFINITION_REPRESENTATION(#{shape},#{base})"));
            for model in several {
                entities.add(&format!("SHAPE_REPRESENTATION_RELATIONSHIP('','',#{base},#{model})"));
            }
        }
    }
}

/// Red, green, blue of a face: by type, paler where assumed.
fn color_of(solid: &Solid, face: &Face) -> [f64; 3] {
    /// Share of white mixed into assumed faces.
    const PALE: f64 = 0.6;
    let color = match solid.geometry(face).kind() {
        Some(SurfaceKind::Plane) => [0.55, 0.65, 0.80],
        Some(SurfaceKind::Cylinder) => [0.90, 0.60, 0.25],
        Some(SurfaceKind::Cone) => [0.45, 0.70, 0.45],
        Some(SurfaceKind::Sphere) => [0.80, 0.40, 0.40],
        Some(SurfaceKind::Torus) => [0.65, 0.50, 0.75],
        None => [0.60, 0.60, 0.60],
    };
    if face.assumed { color.map(|c| c + (1.0 - c) * PALE) } else { color }
}

fn color(entities: &mut Entities, colored: &[([f64; 3], usize)], context: usize) {
    let mut styles: Vec<([f64; 3], usize)> = Vec::new();
    let mut items = Vec::new();
    for (rgb, face) in colored {
        let known = styles.iter().find(|s| s.0 == *rgb).map(|s| s.1);
        let style = known.unwrap_or_else(|| {
            let style = surface_style(entities, rgb);
            styles.push((*rgb, style));
            style
        });
        items.push(entities.add(&format!("STYLED_ITEM('color',(#{style}),#{face})")));
    }
    entities.add(&format!(
        "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{},#{context})",
        references(&items)
    ));
}

fn surface_style(entities: &mut Entities, [r, g, b]: &[f64; 3]) -> usize {
    let color = entities.add(&format!("COLOUR_RGB('',{},{},{})", real(*r), real(*g), real(*b)));
    let fill = entities.add(&format!("FILL_AREA_STYLE_COLOUR('',#{color})"));
    let area = entities.add(&format!("FILL_AREA_STYLE('',(#{fill}))"));
    let surface = entities.add(&format!("SURFACE_STYLE_FILL_AREA(#{area})"));
    let side = entities.add(&format!("SURFACE_SIDE_STYLE('',(#{surface}))"));
    let usage = entities.add(&format!("SURFACE_STYLE_USAGE(.BOTH.,#{side})"));
    entities.add(&format!("PRESENTATION_STYLE_ASSIGNMENT((#{usage}))"))
}
