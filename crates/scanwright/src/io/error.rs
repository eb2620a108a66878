use std::fmt;

/// Why a file was not read. One line each: where, what, and what would be right.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system did not give the file.
    #[error("cannot read {path}: {source}")]
    File {
        /// The file asked for.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// Nothing in the file.
    #[error("the file is empty; a triangle mesh (STL, PLY, OBJ, OFF or 3MF) is needed")]
    Empty,
    /// Neither content nor extension tell a format.
    #[error(
        "neither content nor extension tell a known format; a triangle mesh (STL, PLY, OBJ, OFF or 3MF) is needed"
    )]
    UnknownFormat,
    /// A readable file without triangles.
    #[error("{}; a triangle mesh is needed{}", no_triangles(*.n_points), mesh_first(*.n_points))]
    NoTriangles {
        /// Points that the file holds.
        n_points: usize,
    },
    /// The file ends too early.
    #[error("{place}: the file ends inside {element}; it is cut off or its counts are wrong")]
    Truncated {
        /// Where the element begins or the file ends.
        place: Place,
        /// What is incomplete.
        element: String,
    },
    /// More declared than the file can hold.
    #[error(
        "{place}: {declared} {element} declared, but what follows can hold {possible} at most; the file is cut off or the count is wrong"
    )]
    Count {
        /// Where the count stands.
        place: Place,
        /// What is counted.
        element: &'static str,
        /// The count read.
        declared: u64,
        /// What the remaining bytes can hold.
        possible: u64,
    },
    /// More data than declared.
    #[error("{place}: more data than the {element} declared; the count is wrong or the file is damaged")]
    Trailing {
        /// First byte or line too many.
        place: Place,
        /// What is counted.
        element: &'static str,
    },
    /// A value or word that does not belong where it stands.
    #[error("{place}: {element} is {value}, should be {expected}")]
    Value {
        /// Where it stands.
        place: Place,
        /// What it should describe.
        element: String,
        /// What was found, quoted.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
    /// A reference to a vertex that is not there.
    #[error("{place}: {element} refers to vertex {index}, should be {first} to {last}")]
    Index {
        /// Where it stands.
        place: Place,
        /// What refers.
        element: String,
        /// The index read.
        index: i64,
        /// Lowest valid index.
        first: i64,
        /// Highest valid index; below `first` when there are no vertices.
        last: i64,
    },
    /// A valid file of a kind that is not read.
    #[error("{place}: {what} cannot be read; {instead}")]
    Unsupported {
        /// Where it is declared.
        place: Place,
        /// What is not read.
        what: String,
        /// What to do instead.
        instead: &'static str,
    },
    /// A 3MF that is no proper archive or package.
    #[error("not a readable 3MF archive: {reason}")]
    Archive {
        /// What is wrong with it.
        reason: String,
    },
    /// A 3MF that unpacks to more than is allowed.
    #[error(
        "the 3MF unpacks to more than {limit} bytes, the most allowed for its size; it is damaged or made to exhaust memory"
    )]
    Inflates {
        /// Bytes allowed.
        limit: u64,
    },
    /// More elements than an index can number.
    #[error("more than {limit} {element}; split the scan")]
    TooMany {
        /// What there are too many of.
        element: &'static str,
        /// How many are possible.
        limit: u64,
    },
}

fn no_triangles(n_points: usize) -> String {
    match n_points {
        0 => "the file holds no triangles".to_owned(),
        n => format!("the file holds {n} points but no triangles"),
    }
}

fn mesh_first(n_points: usize) -> &'static str {
    if n_points == 0 {
        ""
    } else {
        ": mesh the points first, in the scanner's software or by Poisson reconstruction"
    }
}

/// A position in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// Line of a text file, from 1.
    Line(usize),
    /// Byte of a binary file, from 0.
    Byte(usize),
    /// Byte of a part of an archive, from 0.
    Part(String, u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Part(part, byte) => write!(f, "{part}, byte {byte}"),
        }
    }
}

/// A value as it may stand in a one-line message: quoted, escaped and cut. Hostile files hold words of megabytes.
pub(super) fn quoted(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    format!("'{}'", escaped(bytes, LONGEST))
}

/// Someone else's message as it may stand in ours.
pub(super) fn one_line(message: &dyn fmt::Display) -> String {
    const LONGEST: usize = 120;
    escaped(message.to_string().as_bytes(), LONGEST)
}

fn escaped(bytes: &[u8], longest: usize) -> String {
    let cut = &bytes[..bytes.len().min(longest)];
    let dots = if cut.len() < bytes.len() { "..." } else { "" };
    // The quotes inside need no escape, unlike control characters and what is no ASCII.
    let text = cut.escape_ascii().to_string().replace("\\'", "'").replace("\\\"", "\"");
    format!("{text}{dots}")
}
