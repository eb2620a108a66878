//! Signed distances between a scan and a model.
