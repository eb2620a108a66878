//! The rows of a PLY file's body, whichever the encoding.

use super::super::error::{Place, ReadError, quoted};
use super::super::text::{Item, Lines, next_word, parse};
use super::header::{Element, Encoding, Header, Kind, Scalar};

/// A value as it is stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Number {
    Integer(i64),
    Real(f64),
}

impl Number {
    pub fn as_real(self) -> f64 {
        match self {
            Self::Integer(i) => i as f64,
            Self::Real(x) => x,
        }
    }
}

/// Reads values one after the other.
#[derive(Debug)]
pub(super) enum Body<'a> {
    Text { lines: Lines<'a>, row: &'a [u8] },
    Binary { bytes: &'a [u8], at: usize, big: bool },
}

impl<'a> Body<'a> {
    pub fn new(bytes: &'a [u8], header: &Header<'_>) -> Self {
        match header.encoding {
            Encoding::Ascii => {
                Self::Text { lines: Lines::new(&bytes[header.body_at..], header.n_lines), row: &[] }
            }
            encoding => Self::Binary { bytes, at: header.body_at, big: encoding == Encoding::BigEndian },
        }
    }

    pub fn place(&self) -> Place {
        match self {
            Self::Text { lines, .. } => lines.place(),
            Self::Binary { at, .. } => Place::Byte(*at),
        }
    }

    pub fn bytes_left(&self) -> usize {
        match self {
            Self::Text { lines, .. } => lines.bytes_left(),
            Self::Binary { bytes, at, .. } => bytes.len() - at,
        }
    }

    /// Refuses a count that the remaining bytes cannot hold.
    pub fn check_count(
        &self,
        element: &Element<'_>,
        encoding: Encoding,
        kind: &'static str,
    ) -> Result<(), ReadError> {
        // The last line of a text needs no end.
        let bytes_left = self.bytes_left() + usize::from(encoding == Encoding::Ascii);
        let Some(possible) = bytes_left.checked_div(element.smallest_row(encoding)) else { return Ok(()) };
        if element.count <= possible as u64 {
            return Ok(());
        }
        let (place, declared, possible) = (Place::Line(element.line), element.count, possible as u64);
        Err(ReadError::Count { place, element: kind, declared, possible })
    }

    pub fn start_row(&mut self, item: Item) -> Result<(), ReadError> {
        if let Self::Text { lines, row } = self {
            *row = lines
                .next_nonblank()
                .ok_or_else(|| ReadError::Truncated { place: lines.place(), element: item.to_string() })?;
        }
        Ok(())
    }

    pub fn end_row(&mut self, item: Item) -> Result<(), ReadError> {
        let Self::Text { lines, row } = self else { return Ok(()) };
        match next_word(row) {
            None => Ok(()),
            Some(word) => Err(ReadError::Value {
                place: lines.place(),
                element: format!("{item}, after its last property,"),
                value: quoted(word),
                expected: "nothing: the header declares no more properties",
            }),
        }
    }

    pub fn scalar(&mut self, scalar: Scalar, item: Item) -> Result<Number, ReadError> {
        match self {
            Self::Text { lines, row } => {
                let word = next_word(row);
                let number = word.and_then(|word| {
                    if scalar.is_integer() {
                        parse(word).map(Number::Integer)
                    } else {
                        parse(word).map(Number::Real)
                    }
                });
                number.ok_or_else(|| ReadError::Value {
                    place: lines.place(),
                    element: format!("a value of {item}"),
                    value: word.map_or_else(|| "missing".to_owned(), quoted),
                    expected: if scalar.is_integer() { "a whole number" } else { "a number" },
                })
            }
            Self::Binary { bytes, at, big } => {
                let size = scalar.size();
                let Some(raw) = bytes.get(*at..*at + size) else {
                    return Err(ReadError::Truncated { place: Place::Byte(*at), element: item.to_string() });
                };
                *at += size;
                Ok(decode(raw, scalar, *big))
            }
        }
    }

    /// Length of a list whose items are `of`; never more than the remaining bytes can hold.
    pub fn list_length(&mut self, count: Scalar, of: Scalar, item: Item) -> Result<usize, ReadError> {
        let place = self.place();
        let Number::Integer(length) = self.scalar(count, item)? else {
            unreachable!("the header admits integer list lengths only")
        };
        let possible = match self {
            // At least a separator and a digit each.
            Self::Text { row, .. } => row.len() / 2,
            Self::Binary { bytes, at, .. } => (bytes.len() - *at) / of.size(),
        };
        match usize::try_from(length) {
            Ok(length) if length <= possible => Ok(length),
            Ok(_) => {
                Err(ReadError::Truncated { place, element: format!("a list of {length} values of {item}") })
            }
            Err(_) => Err(ReadError::Value {
                place,
                element: format!("the length of a list of {item}"),
                value: length.to_string(),
                expected: "zero or more",
            }),
        }
    }

    /// Passes over a property.
    pub fn skip(&mut self, kind: Kind, item: Item) -> Result<(), ReadError> {
        let (scalar, n) = match kind {
            Kind::Scalar(scalar) => (scalar, 1),
            Kind::List { count, item: of } => (of, self.list_length(count, of, item)?),
        };
        for _ in 0..n {
            self.scalar(scalar, item)?;
        }
        Ok(())
    }

    /// Refuses anything but white space (and the zero bytes some writers pad with) after the last element.
    pub fn check_end(&self, last: &'static str) -> Result<(), ReadError> {
        let (rest, place) = match self {
            Self::Text { lines, .. } => {
                let mut ahead = lines.clone();
                (ahead.next_nonblank().unwrap_or_default(), ahead.place())
            }
            Self::Binary { bytes, at, .. } => (&bytes[*at..], Place::Byte(*at)),
        };
        if rest.iter().all(|&b| b.is_ascii_whitespace() || b == 0) {
            return Ok(());
        }
        Err(ReadError::Trailing { place, element: last })
    }
}

fn decode(raw: &[u8], scalar: Scalar, big: bool) -> Number {
    // To little endian, left-aligned in eight bytes.
    let mut bytes = [0; 8];
    for (i, &b) in raw.iter().enumerate() {
        bytes[if big { raw.len() - 1 - i } else { i }] = b;
    }
    let bits = u64::from_le_bytes(bytes);
    match scalar {
        Scalar::U8 | Scalar::U16 | Scalar::U32 => Number::Integer(bits as i64),
        Scalar::I8 => Number::Integer(i64::from(bits as u8 as i8)),
        Scalar::I16 => Number::Integer(i64::from(bits as u16 as i16)),
        Scalar::I32 => Number::Integer(i64::from(bits as u32 as i32)),
        Scalar::F32 => Number::Real(f64::from(f32::from_bits(bits as u32))),
        Scalar::F64 => Number::Real(f64::from_bits(bits)),
    }
}
