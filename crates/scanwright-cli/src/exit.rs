use std::fmt;
use std::path::{Path, PathBuf};

use scanwright::pipeline;

/// Exit codes; `docs/output.md` documents them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Code {
    /// Everything asked for is there.
    Done = 0,
    /// The command line makes no sense.
    Usage = 2,
    /// The input cannot be read.
    Input = 3,
    /// The files are written, but not all of the part became analytic faces of a closed solid.
    Partly = 4,
    /// An output cannot be written.
    Output = 5,
    /// A bug of ours.
    Internal = 7,
    /// Stopped by the user.
    Cancelled = 130,
}

/// Why a verb ended without its result.
#[derive(Debug)]
pub enum Failure {
    /// The command line makes no sense.
    Usage(String),
    /// The input cannot be read.
    Input(PathBuf, String),
    /// An output cannot be written.
    Output(PathBuf, String),
    /// `--strict` asked for no result rather than this.
    Strict(String),
    /// A bug of ours.
    Internal(String),
    /// Stopped by the user.
    Cancelled,
}

impl Failure {
    /// An input that cannot be read, with the reason.
    pub fn input(path: &Path, reason: impl fmt::Display) -> Self {
        Self::Input(path.to_owned(), reason.to_string())
    }

    /// Why the pipeline has no result for a scan: it was stopped, or there is nothing to work on.
    pub fn of_run(scan: &Path, error: pipeline::Error) -> Self {
        match error {
            pipeline::Error::Cancelled(_) => Self::Cancelled,
            other => Self::input(scan, other),
        }
    }

    /// An output that cannot be written, with the reason.
    pub fn output(path: &Path, reason: impl fmt::Display) -> Self {
        Self::Output(path.to_owned(), reason.to_string())
    }

    /// The exit code.
    pub fn code(&self) -> Code {
        match self {
            Self::Usage(_) => Code::Usage,
            Self::Input(..) => Code::Input,
            Self::Output(..) => Code::Output,
            Self::Strict(_) => Code::Partly,
            Self::Internal(_) => Code::Internal,
            Self::Cancelled => Code::Cancelled,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(reason) => write!(f, "{reason}"),
            Self::Input(path, reason) | Self::Output(path, reason) => {
                write!(f, "{}: {reason}", path.display())
            }
            Self::Strict(reason) => write!(f, "nothing written, because of --strict: {reason}"),
            Self::Internal(reason) => {
                write!(f, "internal error, please report it together with the scan: {reason}")
            }
            Self::Cancelled => write!(f, "cancelled, nothing written"),
        }
    }
}
