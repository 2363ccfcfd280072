//! Digests of stored answers: computed before an answer is written, compared whenever it is read.

use sha2::{Digest, Sha256};

use crate::jobs::error::JobError;

/// A stored answer with the digest of its bytes (SHA-256).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sealed<T> {
    pub content: T,
    /// `None` in rows of versions that wrote no digests.
    pub digest: Option<Vec<u8>>,
}

impl<T: AsRef<[u8]>> Sealed<T> {
    /// The answer with its digest, before it is written.
    pub fn new(content: T) -> Self {
        let digest = Sha256::digest(content.as_ref()).to_vec();
        Self { content, digest: Some(digest) }
    }

    /// The answer as it was read; `opened` compares it.
    pub fn stored((content, digest): (T, Option<Vec<u8>>)) -> Self {
        Self { content, digest }
    }

    /// Returns whether the answer is what was written. Without a digest it counts as such.
    pub fn is_intact(&self) -> bool {
        is_intact(self.content.as_ref(), self.digest.as_deref())
    }

    /// The answer, if it is what was written.
    pub fn opened(self) -> Result<T, JobError> {
        if self.is_intact() { Ok(self.content) } else { Err(JobError::Corrupt("its digest differs".to_owned())) }
    }
}

/// Returns whether bytes have this digest. Without a digest they count as such.
pub fn is_intact(content: &[u8], digest: Option<&[u8]>) -> bool {
    digest.is_none_or(|digest| digest == Sha256::digest(content).as_slice())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_bit_is_found() {
        let sealed = Sealed::new(b"{\"level_db\":93.5}".to_vec());
        assert!(sealed.is_intact());
        for bit in 0..8 * sealed.content.len() {
            let mut changed = sealed.clone();
            changed.content[bit / 8] ^= 1 << (bit % 8);
            assert!(changed.opened().is_err(), "bit {bit}");
        }
        assert!(Sealed::stored((b"old".to_vec(), None)).is_intact());
    }
}
