//! All integration tests, one binary.

mod architecture;
mod baselines;
mod brep;
mod close;
mod condition;
mod conditioning;
mod denoise;
mod draw;
mod gauss;
mod gprimdb;
mod gprimdb_store;
mod known_fits;
mod metamorphic;
mod outliers;
mod parts;
mod picture;
mod readers;
mod regularize;
mod scanned;
mod scans;
mod script;
mod segmentation;
mod spectral;
mod step;
mod turned;
mod untidy;
