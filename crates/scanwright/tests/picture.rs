//! Tests of `picture`.
