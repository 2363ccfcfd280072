//! Submissions of several processes on one PostgreSQL server: what they lock, and what they read.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use super::error::JobError;
use super::intake::write_in;
use super::job::{IdempotencyKey, NewJob};
use super::service::Jobs;
use super::settings::{Settings, Simulator};
use super::store::location::Location;
use super::store::pool::Tx;
use super::store::statement::statement;
use super::store::submissions;
use super::store::test_database::new_on_postgres;
use crate::contract::{self, RunFailure};

const JOB: &str =
    r#"{"kind": "simulation", "scene": {"bearing": "608", "operation": {"speed_rpm": 3000}}, "reuse": false}"#;
const STUDY: &str = r#"{"kind": "study", "scene": {"bearing": "608", "operation": {"speed_rpm": 3000}},
    "outputs": {"metrics": ["vibration"]}, "axes": [{"path": "/operation/speed_rpm", "from": 3000, "to": 6000, "count": 4}]}"#;

async fn process(database: &Location) -> Jobs {
    let settings = Settings { workers: 0, sweep_every: Duration::from_secs(86_400), ..Settings::on(database.clone()) };
    let never: Simulator = Arc::new(|_, _| Err(RunFailure::Cancelled));
    Jobs::start(settings, never).await.expect("a database")
}

fn new_job(request: &str, owner: &str, key: Option<&str>) -> NewJob {
    let job = contract::parse_job(request.as_bytes()).expect("a valid job");
    NewJob::new(&job, owner, key.map(|key| IdempotencyKey::new(key, &job)))
}

/// Runs a test of two processes, where a server is named.
fn on_a_server<F: Future<Output = Result<(), JobError>>>(test: impl Fn([Jobs; 2]) -> F) {
    let Some(database) = new_on_postgres("") else { return };
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().expect("threads");
    let test = async { test([process(&database).await, process(&database).await]).await };
    runtime.block_on(test).expect("the database answers");
}

/// A transaction with submissions that is not committed yet.
async fn uncommitted(jobs: &Jobs, submissions: &[NewJob]) -> Result<Tx, JobError> {
    let parts = &jobs.parts;
    let mut tx = parts.store.begin().await?;
    write_in(&mut tx, &parts.queue, &parts.worker, &parts.tokens, Default::default(), submissions).await?;
    Ok(tx)
}

#[test]
fn a_submission_locks_its_own_rows_only_and_waits_for_no_other() {
    on_a_server(async |[one, other]| {
        let mut tx = uncommitted(&one, &[new_job(JOB, "a", Some("key")), new_job(STUDY, "a", None)]).await?;
        // Rows are locked through these modes. Any other would hold up whole tables.
        let sql = "SELECT locktype || ' ' || mode FROM pg_locks WHERE pid = pg_backend_pid() AND locktype NOT IN ('virtualxid', 'transactionid')";
        let held: BTreeSet<String> = statement(sql).values(&mut tx).await?.into_iter().collect();
        let of_rows =
            ["relation AccessShareLock", "relation RowShareLock", "relation RowExclusiveLock"].map(str::to_owned);
        assert!(held.is_subset(&BTreeSet::from(of_rows)), "{held:?}");
        // Another process accepts meanwhile, also for the same owner.
        for (owner, key) in [("a", Some("another key")), ("b", Some("key")), ("b", None)] {
            let submitted = other.parts.intake.submit(new_job(JOB, owner, key));
            tokio::time::timeout(Duration::from_secs(5), submitted).await.expect("no lock is in the way")?;
        }
        // The same key waits for its first use, and is its replay.
        let again = other.parts.intake.submit(new_job(JOB, "a", Some("key")));
        let mut again = std::pin::pin!(again);
        assert!(tokio::time::timeout(Duration::from_millis(300), &mut again).await.is_err(), "it waits");
        tx.commit().await?;
        assert!(again.await?.replayed);
        let mut tx = one.parts.store.begin().await?;
        let unfinished = submissions::unfinished(&mut tx).await?;
        let of = |owner: &str| (unfinished[owner].jobs, unfinished[owner].points);
        assert_eq!((of("a"), of("b")), ((2, 4), (2, 0)));
        Ok(())
    });
}

/// A notification makes all transactions that notify wait for each other until they are on the disk.
#[test]
fn a_submission_sends_no_notification_in_its_transaction() {
    on_a_server(async |[one, _]| {
        let super::store::pool::Pool::Postgres(pool) = one.parts.store.writer() else { panic!("a server") };
        // River notifies with the first delivery of a process.
        uncommitted(&one, &[new_job(JOB, "a", None)]).await?.commit().await?;
        let mut of_transaction = sqlx::postgres::PgListener::connect_with(pool).await?;
        of_transaction.listen("public.river_insert").await?;
        uncommitted(&one, &[new_job(JOB, "a", None)]).await?.commit().await?;
        assert!(tokio::time::timeout(Duration::from_millis(300), of_transaction.recv()).await.is_err());
        // Other processes are told afterwards.
        let mut afterwards = sqlx::postgres::PgListener::connect_with(pool).await?;
        afterwards.listen("raceway_enqueued").await?;
        one.parts.intake.submit(new_job(JOB, "a", None)).await?;
        let told = tokio::time::timeout(Duration::from_secs(5), afterwards.recv()).await;
        told.expect("a notification")?;
        Ok(())
    });
}

#[test]
fn a_submission_reads_indexes_and_counts_only() {
    on_a_server(async |[one, other]| {
        for jobs in [&one, &other] {
            for _ in 0..300 {
                jobs.parts.intake.submit(new_job(JOB, "a", None)).await?;
            }
        }
        let mut tx = one.parts.store.begin().await?;
        for table in ["jobs", "idempotency_keys", "unfinished"] {
            statement(format!("ANALYZE {table}")).run(&mut tx).await?;
        }
        // As with a queue of any length.
        statement("SET LOCAL enable_seqscan = off").run(&mut tx).await?;
        for sql in submissions::QUERIES {
            let sql = sql.replace("$1", "'a'").replace("$2", "'b'");
            let plan: Vec<String> = statement(format!("EXPLAIN {sql}")).values(&mut tx).await?;
            for line in plan.iter().filter(|line| line.contains("Seq Scan")) {
                assert!(line.contains(" on unfinished"), "{sql}\n{plan:#?}");
            }
            assert!(sql != submissions::UNFINISHED || !plan.iter().any(|line| line.contains("jobs")), "{plan:#?}");
        }
        let counts: i64 = statement("SELECT count(*) FROM unfinished").value(&mut tx).await?.unwrap_or(0);
        assert!((1..=12).contains(&counts), "{counts} counts of 600 jobs");
        drop(tx);
        // Closed connections leave one count.
        other.stop().await?;
        one.parts.store.join_counts().await?;
        let mut tx = one.parts.store.begin().await?;
        assert_eq!(submissions::unfinished(&mut tx).await?["a"].jobs, 600);
        Ok(())
    });
}
