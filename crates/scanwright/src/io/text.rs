//! Lines, words and numbers of text files, from bytes that need not be text.

use super::error::{Place, ReadError, quoted};
use super::is_coordinate;

/// An element of a file in messages: "vertex 12".
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    pub kind: &'static str,
    pub index: usize,
}

impl std::fmt::Display for Item {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.kind, self.index)
    }
}

/// What is left of a text, line by line; line ends are LF, CR LF or CR.
#[derive(Debug, Clone)]
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    /// Number of the line last returned, from 1.
    pub number: usize,
}

impl<'a> Lines<'a> {
    /// The lines of `bytes`, without a byte order mark; `n_before` lines were read before.
    pub fn new(bytes: &'a [u8], n_before: usize) -> Self {
        Self { rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), number: n_before }
    }

    pub fn bytes_left(&self) -> usize {
        self.rest.len()
    }

    pub fn place(&self) -> Place {
        Place::Line(self.number.max(1))
    }

    /// The next line without its end.
    pub fn next_line(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(self.rest.len());
        let line = &self.rest[..end];
        let end_length = match &self.rest[end..] {
            [b'\r', b'\n', ..] => 2,
            [] => 0,
            _ => 1,
        };
        self.rest = &self.rest[end + end_length..];
        Some(line)
    }

    /// The next line with a word before any `#`, without the comment.
    pub fn next_uncommented(&mut self) -> Option<&'a [u8]> {
        loop {
            let line = self.next_line()?;
            let line = &line[..line.iter().position(|&b| b == b'#').unwrap_or(line.len())];
            if !line.trim_ascii().is_empty() {
                return Some(line);
            }
        }
    }

    /// The next line with a word.
    pub fn next_nonblank(&mut self) -> Option<&'a [u8]> {
        loop {
            let line = self.next_line()?;
            if !line.trim_ascii().is_empty() {
                return Some(line);
            }
        }
    }
}

/// Takes the next word off `line`.
pub(super) fn next_word<'a>(line: &mut &'a [u8]) -> Option<&'a [u8]> {
    let start = line.iter().position(|b| !b.is_ascii_whitespace())?;
    let tail = &line[start..];
    let end = tail.iter().position(u8::is_ascii_whitespace).unwrap_or(tail.len());
    let (word, rest) = tail.split_at(end);
    *line = rest;
    Some(word)
}

/// A number as text, if it is one.
pub(super) fn parse<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A coordinate that geometry can be done with.
pub(super) fn coordinate(
    word: Option<&[u8]>,
    axis: usize,
    item: Item,
    place: impl Fn() -> Place,
) -> Result<f64, ReadError> {
    match word.and_then(parse::<f64>) {
        Some(value) if is_coordinate(value) => Ok(value),
        _ => Err(bad_coordinate(word, axis, item, place())),
    }
}

/// The error about a coordinate; `word` is its text, `None` when the line ended before it.
#[cold]
pub(super) fn bad_coordinate(word: Option<&[u8]>, axis: usize, item: Item, place: Place) -> ReadError {
    ReadError::Value {
        place,
        element: format!("{} of {item}", ["x", "y", "z"][axis]),
        value: word.map_or_else(|| "missing".to_owned(), quoted),
        expected: "a finite number below 1e30",
    }
}

/// How many points a plain list of points holds: lines of three or more numbers, which a letter ("p") may announce,
/// after at most one line with a count. Zero if the file is anything else.
pub(super) fn count_points(bytes: &[u8]) -> usize {
    let mut lines = Lines::new(bytes, 0);
    let (mut n_points, mut n_counts) = (0, 0);
    while let Some(line) = lines.next_uncommented() {
        let mut words =
            line.split(|b| b.is_ascii_whitespace() || b",;".contains(b)).filter(|w| !w.is_empty()).peekable();
        let letter = words.next_if(|word| matches!(word, [b] if b.is_ascii_alphabetic()));
        let mut n_numbers = 0;
        for word in words {
            if parse::<f64>(word).is_none() {
                return 0;
            }
            n_numbers += 1;
        }
        match letter {
            None | Some(b"p" | b"v") if 3 <= n_numbers => n_points += 1,
            None => n_counts += 1,
            Some(_) => {}
        }
        if 1 < n_counts {
            return 0;
        }
    }
    n_points
}
