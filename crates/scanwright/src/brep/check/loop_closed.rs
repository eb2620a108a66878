//! Each use of a loop begins where the one before ended.

use super::Problem;
use crate::brep::solid::{FaceId, Solid};

pub(super) fn check(solid: &Solid) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (f, face) in solid.faces.iter().enumerate() {
        for (index, run) in face.loops.iter().enumerate() {
            let n = run.uses.len();
            let closes =
                (0..n).all(|i| solid.ends(run.uses[i]).1 == solid.ends(run.uses[(i + 1) % n]).0) && n > 0;
            if !closes {
                problems.push(Problem::LoopOpen { face: FaceId(f as u32), index });
            }
        }
    }
    problems
}
