//! The archive of a 3MF: parts by name, unpacked within a budget.

use super::super::error::{ReadError, one_line};
use std::io::{BufReader, Cursor, Read};
use zip::ZipArchive;

/// Unpacked bytes per byte of the file. Deflate packs the XML of meshes 4 to 30 times; a bomb needs hundreds.
const LARGEST_RATIO: u64 = 200;
/// Unpacked bytes of the largest scan expected, 60 million triangles.
const LARGEST_UNPACKED: u64 = 2 << 30;
/// Bytes of a directory entry without its name.
const SMALLEST_ENTRY: u64 = 46;

/// Bytes that may still be unpacked, over all parts.
#[derive(Debug)]
pub(super) struct Budget {
    pub limit: u64,
    left: u64,
    exceeded: bool,
}

impl Budget {
    fn new(file_size: u64) -> Self {
        let limit = file_size.saturating_mul(LARGEST_RATIO).min(LARGEST_UNPACKED);
        Self { limit, left: limit, exceeded: false }
    }

    pub fn error(&self) -> ReadError {
        ReadError::Inflates { limit: self.limit }
    }
}

/// Counts what really comes out, whatever the archive declares.
struct Capped<'a, R> {
    inner: R,
    budget: &'a mut Budget,
}

impl<R: Read> Read for Capped<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let n = self.inner.read(buffer)?;
        let Some(left) = self.budget.left.checked_sub(n as u64) else {
            self.budget.exceeded = true;
            return Err(std::io::Error::other("unpacks to too much"));
        };
        self.budget.left = left;
        Ok(n)
    }
}

pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    pub budget: Budget,
}

impl<'a> Package<'a> {
    pub fn open(bytes: &'a [u8]) -> Result<Self, ReadError> {
        check_directory(bytes)?;
        let archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| archive_error(&error))?;
        Ok(Self { archive, budget: Budget::new(bytes.len() as u64) })
    }

    /// Name of the part `path` as the archive spells it; part names are compared without case.
    pub fn find(&self, path: &str) -> Option<String> {
        let wanted = path.trim_start_matches('/');
        let names = || self.archive.file_names().filter_map(Result::ok);
        names().find(|name| name.trim_start_matches('/').eq_ignore_ascii_case(wanted)).map(Into::into)
    }

    /// Name of the first part that is a model by its extension.
    pub fn first_model(&self) -> Option<String> {
        let mut names = self.archive.file_names().filter_map(Result::ok);
        names.find(|name| name.to_ascii_lowercase().ends_with(".model")).map(Into::into)
    }

    /// Unpacks the part `name` (as the archive spells it) into `parse`.
    pub fn read<T>(
        &mut self,
        name: &str,
        parse: impl FnOnce(&mut dyn std::io::BufRead) -> Result<T, ReadError>,
    ) -> Result<T, ReadError> {
        let inner = self.archive.by_name(name).map_err(|error| archive_error(&error))?;
        let parsed = parse(&mut BufReader::new(Capped { inner, budget: &mut self.budget }));
        if self.budget.exceeded { Err(self.budget.error()) } else { parsed }
    }
}

pub(super) fn archive_error(reason: &dyn std::fmt::Display) -> ReadError {
    ReadError::Archive { reason: one_line(reason) }
}

/// Refuses a directory of more entries than the file has room for, before the archive reader reserves space for them.
fn check_directory(bytes: &[u8]) -> Result<(), ReadError> {
    let find_last = |signature: &[u8]| bytes.windows(4).rposition(|window| window == signature);
    let number = |at: usize, size: usize| {
        let raw = bytes.get(at..at + size)?;
        Some(raw.iter().rev().fold(0_u64, |n, &b| n << 8 | u64::from(b)))
    };
    let Some(end) = find_last(b"PK\x05\x06") else {
        return Err(ReadError::Archive {
            reason: "its directory is missing; the file is cut off".to_owned(),
        });
    };
    let entries = number(end + 10, 2);
    let entries_64 = find_last(b"PK\x06\x06").and_then(|end| number(end + 32, 8));
    let possible = bytes.len() as u64 / SMALLEST_ENTRY;
    // 16 bits full mean that the 64-bit record counts.
    let declared = entries.filter(|n| *n != 0xFFFF).max(entries_64).unwrap_or(0);
    if declared <= possible {
        return Ok(());
    }
    let reason = format!("its directory declares {declared} entries, the file can hold {possible} at most");
    Err(ReadError::Archive { reason })
}
