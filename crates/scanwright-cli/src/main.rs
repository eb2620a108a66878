//! The command `scanwright`: flags become options, results become files and exit codes.
//!
//! No geometry lives here. A verb returns an [`exit::Code`] or an [`exit::Failure`]; this file turns either into the
//! process's exit code, and a panic into a sentence that asks for a report.

mod align;
mod args;
mod check;
mod assemble;
mod classify;
mod clean;
mod console;
mod convert;
mod exit;
mod gprimdb;
mod info;
mod known;
mod outputs;
mod picture;
mod render;
mod scan;
mod segment;
mod selftest;
mod summary;
mod train;

use std::panic;
use std::process::ExitCode;

use clap::Parser as _;

use args::{Cli, Verb};
use exit::Failure;

fn main() -> ExitCode {
    let cli = Cli::parse();
    panic::set_hook(Box::new(|_| {}));
    let outcome = panic::catch_unwind(|| match &cli.verb {
        Verb::Convert(args) => convert::run(args),
        Verb::Info(args) => info::run(args),
        Verb::Clean(args) => clean::run(args),
        Verb::Segment(args) => segment::run(args),
        Verb::Gprimdb(verb) => gprimdb::run(verb),
        Verb::Classify(args) => classify::run(args),
        Verb::Train(args) => train::run(args),
        Verb::Render(args) => render::run(args),
        Verb::Check(args) => check::run(args),
        Verb::Align(args) => align::run(args),
        Verb::Assemble(args) => assemble::run(args),
        Verb::Selftest => selftest::run(),
    });
    let code = match outcome {
        Ok(Ok(code)) => code,
        Ok(Err(failure)) => {
            eprintln!("scanwright: {failure}");
            failure.code()
        }
        Err(panic) => {
            let failure = Failure::Internal(panic_text(&*panic));
            eprintln!("scanwright: {failure}");
            failure.code()
        }
    };
    ExitCode::from(code as u8)
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message").to_owned()
}
