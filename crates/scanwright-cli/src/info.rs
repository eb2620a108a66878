//! `scanwright info`.

use crate::args::InfoArgs;
use crate::exit::{Code, Failure};
use crate::scan;

/// Says what a scan is.
pub fn run(args: &InfoArgs) -> Result<Code, Failure> {
    let file = scan::read(&args.scan)?;
    println!("read     {}  {} triangles, {} vertices", args.scan.display(), file.mesh.triangles.len(), file.mesh.vertices.len());
    Ok(Code::Done)
}
