//! `scanwright render`.

use std::path::Path;

use scanwright::io;
use scanwright::math::{UnitVec3, Vec3};
use scanwright::surface::SurfaceKind;

use crate::args::{ColorFlag, RenderArgs};
use crate::exit::{Code, Failure};
use crate::picture::{self, Look};
use crate::{console, outputs, scan};

/// Draws a scan or its regions.
pub fn run(args: &RenderArgs) -> Result<Code, Failure> {
    console::handle_interrupts();
    outputs::check(&args.scan, &[&args.output], args.force)?;
    let file = scan::read(&args.scan)?;
    let labels = if file.format == io::Format::Ply { regions(&args.scan)? } else { None };
    if labels.is_none() && args.color.is_some() {
        let reason = "has no regions to color: it needs the face property `primitive` that `convert --segments` writes";
        return Err(Failure::input(&args.scan, reason));
    }
    let look = match args.color {
        Some(ColorFlag::Type) => Look::Type(types_beside(&args.scan)?),
        Some(ColorFlag::Region) | None => Look::Region,
    };
    let up = args.up.map(|[x, y, z]| UnitVec3::new_normalize(Vec3::new(x, y, z)));
    let image = picture::of_mesh(&file.mesh, labels.as_deref(), &look, up);
    outputs::write(&[(&args.output, image.to_png())])?;
    Ok(Code::Done)
}

/// The property `primitive` of a PLY file's faces, if it has one.
fn regions(path: &Path) -> Result<Option<Vec<Option<u32>>>, Failure> {
    let bytes = std::fs::read(path).map_err(|error| Failure::input(path, error))?;
    let labels = io::read_ply_face_property(&bytes, "primitive").ok();
    Ok(labels.map(|labels| labels.into_iter().map(|id| u32::try_from(id).ok()).collect()))
}

/// Types by primitive, from the JSON that `convert` wrote for the same scan: the only `.json` file with the PLY
/// file's name, or `part.json` in its folder.
fn types_beside(path: &Path) -> Result<Vec<Option<SurfaceKind>>, Failure> {
    let candidates = [path.with_extension("json"), path.with_file_name("part.json")];
    let Some(json) = candidates.iter().find(|candidate| candidate.is_file()) else {
        let names = candidates.map(|c| c.display().to_string()).join(" or ");
        return Err(Failure::input(path, format!("types are read from the JSON of the same run, but there is no {names}")));
    };
    let text = std::fs::read_to_string(json).map_err(|error| Failure::input(json, error))?;
    let value: serde_json::Value = serde_json::from_str(&text).map_err(|error| Failure::input(json, error))?;
    let mut kinds = Vec::new();
    for primitive in value["primitives"].as_array().into_iter().flatten() {
        let id = primitive["id"].as_u64().and_then(|id| usize::try_from(id).ok());
        let kind = SurfaceKind::ALL.into_iter().find(|k| primitive["type"] == k.name());
        // Ids are the primitives' places in the list.
        if id != Some(kinds.len()) {
            return Err(Failure::input(json, format!("primitive {} should have id {0}", kinds.len())));
        }
        kinds.push(kind);
    }
    Ok(kinds)
}
