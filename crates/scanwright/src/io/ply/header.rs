//! The header of a PLY file: encoding, elements and their properties.

use super::super::error::{Place, ReadError, quoted};
use super::super::text::{Lines, next_word, parse};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A scalar type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Debug, Clone)]
pub(super) struct Property<'a> {
    pub name: &'a [u8],
    pub kind: Kind,
}

#[derive(Debug, Clone)]
pub(super) struct Element<'a> {
    pub name: &'a [u8],
    pub count: u64,
    /// Line of the header.
    pub line: usize,
    pub properties: Vec<Property<'a>>,
}

impl Element<'_> {
    /// Fewest bytes that one row takes: empty lists in binary, one digit and a separator per value in text.
    pub fn smallest_row(&self, encoding: Encoding) -> usize {
        if encoding == Encoding::Ascii {
            return 2 * self.properties.len();
        }
        let sizes = self.properties.iter().map(|property| match property.kind {
            Kind::Scalar(scalar) => scalar.size(),
            Kind::List { count, .. } => count.size(),
        });
        sizes.sum()
    }

    pub fn property(&self, name: &[u8]) -> Option<usize> {
        self.properties.iter().position(|property| property.name == name)
    }
}

#[derive(Debug, Clone)]
pub(super) struct Header<'a> {
    pub encoding: Encoding,
    pub elements: Vec<Element<'a>>,
    /// First byte after the header.
    pub body_at: usize,
    pub n_lines: usize,
}

impl<'a> Header<'a> {
    pub fn read(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let mut lines = Lines::new(bytes, 0);
        match lines.next_line() {
            Some(line) if line.trim_ascii() == b"ply" => {}
            line => return Err(value(&lines, "the first line", line.unwrap_or_default(), "'ply'")),
        }
        let mut encoding = None;
        let mut elements: Vec<Element<'a>> = Vec::new();
        while let Some(line) = lines.next_line() {
            let mut rest = line;
            match next_word(&mut rest) {
                Some(b"format") => encoding = Some(read_format(&mut rest, &lines)?),
                Some(b"element") => elements.push(read_element(&mut rest, &lines)?),
                Some(b"property") => {
                    let property = read_property(&mut rest, &lines)?;
                    let Some(element) = elements.last_mut() else {
                        return Err(value(
                            &lines,
                            "the keyword",
                            b"property",
                            "'element' before any 'property'",
                        ));
                    };
                    element.properties.push(property);
                }
                Some(b"end_header") => {
                    let Some(encoding) = encoding else {
                        return Err(value(
                            &lines,
                            "the keyword",
                            b"end_header",
                            "'format' before 'end_header'",
                        ));
                    };
                    let body_at = bytes.len() - lines.bytes_left();
                    return Ok(Self { encoding, elements, body_at, n_lines: lines.number });
                }
                Some(b"comment" | b"obj_info") | None => {}
                Some(word) => {
                    let expected = "'format', 'comment', 'element', 'property' or 'end_header'";
                    return Err(value(&lines, "the keyword", word, expected));
                }
            }
        }
        Err(ReadError::Truncated {
            place: lines.place(),
            element: "the header, before 'end_header'".to_owned(),
        })
    }
}

fn read_format(rest: &mut &[u8], lines: &Lines<'_>) -> Result<Encoding, ReadError> {
    match next_word(rest) {
        Some(b"ascii") => Ok(Encoding::Ascii),
        Some(b"binary_little_endian") => Ok(Encoding::LittleEndian),
        Some(b"binary_big_endian") => Ok(Encoding::BigEndian),
        word => {
            let expected = "'ascii', 'binary_little_endian' or 'binary_big_endian'";
            Err(value(lines, "the format", word.unwrap_or_default(), expected))
        }
    }
}

fn read_element<'a>(rest: &mut &'a [u8], lines: &Lines<'_>) -> Result<Element<'a>, ReadError> {
    let name = next_word(rest).unwrap_or_default();
    let word = next_word(rest).unwrap_or_default();
    let Some(count) = parse(word) else {
        let element = format!("the count of element {}", quoted(name));
        return Err(value(lines, &element, word, "a whole number, not negative"));
    };
    Ok(Element { name, count, line: lines.number, properties: Vec::new() })
}

fn read_property<'a>(rest: &mut &'a [u8], lines: &Lines<'_>) -> Result<Property<'a>, ReadError> {
    let scalar = |word: Option<&[u8]>| {
        let word = word.unwrap_or_default();
        let expected = "char, uchar, short, ushort, int, uint, float or double";
        Scalar::from_name(word).ok_or_else(|| value(lines, "the property's type", word, expected))
    };
    let kind = match next_word(rest) {
        Some(b"list") => {
            let count = scalar(next_word(rest))?;
            if !count.is_integer() {
                return Err(value(lines, "the type of a list's length", b"float", "an integer type"));
            }
            Kind::List { count, item: scalar(next_word(rest))? }
        }
        word => Kind::Scalar(scalar(word)?),
    };
    match next_word(rest) {
        Some(name) => Ok(Property { name, kind }),
        None => Err(value(lines, "the property's name", b"", "a word")),
    }
}

fn value(lines: &Lines<'_>, element: &str, value: &[u8], expected: &'static str) -> ReadError {
    ReadError::Value {
        place: Place::Line(lines.number),
        element: element.to_owned(),
        value: quoted(value),
        expected,
    }
}
