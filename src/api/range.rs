//! Ranges of bytes (RFC 9110, 14.1.2).

use std::ops::Range;

/// The bytes that a client asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Requested {
    Whole,
    Part(Range<u64>),
    Unsatisfiable,
}

/// The bytes that `Range` asks for of a body of `length` bytes. Other units, several ranges and invalid ones ask for the whole body.
pub fn requested(range: &str, length: u64) -> Requested {
    parsed(range, length).unwrap_or(Requested::Whole)
}

fn parsed(range: &str, length: u64) -> Option<Requested> {
    let (unit, range) = range.split_once('=')?;
    if !unit.trim().eq_ignore_ascii_case("bytes") || range.contains(',') {
        return None;
    }
    let number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse::<u64>().ok())?;
    let bytes = match range.trim().split_once('-')? {
        ("", last) => length.saturating_sub(number(last)?)..length,
        (first, "") => number(first)?..length,
        (first, last) => {
            let (first, last) = (number(first)?, number(last)?);
            if last < first {
                return None;
            }
            first..last.saturating_add(1).min(length)
        }
    };
    Some(if bytes.is_empty() { Requested::Unsatisfiable } else { Requested::Part(bytes) })
}

#[cfg(test)]
mod tests {
    use super::Requested::{Part, Unsatisfiable, Whole};
    use super::*;

    #[test]
    fn ranges_are_those_of_the_standard() {
        for (range, expected) in [
            ("bytes=0-9", Part(0..10)),
            ("bytes=10-", Part(10..100)),
            ("bytes=-10", Part(90..100)),
            ("bytes=-1000", Part(0..100)),
            ("bytes=90-1000", Part(90..100)),
            ("Bytes=99-99", Part(99..100)),
            ("bytes=100-", Unsatisfiable),
            ("bytes=100-200", Unsatisfiable),
            ("bytes=-0", Unsatisfiable),
            ("bytes=0-1,5-6", Whole),
            ("bytes=9-8", Whole),
            ("bytes=+1-8", Whole),
            ("bytes=a-8", Whole),
            ("bytes=-", Whole),
            ("bytes=", Whole),
            ("lines=0-9", Whole),
            ("bytes=0-99999999999999999999", Whole),
        ] {
            assert_eq!(requested(range, 100), expected, "{range}");
        }
    }
}
