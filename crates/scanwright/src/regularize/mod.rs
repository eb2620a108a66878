//! Relations between primitives: found, and enforced where the evidence allows.
