//! Digests of stored text and answers: computed before they are written, compared whenever they are read.

use std::fmt::Display;

use sha2::{Digest, Sha256};
use uuid::Uuid;

use crate::jobs::error::JobError;

/// First byte of a digest that covers the place of its content. Digests of earlier versions are 32 bytes of the content alone.
const WITH_PLACE: u8 = 2;

/// Where content is stored and what it answers, as text. A row that is found in the place of another has another one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place(String);

impl Place {
    /// A part of a result.
    pub fn of_result(result: Uuid, part: impl Display) -> Self {
        Self(format!("result {result}: {part}"))
    }

    /// A signal of a result.
    pub fn of_signal(result: Uuid, sort: &str, channel: &str) -> Self {
        Self::of_result(result, format_args!("{sort} of {channel}"))
    }

    /// A chunk of a series.
    pub fn of_chunk(result: Uuid, series: i64, number: i64) -> Self {
        Self::of_result(result, format_args!("chunk {number} of {series}"))
    }

    /// The answer of an ended point; `work`: digest of everything that determines it, of a point that succeeded.
    pub fn of_point(study: Uuid, number: i64, status: &str, work: Option<&[u8]>) -> Self {
        Self(format!("point {number} of {study}: {status} {}", hex(work.unwrap_or_default())))
    }

    /// The request of a job; `work`: digest of everything that determines its result.
    pub fn of_request(job: Uuid, owner: &str, work: &[u8]) -> Self {
        Self(format!("request of {job}: {} {owner}", hex(work)))
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Stored content with its digest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sealed<T> {
    pub content: T,
    /// `None` in rows of versions that wrote no digests.
    pub digest: Option<Vec<u8>>,
}

impl<T: AsRef<[u8]>> Sealed<T> {
    /// The content with its digest, before it is written.
    pub fn new(place: &Place, content: T) -> Self {
        let digest = digest_of(place, content.as_ref());
        Self { content, digest: Some(digest) }
    }

    /// The content as it was read; `opened` compares it.
    pub fn stored((content, digest): (T, Option<Vec<u8>>)) -> Self {
        Self { content, digest }
    }

    /// Returns whether this was written in this place. Without a digest it counts as such.
    pub fn is_intact(&self, place: &Place) -> bool {
        is_intact(place, self.content.as_ref(), self.digest.as_deref())
    }

    /// The content, if it was written in this place.
    pub fn opened(self, place: &Place) -> Result<T, JobError> {
        if self.is_intact(place) { Ok(self.content) } else { Err(JobError::Corrupt("its digest differs".to_owned())) }
    }
}

/// Digest of content in a place.
pub fn digest_of(place: &Place, content: &[u8]) -> Vec<u8> {
    let mut digest = Sha256::new();
    digest.update(place.0.len().to_le_bytes());
    digest.update(&place.0);
    digest.update(content);
    [&[WITH_PLACE], digest.finalize().as_slice()].concat()
}

/// Returns whether content in this place has this digest. Without a digest it counts as such.
pub fn is_intact(place: &Place, content: &[u8], digest: Option<&[u8]>) -> bool {
    match digest {
        None => true,
        Some(digest) if digest.len() == 32 => digest == Sha256::digest(content).as_slice(),
        Some(digest) => digest == digest_of(place, content),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_bit_and_another_place_are_found() {
        let [mine, other] = [1, 2].map(Uuid::from_u128);
        let place = Place::of_result(mine, "metrics");
        let sealed = Sealed::new(&place, b"{\"level_db\":93.5}".to_vec());
        assert!(sealed.is_intact(&place));
        for bit in 0..8 * sealed.content.len() {
            let mut changed = sealed.clone();
            changed.content[bit / 8] ^= 1 << (bit % 8);
            assert!(changed.opened(&place).is_err(), "bit {bit}");
        }
        for elsewhere in [Place::of_result(other, "metrics"), Place::of_result(mine, "report")] {
            assert!(!sealed.is_intact(&elsewhere), "{elsewhere:?}");
        }
        let request = Sealed::new(&Place::of_request(mine, "a", &[1]), "{}");
        for (job, owner, work) in [(other, "a", 1), (mine, "b", 1), (mine, "a", 2)] {
            assert!(!request.is_intact(&Place::of_request(job, owner, &[work])));
        }
    }

    #[test]
    fn digests_of_earlier_versions_hold() {
        let place = Place::of_result(Uuid::nil(), "metrics");
        assert!(Sealed::stored((b"old".to_vec(), None)).is_intact(&place));
        let digest = Sha256::digest(b"old").to_vec();
        assert!(Sealed::stored((b"old".to_vec(), Some(digest.clone()))).is_intact(&place));
        assert!(!Sealed::stored((b"new".to_vec(), Some(digest))).is_intact(&place));
    }
}
