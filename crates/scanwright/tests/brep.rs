//! Tests of `brep`.
