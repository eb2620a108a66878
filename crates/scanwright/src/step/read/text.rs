//! Strings of Part 21.

/// The text between the quotes with its escapes undone: doubled quotes and backslashes, `\S\`, `\X\`, `\X2\`, `\X4\`.
/// Bytes beyond ASCII are UTF-8 where they form it, Latin-1 otherwise; an escape that makes no sense stays as it is.
pub(super) fn decode(bytes: &[u8]) -> String {
    let raw = std::str::from_utf8(bytes)
        .map_or_else(|_| bytes.iter().map(|b| char::from(*b)).collect(), str::to_owned);
    let mut out = String::with_capacity(raw.len());
    let mut rest = raw.as_str();
    while let Some(first) = rest.chars().next() {
        let (text, used) = match first {
            '\'' if rest.starts_with("''") => ("'".to_owned(), 2),
            '\\' => escape(rest).unwrap_or_else(|| ("\\".to_owned(), 1)),
            other => (other.to_string(), other.len_utf8()),
        };
        out.push_str(&text);
        rest = &rest[used..];
    }
    out
}

/// The text of the escape at the start of `rest`, and its length in bytes.
fn escape(rest: &str) -> Option<(String, usize)> {
    if rest.starts_with("\\\\") {
        return Some(("\\".to_owned(), 2));
    }
    if let Some(tail) = rest.strip_prefix("\\S\\") {
        let c = tail.chars().next().filter(char::is_ascii)?;
        return Some((char::from(c as u8 + 128).to_string(), 4));
    }
    if let Some(tail) = rest.strip_prefix("\\X\\") {
        let code = u8::from_str_radix(tail.get(..2)?, 16).ok()?;
        return Some((char::from(code).to_string(), 5));
    }
    if rest.starts_with("\\P") && rest.get(3..4) == Some("\\") {
        return Some((String::new(), 4));
    }
    let (tail, width) = match rest.strip_prefix("\\X2\\") {
        Some(tail) => (tail, 4),
        None => (rest.strip_prefix("\\X4\\")?, 8),
    };
    let end = tail.find("\\X0\\")?;
    let digits = tail.get(..end).filter(|d| d.is_ascii() && d.len().is_multiple_of(width))?;
    let codes: Option<Vec<u32>> = (0..digits.len() / width)
        .map(|i| u32::from_str_radix(&digits[i * width..(i + 1) * width], 16).ok())
        .collect();
    let text = if width == 4 {
        let units: Vec<u16> = codes?.iter().map(|c| *c as u16).collect();
        String::from_utf16_lossy(&units)
    } else {
        codes?.iter().map(|c| char::from_u32(*c).unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
    };
    Some((text, 4 + end + 4))
}

#[cfg(test)]
mod tests {
    use super::decode;

    #[test]
    fn escapes_are_undone_and_broken_ones_stay() {
        for (raw, text) in [
            ("it''s", "it's"),
            ("a\\\\b", "a\\b"),
            ("Tr\\X2\\00E4\\X0\\ger", "Träger"),
            ("\\X2\\D83DDE00\\X0\\", "😀"),
            ("\\X4\\0001F600\\X0\\", "😀"),
            ("\\X\\E9t\\X\\E9", "été"),
            ("\\S\\d", "ä"),
            ("\\X2\\00E", "\\X2\\00E"),
            ("\\", "\\"),
        ] {
            assert_eq!(decode(raw.as_bytes()), text, "{raw}");
        }
        assert_eq!(decode(&[b'T', 0xE4]), "Tä");
        assert_eq!(decode("Tä".as_bytes()), "Tä");
    }
}
