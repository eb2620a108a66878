//! Tests of `readers`.
