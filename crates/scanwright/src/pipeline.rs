//! The whole path, from a mesh to a solid.
