//! The place of relations between primitives: parallel, coaxial, equal. It holds nothing yet; primitives pass through
//! the pipeline as they were fitted.
