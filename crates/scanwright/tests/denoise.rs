//! Tests of `denoise`.
