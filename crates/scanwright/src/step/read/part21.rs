//! The clear text of Part 21: where each entity stands, and its attributes when they are asked for.
//!
//! Only what the geometry refers to is parsed, so that odd text in notes and tolerances costs nothing. Entities are
//! found in one pass that knows strings and comments; ISO 10303-21:2016, sections 5 and 12.

use std::collections::BTreeMap;

use super::StepReadError;

/// Most levels of lists within lists; a model has three.
const DEEPEST: usize = 32;

/// The entities of a file.
#[derive(Debug)]
pub(in crate::step) struct Exchange<'a> {
    text: &'a [u8],
    places: BTreeMap<u64, Place>,
    by_type: BTreeMap<&'a str, Vec<u64>>,
}

/// Where an entity stands: its bytes behind the equals sign, without the semicolon.
#[derive(Debug, Clone, Copy)]
struct Place {
    start: usize,
    end: usize,
    line: usize,
}

/// An entity with its attributes: one leaf, or several in a complex instance.
#[derive(Debug, Clone)]
pub(in crate::step) struct Instance<'a> {
    pub(in crate::step) id: u64,
    pub(in crate::step) leaves: Vec<Leaf<'a>>,
}

/// One partial entity.
#[derive(Debug, Clone)]
pub(in crate::step) struct Leaf<'a> {
    pub(in crate::step) name: &'a str,
    values: Vec<Value<'a>>,
}

/// An attribute.
#[derive(Debug, Clone)]
pub(in crate::step) enum Value<'a> {
    /// `$` or `*`, and binary data.
    Omitted,
    Integer(i64),
    Real(f64),
    /// The bytes between the quotes.
    Text(&'a [u8]),
    Enumeration(&'a str),
    Reference(u64),
    List(Vec<Value<'a>>),
    /// `LENGTH_MEASURE(25.4)`.
    Typed(Box<Value<'a>>),
}

impl<'a> Exchange<'a> {
    pub(in crate::step) fn parse(text: &'a [u8]) -> Result<Self, StepReadError> {
        let mut scan = Scan { text, at: 0, line: 1 };
        scan.skip_blank()?;
        if !scan.rest().starts_with(b"ISO-10303-21") {
            return Err(StepReadError::NotStep);
        }
        let mut exchange = Self { text, places: BTreeMap::new(), by_type: BTreeMap::new() };
        let (mut in_data, mut has_data) = (false, false);
        loop {
            scan.skip_blank()?;
            if scan.at >= text.len() {
                // The very end is forgiven: some writers leave the last line out.
                if in_data || !has_data {
                    let element = if in_data { "the data section" } else { "the header" };
                    return Err(StepReadError::Truncated { line: scan.line, element: element.into() });
                }
                return Ok(exchange);
            }
            let (line, start) = (scan.line, scan.at);
            let in_entity = in_data && text[start] == b'#';
            let end = scan.statement(if in_entity { "an entity" } else { "a section" })?;
            let statement = &text[start..end];
            if in_entity {
                exchange.index(start, end, line)?;
            } else if statement.starts_with(b"DATA") {
                (in_data, has_data) = (true, true);
            } else if statement.starts_with(b"ENDSEC") {
                in_data = false;
            } else if statement.starts_with(b"END-ISO-10303-21") {
                return Ok(exchange);
            } else if in_data {
                let found = quote(statement);
                return Err(StepReadError::Syntax { line, found, expected: "an entity as in #1=NAME(...);" });
            }
        }
    }

    fn index(&mut self, start: usize, end: usize, line: usize) -> Result<(), StepReadError> {
        let bad = |found: &[u8]| StepReadError::Syntax {
            line,
            found: quote(found),
            expected: "an entity as in #1=NAME(...);",
        };
        let statement = &self.text[start..end];
        let digits = statement[1..].iter().take_while(|b| b.is_ascii_digit()).count();
        let id = parse_ascii::<u64>(&statement[1..=digits]).ok_or_else(|| bad(statement))?;
        let equals = statement[1 + digits..].iter().position(|b| !b.is_ascii_whitespace());
        let equals = equals.map(|i| i + 1 + digits).filter(|i| statement[*i] == b'=');
        let body = start + equals.ok_or_else(|| bad(statement))? + 1;
        let place = Place { start: body, end, line };
        if self.places.insert(id, place).is_some() {
            return Err(StepReadError::Twice { line, id });
        }
        let mut scan = Scan { text: &self.text[..end], at: body, line };
        scan.skip_blank()?;
        if scan.rest().first() == Some(&b'(') {
            // Complex: its names stand between its lists. A fault inside is told when the entity is needed.
            for leaf in self.get(id).map(|i| i.leaves).unwrap_or_default() {
                self.by_type.entry(leaf.name).or_default().push(id);
            }
        } else if let Some(name) = scan.keyword() {
            self.by_type.entry(name).or_default().push(id);
        }
        Ok(())
    }

    /// Numbers of the entities of a type, in the order of the file.
    pub(in crate::step) fn all(&self, name: &str) -> &[u64] {
        self.by_type.get(name).map_or(&[], Vec::as_slice)
    }

    /// All numbers, ascending.
    pub(in crate::step) fn ids(&self) -> impl Iterator<Item = u64> {
        self.places.keys().copied()
    }

    /// The names of all types that occur.
    pub(in crate::step) fn types(&self) -> impl Iterator<Item = &'a str> {
        self.by_type.keys().copied()
    }

    /// The text of an entity behind the equals sign.
    pub(in crate::step) fn body(&self, id: u64) -> Option<&'a [u8]> {
        self.places.get(&id).map(|place| &self.text[place.start..place.end])
    }

    pub(in crate::step) fn get(&self, id: u64) -> Result<Instance<'a>, StepReadError> {
        let place = *self.places.get(&id).ok_or(StepReadError::Missing(id))?;
        let mut scan = Scan { text: &self.text[..place.end], at: place.start, line: place.line };
        let leaves = scan.leaves()?;
        scan.skip_blank()?;
        if scan.rest().is_empty() {
            Ok(Instance { id, leaves })
        } else {
            Err(scan.unexpected("the end of the entity"))
        }
    }
}

impl<'a> Instance<'a> {
    /// Whether it is, or is partly, of this type.
    pub(in crate::step) fn is(&self, name: &str) -> bool {
        self.leaves.iter().any(|leaf| leaf.name == name)
    }

    /// Its type; of a complex instance, its leaves joined.
    pub(in crate::step) fn kind(&self) -> String {
        self.leaves.iter().map(|leaf| leaf.name).collect::<Vec<_>>().join("+")
    }

    /// The attributes of the leaf `name`. A simple instance lists those of its supertypes first: `n_inherited` of them.
    pub(in crate::step) fn fields(&self, name: &str, n_inherited: usize) -> Fields<'a, '_> {
        let values = match self.leaves.as_slice() {
            [one] => one.values.get(n_inherited..).unwrap_or(&[]),
            several => several.iter().find(|l| l.name == name).map_or(&[][..], |l| &l.values),
        };
        Fields { id: self.id, values }
    }

    /// All attributes of a simple instance.
    pub(in crate::step) fn all_fields(&self) -> Fields<'a, '_> {
        self.fields("", 0)
    }

    /// The name that every item of a representation has, decoded.
    pub(in crate::step) fn name(&self) -> String {
        let fields = self.fields("REPRESENTATION_ITEM", 0);
        fields.text(0).unwrap_or_default()
    }

    pub(in crate::step) fn unsupported(&self) -> StepReadError {
        StepReadError::Unsupported { id: self.id, kind: self.kind() }
    }

    /// An error about this entity.
    pub(in crate::step) fn wrong(&self, found: impl Into<String>, expected: &'static str) -> StepReadError {
        StepReadError::Entity { id: self.id, found: found.into(), expected }
    }
}

/// Attributes of an entity or a leaf of it, by position from 0.
#[derive(Debug, Clone, Copy)]
pub(in crate::step) struct Fields<'a, 'i> {
    id: u64,
    values: &'i [Value<'a>],
}

impl<'a, 'i> Fields<'a, 'i> {
    pub(in crate::step) fn get(&self, i: usize) -> Option<&'i Value<'a>> {
        self.values.get(i)
    }

    pub(in crate::step) fn len(&self) -> usize {
        self.values.len()
    }

    fn wrong(&self, i: usize, expected: &'static str) -> StepReadError {
        let found = match self.values.get(i) {
            None => format!("has {} attributes, number {}", self.values.len(), i + 1),
            Some(value) => format!("has {} as attribute {}", value.kind(), i + 1),
        };
        StepReadError::Entity { id: self.id, found, expected }
    }

    pub(in crate::step) fn real(&self, i: usize) -> Result<f64, StepReadError> {
        self.get(i).and_then(Value::real).ok_or_else(|| self.wrong(i, "a finite number"))
    }

    pub(in crate::step) fn count(&self, i: usize) -> Result<usize, StepReadError> {
        match self.get(i) {
            Some(Value::Integer(n)) if *n >= 0 => Ok(*n as usize),
            _ => Err(self.wrong(i, "a count")),
        }
    }

    pub(in crate::step) fn reference(&self, i: usize) -> Result<u64, StepReadError> {
        match self.get(i) {
            Some(Value::Reference(id)) => Ok(*id),
            _ => Err(self.wrong(i, "a reference")),
        }
    }

    /// A reference, or nothing where it is left out.
    pub(in crate::step) fn optional(&self, i: usize) -> Option<u64> {
        self.reference(i).ok()
    }

    pub(in crate::step) fn flag(&self, i: usize) -> Result<bool, StepReadError> {
        match self.get(i) {
            Some(Value::Enumeration("T" | "TRUE")) => Ok(true),
            Some(Value::Enumeration("F" | "FALSE")) => Ok(false),
            _ => Err(self.wrong(i, ".T. or .F.")),
        }
    }

    pub(in crate::step) fn word(&self, i: usize) -> Option<&'a str> {
        match self.get(i) {
            Some(Value::Enumeration(word)) => Some(word),
            _ => None,
        }
    }

    pub(in crate::step) fn text(&self, i: usize) -> Option<String> {
        match self.get(i) {
            Some(Value::Text(bytes)) => Some(super::text::decode(bytes)),
            _ => None,
        }
    }

    pub(in crate::step) fn list(&self, i: usize) -> Result<&'i [Value<'a>], StepReadError> {
        match self.get(i) {
            Some(Value::List(values)) => Ok(values),
            _ => Err(self.wrong(i, "a list")),
        }
    }

    pub(in crate::step) fn references(&self, i: usize) -> Result<Vec<u64>, StepReadError> {
        let list = self.list(i)?;
        list.iter()
            .map(|value| match value {
                Value::Reference(id) => Ok(*id),
                _ => Err(self.wrong(i, "a list of references")),
            })
            .collect()
    }

    pub(in crate::step) fn reals(&self, i: usize) -> Result<Vec<f64>, StepReadError> {
        let list = self.list(i)?;
        list.iter().map(|v| v.real().ok_or_else(|| self.wrong(i, "a list of finite numbers"))).collect()
    }

    pub(in crate::step) fn counts(&self, i: usize) -> Result<Vec<usize>, StepReadError> {
        let whole = |v: &Value| match v {
            Value::Integer(n) if *n >= 0 => Some(*n as usize),
            _ => None,
        };
        let list = self.list(i)?;
        list.iter().map(|v| whole(v).ok_or_else(|| self.wrong(i, "a list of counts"))).collect()
    }

    /// The rows of a list of lists.
    pub(in crate::step) fn rows(&self, i: usize) -> Result<Vec<Fields<'a, 'i>>, StepReadError> {
        let list = self.list(i)?;
        list.iter()
            .map(|value| match value {
                Value::List(values) => Ok(Fields { id: self.id, values }),
                _ => Err(self.wrong(i, "a list of lists")),
            })
            .collect()
    }

    /// All attributes as finite numbers.
    pub(in crate::step) fn as_reals(&self) -> Result<Vec<f64>, StepReadError> {
        (0..self.len()).map(|i| self.real(i)).collect()
    }

    /// All attributes as references.
    pub(in crate::step) fn as_references(&self) -> Result<Vec<u64>, StepReadError> {
        (0..self.len()).map(|i| self.reference(i)).collect()
    }
}

impl Value<'_> {
    fn real(&self) -> Option<f64> {
        match self {
            Self::Integer(n) => Some(*n as f64),
            Self::Real(x) => x.is_finite().then_some(*x),
            Self::Typed(inner) => inner.real(),
            _ => None,
        }
    }

    fn kind(&self) -> &'static str {
        match self {
            Self::Omitted => "nothing",
            Self::Integer(_) => "an integer",
            Self::Real(_) => "a real",
            Self::Text(_) => "a string",
            Self::Enumeration(_) => "an enumeration",
            Self::Reference(_) => "a reference",
            Self::List(_) => "a list",
            Self::Typed(_) => "a typed value",
        }
    }
}

/// A position in the text.
struct Scan<'a> {
    text: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Scan<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.text[self.at..]
    }

    fn advance(&mut self, n: usize) {
        self.line += self.rest()[..n].iter().map(|b| usize::from(*b == b'\n')).sum::<usize>();
        self.at += n;
    }

    fn unexpected(&self, expected: &'static str) -> StepReadError {
        StepReadError::Syntax { line: self.line, found: quote(self.rest()), expected }
    }

    /// Skips white space and comments.
    fn skip_blank(&mut self) -> Result<(), StepReadError> {
        loop {
            let n = self.rest().iter().take_while(|b| b.is_ascii_whitespace()).count();
            self.advance(n);
            if !self.rest().starts_with(b"/*") {
                return Ok(());
            }
            let Some(end) = self.rest().windows(2).skip(2).position(|w| w == b"*/") else {
                return Err(StepReadError::Truncated { line: self.line, element: "a comment".into() });
            };
            self.advance(end + 4);
        }
    }

    /// Skips to behind the next semicolon outside strings and comments; its position.
    fn statement(&mut self, element: &str) -> Result<usize, StepReadError> {
        let line = self.line;
        let cut = || StepReadError::Truncated { line, element: element.into() };
        loop {
            match self.rest().first() {
                None => return Err(cut()),
                Some(b';') => {
                    self.advance(1);
                    return Ok(self.at - 1);
                }
                Some(quote @ (b'\'' | b'"')) => {
                    let end = self.rest()[1..].iter().position(|b| b == quote).ok_or_else(cut)?;
                    self.advance(end + 2);
                }
                Some(b'/') if self.rest().starts_with(b"/*") => self.skip_blank()?,
                Some(_) => self.advance(1),
            }
        }
    }

    fn word(&mut self, belongs: impl Fn(u8) -> bool) -> &'a str {
        let n = self.rest().iter().take_while(|b| b.is_ascii() && belongs(**b)).count();
        let word = std::str::from_utf8(&self.rest()[..n]).expect("only ASCII was taken");
        self.at += n;
        word
    }

    fn keyword(&mut self) -> Option<&'a str> {
        let starts = self.rest().first().is_some_and(|b| b.is_ascii_alphabetic() || matches!(b, b'!' | b'_'));
        starts.then(|| self.word(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'!' | b'-')))
    }

    /// `NAME(...)`, or `(A(...)B(...))`.
    fn leaves(&mut self) -> Result<Vec<Leaf<'a>>, StepReadError> {
        self.skip_blank()?;
        if self.rest().first() != Some(&b'(') {
            return Ok(vec![self.leaf()?]);
        }
        self.advance(1);
        let mut leaves = Vec::new();
        loop {
            self.skip_blank()?;
            if self.rest().first() == Some(&b')') {
                self.advance(1);
                return Ok(leaves);
            }
            leaves.push(self.leaf()?);
        }
    }

    fn leaf(&mut self) -> Result<Leaf<'a>, StepReadError> {
        let name = self.keyword().ok_or_else(|| self.unexpected("the name of an entity"))?;
        self.skip_blank()?;
        if self.rest().first() != Some(&b'(') {
            return Err(self.unexpected("a list of attributes"));
        }
        Ok(Leaf { name, values: self.list(0)? })
    }

    /// The values between parentheses.
    fn list(&mut self, depth: usize) -> Result<Vec<Value<'a>>, StepReadError> {
        if depth > DEEPEST {
            return Err(self.unexpected("lists within lists to a depth of 32 at most"));
        }
        self.advance(1);
        let mut values = Vec::new();
        loop {
            self.skip_blank()?;
            match self.rest().first() {
                Some(b')') => {
                    self.advance(1);
                    return Ok(values);
                }
                Some(b',') if !values.is_empty() => {
                    self.advance(1);
                    values.push(self.value(depth)?);
                }
                Some(_) if values.is_empty() => values.push(self.value(depth)?),
                _ => return Err(self.unexpected("a comma or a closing parenthesis")),
            }
        }
    }

    fn value(&mut self, depth: usize) -> Result<Value<'a>, StepReadError> {
        self.skip_blank()?;
        let expected = "an attribute";
        match self.rest().first().copied() {
            Some(b'$' | b'*') => {
                self.advance(1);
                Ok(Value::Omitted)
            }
            Some(b'#') => {
                self.advance(1);
                let digits = self.word(|b| b.is_ascii_digit());
                digits.parse().map(Value::Reference).map_err(|_| self.unexpected("the number of an entity"))
            }
            Some(b'\'') => self.text().map(Value::Text),
            Some(b'"') => {
                let end = self.rest()[1..].iter().position(|b| *b == b'"');
                let end = end.ok_or_else(|| self.unexpected(expected))?;
                self.advance(end + 2);
                Ok(Value::Omitted)
            }
            Some(b'(') => self.list(depth + 1).map(Value::List),
            Some(b'.') if self.rest().get(1).is_some_and(|b| !b.is_ascii_digit()) => {
                self.advance(1);
                let word = self.word(|b| b.is_ascii_alphanumeric() || b == b'_');
                if self.rest().first() != Some(&b'.') {
                    return Err(self.unexpected("the closing point of an enumeration"));
                }
                self.advance(1);
                Ok(Value::Enumeration(word))
            }
            Some(b) if b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.') => self.number(),
            _ => {
                self.keyword().ok_or_else(|| self.unexpected(expected))?;
                self.skip_blank()?;
                if self.rest().first() != Some(&b'(') {
                    return Err(self.unexpected("the value of a typed attribute"));
                }
                let mut inner = self.list(depth + 1)?;
                let one = if inner.len() == 1 { inner.pop() } else { None };
                Ok(Value::Typed(Box::new(one.unwrap_or(Value::List(inner)))))
            }
        }
    }

    /// A string; two quotes in it stand for one.
    fn text(&mut self) -> Result<&'a [u8], StepReadError> {
        let start = self.at + 1;
        self.advance(1);
        loop {
            let Some(end) = self.rest().iter().position(|b| *b == b'\'') else {
                return Err(self.unexpected("the closing quote of a string"));
            };
            self.advance(end + 1);
            if self.rest().first() != Some(&b'\'') {
                return Ok(&self.text[start..self.at - 1]);
            }
            self.advance(1);
        }
    }

    fn number(&mut self) -> Result<Value<'a>, StepReadError> {
        let word = self.word(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.' | b'E' | b'e'));
        let digits = word.strip_prefix('+').unwrap_or(word);
        if let Ok(n) = digits.parse::<i64>() {
            return Ok(Value::Integer(n));
        }
        digits.parse().map(Value::Real).map_err(|_| StepReadError::Syntax {
            line: self.line,
            found: quote(word.as_bytes()),
            expected: "a number",
        })
    }
}

fn parse_ascii<T: std::str::FromStr>(bytes: &[u8]) -> Option<T> {
    std::str::from_utf8(bytes).ok()?.parse().ok()
}

/// The first characters of what is there, for a message.
fn quote(bytes: &[u8]) -> String {
    const MOST: usize = 24;
    if bytes.is_empty() {
        return "the entity ends".into();
    }
    let cut = &bytes[..bytes.len().min(MOST)];
    let shown: String = cut.iter().map(|b| if (32..127).contains(b) { *b as char } else { '?' }).collect();
    format!("\"{}\"{}", shown.trim_end(), if bytes.len() > MOST { "..." } else { "" })
}
