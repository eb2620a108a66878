//! The solid encloses a positive volume, by the divergence theorem on its triangles.

use super::Problem;
use crate::brep::solid::Solid;
use crate::brep::tessellate::tessellate;

pub(super) fn check(solid: &Solid) -> Vec<Problem> {
    let volume = tessellate(solid).mesh.signed_volume();
    if volume > 0.0 { Vec::new() } else { vec![Problem::Volume(volume)] }
}
