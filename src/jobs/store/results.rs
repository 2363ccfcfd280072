//! Results. A simulation has its metrics as JSON text and one row for each spectrum (encoded) and series, whose values are chunks.
//! Jobs of other kinds have one compressed report.

use raceway_core::numerics::parallel::both;
use raceway_core::simulation::result::series::Series;
use serde::Serialize;
use sqlx::FromRow;
use uuid::Uuid;

use super::compression::{compressed, decompressed};
use super::database::{Store, in_time};
use super::dialect::Dialect;
use super::digest::{Place, Sealed};
use super::part_names::{METRICS, REPORT, REQUEST, VIEWS, signal_name};
use super::pool::Tx;
use super::sealed_request::{SEALED_REQUEST, SealedRequest};
use super::series_chunks::{RecordedChunks, completion, insertion_of_chunks, no_metrics};
use super::series_reader::StoredHead;
use super::signal::{Signal, WITH_SIGNALS};
use super::spectrum_codec::{decoded, encoded};
use super::statement::{Statement, statement};
use crate::contract::{JobKind, MachineOutcome, Outcome, SeriesHead, Simulated, SpectrumAnswer, SpectrumKind};
use crate::jobs::error::JobError;
use crate::jobs::job::Status;

/// A result as it is written. It is prepared outside any transaction, because compression and digests take time.
#[derive(Debug)]
pub enum StoredResult {
    /// Of a simulation or a machine: metrics, signals by channel, chunks of the series, and the data of the plots.
    Run {
        kind: JobKind,
        metrics: Sealed<String>,
        signals: Signals,
        chunks: RecordedChunks,
        views: Option<Sealed<Vec<u8>>>,
    },
    Report(Uuid, Sealed<Vec<u8>>),
}

impl StoredResult {
    /// Encodes and compresses the outcome of a job; `chunks`: those of its series.
    pub fn of(outcome: &Outcome, chunks: RecordedChunks) -> Result<Self, JobError> {
        match outcome {
            Outcome::Simulation(simulated) => Self::of_simulation(simulated, chunks),
            Outcome::Accuracy(answer) => Self::of_report(chunks.result, answer),
            Outcome::Modes(answer) => Self::of_report(chunks.result, answer),
            Outcome::Optimum(answer) => Self::of_report(chunks.result, answer),
            Outcome::Rotor(answer) => Self::of_report(chunks.result, answer),
            Outcome::Machine(outcome) => Self::of_machine(outcome, chunks),
        }
    }

    /// Id of the result.
    pub fn id(&self) -> Uuid {
        match self {
            Self::Run { chunks, .. } => chunks.result,
            Self::Report(result, _) => *result,
        }
    }

    fn of_report(result: Uuid, answer: &impl Serialize) -> Result<Self, JobError> {
        Ok(Self::Report(result, sealed(&Place::of_result(result, REPORT), answer)?))
    }

    fn of_machine(outcome: &MachineOutcome, chunks: RecordedChunks) -> Result<Self, JobError> {
        let result = chunks.result;
        let metrics = sealed_metrics(result, &outcome.answer)?;
        let heads = outcome.series.iter().map(|series| series.head.clone());
        let series = heads.enumerate().map(|(number, head)| series_signal(result, &StoredHead::new(head, number)));
        let signals = [spectra_of(result, &outcome.spectra)?, series.collect::<Result<_, _>>()?].concat();
        Ok(Self::Run { kind: JobKind::Machine, metrics, signals, chunks, views: None })
    }

    fn of_simulation(outcome: &Simulated, chunks: RecordedChunks) -> Result<Self, JobError> {
        let result = chunks.result;
        let json = || sealed_metrics(result, &outcome.metrics);
        let seal = |views| sealed(&Place::of_result(result, VIEWS), views);
        let views = || Some(&outcome.views).filter(|views| !views.is_empty()).map(seal).transpose();
        // Half of the work on another core: for a short run it takes nearly as long as the run.
        let (ahead, behind) = outcome.spectra.split_at(outcome.spectra.len() / 2);
        let ((ahead, views), (behind, series, metrics)) = both(
            || (spectra_of(result, ahead), views()),
            || (spectra_of(result, behind), series_of(result, outcome), json()),
        );
        let signals = [ahead?, behind?, series?].concat();
        Ok(Self::Run { kind: JobKind::Simulation, metrics: metrics?, signals, chunks, views: views? })
    }
}

/// Signals by kind and channel.
type Signals = Vec<(Signal, String, Sealed<Vec<u8>>)>;

fn sealed_metrics(result: Uuid, answer: &impl Serialize) -> Result<Sealed<String>, JobError> {
    let text = serde_json::to_string(answer).map_err(|error| JobError::Corrupt(error.to_string()))?;
    Ok(Sealed::new(&Place::of_result(result, METRICS), text))
}

fn sealed(place: &Place, answer: &impl Serialize) -> Result<Sealed<Vec<u8>>, JobError> {
    Ok(Sealed::new(place, compressed(answer)?))
}

fn spectra_of(result: Uuid, spectra: &[SpectrumAnswer]) -> Result<Signals, JobError> {
    let stored = |spectrum: &SpectrumAnswer| {
        let signal = Signal::from(spectrum.kind);
        let place = Place::of_signal(result, signal.name(), &spectrum.channel);
        Ok((signal, spectrum.channel.clone(), Sealed::new(&place, encoded(spectrum)?)))
    };
    spectra.iter().map(stored).collect()
}

fn series_of(result: Uuid, outcome: &Simulated) -> Result<Signals, JobError> {
    let stored = |series: &Series| series_signal(result, &StoredHead::new(SeriesHead::of(series), series.number));
    outcome.series.iter().map(stored).collect()
}

/// The signal of a series whose values are chunks.
pub fn series_signal(result: Uuid, head: &StoredHead) -> Result<(Signal, String, Sealed<Vec<u8>>), JobError> {
    let place = Place::of_signal(result, Signal::Series.name(), &head.head.channel);
    Ok((Signal::Series, head.head.channel.clone(), sealed(&place, head)?))
}

/// Statements that insert a result; `provided` is the end of a query that yields one row if the result is to be inserted.
pub(super) fn insertion(id: Uuid, result: &StoredResult, provided: &str) -> Vec<Statement> {
    // A row is there if the answer to its commit was lost.
    let insert = |into: &str| {
        statement(format!("INSERT INTO {into} SELECT $1, $2, $3{provided} ON CONFLICT DO NOTHING")).bind(id)
    };
    let of_metrics = |metrics: &Sealed<String>| {
        // It is there if chunks of its series are.
        let sql = format!(
            "INSERT INTO results (id, metrics, digest) SELECT $1, $2, $3{provided} \
             ON CONFLICT (id) DO UPDATE SET metrics = excluded.metrics, digest = excluded.digest"
        );
        statement(sql).bind(id).bind(&metrics.content).bind(metrics.digest.as_deref())
    };
    let of_answer = |table: &str, answer: &Sealed<Vec<u8>>| {
        insert(&format!("{table} (result_id, answer, digest)")).bind(&answer.content).bind(answer.digest.as_deref())
    };
    match result {
        StoredResult::Report(_, answer) => vec![of_metrics(&no_metrics(id)), of_answer("reports", answer)],
        StoredResult::Run { metrics, signals, chunks, views, .. } => {
            let mut statements = vec![of_metrics(metrics)];
            if !signals.is_empty() {
                statements.push(insertion_of_signals(id, signals, provided));
            }
            if !chunks.rest.is_empty() {
                statements.push(insertion_of_chunks(id, &chunks.rest, provided));
            }
            if chunks.is_stored {
                statements.push(completion(id, provided));
            }
            statements.extend(views.iter().map(|views| of_answer("views", views)));
            statements
        }
    }
}

fn insertion_of_signals(id: Uuid, signals: &Signals, provided: &str) -> Statement {
    let row = |k| format!("SELECT $1, ${}, ${}, ${}, ${}{provided}", 4 * k + 2, 4 * k + 3, 4 * k + 4, 4 * k + 5);
    let rows: Vec<String> = (0..signals.len()).map(row).collect();
    let insert = format!(
        "INSERT INTO signals (result_id, sort, channel, answer, digest) {} ON CONFLICT DO NOTHING",
        rows.join(" UNION ALL ")
    );
    signals.iter().fold(statement(insert).bind(id), |insert, (signal, channel, answer)| {
        insert.bind(signal.name()).bind(channel).bind(&answer.content).bind(answer.digest.as_deref())
    })
}

/// Inserts an empty result, for a study, whose points hold their own results.
pub(super) async fn insert_empty(tx: &mut Tx) -> Result<Uuid, JobError> {
    let id = Uuid::now_v7();
    let Sealed { content, digest } = no_metrics(id);
    let sql = "INSERT INTO results (id, metrics, digest) VALUES ($1, $2, $3)";
    statement(sql).bind(id).bind(content).bind(digest.as_deref()).run(&mut *tx).await?;
    Ok(id)
}

/// Removes a result unless a job refers to it.
pub(super) async fn remove_orphan(tx: &mut Tx, result: Uuid) -> Result<(), JobError> {
    remove_orphans(tx, &[result]).await
}

/// Removes the results that no job refers to, of these in ascending order.
pub(super) async fn remove_orphans(tx: &mut Tx, results: &[Uuid]) -> Result<(), JobError> {
    if results.is_empty() {
        return Ok(());
    }
    let places = (1..=results.len()).map(|place| format!("${place}")).collect::<Vec<_>>().join(", ");
    let of = |sql: String| results.iter().fold(statement(sql), Statement::bind);
    // Serialized: two transactions that delete the last two jobs would each still see the other job.
    if tx.dialect() == Dialect::Postgres {
        of(format!("SELECT 1 FROM results WHERE id IN ({places}) ORDER BY id FOR UPDATE")).run(&mut *tx).await?;
    }
    let sql = format!(
        "DELETE FROM results WHERE id IN ({places}) AND NOT EXISTS (SELECT 1 FROM jobs WHERE result_id = results.id)"
    );
    of(sql).run(&mut *tx).await?;
    Ok(())
}

impl Store {
    /// The metrics of a succeeded simulation or machine job, as JSON text.
    pub async fn metrics(&self, owner: &str, job: Uuid, kind: JobKind) -> Result<String, JobError> {
        let result = self.result_of(owner, job, kind).await?;
        let sql = "SELECT metrics, digest FROM results WHERE id = $1";
        let read = async {
            one_part(statement(sql).bind(result).optional(&self.readers).await?)?
                .opened(&Place::of_result(result, METRICS))
        };
        self.noted(job, METRICS, read.await).await
    }

    /// A spectrum of a succeeded job.
    pub async fn spectrum(
        &self,
        owner: &str,
        job: Uuid,
        kind: SpectrumKind,
        channel: &str,
    ) -> Result<SpectrumAnswer, JobError> {
        let result = self.result_among(owner, job, &WITH_SIGNALS).await?;
        self.signal(job, result, kind.into(), channel, decoded).await
    }

    /// A signal of a job's result.
    pub(super) async fn signal<T: Send + 'static>(
        &self,
        job: Uuid,
        result: Uuid,
        signal: Signal,
        channel: &str,
        open: fn(&[u8]) -> Result<T, JobError>,
    ) -> Result<T, JobError> {
        let sql = "SELECT answer, digest FROM signals WHERE result_id = $1 AND sort = $2 AND channel = $3";
        let query = statement(sql).bind(result).bind(signal.name()).bind(channel);
        let place = Place::of_signal(result, signal.name(), channel);
        let read = async {
            match query.optional(&self.readers).await? {
                Some(answer) => {
                    let open = move |stored: Sealed<Vec<u8>>| open(&stored.opened(&place)?);
                    read_aside(Sealed::stored(answer), open).await.map(Some)
                }
                None => Ok(None),
            }
        };
        match self.noted(job, &signal_name(signal.name(), channel), read.await).await? {
            Some(answer) => Ok(answer),
            None => Err(JobError::UnknownChannel { kept: self.kept(result, signal).await? }),
        }
    }

    /// Data of the plots of a succeeded simulation, as JSON text; `None` if none are kept.
    pub async fn views(&self, owner: &str, job: Uuid) -> Result<Option<Vec<u8>>, JobError> {
        let result = self.result_of(owner, job, JobKind::Simulation).await?;
        let sql = "SELECT answer, digest FROM views WHERE result_id = $1";
        let read = async {
            let answer: Option<(Vec<u8>, Option<Vec<u8>>)> =
                statement(sql).bind(result).optional(&self.readers).await?;
            let place = Place::of_result(result, VIEWS);
            answer.map(|answer| decompressed(&Sealed::stored(answer).opened(&place)?)).transpose()
        };
        self.noted(job, VIEWS, read.await).await
    }

    /// The report of a succeeded optimum or accuracy job, as JSON text.
    pub async fn report(&self, owner: &str, job: Uuid, kind: JobKind) -> Result<Vec<u8>, JobError> {
        let result = self.result_of(owner, job, kind).await?;
        let sql = "SELECT answer, digest FROM reports WHERE result_id = $1";
        let read = async {
            let answer: Option<(Vec<u8>, Option<Vec<u8>>)> =
                statement(sql).bind(result).optional(&self.readers).await?;
            decompressed(&one_part(answer)?.opened(&Place::of_result(result, REPORT))?)
        };
        self.noted(job, REPORT, read.await).await
    }

    /// Channels for which a job keeps a signal of this kind.
    pub async fn channels(&self, owner: &str, job: Uuid, signal: Signal) -> Result<Vec<String>, JobError> {
        let result = self.result_among(owner, job, &WITH_SIGNALS).await?;
        self.kept(result, signal).await
    }

    async fn kept(&self, result: Uuid, signal: Signal) -> Result<Vec<String>, JobError> {
        let order = match self.dialect() {
            Dialect::Sqlite => "rowid",
            Dialect::Postgres => "number",
        };
        let sql = format!("SELECT channel FROM signals WHERE result_id = $1 AND sort = $2 ORDER BY {order}");
        statement(sql).bind(result).bind(signal.name()).values(&self.readers).await
    }

    /// Digest of everything that determines the result of a succeeded job; `None` for any other job.
    pub async fn fingerprint(&self, owner: &str, job: Uuid) -> Result<Option<Fingerprint>, JobError> {
        let sql = "SELECT content_hash AS work, CASE WHEN kind IN ($3, $4) THEN finished_at END AS study_ended FROM jobs \
                   WHERE id = $1 AND owner = $2 AND status = 'succeeded'";
        let [study, uncertainty] = [JobKind::Study, JobKind::Uncertainty].map(JobKind::name);
        statement(sql).bind(job).bind(owner).bind(study).bind(uncertainty).optional(&self.readers).await
    }

    /// The result of a job of the wanted kind; jobs of other kinds never have such a result.
    pub(super) async fn result_of(&self, owner: &str, job: Uuid, wanted: JobKind) -> Result<Uuid, JobError> {
        self.result_among(owner, job, &[wanted]).await
    }

    /// The result of a job of one of the wanted kinds.
    pub(super) async fn result_among(&self, owner: &str, job: Uuid, wanted: &[JobKind]) -> Result<Uuid, JobError> {
        let sql = format!("SELECT status, result_id, kind, {SEALED_REQUEST} FROM jobs WHERE id = $1 AND owner = $2");
        #[derive(FromRow)]
        struct Row {
            status: String,
            result_id: Option<Uuid>,
            kind: String,
            #[sqlx(flatten)]
            request: SealedRequest,
        }
        let read = async {
            let row: Option<Row> = in_time(statement(sql).bind(job).bind(owner).optional(&self.readers)).await?;
            let row = row.ok_or(JobError::NotFound)?;
            row.request.check(job, owner)?;
            Ok((row.status, row.result_id, row.kind))
        };
        result_in(self.noted(job, REQUEST, read.await).await?, wanted)
    }
}

fn result_in((status, result, kind): (String, Option<Uuid>, String), wanted: &[JobKind]) -> Result<Uuid, JobError> {
    if !wanted.iter().any(|wanted| kind == wanted.name()) {
        return Err(JobError::OtherKind { kind });
    }
    match (result, Status::parse(&status)) {
        (Some(result), _) => Ok(result),
        (None, Some(status)) if status.is_final() => Err(JobError::NoResult(status)),
        (None, Some(status)) => Err(JobError::NotReady(status)),
        (None, None) => Err(JobError::Corrupt(format!("status {status}"))),
    }
}

/// Fields that determine the result of a succeeded job.
#[derive(Debug, Clone, PartialEq, Eq, FromRow)]
pub struct Fingerprint {
    /// Digest of the work.
    pub work: Vec<u8>,
    /// Of a study, when it ended [µs since 1970]: its table changes when it is resumed.
    pub study_ended: Option<i64>,
}

/// The part of a result that every result of its kind has.
fn one_part<T: AsRef<[u8]>>(row: Option<(T, Option<Vec<u8>>)>) -> Result<Sealed<T>, JobError> {
    row.map(Sealed::stored).ok_or_else(|| JobError::Corrupt("its row is missing".to_owned()))
}

/// Reads a stored answer; a long one on a thread that delays no request.
pub(super) async fn read_aside<T: Send + 'static>(
    stored: Sealed<Vec<u8>>,
    read: impl FnOnce(Sealed<Vec<u8>>) -> Result<T, JobError> + Send + 'static,
) -> Result<T, JobError> {
    if stored.content.len() < LONG_ANSWER_BYTES {
        return read(stored);
    }
    let read = tokio::task::spawn_blocking(move || read(stored)).await;
    read.unwrap_or_else(|error| Err(JobError::Corrupt(error.to_string())))
}

/// Length from which reading takes some milliseconds [B].
pub(super) const LONG_ANSWER_BYTES: usize = 256 << 10;
