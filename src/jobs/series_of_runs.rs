//! Time series of runs that end, are rejected or are lost, on the real store.

use std::sync::Arc;
use std::time::Duration;

use raceway_core::simulation::input::series_sink::SeriesSink;
use uuid::Uuid;

use super::error::JobError;
use super::running::{Run, StopReason};
use super::series_writer::SeriesWriter;
use super::service::Jobs;
use super::settings::{Settings, Simulator};
use super::store::claims::{Claim, End};
use super::store::database::Store;
use super::store::digest::{Place, Sealed};
use super::store::location::Location;
use super::store::results::{StoredResult, series_signal};
use super::store::series_chunks::RecordedChunks;
use super::store::series_reader::StoredHead;
use super::store::statement::statement;
use super::store::test_database::new_on_postgres;
use super::store::turns::{Turn, TurnLimits};
use crate::contract::{self, JobKind, RunFailure, SeriesHead};

const JOB: &str =
    r#"{"kind": "simulation", "scene": {"bearing": "608", "operation": {"speed_rpm": 3000}}, "reuse": false}"#;
const CHANNEL: &str = "cage.speed";
/// More values than are stored together, and no whole number of chunks.
const VALUES: usize = 300_001;

/// Values that hardly compress.
fn values() -> Vec<f64> {
    let mut state = 88_172_645_463_325_252_u64;
    let next = |_| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        f64::from_bits(state >> 2)
    };
    (0..VALUES).map(next).collect()
}

struct World {
    jobs: Jobs,
}

impl World {
    fn store(&self) -> &Store {
        &self.jobs.parts.store
    }

    /// A claim of a new job.
    async fn claim(&self) -> Claim {
        let job = contract::parse_job(JOB.as_bytes()).expect("a valid job");
        self.jobs.submit(&job, "", None).await.expect("accepted");
        let sql = "UPDATE river_job SET state = 'running' WHERE id = \
                   (SELECT min(id) FROM river_job WHERE state = 'available') RETURNING id";
        let delivery: i64 = statement(sql).value(self.store().writer()).await.expect("a query").expect("a delivery");
        match self.store().take_turn(delivery, TurnLimits { max_lost_runs: 2, alone: false }).await {
            Ok(Turn::Job(claim)) => claim,
            other => panic!("{other:?}"),
        }
    }

    /// Records `attempts`, of which the last is the result, on a thread as that of a run.
    async fn record(&self, claim: &Claim, attempts: u64) -> (Arc<SeriesWriter>, Arc<Run>) {
        let run = Arc::new(Run::default());
        let writer = SeriesWriter::new(self.store().clone(), claim, Arc::clone(&run), Duration::from_secs(60));
        let writer = Arc::new(writer);
        let recording = Arc::clone(&writer);
        let recorded = tokio::task::spawn_blocking(move || {
            for attempt in 0..attempts {
                assert_eq!(recording.begin(), attempt);
                values().chunks(1000).for_each(|part| recording.write(attempt, 0, part));
            }
            (0..attempts - 1).for_each(|attempt| recording.discard(attempt));
        });
        recorded.await.expect("recorded");
        (writer, run)
    }

    async fn count(&self, table: &str) -> i64 {
        let sql = format!("SELECT count(*) FROM {table}");
        statement(sql).value(self.store().writer()).await.expect("a query").unwrap_or(0)
    }

    /// Waits until the chunks of other attempts are removed.
    async fn until_one_recording(&self) {
        for _ in 0..500 {
            if self.count("recordings").await == 1 {
                return;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        panic!("rejected attempts stay");
    }

    async fn finish(&self, claim: &Claim, chunks: RecordedChunks) -> Result<Option<Uuid>, JobError> {
        let head = SeriesHead { channel: CHANNEL.into(), unit: "Hz".into(), start_s: 0.0, step_s: 1.0, length: VALUES };
        let result = StoredResult::Run {
            kind: JobKind::Simulation,
            metrics: Sealed::new(&Place::of_result(chunks.result, "metrics"), "{}".into()),
            signals: vec![series_signal(chunks.result, &StoredHead::new(head, 0))?],
            chunks,
            views: None,
        };
        let end = End::Succeeded(result);
        Ok(self.store().finish(claim, &end, 1.0, 0.0, 60.0).await?.map(|record| record.id))
    }
}

/// Runs a test on a file and, where a server is named, on PostgreSQL.
fn on_each_database<F: Future<Output = Result<(), JobError>>>(test: impl Fn(World) -> F) {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().expect("threads");
    let place = tempfile::tempdir().expect("a directory");
    let file = Location::File(place.path().join("jobs.db"));
    for database in [Some(file), new_on_postgres("")].into_iter().flatten() {
        let settings = Settings { workers: 0, sweep_every: Duration::from_secs(86_400), ..Settings::on(database) };
        let never: Simulator = Arc::new(|_, _| Err(RunFailure::Cancelled));
        let test = async { test(World { jobs: Jobs::start(settings, never).await.expect("a database") }).await };
        runtime.block_on(test).expect("the database answers");
    }
}

#[test]
fn a_series_returns_bit_for_bit_and_a_changed_chunk_is_found() {
    on_each_database(async |world: World| {
        let claim = world.claim().await;
        let (writer, run) = world.record(&claim, 2).await;
        assert_eq!(run.stopped(), None);
        world.until_one_recording().await;
        let chunks = writer.take()?;
        assert!(chunks.is_stored && chunks.rest.len() < 9, "most chunks are stored during the run");
        let job = world.finish(&claim, chunks).await?.expect("the claim holds");
        assert_eq!((world.count("recordings").await, world.count("results").await), (0, 1));
        assert_eq!(world.count("series_chunks").await, 19);
        assert_eq!(world.store().remove_lost_recordings().await?, 0);

        let series = world.store().series("", job, CHANNEL).await?;
        let expected = values();
        assert_eq!(series.beginning(VALUES as f64).await?.value, expected);
        assert_eq!(series.values(16_000..17_000).await?, expected[16_000..16_384]);
        assert_eq!(series.values(300_000..300_001).await?, expected[300_000..]);
        let sql = "SELECT result_id FROM jobs WHERE id = $1";
        let result: Uuid = statement(sql).bind(job).value(world.store().writer()).await?.expect("a result");
        assert_eq!(world.store().inspect_result(result).await?.parts, 21);

        // A chunk in the place of another.
        let sql =
            "UPDATE series_chunks SET content = (SELECT content FROM series_chunks WHERE number = 3) WHERE number = 2";
        statement(sql).run(world.store().writer()).await?;
        assert!(series.check(0..32_768).await.is_ok());
        assert!(matches!(series.check(0..32_769).await, Err(JobError::ResultCorrupt { .. })));
        assert!(!world.store().is_intact(result).await?);
        // A missing last chunk.
        statement("DELETE FROM series_chunks WHERE number = 18").run(world.store().writer()).await?;
        assert!(matches!(series.values(300_000..300_001).await, Err(JobError::ResultCorrupt { .. })));
        assert_eq!(world.store().inspect_result(result).await?.corrupt, ["series of cage.speed"; 2]);

        world.jobs.delete("", job).await?;
        assert_eq!((world.count("series_chunks").await, world.count("results").await), (0, 0));
        Ok(())
    });
}

#[test]
fn the_series_of_a_lost_run_are_removed_and_it_writes_no_more() {
    on_each_database(async |world: World| {
        let claim = world.claim().await;
        let (writer, _) = world.record(&claim, 1).await;
        assert_eq!(world.store().remove_lost_recordings().await?, 0);
        assert!(world.count("series_chunks").await > 8);
        // Another process takes the job.
        statement("UPDATE jobs SET claim = claim + 1").run(world.store().writer()).await?;
        assert_eq!(world.store().remove_lost_recordings().await?, 1);
        assert_eq!((world.count("series_chunks").await, world.count("results").await), (0, 0));
        assert_eq!(world.finish(&claim, writer.take()?).await?, None);
        assert_eq!((world.count("series_chunks").await, world.count("results").await), (0, 0));
        // A later claim that is lost stops its run.
        let lost = Claim { number: 2, ..claim.clone() };
        statement("UPDATE jobs SET claim = 3").run(world.store().writer()).await?;
        let (_, run) = world.record(&lost, 1).await;
        assert_eq!(run.stopped(), Some(StopReason::ClaimLost));
        assert_eq!(world.count("results").await, 0);
        Ok(())
    });
}
