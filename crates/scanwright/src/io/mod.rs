//! Readers and writers of meshes.
