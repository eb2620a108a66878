//! The result as data: JSON and labelled mesh.
