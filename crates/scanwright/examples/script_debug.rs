//! debug
use scanwright::{io, pipeline, progress::Progress, script};
fn main() {
    for path in std::env::args().skip(1) {
        let scan = io::read_mesh_file(path.as_ref()).unwrap();
        let result = pipeline::run(&scan.mesh, &pipeline::Options::default(), &Progress::none()).unwrap();
        let m = &result.measured;
        let tol = 0.2 * m.spacing + m.noise;
        let t = std::time::Instant::now();
        println!("== {path} tol {tol:.3} solids {}", result.model.solids.len());
        for s in &result.model.solids {
            println!("{}", script::debug(s, tol));
        }
        println!("{:.2?}", t.elapsed());
    }
}
