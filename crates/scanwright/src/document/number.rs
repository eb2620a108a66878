//! Numbers for people, rounded to what is known of them.

/// Digits after the point beyond which nothing is written.
const MOST_DECIMALS: i32 = 12;
/// Sizes between which numbers are written without an exponent.
const PLAIN: std::ops::Range<f64> = 1e-4..1e9;
/// Significant digits of an uncertainty: the second keeps the rounding below a twentieth of it (JCGM 100:2008, 7.2.6).
const UNCERTAINTY_DIGITS: i32 = 2;
/// Significant digits of a value whose uncertainty is not known.
const VALUE_DIGITS: i32 = 5;
/// What stands for a number that is not known.
pub(super) const UNKNOWN: &str = "-";

/// A value and its expanded uncertainty `u95`, both rounded to the second significant digit of the latter.
pub(super) fn with_uncertainty(value: Option<f64>, u95: Option<f64>) -> (String, String) {
    let Some(u95) = u95.filter(|u| u.is_finite() && *u > 0.0) else {
        return (significant(value, VALUE_DIGITS), UNKNOWN.to_owned());
    };
    let place = place_of(u95);
    (at_place(value, place), at_place(Some(u95), place))
}

/// A value rounded to the second significant digit of an uncertainty.
pub(super) fn known_within(value: Option<f64>, uncertainty: Option<f64>) -> String {
    with_uncertainty(value, uncertainty).0
}

/// The power of ten of the last digit of an uncertainty.
fn place_of(u: f64) -> i32 {
    let place = u.log10().floor() as i32 + 1 - UNCERTAINTY_DIGITS;
    // Rounding may carry into one more digit: 0.0996 is 0.10.
    let unit = 10_f64.powi(place);
    if (u / unit).round() >= 10_f64.powi(UNCERTAINTY_DIGITS) { place + 1 } else { place }
}

fn at_place(value: Option<f64>, place: i32) -> String {
    let Some(value) = value.filter(|x| x.is_finite()) else { return UNKNOWN.to_owned() };
    if value != 0.0 && !PLAIN.contains(&value.abs()) && value.abs() >= PLAIN.end {
        return significant(Some(value), VALUE_DIGITS);
    }
    if place > 0 {
        let unit = 10_f64.powi(place);
        return plain(format!("{:.0}", (value / unit).round() * unit));
    }
    plain(format!("{value:.*}", (-place).min(MOST_DECIMALS) as usize))
}

/// A value with so many significant digits.
pub(super) fn significant(value: Option<f64>, digits: i32) -> String {
    let Some(value) = value.filter(|x| x.is_finite()) else { return UNKNOWN.to_owned() };
    if value == 0.0 {
        return "0".to_owned();
    }
    if !PLAIN.contains(&value.abs()) {
        return format!("{value:.*e}", (digits - 1).max(0) as usize);
    }
    // Rounding first: 9.996 with three digits is 10.0, not 10.00.
    let rounded = format!("{value:.*e}", (digits - 1).max(0) as usize).parse().unwrap_or(value);
    at_place(Some(rounded), f64::log10(rounded.abs()).floor() as i32 + 1 - digits)
}

/// Without the zeros that end a decimal fraction.
pub(super) fn trimmed(text: &str) -> String {
    if !text.contains('.') || text.contains('e') {
        return text.to_owned();
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Three significant digits: for what is only looked at.
pub(super) fn short(value: Option<f64>) -> String {
    significant(value, 3)
}

/// A number of standard uncertainties: a second decimal says nothing.
pub(super) fn deviations(z: Option<f64>) -> String {
    match z.filter(|z| z.is_finite()) {
        Some(z) if z.abs() < 1000.0 => format!("{:.1}", z.abs()),
        other => short(other.map(f64::abs)),
    }
}

/// Five significant digits, those before the point in groups of three.
pub(super) fn large(value: Option<f64>) -> String {
    let text = significant(value, VALUE_DIGITS);
    text.parse::<usize>().map_or(text, count)
}

/// A share as percent. What is not all is never written as 100.
pub(super) fn percent(share: Option<f64>) -> String {
    let Some(share) = share.filter(|x| x.is_finite()) else { return UNKNOWN.to_owned() };
    let text = format!("{:.1}", 100.0 * share);
    if text == "100.0" && share < 1.0 { "99.9".to_owned() } else { text }
}

/// Digits in groups of three.
pub(super) fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut grouped = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            grouped.push(' ');
        }
        grouped.push(digit);
    }
    grouped
}

/// A count in a table, for people and spreadsheets.
pub(super) fn plain_count(n: Option<usize>) -> String {
    n.map_or_else(|| UNKNOWN.to_owned(), |n| format!("{n}"))
}

/// A count with its noun, which takes an `s` but for one.
pub(super) fn counted(n: usize, noun: &str) -> String {
    format!("{} {noun}{}", count(n), if n == 1 { "" } else { "s" })
}

/// No zero with a sign.
fn plain(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_end_where_their_uncertainty_ends() {
        let cases = [
            (5.983_41, 0.012_2, "5.983", "0.012"),
            (5.983_41, 0.009_96, "5.983", "0.010"),
            (5.983_41, 0.0996, "5.98", "0.10"),
            (1234.5, 234.0, "1230", "230"),
            (-0.000_4, 0.02, "0.000", "0.020"),
            (12.0, 3.0, "12.0", "3.0"),
        ];
        for (value, u95, text, uncertainty) in cases {
            let expected = (text.to_owned(), uncertainty.to_owned());
            assert_eq!(with_uncertainty(Some(value), Some(u95)), expected, "{value} {u95}");
        }
    }

    #[test]
    fn what_is_not_known_is_a_dash_and_never_rounded_by_it() {
        assert_eq!(with_uncertainty(Some(5.983_412_3), None), ("5.9834".to_owned(), "-".to_owned()));
        assert_eq!(with_uncertainty(None, Some(0.1)), ("-".to_owned(), "0.10".to_owned()));
        assert_eq!(with_uncertainty(Some(f64::NAN), Some(f64::INFINITY)).0, "-");
    }

    #[test]
    fn sizes_of_every_order_stay_short() {
        for (value, text) in [
            (9.996, "10.0"),
            (0.012_34, "0.0123"),
            (1.5e300, "1.50e300"),
            (2e-9, "2.00e-9"),
            (7.7e-5, "7.70e-5"),
        ] {
            assert_eq!(short(Some(value)), text);
        }
        assert!(with_uncertainty(Some(1e300), Some(1e-300)).0.len() < 20);
        assert!(with_uncertainty(Some(1.0), Some(1e-300)).0.len() < 20);
    }

    #[test]
    fn a_hundred_percent_is_all() {
        assert_eq!(percent(Some(0.999_96)), "99.9");
        assert_eq!(percent(Some(1.0)), "100.0");
    }
}
