//! The order of turns of several owners, on the real store. River hands out its deliveries in order; one worker takes them, and the
//! processor time of its runs is given.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;
use std::time::Duration;

use uuid::Uuid;

use super::error::JobError;
use super::job::{Failure, INTERNAL};
use super::service::Jobs;
use super::settings::{Settings, Simulator};
use super::store::claims::End;
use super::store::dialect::Dialect;
use super::store::due;
use super::store::location::Location;
use super::store::statement::statement;
use super::store::studies::{Next, PointResult};
use super::store::test_database::new_on_postgres;
use super::store::turns::{self, Turn, TurnLimits};
use crate::contract::answer::point::PointError;
use crate::contract::{self, PointEnd, RunFailure};

const LIMITS: TurnLimits = TurnLimits { max_lost_runs: 2, alone: false };

struct World {
    jobs: Jobs,
}

/// A turn that was used: whose, and for which job.
type Used = (String, Uuid);

impl World {
    async fn new(database: Location) -> Self {
        let settings = Settings { workers: 0, sweep_every: Duration::from_secs(86_400), ..Settings::on(database) };
        let never: Simulator = Arc::new(|_, _| Err(RunFailure::Cancelled));
        Self { jobs: Jobs::start(settings, never).await.expect("a database") }
    }

    async fn submit(&self, owner: &str, request: &str) -> Uuid {
        let job = contract::parse_job(request.as_bytes()).expect("a valid job");
        self.jobs.submit(&job, owner, None).await.expect("accepted").record.id
    }

    async fn submit_many(&self, owner: &str, count: usize) {
        for _ in 0..count {
            self.submit(owner, &simulation(2)).await;
        }
    }

    /// Uses the next delivery for `used_s(owner)` of processor time; `None` if no delivery waits.
    async fn turn(&self, used_s: impl Fn(&str) -> f64) -> Result<Option<Used>, JobError> {
        let store = &self.jobs.parts.store;
        let sql = "UPDATE river_job SET state = 'running' WHERE id = \
                   (SELECT min(id) FROM river_job WHERE state = 'available') RETURNING id";
        let Some(delivery) = statement(sql).value::<i64>(store.writer()).await? else { return Ok(None) };
        let (used, state) = match store.take_turn(delivery, LIMITS).await? {
            Turn::Job(claim) => {
                let end = End::Failed(Failure::new(INTERNAL, "intended by the test"));
                store.finish(&claim, &end, 0.0, used_s(&claim.owner), 60.0).await?.expect("the claim holds");
                ((claim.owner, claim.job), "completed")
            }
            Turn::Shard(shard) => {
                store.start_shard(&shard, 2).await?;
                let Next::Point(point) = store.advance(&shard, None, false, 60.0).await? else {
                    panic!("a point waits")
                };
                let error = PointError { cause: INTERNAL.into(), detail: String::new(), errors: Vec::new() };
                let used_s = used_s(&shard.owner);
                let result = PointResult { end: PointEnd::Failed(error), reused: false, content_hash: None, used_s };
                // After its time slice.
                let state = match store.advance(&shard, Some((point, &result)), true, 60.0).await? {
                    Next::GiveWay => "available",
                    Next::Ended => "completed",
                    Next::Point(point) => {
                        store.give_back(&shard, point).await?;
                        "available"
                    }
                    other => panic!("{other:?}"),
                };
                store.rest_shard(shard.delivery).await?;
                ((shard.owner, shard.job), state)
            }
            other => panic!("{other:?}"),
        };
        let finalized = if state == "completed" { ", finalized_at = CURRENT_TIMESTAMP" } else { "" };
        statement(format!("UPDATE river_job SET state = '{state}'{finalized} WHERE id = $1"))
            .bind(delivery)
            .run(store.writer())
            .await?;
        self.check_deliveries().await?;
        Ok(Some(used))
    }

    /// Every waiting job and shard has a delivery of its own that waits.
    async fn check_deliveries(&self) -> Result<(), JobError> {
        let writer = self.jobs.parts.store.writer();
        let sql = "SELECT delivery FROM jobs WHERE status = 'queued' AND kind NOT IN ('study', 'uncertainty') \
                   UNION ALL SELECT delivery FROM strands";
        let of_work: Vec<i64> = statement(sql).values(writer).await?;
        let sql = "SELECT id FROM river_job WHERE state = 'available'";
        let waiting: HashSet<i64> = statement(sql).values(writer).await?.into_iter().collect();
        assert_eq!(of_work.len(), waiting.len());
        assert_eq!(of_work.into_iter().collect::<HashSet<_>>(), waiting);
        Ok(())
    }
}

fn simulation(priority: u8) -> String {
    format!(
        r#"{{"kind": "simulation", "scene": {{"bearing": "608", "operation": {{"speed_rpm": 3000}}}}, "priority": {priority}}}"#
    )
}

const STUDY: &str = r#"{"kind": "study", "scene": {"bearing": "608", "operation": {"speed_rpm": 3000}},
    "outputs": {"metrics": ["vibration"]}, "axes": [{"path": "/operation/speed_rpm", "from": 3000, "to": 6000, "count": 4}]}"#;

/// Runs a test on a file and, where a server is named, on PostgreSQL.
fn on_each_database<F: Future<Output = Result<(), JobError>>>(test: impl Fn(World) -> F) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    let place = tempfile::tempdir().expect("a directory");
    let file = Location::File(place.path().join("jobs.db"));
    for database in [Some(file), new_on_postgres("")].into_iter().flatten() {
        runtime.block_on(async { test(World::new(database).await).await }).expect("the database answers");
    }
}

#[test]
fn a_job_waits_for_one_turn_however_many_jobs_of_another_owner_wait() {
    on_each_database(async |world: World| {
        world.submit_many("a", 40).await;
        assert_eq!(world.turn(|_| 0.01).await?.expect("a turn").0, "a");
        // The last priority: priorities order the work of one owner only.
        let short = world.submit("b", &simulation(4)).await;
        assert_eq!(world.turn(|_| 0.01).await?, Some(("b".into(), short)));
        Ok(())
    });
}

#[test]
fn owners_get_equal_processor_time_and_their_jobs_by_priority() {
    on_each_database(async |world: World| {
        world.submit_many("a", 30).await;
        world.submit_many("b", 90).await;
        let first = world.submit("b", &simulation(1)).await;
        let mut turns: BTreeMap<String, usize> = BTreeMap::new();
        let mut of_b = Vec::new();
        for _ in 0..55 {
            let (owner, job) = world.turn(|owner| if owner == "a" { 1.0 } else { 0.1 }).await?.expect("a turn");
            if owner == "b" {
                of_b.push(job);
            }
            *turns.entry(owner).or_default() += 1;
        }
        assert_eq!((turns["a"], turns["b"]), (5, 50));
        assert_eq!(of_b[0], first);
        assert!(of_b[1..].is_sorted());
        Ok(())
    });
}

#[test]
fn time_used_while_no_other_waits_is_no_debt() {
    on_each_database(async |world: World| {
        world.submit_many("a", 10).await;
        for _ in 0..10 {
            world.turn(|_| 100.0).await?;
        }
        world.submit_many("b", 10).await;
        world.turn(|_| 0.1).await?;
        let again = world.submit("a", &simulation(2)).await;
        // The last run of a took 100 s more than b has used since; the 900 s before it do not count.
        for _ in 0..5 {
            assert_eq!(world.turn(|_| 20.0).await?.map(|used| used.0), Some("b".into()));
        }
        assert_eq!(world.turn(|_| 20.0).await?, Some(("a".into(), again)));
        Ok(())
    });
}

#[test]
fn studies_take_turns_with_each_other_and_with_jobs_of_other_owners() {
    on_each_database(async |world: World| {
        let studies = [world.submit("a", STUDY).await, world.submit("a", STUDY).await];
        world.turn(|_| 1.0).await?;
        let short = world.submit("b", &simulation(4)).await;
        assert_eq!(world.turn(|_| 0.01).await?, Some(("b".into(), short)));
        let mut order = Vec::new();
        while let Some((_, job)) = world.turn(|_| 1.0).await? {
            order.push(job);
        }
        let [first, second] = studies;
        assert_eq!(order, [second, first, second, first, second, first, second]);
        Ok(())
    });
}

#[test]
fn a_turn_reads_indexes_only() {
    on_each_database(async |world: World| {
        world.submit_many("a", 20).await;
        world.submit("b", STUDY).await;
        let mut tx = world.jobs.parts.store.begin().await?;
        for sql in due::QUERIES.into_iter().chain(turns::QUERIES) {
            let plan: Vec<String> = match tx.dialect() {
                Dialect::Sqlite => {
                    let rows: Vec<(i64, i64, i64, String)> =
                        statement(format!("EXPLAIN QUERY PLAN {sql}")).all(&mut tx).await?;
                    rows.into_iter().map(|row| row.3).collect()
                }
                Dialect::Postgres => {
                    statement("ANALYZE jobs").run(&mut tx).await?;
                    statement("SET LOCAL enable_seqscan = off").run(&mut tx).await?;
                    let sql = sql.replace("owner = $1", "owner = 'a'").replace("$1", "1");
                    statement(format!("EXPLAIN {sql}")).values(&mut tx).await?
                }
            };
            for table in ["jobs", "strands", "points", "turns"] {
                for line in plan.iter().filter(|line| line.split(' ').any(|word| word == table)) {
                    let whole = line.contains(&format!("SCAN {table}")) || line.contains("Seq Scan");
                    assert!(!whole, "{sql}\n{plan:#?}");
                }
            }
            let sorts = plan.iter().any(|line| line.contains("TEMP B-TREE FOR ORDER BY") || line.contains("Sort"));
            // Owners are sorted, their work is not.
            assert!(!sorts || sql.contains("RECURSIVE"), "{sql}\n{plan:#?}");
        }
        Ok(())
    });
}
