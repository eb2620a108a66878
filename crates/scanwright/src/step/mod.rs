//! STEP text (AP242, AP214) from a solid.
