//! The search for a finished result of identical work.

use sqlx::FromRow;
use uuid::Uuid;

use super::sealed_request::SealedRequest;
use super::statement::{Executor, statement};
use crate::jobs::error::JobError;

/// A finished result of identical work.
#[derive(Debug, Clone, Copy)]
pub struct Reusable {
    pub job: Uuid,
    pub result: Uuid,
    /// True if the stored request of its job still has its digest, for this work of this owner.
    pub is_sound: bool,
}

/// Without the expression SQLite would choose the index of an owner's succeeded jobs, and read all of them.
pub(super) const REUSABLE: &str = "SELECT id, result_id, request, request_digest, content_hash FROM jobs \
     WHERE content_hash = $1 AND status = 'succeeded' AND owner || '' = $2 \
     AND NOT EXISTS (SELECT 1 FROM corrupt_results WHERE job = jobs.id) LIMIT 1";

/// The result of identical finished work of the same owner, unless it is known to be corrupt.
///
/// `lock` ends the query: a transaction that deletes the job of the result waits until another job refers to the result.
pub async fn reusable<'a>(
    place: impl Into<Executor<'a>>,
    owner: &str,
    work: &[u8],
    lock: &str,
) -> Result<Option<Reusable>, JobError> {
    let row: Option<ReusableRow> =
        statement(format!("{REUSABLE}{lock}")).bind(work).bind(owner).optional(place).await?;
    Ok(row.map(|ReusableRow { id, result_id, request }| Reusable {
        job: id,
        result: result_id,
        is_sound: request.is_of(id, owner, work),
    }))
}

#[derive(FromRow)]
struct ReusableRow {
    id: Uuid,
    result_id: Uuid,
    #[sqlx(flatten)]
    request: SealedRequest,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::store::database::Store;
    use crate::jobs::store::location::Location;

    #[test]
    fn the_search_for_a_result_reads_the_index_by_content() {
        let place = tempfile::tempdir().expect("a directory");
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
        runtime.block_on(async {
            let location = Location::File(place.path().join("jobs.db"));
            let store = Store::open(&location, 1, None).await.expect("the database opens");
            store.migrate().await.expect("the tables are made");
            let query = statement(REUSABLE).bind(vec![0_u8]).bind("a").explained("EXPLAIN QUERY PLAN");
            let plan: Vec<(i64, i64, i64, String)> = query.all(&store.readers).await.expect("a plan");
            assert!(plan.iter().any(|step| step.3.contains("jobs_by_content")), "{plan:?}");
            store.disconnect().await;
        });
    }
}
