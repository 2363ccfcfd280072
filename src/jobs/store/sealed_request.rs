//! Requests of jobs with their digests. A digest also covers the job, its owner and the work that its result answers: a row that an
//! index finds in the place of another is not taken for it.

use sqlx::FromRow;
use uuid::Uuid;

use super::digest::{Place, Sealed, is_intact};
use crate::jobs::error::JobError;

/// Columns of `SealedRequest`.
pub const SEALED_REQUEST: &str = "request, request_digest, content_hash";

/// The request of a job as it is stored.
#[derive(Debug, FromRow)]
pub struct SealedRequest {
    request: String,
    request_digest: Option<Vec<u8>>,
    content_hash: Vec<u8>,
}

impl SealedRequest {
    /// The request, if it is the one of this job and its owner.
    pub fn opened(self, job: Uuid, owner: &str) -> Result<String, JobError> {
        self.check(job, owner)?;
        Ok(self.request)
    }

    /// An error unless this is the request of this job and its owner.
    pub fn check(&self, job: Uuid, owner: &str) -> Result<(), JobError> {
        if self.is_of(job, owner, &self.content_hash) {
            return Ok(());
        }
        Err(JobError::Corrupt("its digest differs".to_owned()))
    }

    /// The request as it was read.
    pub fn unchecked(self) -> String {
        self.request
    }

    /// The request as it was read, and its place.
    pub fn sealed(self, job: Uuid, owner: &str) -> (Place, Sealed<String>) {
        let place = Place::of_request(job, owner, &self.content_hash);
        (place, Sealed::stored((self.request, self.request_digest)))
    }

    /// Returns whether this is the request of this job and its owner, for this work.
    pub fn is_of(&self, job: Uuid, owner: &str, work: &[u8]) -> bool {
        let place = Place::of_request(job, owner, work);
        is_intact(&place, self.request.as_bytes(), self.request_digest.as_deref())
    }

    /// Length of the request [B].
    pub fn bytes(&self) -> usize {
        self.request.len()
    }
}
