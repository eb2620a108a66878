//! Criterion benches live in `benches/`; this crate is never published.
