//! `scanwright info`.

use scanwright::condition::{self, ConditionReport};
use scanwright::io::ScanFile;
use scanwright::mesh::{Adjacency, Mesh};
use scanwright::tolerance::{Measured, Tolerances};

use crate::args::InfoArgs;
use crate::exit::{Code, Failure};
use crate::scan;
use crate::summary::{Lines, count, short};

/// Says what a scan is.
pub fn run(args: &InfoArgs) -> Result<Code, Failure> {
    let file = scan::read(&args.scan)?;
    let conditioned = condition::condition(&file.mesh);
    if conditioned.mesh.triangles.is_empty() {
        return Err(Failure::input(&args.scan, "no triangle has an area"));
    }
    let mesh = &conditioned.mesh;
    let adjacency = Adjacency::new(mesh);
    let measured = condition::measure(mesh, &adjacency);
    let tolerances = Tolerances::new(measured, None);
    let support: Option<condition::Support> = None; let _ = &tolerances;

    let mut lines = Lines::default();
    lines.add("file", &file_line(args, &file));
    lines.add("mesh", &mesh_line(mesh, &conditioned.report));
    for repair in repairs(&conditioned.report) {
        lines.add("repair", &repair);
    }
    lines.add("holes", &holes_line(&conditioned.report));
    lines.add("size", &size_line(mesh, &measured));
    lines.add("scanner", &scanner_line(&measured));
    lines.add("limits", &limits_line(&measured));
    lines.add("support", &support.map_or("no table found".to_owned(), |s| support_line(&s.on_table)));
    lines.add("units", &units_line(&file, mesh, &measured));
    print!("{}", lines.text());
    Ok(Code::Done)
}

fn file_line(args: &InfoArgs, file: &ScanFile) -> String {
    let mut text = format!(
        "{}  {}, {} triangles, {} vertices",
        args.scan.display(),
        scan::format_name(file.format),
        count(file.mesh.triangles.len()),
        count(file.mesh.vertices.len())
    );
    if file.n_polygons > 0 {
        text += &format!(", {} polygons cut into triangles", count(file.n_polygons));
    }
    if file.n_unused_vertices > 0 {
        text += &format!(", {} vertices that no triangle uses", count(file.n_unused_vertices));
    }
    text
}

fn mesh_line(mesh: &Mesh, report: &ConditionReport) -> String {
    format!(
        "{} triangles, {} vertices, {} after repair, area {}",
        count(mesh.triangles.len()),
        count(mesh.vertices.len()),
        plural(report.n_components, "piece"),
        short(mesh.total_area())
    )
}

/// What conditioning had to do, in the order it did it.
fn repairs(report: &ConditionReport) -> Vec<String> {
    let all = [
        (report.n_welded_vertices, "vertices merged"),
        (report.n_zero_area_triangles, "triangles without area dropped"),
        (report.n_repeated_triangles, "repeated triangles dropped"),
        (report.n_split_edges, "edges of three or more triangles split"),
        (report.n_split_vertices, "vertices added to split fans"),
        (report.n_one_sided_edges, "edges cut where the surface has one side"),
        (report.n_flipped_triangles, "triangles turned over"),
        (report.n_speck_triangles, "triangles of specks dropped"),
    ];
    all.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{} {what}", count(*n))).collect()
}

fn holes_line(report: &ConditionReport) -> String {
    if report.n_boundary_loops == 0 {
        return "none, the mesh is closed".to_owned();
    }
    let loops = plural(report.n_boundary_loops, "boundary loop");
    format!("{loops} with {} edges", count(report.n_boundary_edges))
}

fn size_line(mesh: &Mesh, measured: &Measured) -> String {
    let extent = mesh.bounds().map_or(scanwright::math::Vec3::zeros(), |(lo, hi)| hi - lo);
    format!(
        "{} x {} x {}, diagonal {}",
        short(extent.x),
        short(extent.y),
        short(extent.z),
        short(measured.diagonal)
    )
}

fn scanner_line(measured: &Measured) -> String {
    let rounding = match measured.edge_rounding {
        0.0 => "no sharp edge to judge rounding by".to_owned(),
        sigma => format!("sharp edges rounded by a spot of sigma {}", short(sigma)),
    };
    format!(
        "spacing {}, noise along the normal sigma {}, of normals {:.1} deg, {rounding}",
        short(measured.spacing),
        short(measured.noise),
        measured.normal_noise.to_degrees()
    )
}

/// A face needs a few points across to be told from its neighbours.
const SPACINGS_PER_FACE: f64 = 3.0;

fn limits_line(measured: &Measured) -> String {
    let narrowest = short(SPACINGS_PER_FACE * measured.spacing);
    format!("faces narrower than about {narrowest} cannot be told from their neighbours")
}

fn support_line(on_table: &[bool]) -> String {
    let n = on_table.iter().filter(|on| **on).count();
    format!("the part stands on a table of {} triangles; `convert` takes it away", count(n))
}

/// Diagonals of parts that people scan, millimetres: a coin to an engine block.
const USUAL_MM: std::ops::RangeInclusive<f64> = 10.0..=1500.0;

/// The unit the numbers are likely in, and why.
fn units_line(file: &ScanFile, mesh: &Mesh, measured: &Measured) -> String {
    if let Some(unit) = file.units {
        return format!("{}, as the file says", scan::unit_name(unit));
    }
    let diagonal = mesh.diagonal();
    let candidates = [("mm", 1.0), ("m", 1000.0), ("in", 25.4), ("cm", 10.0)];
    let likely = candidates.iter().find(|(_, mm)| USUAL_MM.contains(&(diagonal * mm)));
    let spacing = short(measured.spacing);
    match likely {
        Some((name, mm)) => format!(
            "likely {name}: the part would be {} mm across and its points {} mm apart; the file does not say, --units sets it",
            short(diagonal * mm),
            short(measured.spacing * mm)
        ),
        None => format!(
            "unclear: {} across, points {spacing} apart; the file does not say, --units sets it",
            short(diagonal)
        ),
    }
}

fn plural(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{} {noun}s", count(n)) }
}
