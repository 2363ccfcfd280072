//! Results. A simulation has its metrics as JSON text and one row for each spectrum (encoded) and series (compressed). Jobs of
//! other kinds have one compressed report.

use raceway_core::numerics::parallel::both;
use uuid::Uuid;

use super::compression::{compressed, decompressed};
use super::database::Store;
use super::dialect::Dialect;
use super::pool::Tx;
use super::spectrum_codec::{decoded, encoded};
use super::statement::{Statement, statement};
use crate::contract::{JobKind, Outcome, SeriesAnswer, Simulated, SpectrumAnswer, SpectrumKind};
use crate::jobs::error::JobError;
use crate::jobs::job::Status;

/// Kind of a stored signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signal {
    Amplitude,
    Envelope,
    Series,
}

impl From<SpectrumKind> for Signal {
    fn from(kind: SpectrumKind) -> Self {
        match kind {
            SpectrumKind::Amplitude => Self::Amplitude,
            SpectrumKind::Envelope => Self::Envelope,
        }
    }
}

impl Signal {
    fn name(self) -> &'static str {
        match self {
            Self::Amplitude => "amplitude",
            Self::Envelope => "envelope",
            Self::Series => "series",
        }
    }
}

/// A result as it is written. It is prepared outside any transaction, because compression takes time.
#[derive(Debug)]
pub enum StoredResult {
    /// Metrics, signals by channel, and the data of the plots.
    Simulation {
        metrics: String,
        signals: Signals,
        views: Option<Vec<u8>>,
    },
    Report(Vec<u8>),
}

impl StoredResult {
    /// Encodes and compresses the outcome of a job.
    pub fn of(outcome: &Outcome) -> Result<Self, JobError> {
        match outcome {
            Outcome::Simulation(simulated) => Self::of_simulation(simulated),
            Outcome::Accuracy(answer) => Ok(Self::Report(compressed(answer)?)),
            Outcome::Optimum(answer) => Ok(Self::Report(compressed(answer)?)),
        }
    }

    fn of_simulation(outcome: &Simulated) -> Result<Self, JobError> {
        let json = || serde_json::to_string(&outcome.metrics).map_err(|error| JobError::Corrupt(error.to_string()));
        let views = || Some(&outcome.views).filter(|views| !views.is_empty()).map(compressed).transpose();
        // Half of the work on another core: for a short run it takes nearly as long as the run.
        let (ahead, behind) = outcome.spectra.split_at(outcome.spectra.len() / 2);
        let ((ahead, views), (behind, series, metrics)) =
            both(|| (spectra_of(ahead), views()), || (spectra_of(behind), series_of(outcome), json()));
        Ok(Self::Simulation { metrics: metrics?, signals: [ahead?, behind?, series?].concat(), views: views? })
    }
}

type Signals = Vec<(Signal, String, Vec<u8>)>;

fn spectra_of(spectra: &[SpectrumAnswer]) -> Result<Signals, JobError> {
    let stored =
        |spectrum: &SpectrumAnswer| Ok((Signal::from(spectrum.kind), spectrum.channel.clone(), encoded(spectrum)?));
    spectra.iter().map(stored).collect()
}

fn series_of(outcome: &Simulated) -> Result<Signals, JobError> {
    let stored = |series: &SeriesAnswer| Ok((Signal::Series, series.channel.clone(), compressed(series)?));
    outcome.series.iter().map(stored).collect()
}

/// Statements that insert a result; `provided` is the end of a query that yields one row if the result is to be inserted.
pub(super) fn insertion(id: Uuid, result: &StoredResult, provided: &str) -> Vec<Statement> {
    let insert = |into: &str| statement(format!("INSERT INTO {into} SELECT $1, $2{provided}")).bind(id);
    match result {
        StoredResult::Report(answer) => {
            vec![insert("results (id, metrics)").bind(""), insert("reports (result_id, answer)").bind(answer)]
        }
        StoredResult::Simulation { metrics, signals, views } => {
            let mut statements = vec![insert("results (id, metrics)").bind(metrics)];
            if !signals.is_empty() {
                statements.push(insertion_of_signals(id, signals, provided));
            }
            statements.extend(views.iter().map(|views| insert("views (result_id, answer)").bind(views)));
            statements
        }
    }
}

fn insertion_of_signals(id: Uuid, signals: &[(Signal, String, Vec<u8>)], provided: &str) -> Statement {
    let row = |k| format!("SELECT $1, ${}, ${}, ${}{provided}", 3 * k + 2, 3 * k + 3, 3 * k + 4);
    let rows: Vec<String> = (0..signals.len()).map(row).collect();
    let insert = format!("INSERT INTO signals (result_id, sort, channel, answer) {}", rows.join(" UNION ALL "));
    signals.iter().fold(statement(insert).bind(id), |insert, (signal, channel, answer)| {
        insert.bind(signal.name()).bind(channel).bind(answer)
    })
}

/// Inserts an empty result, for a study, whose points hold their own results.
pub(super) async fn insert_empty(tx: &mut Tx) -> Result<Uuid, JobError> {
    let id = Uuid::now_v7();
    statement("INSERT INTO results (id, metrics) VALUES ($1, '')").bind(id).run(&mut *tx).await?;
    Ok(id)
}

/// Removes a result unless a job refers to it.
pub(super) async fn remove_orphan(tx: &mut Tx, result: Uuid) -> Result<(), JobError> {
    // Serialized: two transactions that delete the last two jobs would each still see the other job.
    if tx.dialect() == Dialect::Postgres {
        statement("SELECT 1 FROM results WHERE id = $1 FOR UPDATE").bind(result).run(&mut *tx).await?;
    }
    let sql = "DELETE FROM results WHERE id = $1 AND NOT EXISTS (SELECT 1 FROM jobs WHERE result_id = $1)";
    statement(sql).bind(result).run(&mut *tx).await?;
    Ok(())
}

impl Store {
    /// The metrics of a succeeded job, as JSON text.
    pub async fn metrics(&self, owner: &str, job: Uuid) -> Result<String, JobError> {
        let sql = "SELECT status, result_id, kind, metrics FROM jobs LEFT JOIN results ON results.id = jobs.result_id \
                   WHERE jobs.id = $1 AND owner = $2";
        type Row = (String, Option<Uuid>, String, Option<String>);
        let row: Option<Row> = statement(sql).bind(job).bind(owner).optional(&self.readers).await?;
        let (status, result, kind, metrics) = row.ok_or(JobError::NotFound)?;
        result_in((status, result, kind), JobKind::Simulation)?;
        metrics.ok_or(JobError::NotFound)
    }

    /// A spectrum of a succeeded job.
    pub async fn spectrum(
        &self,
        owner: &str,
        job: Uuid,
        kind: SpectrumKind,
        channel: &str,
    ) -> Result<SpectrumAnswer, JobError> {
        let stored = self.signal(owner, job, kind.into(), channel).await?;
        read_aside(stored, |stored| decoded(&stored)).await
    }

    /// A series of a succeeded job, as JSON text.
    pub async fn series(&self, owner: &str, job: Uuid, channel: &str) -> Result<Vec<u8>, JobError> {
        let stored = self.signal(owner, job, Signal::Series, channel).await?;
        read_aside(stored, |stored| decompressed(&stored)).await
    }

    async fn signal(&self, owner: &str, job: Uuid, signal: Signal, channel: &str) -> Result<Vec<u8>, JobError> {
        let result = self.result_of(owner, job, JobKind::Simulation).await?;
        let sql = "SELECT answer FROM signals WHERE result_id = $1 AND sort = $2 AND channel = $3";
        let answer: Option<Vec<u8>> =
            statement(sql).bind(result).bind(signal.name()).bind(channel).value(&self.readers).await?;
        match answer {
            Some(answer) => Ok(answer),
            None => Err(JobError::UnknownChannel { kept: self.kept(result, signal).await? }),
        }
    }

    /// Data of the plots of a succeeded simulation, as JSON text; `None` if none are kept.
    pub async fn views(&self, owner: &str, job: Uuid) -> Result<Option<Vec<u8>>, JobError> {
        let result = self.result_of(owner, job, JobKind::Simulation).await?;
        let sql = "SELECT answer FROM views WHERE result_id = $1";
        let answer: Option<Vec<u8>> = statement(sql).bind(result).value(&self.readers).await?;
        answer.map(|answer| decompressed(&answer)).transpose()
    }

    /// The report of a succeeded optimum or accuracy job, as JSON text.
    pub async fn report(&self, owner: &str, job: Uuid, kind: JobKind) -> Result<Vec<u8>, JobError> {
        let result = self.result_of(owner, job, kind).await?;
        let sql = "SELECT answer FROM reports WHERE result_id = $1";
        let answer: Option<Vec<u8>> = statement(sql).bind(result).value(&self.readers).await?;
        decompressed(&answer.ok_or(JobError::NotFound)?)
    }

    /// Channels for which a job keeps a signal of this kind.
    pub async fn channels(&self, owner: &str, job: Uuid, signal: Signal) -> Result<Vec<String>, JobError> {
        let result = self.result_of(owner, job, JobKind::Simulation).await?;
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
    pub async fn fingerprint(&self, owner: &str, job: Uuid) -> Result<Option<Vec<u8>>, JobError> {
        let sql = "SELECT content_hash FROM jobs WHERE id = $1 AND owner = $2 AND status = 'succeeded'";
        statement(sql).bind(job).bind(owner).value(&self.readers).await
    }

    /// The result of a job of the wanted kind; jobs of other kinds never have such a result.
    async fn result_of(&self, owner: &str, job: Uuid, wanted: JobKind) -> Result<Uuid, JobError> {
        let sql = "SELECT status, result_id, kind FROM jobs WHERE id = $1 AND owner = $2";
        let row: Option<(String, Option<Uuid>, String)> =
            statement(sql).bind(job).bind(owner).optional(&self.readers).await?;
        result_in(row.ok_or(JobError::NotFound)?, wanted)
    }
}

fn result_in((status, result, kind): (String, Option<Uuid>, String), wanted: JobKind) -> Result<Uuid, JobError> {
    if kind != wanted.name() {
        return Err(JobError::OtherKind { kind });
    }
    match (result, Status::parse(&status)) {
        (Some(result), _) => Ok(result),
        (None, Some(status)) if status.is_final() => Err(JobError::NoResult(status)),
        (None, Some(status)) => Err(JobError::NotReady(status)),
        (None, None) => Err(JobError::Corrupt(format!("status {status}"))),
    }
}

/// Reads a stored answer; a long one on a thread that delays no request.
async fn read_aside<T: Send + 'static>(
    stored: Vec<u8>,
    read: fn(Vec<u8>) -> Result<T, JobError>,
) -> Result<T, JobError> {
    if stored.len() < LONG_ANSWER_BYTES {
        return read(stored);
    }
    let read = tokio::task::spawn_blocking(move || read(stored)).await;
    read.unwrap_or_else(|error| Err(JobError::Corrupt(error.to_string())))
}

/// Length from which reading takes some milliseconds [B].
const LONG_ANSWER_BYTES: usize = 256 << 10;
