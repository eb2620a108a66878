//! `scanwright selftest`.

use scanwright::fit::FitMethod;
use scanwright::selftest::{ANGLE, Errors, LENGTH, references};

use crate::exit::{Code, Failure};

/// Fits reference data and prints how far from the known answers they end.
pub fn run() -> Result<Code, Failure> {
    const METHODS: [FitMethod; 2] = [FitMethod::Robust, FitMethod::Lsge];
    println!("Errors of fits to data whose least-squares answer is known: length in mm, angle in radians.\n");
    print!("{:42}", "");
    println!("{}", METHODS.map(|method| format!("{:>22}", method.name())).concat());
    let mut failed = Vec::new();
    for reference in references() {
        print!("{:42}", reference.name);
        for method in METHODS {
            let errors = reference.errors(method);
            let cell = errors.map_or("no surface".to_owned(), |Errors { length, angle }| {
                format!("{length:>13.1e} {angle:>8.1e}")
            });
            print!("{cell:>22}");
            if !errors.is_some_and(|errors| errors.pass()) {
                failed.push(format!("{} by {}", reference.name, method.name()));
            }
        }
        println!();
    }
    println!("\nallowed{:35}{:>13} {:>8}", "", format!("{LENGTH:.0e}"), format!("{ANGLE:.0e}"));
    if failed.is_empty() {
        println!("all within");
        return Ok(Code::Done);
    }
    Err(Failure::Internal(format!("fits miss their answers: {}", failed.join("; "))))
}
