/// Why a STEP file was not read. One line each: where, what, and what would be right.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepReadError {
    /// The first words are not those of Part 21.
    #[error("not a STEP file: it should begin with ISO-10303-21;")]
    NotStep,
    /// The text breaks the rules of Part 21.
    #[error("line {line}: {found}, should be {expected}")]
    Syntax {
        /// Line of the file, from 1.
        line: usize,
        /// What is there.
        found: String,
        /// What would be right.
        expected: &'static str,
    },
    /// A file that ends too early.
    #[error("line {line}: the file ends inside {element}; it is cut off")]
    Truncated {
        /// Line where the element begins.
        line: usize,
        /// What is incomplete.
        element: String,
    },
    /// One number for two entities.
    #[error("line {line}: #{id} is defined a second time")]
    Twice {
        /// Line of the second definition.
        line: usize,
        /// The number.
        id: u64,
    },
    /// An entity that is referred to and does not exist.
    #[error("#{0} is referred to and not defined")]
    Missing(u64),
    /// An entity that does not say what it should.
    #[error("#{id} {found}, should be {expected}")]
    Entity {
        /// Number of the entity.
        id: u64,
        /// What it is or has.
        found: String,
        /// What would be right.
        expected: &'static str,
    },
    /// An entity of a kind that is not read.
    #[error("#{id} is {kind}, which is not supported")]
    Unsupported {
        /// Number of the entity.
        id: u64,
        /// Its name in the schema.
        kind: String,
    },
    /// Entities that refer to themselves, or more deeply than any model does.
    #[error("#{0} refers to itself, or to others more deeply than any model does")]
    Cycle(u64),
    /// A face whose border cannot be laid out on its surface.
    #[error("#{id}: {reason}")]
    Face {
        /// Number of the face.
        id: u64,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A file that stands for more than can be held.
    #[error("#{id}: the file stands for more than {most} {what}")]
    TooLarge {
        /// Entity at which the limit was met.
        id: u64,
        /// The limit.
        most: usize,
        /// What is counted.
        what: &'static str,
    },
    /// No face at all.
    #[error("the file has no face that can be read{}", .first.as_ref().map(|f| format!(": {f}")).unwrap_or_default())]
    NoFaces {
        /// The first reason, when there is one.
        first: Option<String>,
    },
}
