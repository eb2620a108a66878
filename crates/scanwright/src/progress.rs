//! The one callback: how far a run is, and whether it should go on.

/// A stage of the pipeline, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// Welding, splitting, orienting, measuring.
    Condition,
    /// Removal of the supporting table.
    Support,
    /// Filtered normals for topology decisions.
    Denoise,
    /// Regions and their primitives.
    Segment,
    /// Relations between primitives.
    Regularize,
    /// The solid.
    Build,
    /// Files.
    Write,
}

impl Stage {
    /// Name for people, lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Condition => "condition",
            Self::Support => "support",
            Self::Denoise => "denoise",
            Self::Segment => "segment",
            Self::Regularize => "regularize",
            Self::Build => "build",
            Self::Write => "write",
        }
    }
}

/// The run was stopped by its progress callback.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Reports progress; the callback returns whether to go on.
pub struct Progress<'a>(Box<dyn Fn(Stage, f64) -> bool + Sync + 'a>);

impl<'a> Progress<'a> {
    /// Progress that calls `callback(stage, fraction in [0, 1])`.
    pub fn new(callback: impl Fn(Stage, f64) -> bool + Sync + 'a) -> Self {
        Self(Box::new(callback))
    }

    /// Progress that nobody watches.
    pub fn none() -> Self {
        Self::new(|_, _| true)
    }

    /// Reports that `stage` is `fraction` done.
    pub fn report(&self, stage: Stage, fraction: f64) -> Result<(), Cancelled> {
        if (self.0)(stage, fraction) { Ok(()) } else { Err(Cancelled) }
    }
}

impl std::fmt::Debug for Progress<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Progress")
    }
}
