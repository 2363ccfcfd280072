//! Every order of actions of two processes on one job, explored breadth first over the real store.
//!
//! After each step three conditions are checked. The stored job must equal the specification `after`, which uses no SQL. The invariants
//! must hold (`check_invariants`). From each state the job must reach an end by itself (`reaches_an_end`).
//!
//! River, the run and the clock are simulated; everything else is the store. An hour passes where a step states it. Two states are equal
//! if they differ only in numbers and in the order of the processes.

use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;
use std::time::Duration;

use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::error::JobError;
use super::job::{NewJob, Status};
use super::parts::Parts;
use super::running::{Run, StopReason};
use super::service::{Cancelled, Jobs};
use super::settings::{Settings, Simulator};
use super::store::claims::{Claim, Heartbeat};
use super::store::database::Store;
use super::store::dialect::Dialect;
use super::store::digest::{Place, Sealed};
use super::store::location::Location;
use super::store::results::StoredResult;
use super::store::series_chunks::RecordedChunks;
use super::store::statement::statement;
use super::store::submissions;
use super::store::test_database::new_on_postgres;
use super::store::turns::{Turn, TurnLimits};
use super::sweep;
use super::worker::{RunOutcome, Worker, apply_heartbeat, outcome_of};
use crate::contract::{self, JobKind, RunFailure};

const OWNER: &str = "";
const REQUEST: &str =
    r#"{"kind": "simulation", "scene": {"bearing": "608", "operation": {"speed_rpm": 3000}}, "keep_for_s": 900}"#;
const MAX_LOST_RUNS: u32 = 2;
/// Three times this, after which a silent process is no longer listed, is less than the hour that passes.
const LOST_AFTER: Duration = Duration::from_secs(15 * 60);
const HOUR: Duration = Duration::from_secs(60 * 60);
/// Indices of the two processes.
const BOTH: [usize; 2] = [0, 1];

/// A possible action; the number is the index of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// River hands the oldest waiting delivery to the process.
    Deliver(usize),
    /// The process claims the job of its delivery.
    Take(usize),
    Beat(usize),
    Finish(usize, Solved),
    /// The process stops: a run gets its stop flag, an unclaimed delivery is returned.
    Stop(usize),
    /// The process dies and starts again.
    Die(usize),
    /// River treats a delivery as lost that a process holds.
    DeliverAgain,
    Cancel(usize),
    Sweep(usize),
    /// An hour passes, then the process sweeps.
    LateSweep(usize),
    Delete,
}

/// The end of the solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Solved {
    Result,
    Failure,
    /// It was stopped, or never started.
    Obeyed,
}

/// The delivery or run that a process holds.
#[derive(Debug, Clone)]
enum Hand {
    Nothing,
    Delivery(i64),
    Run { delivery: i64, claim: Claim, stopped: Option<StopReason> },
}

/// The stored job.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Row {
    status: Status,
    cancel: bool,
    lost: i64,
    claim: i64,
    /// 0: the job started inline and has no delivery.
    delivery: i64,
    /// True if the heartbeat is recent.
    fresh: bool,
    result: bool,
    cause: Option<String>,
}

/// A delivery that River has not completed.
#[derive(Debug, Clone)]
struct Delivery {
    id: i64,
    /// Held by a process; otherwise waiting.
    out: bool,
    /// Held by a process that is no longer listed. A file has one process, which needs no list.
    orphaned: bool,
}

/// The content of the database.
#[derive(Debug, Clone)]
struct Stored {
    /// `None`: the job is removed.
    row: Option<Row>,
    deliveries: Vec<Delivery>,
    results: i64,
    listed: Vec<Uuid>,
}

#[derive(Debug, Clone)]
struct State {
    /// Number of its saved rows.
    saved: i64,
    seen: Stored,
    hands: [Hand; 2],
    workers: [Uuid; 2],
    trace: Vec<Step>,
}

impl Stored {
    fn delivery(&self, id: i64) -> Option<&Delivery> {
        self.deliveries.iter().find(|delivery| delivery.id == id)
    }

    fn unfinished(&self) -> Option<&Row> {
        self.row.as_ref().filter(|row| !row.status.is_final())
    }
}

/// The specification: the stored job after a step.
fn after(step: Step, before: &State, file: bool) -> Option<Row> {
    let row = before.seen.row.clone()?;
    if row.status.is_final() {
        // An ended job changes only by its removal, on request or by expiry.
        return (!matches!(step, Step::Delete | Step::LateSweep(_))).then_some(row);
    }
    let running = row.status == Status::Running;
    // After the largest number of losses no run starts, so none is lost.
    let lost = row.lost + i64::from(running && row.lost < i64::from(MAX_LOST_RUNS));
    let ended = |status| Row { status, fresh: false, ..row.clone() };
    Some(match step {
        Step::Take(process) => match &before.hands[process] {
            Hand::Delivery(delivery) if *delivery == row.delivery => {
                Row { status: Status::Running, claim: row.claim + 1, lost, fresh: true, ..row }
            }
            _ => row,
        },
        Step::Beat(process) if before.holds(process) => Row { fresh: true, ..row },
        Step::Finish(process, solved) => match (&before.hands[process], solved) {
            _ if !before.holds(process) => row,
            (Hand::Run { stopped: Some(StopReason::HandedBack), .. }, Solved::Obeyed) => {
                Row { status: Status::Queued, fresh: false, ..row }
            }
            (Hand::Run { stopped: Some(StopReason::ClaimLost), .. }, Solved::Obeyed) => row,
            // A requested cancellation holds for every end of the run.
            _ if row.cancel => ended(Status::Cancelled),
            (_, Solved::Result) => Row { result: true, ..ended(Status::Succeeded) },
            (_, Solved::Failure) => Row { cause: Some("did-not-converge".into()), ..ended(Status::Failed) },
            (Hand::Run { stopped: Some(_), .. }, Solved::Obeyed) => ended(Status::Cancelled),
            // It was lost too often to start again.
            _ => Row { cause: Some("worker-lost".into()), ..ended(Status::Failed) },
        },
        Step::Cancel(_) if running => Row { cancel: true, ..row },
        Step::Cancel(_) => Row { cancel: true, ..ended(Status::Cancelled) },
        Step::Sweep(process) | Step::LateSweep(process) => {
            let silent = !row.fresh || matches!(step, Step::LateSweep(_));
            let delivery = before.seen.delivery(row.delivery);
            let orphaned = !file && !running && delivery.is_some_and(|delivery| delivery.orphaned);
            let runs_here = matches!(before.hands[process], Hand::Run { .. });
            // In a file a run without a delivery belongs to the sweeping process or to a dead one.
            let never_had_one = !file && running && row.delivery == 0;
            let gone = delivery.is_none() && !never_had_one;
            if row.cancel && (!running || silent) {
                ended(Status::Cancelled)
            } else if !runs_here && (gone || orphaned || running && silent) {
                // `step` checks that the delivery is a new one.
                Row { status: Status::Queued, lost, delivery: 0, fresh: false, ..row }
            } else {
                Row { fresh: running && !silent, ..row }
            }
        }
        _ => row,
    })
}

impl State {
    /// Returns whether the process holds the current claim.
    fn holds(&self, process: usize) -> bool {
        let claim = match &self.hands[process] {
            Hand::Run { claim, .. } => claim.number,
            _ => return false,
        };
        self.seen.row.as_ref().is_some_and(|row| row.status == Status::Running && row.claim == claim)
    }

    /// The possible steps.
    fn steps(&self, begins: impl Fn(&Claim) -> bool) -> Vec<Step> {
        let mut steps = vec![Step::Delete];
        if self.seen.deliveries.iter().any(|delivery| delivery.out) {
            steps.push(Step::DeliverAgain);
        }
        for process in BOTH {
            steps.extend([Step::Cancel(process), Step::Sweep(process), Step::LateSweep(process)]);
            match &self.hands[process] {
                Hand::Nothing if self.seen.deliveries.iter().any(|delivery| !delivery.out) => {
                    steps.push(Step::Deliver(process));
                }
                Hand::Nothing => {}
                Hand::Delivery(_) => steps.extend([Step::Take(process), Step::Stop(process), Step::Die(process)]),
                Hand::Run { claim, .. } if !begins(claim) => {
                    steps.extend([Step::Finish(process, Solved::Obeyed), Step::Die(process)]);
                }
                Hand::Run { stopped, .. } => {
                    let ends = [Solved::Result, Solved::Failure].map(|solved| Step::Finish(process, solved));
                    steps.extend(ends.into_iter().chain([Step::Beat(process), Step::Die(process)]));
                    steps.push(match stopped {
                        Some(_) => Step::Finish(process, Solved::Obeyed),
                        None => Step::Stop(process),
                    });
                }
            }
        }
        steps
    }

    /// A key that is equal for states which differ only in numbers.
    fn key(&self) -> String {
        let row = self.seen.row.as_ref();
        let now = row.map(|row| (row.status, row.cancel, row.lost, row.fresh, row.result, row.cause.clone()));
        let is_now = |delivery: i64| row.is_some_and(|row| row.delivery == delivery);
        let held = |process: usize| match &self.hands[process] {
            Hand::Nothing => "nothing".to_owned(),
            Hand::Delivery(delivery) => format!("delivery {}", is_now(*delivery)),
            Hand::Run { delivery, claim, stopped } => format!(
                "run {} {} {:?} {} {}",
                is_now(*delivery),
                self.holds(process),
                stopped,
                claim.cancel_requested,
                claim.lost >= MAX_LOST_RUNS
            ),
        };
        let mut processes = BOTH.map(|process| (held(process), self.seen.listed.contains(&self.workers[process])));
        processes.sort();
        let deliveries: BTreeSet<_> =
            self.seen.deliveries.iter().map(|one| (is_now(one.id), one.out, one.orphaned)).collect();
        format!("{now:?} {processes:?} {deliveries:?}")
    }
}

/// Checks the invariants of every step.
fn check_invariants(step: Step, before: &Stored, now: &State) {
    let held = BOTH.into_iter().filter(|process| now.holds(*process)).count();
    assert!(held <= 1, "two processes hold the claim");
    let kept = now.seen.row.as_ref();
    assert_eq!(now.seen.results, i64::from(kept.is_some_and(|row| row.status == Status::Succeeded)), "results");
    let Some(row) = kept else {
        let ended = before.row.as_ref().is_none_or(|row| row.status.is_final());
        return assert!(ended, "an unfinished job was removed");
    };
    let was = before.row.as_ref().expect("a removed job does not reappear");
    assert!(!was.status.is_final() || row == was, "an end was changed");
    assert!(!was.cancel || row.cancel, "a request to cancel is forgotten");
    assert!(
        !row.status.is_final() || !row.cancel || row.status == Status::Cancelled,
        "a cancelled job did not end as cancelled"
    );
    assert!(row.lost <= i64::from(MAX_LOST_RUNS), "lost too often");
    if let (Step::Sweep(process) | Step::LateSweep(process), false) = (step, row.status.is_final()) {
        let delivery = now.seen.delivery(row.delivery);
        let runs_here = matches!(now.hands[process], Hand::Run { .. });
        // Also a job that another process runs, by its heartbeat.
        let runs_there = row.delivery == 0 && row.status == Status::Running && row.fresh;
        assert!(delivery.is_some() || runs_here || runs_there, "no process will run it");
        assert!(row.status == Status::Queued || row.fresh || runs_here, "no process runs it");
    }
}

/// Prints the steps that led to a failed assertion.
struct TraceOnPanic(Vec<Step>);

impl Drop for TraceOnPanic {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("steps: {:?}", self.0);
        }
    }
}

/// The tables whose rows form a state, parents first.
const TABLES: [&str; 5] = ["results", "jobs", "river_job", "workers", "removed_jobs"];

struct World {
    jobs: Jobs,
    store: Store,
    job: Uuid,
    settings: Settings,
    /// Statements that save, remove and restore the rows of a table.
    table_statements: Vec<[String; 3]>,
    saved: i64,
}

/// A process for the duration of a step.
struct Process {
    jobs: Jobs,
    worker: Worker,
    run: Option<Arc<Run>>,
}

impl World {
    /// A queued job, and two processes that have just started.
    async fn new(database: Location) -> Result<(Self, State), JobError> {
        let never: Simulator = Arc::new(|_, _| Err(RunFailure::Cancelled));
        let mut settings = Settings::on(database);
        settings.workers = 0;
        settings.sweep_every = Duration::from_secs(86_400);
        let jobs = Jobs::start(settings.clone(), never).await?;
        settings.workers = 1;
        settings.lost_after = LOST_AFTER;
        settings.max_lost_runs = MAX_LOST_RUNS;
        let job = contract::parse_job(REQUEST.as_bytes()).expect("a valid job");
        let job = jobs.submit(&job, OWNER, None).await?.record.id;
        let store = jobs.parts.store.clone();
        let mut world = Self { jobs, store, job, settings, table_statements: Vec::new(), saved: 0 };
        if world.is_file() {
            // Power cuts are not explored.
            statement("PRAGMA synchronous = OFF").run(world.store.writer()).await?;
        }
        for table in TABLES {
            world.prepare(table).await?;
        }
        let workers = [Uuid::now_v7(), Uuid::now_v7()];
        let hands = [Hand::Nothing, Hand::Nothing];
        let mut state = State { saved: 0, seen: world.look().await?, hands, workers, trace: Vec::new() };
        for process in BOTH {
            sweep::sweep(&world.process(&state, process).jobs.parts).await?;
        }
        state.seen = world.look().await?;
        world.save(&mut state).await?;
        Ok((world, state))
    }

    /// Another job in place of the first: the first process started it inline.
    async fn inline_run(&mut self, first: &State) -> Result<State, JobError> {
        let request = contract::parse_job(REQUEST.as_bytes()).expect("a valid job");
        let job = NewJob { id: self.job, ..NewJob::new(&request, OWNER, None) };
        let claim = Claim::at_acceptance(&job);
        let mut tx = self.store.begin().await?;
        for table in ["jobs", "river_job"] {
            statement(format!("DELETE FROM {table}")).run(&mut tx).await?;
        }
        submissions::insert_started(&mut tx, &job).await?;
        tx.commit().await?;
        let hands = [Hand::Run { delivery: 0, claim, stopped: None }, Hand::Nothing];
        let mut state = State { seen: self.look().await?, hands, ..first.clone() };
        assert!(state.holds(0));
        self.save(&mut state).await?;
        Ok(state)
    }

    fn is_file(&self) -> bool {
        self.store.dialect() == Dialect::Sqlite
    }

    async fn prepare(&mut self, table: &str) -> Result<(), JobError> {
        let columns = match self.store.dialect() {
            Dialect::Sqlite => "SELECT name FROM pragma_table_info($1)",
            Dialect::Postgres => {
                "SELECT CAST(column_name AS TEXT) FROM information_schema.columns \
                 WHERE table_schema = current_schema() AND table_name = $1"
            }
        };
        let columns: Vec<String> = statement(columns).bind(table).values(self.store.writer()).await?;
        let columns = columns.join(", ");
        let make =
            format!("CREATE TABLE saved_{table} AS SELECT CAST(0 AS BIGINT) AS saved, * FROM {table} WHERE 1 = 0");
        let index = format!("CREATE INDEX saved_{table}_states ON saved_{table} (saved)");
        for sql in [make, index] {
            statement(sql).run(self.store.writer()).await?;
        }
        self.table_statements.push([
            format!("INSERT INTO saved_{table} SELECT CAST($1 AS BIGINT), * FROM {table}"),
            format!("DELETE FROM {table}"),
            format!("INSERT INTO {table} ({columns}) SELECT {columns} FROM saved_{table} WHERE saved = $1"),
        ]);
        Ok(())
    }

    async fn save(&mut self, state: &mut State) -> Result<(), JobError> {
        self.saved += 1;
        state.saved = self.saved;
        let mut tx = self.store.begin().await?;
        for [save, ..] in &self.table_statements {
            statement(save.clone()).bind(state.saved).run(&mut tx).await?;
        }
        tx.commit().await
    }

    async fn restore(&self, state: &State) -> Result<(), JobError> {
        let mut tx = self.store.begin().await?;
        for [_, remove, _] in self.table_statements.iter().rev() {
            statement(remove.clone()).run(&mut tx).await?;
        }
        for [.., bring_back] in &self.table_statements {
            statement(bring_back.clone()).bind(state.saved).run(&mut tx).await?;
        }
        tx.commit().await
    }

    async fn look(&self) -> Result<Stored, JobError> {
        let writer = self.store.writer();
        let sql = format!(
            "SELECT status, cancel_requested_at IS NOT NULL, lost, claim, coalesce(delivery, 0), \
             status = 'running' AND heartbeat_at > {} - $2, result_id IS NOT NULL, error_cause FROM jobs WHERE id = $1",
            self.store.dialect().now()
        );
        type Columns = (String, bool, i64, i64, i64, bool, bool, Option<String>);
        let row: Option<Columns> =
            statement(sql).bind(self.job).bind(LOST_AFTER.as_micros() as i64).optional(writer).await?;
        let row = row.map(|(status, cancel, lost, claim, delivery, fresh, result, cause)| Row {
            status: Status::parse(&status).expect("a status"),
            cancel,
            lost,
            claim,
            delivery,
            fresh,
            result,
            cause,
        });
        let holder = match self.store.dialect() {
            Dialect::Sqlite => "CAST(NULL AS TEXT)",
            Dialect::Postgres => "attempted_by[array_upper(attempted_by, 1)]",
        };
        let sql = format!(
            "SELECT id, CAST(state AS TEXT) = 'running', {holder} FROM river_job \
             WHERE state NOT IN ('completed', 'cancelled', 'discarded') ORDER BY id"
        );
        let deliveries: Vec<(i64, bool, Option<String>)> = statement(sql).all(writer).await?;
        let listed: Vec<Uuid> = statement("SELECT id FROM workers ORDER BY id").values(writer).await?;
        let is_listed = |holder: &str| listed.iter().any(|worker| worker.to_string() == holder);
        let deliveries = deliveries.into_iter().map(|(id, out, holder)| Delivery {
            id,
            out,
            orphaned: out && holder.is_some_and(|holder| !is_listed(&holder)),
        });
        let deliveries = deliveries.collect();
        let results = statement("SELECT count(*) FROM results").value(writer).await?.unwrap_or(0);
        Ok(Stored { row, deliveries, results, listed })
    }

    /// Another process on the same database that only sweeps and answers requests.
    fn second_process(&self, worker_id: Uuid, settings: Settings) -> Jobs {
        let (running, stopping) = (Arc::default(), CancellationToken::new());
        let parts = Parts { worker_id, settings, running, stopping, ..Parts::clone(&self.jobs.parts) };
        Jobs { parts: Arc::new(parts) }
    }

    fn process(&self, state: &State, process: usize) -> Process {
        let jobs = self.second_process(state.workers[process], self.settings.clone());
        let parts = &jobs.parts;
        let never: Simulator = Arc::new(|_, _| Err(RunFailure::Cancelled));
        let worker = Worker::new(parts.store.clone(), Arc::clone(&parts.running), never, parts.settings.clone());
        let mut run = None;
        if let Hand::Run { stopped, .. } = &state.hands[process] {
            let guard = parts.running.enter(self.job, Arc::default());
            if let Some(reason) = stopped {
                guard.run.stop(*reason);
            }
            run = Some(Arc::clone(&guard.run));
            // The run lasts as long as this process.
            std::mem::forget(guard);
        }
        Process { jobs, worker, run }
    }

    /// Changes the state of a delivery, as River does.
    async fn river(&self, sets: &str, only: &str, delivery: i64) -> Result<(), JobError> {
        let sql = format!("UPDATE river_job SET {sets} WHERE id = $1 AND {only}");
        statement(sql).bind(delivery).run(self.store.writer()).await?;
        Ok(())
    }

    async fn river_hands_out(&self, delivery: i64, worker: Uuid) -> Result<(), JobError> {
        let holder = match self.store.dialect() {
            Dialect::Sqlite => "attempted_by",
            Dialect::Postgres => &format!("array_append(attempted_by, '{worker}')"),
        };
        self.river(&format!("state = 'running', attempted_by = {holder}"), "state = 'available'", delivery).await
    }

    async fn river_is_done(&self, delivery: i64) -> Result<(), JobError> {
        self.river("state = 'completed', finalized_at = CURRENT_TIMESTAMP", "state = 'running'", delivery).await
    }

    async fn river_takes_back(&self, delivery: i64) -> Result<(), JobError> {
        self.river("state = 'available'", "state = 'running'", delivery).await
    }

    async fn an_hour_passes(&self) -> Result<(), JobError> {
        for sql in [
            "UPDATE jobs SET heartbeat_at = heartbeat_at - $1, expires_at = expires_at - $1",
            "UPDATE workers SET heartbeat_at = heartbeat_at - $1",
        ] {
            statement(sql).bind(HOUR.as_micros() as i64).run(self.store.writer()).await?;
        }
        Ok(())
    }

    /// Makes a step and checks the new state.
    async fn step(&self, before: &State, step: Step) -> Result<State, JobError> {
        let mut state = before.clone();
        state.trace.push(step);
        let _trace = TraceOnPanic(state.trace.clone());
        self.make(before, step, &mut state.hands, &mut state.workers).await?;
        state.seen = self.look().await?;
        let mut expected = after(step, before, self.is_file());
        if let (Some(expected), Some(row)) = (&mut expected, &state.seen.row)
            && expected.delivery == 0
            && before.seen.delivery(row.delivery).is_none()
        {
            expected.delivery = row.delivery;
        }
        assert_eq!(state.seen.row, expected);
        check_invariants(step, &before.seen, &state);
        Ok(state)
    }

    async fn make(
        &self,
        before: &State,
        step: Step,
        hands: &mut [Hand; 2],
        workers: &mut [Uuid; 2],
    ) -> Result<(), JobError> {
        let held = |process: usize| match &before.hands[process] {
            Hand::Run { delivery, claim, .. } => (*delivery, claim.clone()),
            other => unreachable!("no run in hand: {other:?}"),
        };
        match step {
            Step::Deliver(process) => {
                let first = before.seen.deliveries.iter().find(|delivery| !delivery.out).expect("one that waits");
                self.river_hands_out(first.id, before.workers[process]).await?;
                hands[process] = Hand::Delivery(first.id);
            }
            Step::Take(process) => {
                let Hand::Delivery(delivery) = before.hands[process] else { unreachable!("no delivery in hand") };
                let limits = |alone| TurnLimits { max_lost_runs: MAX_LOST_RUNS, alone };
                let mut turn = self.store.take_turn(delivery, limits(false)).await?;
                let runs_alone = matches!(turn, Turn::Alone);
                if runs_alone {
                    turn = self.store.take_turn(delivery, limits(true)).await?;
                }
                hands[process] = match turn {
                    Turn::Job(claim) => {
                        assert_eq!(runs_alone, claim.lost >= 2);
                        Hand::Run { delivery, claim, stopped: None }
                    }
                    Turn::Void => {
                        assert!(!runs_alone);
                        self.river_is_done(delivery).await?;
                        Hand::Nothing
                    }
                    other => panic!("a single job was answered by {other:?}"),
                };
            }
            Step::Beat(process) => {
                let answer = self.store.heartbeat(&held(process).1, 0.5, 1.0).await?;
                let cancelled = before.seen.row.as_ref().is_some_and(|row| row.cancel);
                let expected = Heartbeat::of(before.holds(process).then_some(cancelled));
                assert_eq!(answer, expected);
                let here = self.process(before, process);
                let run = here.run.expect("a run");
                apply_heartbeat(Ok(answer), &run);
                let Hand::Run { stopped, .. } = &mut hands[process] else { unreachable!("a run") };
                *stopped = run.stopped();
            }
            Step::Finish(process, solved) => {
                let (delivery, claim) = held(process);
                self.finish(&self.process(before, process), &claim, solved, before.holds(process)).await?;
                let handed_back = matches!(
                    (&before.hands[process], solved),
                    (Hand::Run { stopped: Some(StopReason::HandedBack), .. }, Solved::Obeyed)
                );
                if handed_back {
                    self.river_takes_back(delivery).await?;
                } else {
                    self.river_is_done(delivery).await?;
                }
                hands[process] = Hand::Nothing;
            }
            Step::Stop(process) => match &mut hands[process] {
                Hand::Run { stopped, .. } => *stopped = stopped.or(Some(StopReason::HandedBack)),
                hand => {
                    if let Hand::Delivery(delivery) = hand {
                        self.river_takes_back(*delivery).await?;
                    }
                    *hand = Hand::Nothing;
                }
            },
            Step::Die(process) => {
                if let (true, Hand::Delivery(delivery) | Hand::Run { delivery, .. }) = (self.is_file(), &hands[process])
                {
                    // As `recover_deliveries` does at a start.
                    self.river_takes_back(*delivery).await?;
                }
                hands[process] = Hand::Nothing;
                workers[process] = Uuid::now_v7();
            }
            Step::DeliverAgain => {
                for delivery in before.seen.deliveries.iter().filter(|delivery| delivery.out) {
                    self.river_takes_back(delivery.id).await?;
                }
            }
            Step::Cancel(process) => {
                let here = self.process(before, process);
                let answer = here.jobs.cancel(OWNER, self.job).await;
                match (before.seen.row.as_ref().map(|row| row.status), answer) {
                    (None, Err(JobError::NotFound | JobError::Expired(_))) => {}
                    (Some(Status::Queued | Status::Cancelled), Ok(Cancelled::Now(record))) => {
                        assert_eq!(record.status, Status::Cancelled);
                    }
                    (Some(Status::Running), Ok(Cancelled::Soon(record))) => {
                        assert_eq!(record.status, Status::Running);
                    }
                    (Some(ended), Err(JobError::Conflict(status))) => assert_eq!(status, ended),
                    (was, answer) => panic!("{was:?} was answered by {answer:?}"),
                }
                if let (Hand::Run { stopped, .. }, Some(run)) = (&mut hands[process], here.run) {
                    *stopped = run.stopped();
                }
            }
            Step::Sweep(process) => sweep::sweep(&self.process(before, process).jobs.parts).await?,
            Step::LateSweep(process) => {
                self.an_hour_passes().await?;
                let here = self.process(before, process).jobs;
                sweep::sweep(&here.parts).await?;
                sweep::expire(&here.parts).await?;
            }
            Step::Delete => {
                let answer = self.jobs.delete(OWNER, self.job).await;
                match (before.seen.row.as_ref().map(|row| row.status), answer) {
                    (None, Err(JobError::NotFound | JobError::Expired(_))) => {}
                    (Some(status), Ok(())) => assert!(status.is_final()),
                    (Some(status), Err(JobError::Conflict(reported))) => {
                        assert!(!status.is_final() && reported == status)
                    }
                    (was, answer) => panic!("{was:?} was answered by {answer:?}"),
                }
            }
        }
        Ok(())
    }

    /// Completes a run, as a worker does.
    async fn finish(&self, here: &Process, claim: &Claim, solved: Solved, holds: bool) -> Result<(), JobError> {
        let run = here.run.as_ref().expect("a run");
        let result = || {
            let chunks = RecordedChunks::none();
            StoredResult::Run {
                kind: JobKind::Simulation,
                metrics: Sealed::new(&Place::of_result(chunks.result, "metrics"), "{}".into()),
                signals: Vec::new(),
                chunks,
                views: None,
            }
        };
        let failure = || RunFailure::Failed {
            cause: contract::answer::failure::DID_NOT_CONVERGE,
            detail: "intended by the test".into(),
        };
        let outcome = match (here.worker.end_without_run(claim), solved) {
            (Some(end), _) => RunOutcome::Ended(end, 0.0),
            (None, Solved::Result) => outcome_of(Ok(Ok(result())), 0.0, run, Duration::MAX),
            (None, Solved::Failure) => outcome_of(Ok(Err(failure())), 0.0, run, Duration::MAX),
            (None, Solved::Obeyed) => outcome_of(Ok(Err(RunFailure::Cancelled)), 0.0, run, Duration::MAX),
        };
        match outcome {
            RunOutcome::Ended(end, used_s) => {
                let written = self.store.finish(claim, &end, run.progress(), used_s, self.settings.keep_s).await?;
                assert_eq!(written.is_some(), holds);
                Ok(())
            }
            RunOutcome::HandedBack => self.store.hand_back(claim).await,
            RunOutcome::ClaimLost => Ok(()),
        }
    }

    /// Returns whether a run starts under the claim.
    fn begins(&self, claim: &Claim) -> bool {
        !claim.cancel_requested && claim.lost < self.settings.max_lost_runs
    }

    /// Checks that the job ends after both processes have died, if one new process sweeps and runs deliveries. `known` holds the keys of
    /// states that were checked before.
    async fn reaches_an_end(&self, state: &State, known: &mut HashSet<String>) -> Result<(), JobError> {
        let mut now = state.clone();
        for step in BOTH.map(Step::Die) {
            now = self.step(&now, step).await?;
        }
        if !known.insert(now.key()) {
            return Ok(());
        }
        // The first sweep removes the dead processes from the list, the second redelivers what they held.
        for step in [Step::LateSweep(0), Step::Sweep(0)] {
            now = self.step(&now, step).await?;
        }
        while now.seen.unfinished().is_some() {
            assert!(now.trace.len() < state.trace.len() + 20, "no end: {:?}", now.trace);
            let step = match &now.hands[0] {
                Hand::Nothing => Step::Deliver(0),
                Hand::Delivery(_) => Step::Take(0),
                Hand::Run { claim, .. } if self.begins(claim) => Step::Finish(0, Solved::Result),
                Hand::Run { .. } => Step::Finish(0, Solved::Obeyed),
            };
            now = self.step(&now, step).await?;
        }
        Ok(())
    }
}

/// Makes every step from every state, up to `depth` steps from a queued job with each number of losses and from one that started inline.
/// Returns the number of states.
async fn explore(database: Location, depth: usize) -> Result<usize, JobError> {
    let (mut world, first) = World::new(database).await?;
    let mut frontier = vec![first.clone(), world.inline_run(&first).await?];
    world.restore(&first).await?;
    let mut lost = first;
    for losses in 1..=MAX_LOST_RUNS {
        for step in [Step::Deliver(0), Step::Take(0), Step::LateSweep(1), Step::Finish(0, Solved::Result)] {
            lost = world.step(&lost, step).await?;
        }
        let row = lost.seen.unfinished().expect("the result of a lost run is not written");
        assert_eq!((row.status, row.lost), (Status::Queued, i64::from(losses)));
        world.save(&mut lost).await?;
        frontier.push(lost.clone());
    }
    let mut known: HashSet<String> = frontier.iter().map(State::key).collect();
    let mut known_to_end = HashSet::new();
    let mut steps = 0;
    for _ in 0..depth {
        let mut next = Vec::new();
        for state in &frontier {
            for step in state.steps(|claim| world.begins(claim)) {
                world.restore(state).await?;
                let mut reached = world.step(state, step).await?;
                steps += 1;
                if known.insert(reached.key()) {
                    world.save(&mut reached).await?;
                    world.reaches_an_end(&reached, &mut known_to_end).await?;
                    next.push(reached);
                }
            }
        }
        frontier = next;
    }
    world.jobs.stop().await?;
    println!("{} states in {depth} steps, {steps} steps made", known.len());
    Ok(known.len())
}

fn explored(database: Location, depth: usize) -> usize {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    runtime.block_on(explore(database, depth)).expect("the database answers")
}

/// Environment variable with the depth of the search.
const DEPTH: &str = "RACEWAY_TEST_DEPTH";

fn depth(default: usize) -> usize {
    std::env::var(DEPTH).ok().and_then(|depth| depth.parse().ok()).unwrap_or(default)
}

#[test]
fn the_invariants_of_a_job_hold_in_every_order_of_actions_of_two_processes() {
    let place = tempfile::tempdir().expect("a directory");
    let states = explored(Location::File(place.path().join("jobs.db")), depth(7));
    assert!(states > 300, "only {states} states");
}

/// Without a server the test is skipped, like all tests on PostgreSQL.
#[test]
fn the_invariants_of_a_job_hold_on_postgres() {
    // Power cuts are not explored.
    let Some(database) = new_on_postgres("?options[synchronous_commit]=off") else { return };
    let states = explored(database, depth(4));
    assert!(states > 200, "only {states} states");
}
