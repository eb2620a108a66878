//! Solvers: orthogonal-distance least squares, one file per surface type.
