//! Designations as people order bearings: a bearing of the catalogue, suffixes and a maker's prefix, such as `6206-2RS/C3` or `HCB7008C`.

use super::catalogue::{self, CatalogueBearing};
use super::clearance::ClearanceGroup;

/// A designation that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Designation {
    pub bearing: &'static CatalogueBearing,
    pub suffixes: Vec<Suffix>,
}

/// A suffix, with its usual text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Suffix {
    /// Rubbing seals of rubber; their friction is omitted.
    Seals(&'static str),
    /// Shields without contact, or seals without contact.
    Shields(&'static str),
    Clearance(ClearanceGroup),
    /// Tolerance class of dimensions and running accuracy; without effect on the ideal geometry.
    Tolerance(&'static str),
    /// Balls of silicon nitride.
    Hybrid(&'static str),
    /// Design of an angular-contact bearing with balls of the usual size, which is that of the catalogue.
    Design(&'static str),
    /// Cage of a material; the cage is that of the catalogue nevertheless.
    Cage(&'static str),
}

/// Why a designation cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum UnknownDesignation {
    /// No bearing of the catalogue; those with a similar designation.
    Bearing { similar: Vec<&'static str> },
    /// The bearing is known, the rest is no suffix.
    Suffix { bearing: &'static str, rest: String },
    /// Two clearance groups.
    TwoGroups { bearing: &'static str },
    /// Two bearings that face each other.
    Arrangement { bearing: &'static str, arrangement: &'static str },
}

/// Suffixes, longer ones before those that they begin with. Makers' names of the same seal stand together.
const SUFFIXES: [Suffix; 50] = [
    Suffix::Seals("2RS1"),
    Suffix::Seals("2RSH"),
    Suffix::Seals("2RSR"),
    Suffix::Seals("2RS"),
    Suffix::Seals("DDU"),
    Suffix::Seals("LLU"),
    Suffix::Seals("2RU"),
    Suffix::Seals("RS1"),
    Suffix::Seals("RSH"),
    Suffix::Seals("RSR"),
    Suffix::Seals("RS"),
    Suffix::Seals("DU"),
    Suffix::Seals("LU"),
    Suffix::Shields("2RZ"),
    Suffix::Shields("LLB"),
    Suffix::Shields("VV"),
    Suffix::Shields("2ZR"),
    Suffix::Shields("2Z"),
    Suffix::Shields("ZZ"),
    Suffix::Shields("RZ"),
    Suffix::Shields("Z"),
    Suffix::Clearance(ClearanceGroup::Mc1),
    Suffix::Clearance(ClearanceGroup::Mc2),
    Suffix::Clearance(ClearanceGroup::Mc3),
    Suffix::Clearance(ClearanceGroup::Mc4),
    Suffix::Clearance(ClearanceGroup::Mc5),
    Suffix::Clearance(ClearanceGroup::Mc6),
    Suffix::Clearance(ClearanceGroup::C2),
    Suffix::Clearance(ClearanceGroup::Cn),
    Suffix::Clearance(ClearanceGroup::C3),
    Suffix::Clearance(ClearanceGroup::C4),
    Suffix::Clearance(ClearanceGroup::C5),
    Suffix::Tolerance("ABEC1"),
    Suffix::Tolerance("ABEC3"),
    Suffix::Tolerance("ABEC5"),
    Suffix::Tolerance("ABEC7"),
    Suffix::Tolerance("P0"),
    Suffix::Tolerance("P6"),
    Suffix::Tolerance("P5"),
    Suffix::Tolerance("P4A"),
    Suffix::Tolerance("P4S"),
    Suffix::Tolerance("P4"),
    Suffix::Tolerance("P2"),
    Suffix::Hybrid("HC5"),
    Suffix::Hybrid("HC"),
    Suffix::Design("D"),
    Suffix::Cage("TN9"),
    Suffix::Cage("TVP"),
    Suffix::Cage("TPA"),
    Suffix::Cage("T"),
];

/// Prefixes of makers, longer ones first.
const PREFIXES: [Suffix; 3] = [Suffix::Hybrid("HCB"), Suffix::Hybrid("HC"), Suffix::Design("B")];

/// Arrangements of two bearings, and letters of the preload that may follow.
const ARRANGEMENTS: [&str; 3] = ["DB", "DF", "DT"];
const PRELOADS: [char; 3] = ['L', 'M', 'H'];

/// Characters between designation and suffixes.
const SEPARATORS: [char; 5] = [' ', '-', '/', '.', ','];
/// Longest designation that is read [characters].
const LONGEST: usize = 40;
/// Number of similar designations in an error, and the largest number of changed characters.
const MOST_SIMILAR: usize = 5;
const MOST_CHANGES: usize = 2;

impl Designation {
    /// Reads a designation; case and separators do not matter.
    pub fn read(text: &str) -> Result<Self, UnknownDesignation> {
        let text = text.trim().to_ascii_uppercase();
        let unknown = || UnknownDesignation::Bearing { similar: similar(&text) };
        if text.chars().count() > LONGEST {
            return Err(UnknownDesignation::Bearing { similar: Vec::new() });
        }
        let prefixed = PREFIXES.iter().find_map(|prefix| Some((*prefix, text.strip_prefix(prefix.text())?)));
        let (mut suffixes, bare) = prefixed.map_or((Vec::new(), text.as_str()), |(prefix, bare)| (vec![prefix], bare));
        let bare = bare.trim_start_matches(SEPARATORS);
        let known = catalogue::bearings().iter();
        let known = known.filter_map(|bearing| Some((bearing, after(bearing.designation, bare)?)));
        let longest = known.max_by_key(|(bearing, _)| bearing.designation.len());
        let (bearing, mut rest) = longest.ok_or_else(unknown)?;
        // Letters of designs follow or precede those of a contact angle.
        let fits = |suffix: &Suffix| !matches!(suffix, Suffix::Design(_)) || bearing.designation.ends_with('C');
        if !suffixes.iter().all(fits) {
            return Err(unknown());
        }
        loop {
            rest = rest.trim_start_matches(SEPARATORS);
            if rest.is_empty() {
                break;
            }
            if let Some(arrangement) = arrangement(rest) {
                return Err(UnknownDesignation::Arrangement { bearing: bearing.designation, arrangement });
            }
            let found = SUFFIXES
                .iter()
                .filter(|suffix| fits(suffix))
                .find_map(|suffix| Some((suffix, rest.strip_prefix(suffix.text())?)));
            let Some((suffix, after)) = found else {
                // `62066` is no 6206 with a suffix.
                let is_longer = bare.len() == bearing.designation.len() + rest.len();
                return Err(if is_longer && rest.starts_with(|c: char| c.is_ascii_digit()) {
                    unknown()
                } else {
                    UnknownDesignation::Suffix { bearing: bearing.designation, rest: rest.to_owned() }
                });
            };
            suffixes.push(*suffix);
            rest = after;
        }
        let groups = suffixes.iter().filter(|suffix| matches!(suffix, Suffix::Clearance(_))).count();
        if groups > 1 {
            return Err(UnknownDesignation::TwoGroups { bearing: bearing.designation });
        }
        Ok(Self { bearing, suffixes })
    }

    /// The clearance group that a suffix names.
    pub fn clearance_group(&self) -> Option<ClearanceGroup> {
        self.suffixes.iter().find_map(|suffix| match suffix {
            Suffix::Clearance(group) => Some(*group),
            _ => None,
        })
    }

    /// True if the balls are of silicon nitride.
    pub fn is_hybrid(&self) -> bool {
        self.suffixes.iter().any(|suffix| matches!(suffix, Suffix::Hybrid(_)))
    }
}

impl Suffix {
    /// The text of the designation.
    pub fn text(self) -> &'static str {
        match self {
            Self::Seals(text)
            | Self::Shields(text)
            | Self::Tolerance(text)
            | Self::Hybrid(text)
            | Self::Design(text)
            | Self::Cage(text) => text,
            Self::Clearance(group) => group.name(),
        }
    }

    /// All suffixes.
    pub fn all() -> impl Iterator<Item = &'static str> {
        SUFFIXES.iter().map(|suffix| suffix.text())
    }
}

/// The rest of a text after a designation, which may have separators before the letters of the contact angle: `7008-C`.
fn after<'t>(designation: &str, text: &'t str) -> Option<&'t str> {
    designation.chars().try_fold(text, |rest, next| {
        let rest = if next.is_ascii_alphabetic() { rest.trim_start_matches(SEPARATORS) } else { rest };
        rest.strip_prefix(next)
    })
}

/// Designations that differ in few characters: first those that continue the text, then the nearest.
fn similar(text: &str) -> Vec<&'static str> {
    let mut near: Vec<((bool, usize), &'static str)> = catalogue::bearings()
        .iter()
        .map(|bearing| {
            let continues = !text.is_empty() && bearing.designation.starts_with(text);
            ((!continues, changes(text, bearing.designation)), bearing.designation)
        })
        .filter(|((_, changes), _)| *changes <= MOST_CHANGES)
        .collect();
    near.sort_by_key(|(order, _)| *order);
    near.into_iter().take(MOST_SIMILAR).map(|(_, designation)| designation).collect()
}

/// Number of inserted, removed and replaced characters between two texts (Levenshtein).
fn changes(one: &str, other: &str) -> usize {
    let other: Vec<char> = other.chars().collect();
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (i, a) in one.chars().enumerate() {
        let mut before = i;
        let mut left = i + 1;
        for (place, b) in row.iter_mut().skip(1).zip(&other) {
            let replaced = before + usize::from(a != *b);
            before = *place;
            left = replaced.min(before + 1).min(left + 1);
            *place = left;
        }
        if let Some(first) = row.first_mut() {
            *first = i + 1;
        }
    }
    row.last().copied().unwrap_or_default()
}

/// The arrangement that a text begins with as a whole word.
fn arrangement(text: &str) -> Option<&'static str> {
    let is_word = |rest: &str| rest.strip_prefix(PRELOADS).unwrap_or(rest).trim_start_matches(SEPARATORS).is_empty();
    ARRANGEMENTS.into_iter().find(|arrangement| text.strip_prefix(arrangement).is_some_and(is_word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (&'static str, Vec<&'static str>) {
        let read = Designation::read(text).unwrap_or_else(|error| panic!("{text}: {error:?}"));
        (read.bearing.designation, read.suffixes.iter().map(|suffix| suffix.text()).collect())
    }

    #[test]
    fn suffixes_are_read() {
        assert_eq!(read("6206-2RS/C3"), ("6206", vec!["2RS", "C3"]));
        assert_eq!(read("6206 zz c3"), ("6206", vec!["ZZ", "C3"]));
        assert_eq!(read("62062RS1C4"), ("6206", vec!["2RS1", "C4"]));
        assert_eq!(read("62/28-2Z"), ("62/28", vec!["2Z"]));
        assert_eq!(read("7008C/P4"), ("7008C", vec!["P4"]));
        assert_eq!(read("71805AC"), ("71805AC", vec![]));
        assert_eq!(read("608ZZMC3"), ("608", vec!["ZZ", "MC3"]));
        assert_eq!(read("HCB7008-C/P4A"), ("7008C", vec!["HCB", "P4A"]));
        assert_eq!(read("7008C HC P4"), ("7008C", vec!["HC", "P4"]));
        assert_eq!(read("7008 CD/P4A"), ("7008C", vec!["D", "P4A"]));
        assert_eq!(read("71805 ACD/HCP4A"), ("71805AC", vec!["D", "HC", "P4A"]));
        assert_eq!(read("B7008-C-T-P4S"), ("7008C", vec!["B", "T", "P4S"]));
        assert_eq!(read("6206-2Z/C3TN9"), ("6206", vec!["2Z", "C3", "TN9"]));
        assert_eq!(read("6205-2RS/HC5C3"), ("6205", vec!["2RS", "HC5", "C3"]));
        assert_eq!(Designation::read("6205/C3").unwrap().clearance_group(), Some(ClearanceGroup::C3));
        assert!(Designation::read("HC7008C").unwrap().is_hybrid() && !Designation::read("7008C").unwrap().is_hybrid());
        for bearing in catalogue::bearings() {
            assert_eq!(read(bearing.designation), (bearing.designation, vec![]));
            assert_eq!(read(&format!("{}-ZZ", bearing.designation)), (bearing.designation, vec!["ZZ"]));
        }
    }

    #[test]
    fn unknown_designations_name_similar_ones() {
        let similar = |text: &str| match Designation::read(text) {
            Err(UnknownDesignation::Bearing { similar }) => similar,
            other => panic!("{other:?}"),
        };
        assert_eq!(similar("7206")[..3], ["7206A", "7206B", "7206C"]);
        assert!(similar("62066").contains(&"6206"));
        assert!(similar("bearing").is_empty() && similar("").is_empty());
        assert!(similar(&"6".repeat(1000)).is_empty() && similar("µ6205").contains(&"6205"));
    }

    #[test]
    fn unknown_suffixes_are_named() {
        let suffix = UnknownDesignation::Suffix { bearing: "6206", rest: "NR".to_owned() };
        assert_eq!(Designation::read("6206-NR"), Err(suffix));
        let design = UnknownDesignation::Suffix { bearing: "6206", rest: "D".to_owned() };
        assert_eq!(Designation::read("6206D"), Err(design));
        assert!(matches!(Designation::read("B6206"), Err(UnknownDesignation::Bearing { .. })));
        for (name, arrangement) in [("7008C DB", "DB"), ("7008CDT", "DT"), ("B7008-C-T-P4S-DFL", "DF")] {
            let pair = UnknownDesignation::Arrangement { bearing: "7008C", arrangement };
            assert_eq!(Designation::read(name), Err(pair), "{name}");
        }
        assert!(Designation::read("7008 CDTN9").is_ok());
        assert_eq!(Designation::read("6206C3C4"), Err(UnknownDesignation::TwoGroups { bearing: "6206" }));
    }

    /// A suffix is found before a shorter one that it begins with.
    #[test]
    fn longer_suffixes_come_first() {
        for (place, suffix) in SUFFIXES.iter().enumerate() {
            let earlier = SUFFIXES[..place].iter().find(|other| suffix.text().starts_with(other.text()));
            assert_eq!(earlier, None, "{suffix:?}");
        }
    }

    #[test]
    fn changes_are_counted() {
        assert_eq!([changes("", "abc"), changes("abc", "abc"), changes("6205", "6250")], [3, 0, 2]);
        assert_eq!([changes("7206", "7206C"), changes("kitten", "sitting")], [1, 3]);
    }
}
