//! All integration tests, one binary.

mod architecture;
mod brep;
mod close;
mod condition;
mod conditioning;
mod denoise;
mod picture;
mod readers;
mod scanned;
mod step;
