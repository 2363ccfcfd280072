//! Uploaded series that a request names by their content hash.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use raceway_core::physics::samples::Samples;

/// Length of a content hash: SHA-256 in hexadecimal digits.
const HASH_LENGTH: usize = 64;

/// The series that a request may name.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Uploads {
    known: BTreeMap<String, Arc<Samples>>,
    /// Stands in for series that are not known.
    stand_in: Option<Arc<Samples>>,
}

impl Uploads {
    pub fn new(known: BTreeMap<String, Arc<Samples>>) -> Self {
        Self { known, stand_in: None }
    }

    /// For requests that are read again and not run: their series may be gone.
    pub fn stand_in() -> Self {
        Self { known: BTreeMap::new(), stand_in: Samples::new(1000.0, vec![0.0; 2]).map(Arc::new) }
    }

    /// The series with this hash.
    pub fn get(&self, hash: &str) -> Option<Arc<Samples>> {
        self.known.get(hash).or(self.stand_in.as_ref()).cloned()
    }
}

/// True if a text has the form of a content hash.
pub fn is_content_hash(text: &[u8]) -> bool {
    text.len() == HASH_LENGTH && text.iter().all(|digit| matches!(digit, b'0'..=b'9' | b'a'..=b'f'))
}

/// All texts of a request that have the form of a content hash.
pub fn named_series(body: &[u8]) -> BTreeSet<String> {
    let hashes = body.split(|byte| *byte == b'"').filter(|text| is_content_hash(text));
    hashes.map(|hash| String::from_utf8_lossy(hash).into_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_found_wherever_they_stand() {
        let (one, other) = ("0a".repeat(32), "f9".repeat(32));
        let body =
            format!(r#"{{"axes":[{{"values":["{one}"]}}],"series":{{"hash":"{other}"}},"x":"{}"}}"#, "0A".repeat(32));
        assert_eq!(named_series(body.as_bytes()), BTreeSet::from([one, other]));
    }
}
