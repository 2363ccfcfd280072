//! SQLite in a file or PostgreSQL on a server, and statements that run on both: each is written once, with `$1`, `$2`, … for
//! what is bound. Where the two speak differently, `Dialect` says how.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::postgres::{PgArguments, PgConnectOptions, PgPool, PgPoolOptions, PgRow};
use sqlx::sqlite::{
    SqliteArguments, SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteRow,
    SqliteSynchronous,
};
use sqlx::{
    Arguments, AssertSqlSafe, Connection, FromRow, PgConnection, Postgres, SqlSafeStr, Sqlite, SqliteConnection,
    Transaction,
};
use uuid::Uuid;

use crate::jobs::JobError;

/// Where the records are.
#[derive(Clone)]
pub enum Location {
    File(PathBuf),
    Server(Box<PgConnectOptions>),
}

impl Location {
    /// A PostgreSQL server by its URL; `None` where that is none.
    pub fn server(url: &str) -> Option<Self> {
        PgConnectOptions::from_str(url).ok().map(|options| Self::Server(Box::new(options)))
    }

    /// The product behind it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::File(_) => "SQLite",
            Self::Server(_) => "PostgreSQL",
        }
    }
}

/// Without user and password.
impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Server(options) => {
                let database = options.get_database().unwrap_or_default();
                write!(f, "postgres://{}:{}/{database}", options.get_host(), options.get_port())
            }
        }
    }
}

impl fmt::Debug for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Connections of one kind.
#[derive(Debug, Clone)]
pub enum Pool {
    Sqlite(SqlitePool),
    Postgres(PgPool),
}

/// What the two databases say differently.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    Sqlite,
    Postgres,
}

impl Dialect {
    /// The database's own clock, in microseconds since 1970: machines that share a database share no other.
    pub fn now(self) -> &'static str {
        match self {
            Self::Sqlite => "CAST((julianday('now') - 2440587.5) * 86400000000.0 AS INTEGER)",
            Self::Postgres => "CAST(extract(epoch FROM clock_timestamp()) * 1000000 AS BIGINT)",
        }
    }

    /// Whether the labels of a job hold what is bound at this place.
    pub fn has_label(self, place: usize) -> String {
        match self {
            Self::Sqlite => {
                format!("EXISTS (SELECT 1 FROM json_each(jobs.labels) AS label WHERE label.value = ${place})")
            }
            Self::Postgres => format!("jsonb_exists(CAST(jobs.labels AS JSONB), ${place})"),
        }
    }

    /// Whether a delivery, `river_job`, is in the hands of a process that is not among the workers any more. The process of a file
    /// has it all delivered again when it starts.
    pub fn is_orphaned(self) -> &'static str {
        match self {
            Self::Sqlite => "FALSE",
            Self::Postgres => {
                "river_job.state = 'running' AND NOT EXISTS (SELECT 1 FROM workers WHERE CAST(workers.id AS TEXT) \
                 = river_job.attempted_by[array_upper(river_job.attempted_by, 1)])"
            }
        }
    }

    /// Keeps the rows that a statement reads from being changed until its transaction ends. On SQLite nobody else writes.
    pub fn for_share(self) -> &'static str {
        match self {
            Self::Sqlite => "",
            Self::Postgres => " FOR SHARE",
        }
    }
}

impl Pool {
    pub fn dialect(&self) -> Dialect {
        match self {
            Self::Sqlite(_) => Dialect::Sqlite,
            Self::Postgres(_) => Dialect::Postgres,
        }
    }

    /// Begins a write transaction.
    pub async fn begin(&self) -> Result<Tx, JobError> {
        Ok(match self {
            Self::Sqlite(pool) => Tx::Sqlite(riverqueue::database::begin_sqlite_write(pool).await?),
            Self::Postgres(pool) => Tx::Postgres(riverqueue::database::begin_postgres(pool).await?),
        })
    }

    /// Begins one that waits until no other process does this. SQLite has one writer at a time anyway.
    pub async fn begin_alone(&self, lock: Lock) -> Result<Tx, JobError> {
        match self {
            Self::Sqlite(_) => self.begin().await,
            // Both in one way to the server and back.
            Self::Postgres(pool) => {
                let begin = format!("BEGIN; SELECT pg_advisory_xact_lock({})", lock as i64);
                Ok(Tx::Postgres(pool.begin_with(AssertSqlSafe(begin)).await?))
            }
        }
    }

    pub async fn close(&self) {
        match self {
            Self::Sqlite(pool) => pool.close().await,
            Self::Postgres(pool) => pool.close().await,
        }
    }
}

/// A write transaction.
#[derive(Debug)]
pub enum Tx {
    Sqlite(Transaction<'static, Sqlite>),
    Postgres(Transaction<'static, Postgres>),
}

/// What only one process does at a time, on servers that several share.
#[derive(Debug, Clone, Copy)]
pub enum Lock {
    /// Bringing the tables up to date.
    Migration = 0x7261_6365,
    /// Taking submissions: limits and idempotency keys are looked up before rows are added.
    Intake,
    /// Looking for what was lost.
    Sweep,
}

impl Tx {
    pub fn dialect(&self) -> Dialect {
        match self {
            Self::Sqlite(_) => Dialect::Sqlite,
            Self::Postgres(_) => Dialect::Postgres,
        }
    }

    pub async fn commit(self) -> Result<(), JobError> {
        match self {
            Self::Sqlite(tx) => tx.commit().await?,
            Self::Postgres(tx) => tx.commit().await?,
        }
        Ok(())
    }

    /// Tells all processes that a job has ended, once the transaction is committed.
    pub async fn tell_ended(&mut self, job: Uuid) -> Result<(), JobError> {
        self.tell(ENDED, job).await
    }

    /// Tells all processes that someone wants a job to end, once the transaction is committed.
    pub async fn tell_cancelled(&mut self, job: Uuid) -> Result<(), JobError> {
        self.tell(CANCELLED, job).await
    }

    async fn tell(&mut self, channel: &str, job: Uuid) -> Result<(), JobError> {
        if self.dialect() == Dialect::Postgres {
            statement("SELECT pg_notify($1, $2)").bind(channel).bind(job.to_string()).run(self).await?;
        }
        Ok(())
    }
}

/// Channels of what processes that share a database tell each other; the message is a job's id.
pub const ENDED: &str = "raceway_ended";
pub const CANCELLED: &str = "raceway_cancelled";

/// Where a statement runs.
pub enum Place<'a> {
    SqlitePool(&'a SqlitePool),
    SqliteTx(&'a mut SqliteConnection),
    PgPool(&'a PgPool),
    PgTx(&'a mut PgConnection),
}

impl<'a> From<&'a Pool> for Place<'a> {
    fn from(pool: &'a Pool) -> Self {
        match pool {
            Pool::Sqlite(pool) => Self::SqlitePool(pool),
            Pool::Postgres(pool) => Self::PgPool(pool),
        }
    }
}

impl<'a> From<&'a mut Tx> for Place<'a> {
    fn from(tx: &'a mut Tx) -> Self {
        match tx {
            Tx::Sqlite(tx) => Self::SqliteTx(tx),
            Tx::Postgres(tx) => Self::PgTx(tx),
        }
    }
}

/// What both databases give as a row of this kind.
pub trait Record: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin {}
impl<T: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin> Record for T {}

/// What can be bound.
#[derive(Debug, Clone)]
pub enum Value {
    Uuid(Option<Uuid>),
    Text(Option<String>),
    Integer(Option<i64>),
    Real(Option<f64>),
    Bool(bool),
    Bytes(Option<Vec<u8>>),
}

macro_rules! binds {
    ($($type:ty => $kind:ident: |$value:ident| $made:expr;)*) => {
        $(impl From<$type> for Value {
            fn from($value: $type) -> Self {
                Self::$kind($made)
            }
        })*
    };
}

binds! {
    Uuid => Uuid: |id| Some(id);
    &Uuid => Uuid: |id| Some(*id);
    Option<Uuid> => Uuid: |id| id;
    &str => Text: |text| Some(text.to_owned());
    &String => Text: |text| Some(text.clone());
    String => Text: |text| Some(text);
    Option<&str> => Text: |text| text.map(str::to_owned);
    Option<&String> => Text: |text| text.cloned();
    i64 => Integer: |number| Some(number);
    &i64 => Integer: |number| Some(*number);
    Option<i64> => Integer: |number| number;
    f64 => Real: |number| Some(number);
    Option<f64> => Real: |number| number;
    bool => Bool: |truth| truth;
    &[u8] => Bytes: |bytes| Some(bytes.to_vec());
    &Vec<u8> => Bytes: |bytes| Some(bytes.clone());
    Vec<u8> => Bytes: |bytes| Some(bytes);
    Option<&[u8]> => Bytes: |bytes| bytes.map(<[u8]>::to_vec);
}

/// A statement with what is bound to its places.
#[derive(Debug)]
pub struct Statement {
    sql: sqlx::SqlStr,
    values: Vec<Value>,
}

/// A statement; text that was put together holds nothing that came from outside.
pub fn statement(sql: impl Into<std::borrow::Cow<'static, str>>) -> Statement {
    let sql = match sql.into() {
        std::borrow::Cow::Borrowed(sql) => sql.into_sql_str(),
        std::borrow::Cow::Owned(sql) => AssertSqlSafe(sql).into_sql_str(),
    };
    Statement { sql, values: Vec::new() }
}

/// SQL whose places `$1`, `$2`, … come so many later.
fn shifted(sql: &str, by: usize) -> String {
    let mut parts = sql.split('$');
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let digits = part.find(|c: char| !c.is_ascii_digit()).unwrap_or(part.len());
        let place = part[..digits].parse::<usize>().map_or_else(|_| String::new(), |place| (place + by).to_string());
        format!("{text}${place}{}", &part[digits..])
    })
}

/// The same code for each database; `Db` is its type within.
macro_rules! at {
    ($statement:ident, $place:expr, |$sql:ident, $arguments:ident, $executor:ident| $body:expr) => {
        match $place.into() {
            Place::SqlitePool($executor) => {
                type Db = Sqlite;
                let ($sql, $arguments) = $statement.arguments::<SqliteArguments, Db>()?;
                $body
            }
            Place::SqliteTx($executor) => {
                type Db = Sqlite;
                let ($sql, $arguments) = $statement.arguments::<SqliteArguments, Db>()?;
                $body
            }
            Place::PgPool($executor) => {
                type Db = Postgres;
                let ($sql, $arguments) = $statement.arguments::<PgArguments, Db>()?;
                $body
            }
            Place::PgTx($executor) => {
                type Db = Postgres;
                let ($sql, $arguments) = $statement.arguments::<PgArguments, Db>()?;
                $body
            }
        }
    };
}

impl Statement {
    /// Binds the next place.
    #[must_use]
    pub fn bind(mut self, value: impl Into<Value>) -> Self {
        self.values.push(value.into());
        self
    }

    /// The same with others before it, each by a name that those after it may ask, as PostgreSQL has them in one.
    pub fn with(mut self, before: impl IntoIterator<Item = (String, Self)>) -> Self {
        let mut steps = Vec::new();
        for (name, statement) in before {
            steps.push(format!("{name} AS ({})", shifted(statement.sql.as_str(), self.values.len())));
            self.values.extend(statement.values);
        }
        let sql = format!("WITH {} {}", steps.join(", "), self.sql.as_str());
        Self { sql: AssertSqlSafe(sql).into_sql_str(), ..self }
    }

    fn arguments<A, Db>(self) -> Result<(sqlx::SqlStr, A), JobError>
    where
        Db: sqlx::Database,
        A: Arguments<Database = Db>,
        Option<Uuid>: for<'q> sqlx::Encode<'q, Db> + sqlx::Type<Db>,
        Option<String>: for<'q> sqlx::Encode<'q, Db> + sqlx::Type<Db>,
        Option<i64>: for<'q> sqlx::Encode<'q, Db> + sqlx::Type<Db>,
        Option<f64>: for<'q> sqlx::Encode<'q, Db> + sqlx::Type<Db>,
        bool: for<'q> sqlx::Encode<'q, Db> + sqlx::Type<Db>,
        Option<Vec<u8>>: for<'q> sqlx::Encode<'q, Db> + sqlx::Type<Db>,
    {
        let mut arguments = A::default();
        for value in self.values {
            match value {
                Value::Uuid(id) => arguments.add(id),
                Value::Text(text) => arguments.add(text),
                Value::Integer(number) => arguments.add(number),
                Value::Real(number) => arguments.add(number),
                Value::Bool(truth) => arguments.add(truth),
                Value::Bytes(bytes) => arguments.add(bytes),
            }
            .map_err(sqlx::Error::Encode)?;
        }
        Ok((self.sql, arguments))
    }

    /// Runs it; the number of rows that it has changed.
    pub async fn run<'a>(self, place: impl Into<Place<'a>>) -> Result<u64, JobError> {
        at!(self, place, |sql, arguments, executor| {
            Ok(sqlx::query_with::<Db, _>(sql, arguments).execute(executor).await?.rows_affected())
        })
    }

    /// The first row, if there is one. All are read: a statement outside of transactions is committed after its last.
    pub async fn optional<'a, T: Record>(self, place: impl Into<Place<'a>>) -> Result<Option<T>, JobError> {
        Ok(self.all(place).await?.into_iter().next())
    }

    /// The one row that there is.
    pub async fn one<'a, T: Record>(self, place: impl Into<Place<'a>>) -> Result<T, JobError> {
        self.optional(place).await?.ok_or(JobError::Database(sqlx::Error::RowNotFound))
    }

    /// All rows.
    pub async fn all<'a, T: Record>(self, place: impl Into<Place<'a>>) -> Result<Vec<T>, JobError> {
        at!(self, place, |sql, arguments, executor| {
            Ok(sqlx::query_as_with::<Db, T, _>(sql, arguments).fetch_all(executor).await?)
        })
    }

    /// Row after row, until the taker has enough.
    pub async fn each<'a, T: Record>(
        self,
        place: impl Into<Place<'a>>,
        mut takes_more: impl FnMut(T) -> Result<bool, JobError>,
    ) -> Result<(), JobError> {
        use futures_util::TryStreamExt;
        at!(self, place, |sql, arguments, executor| {
            let mut rows = sqlx::query_as_with::<Db, T, _>(sql, arguments).fetch(executor);
            while let Some(row) = rows.try_next().await? {
                if !takes_more(row)? {
                    break;
                }
            }
            Ok(())
        })
    }

    /// The first column of the first row, if there is one.
    pub async fn value<'a, T>(self, place: impl Into<Place<'a>>) -> Result<Option<T>, JobError>
    where
        (T,): Record,
    {
        Ok(self.optional::<(T,)>(place).await?.map(|row| row.0))
    }

    /// The first column of every row.
    pub async fn values<'a, T>(self, place: impl Into<Place<'a>>) -> Result<Vec<T>, JobError>
    where
        (T,): Record,
    {
        Ok(self.all::<(T,)>(place).await?.into_iter().map(|row| row.0).collect())
    }
}

/// Opens a file for one writer and some readers.
pub async fn open_file(
    path: &Path,
    readers: u32,
    max_pages: Option<u32>,
) -> Result<(SqlitePool, SqlitePool), JobError> {
    let mut options = SqliteConnectOptions::new()
        .filename(path)
        .create_if_missing(true)
        .journal_mode(SqliteJournalMode::Wal)
        // A 202 promises that the job survives a power cut.
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(Duration::from_secs(10));
    // Asked of the file itself: SQLite would tell it with the first write only, and leave a log that can be written as little.
    match std::fs::OpenOptions::new().append(true).open(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error.into()),
        _ => {}
    }
    if let Some(pages) = max_pages {
        options = options.pragma("max_page_count", pages.to_string());
    }
    let writer = file_pool(1).connect_with(options.clone()).await?;
    let readers = file_pool(readers).connect_lazy_with(options.create_if_missing(false).read_only(true));
    Ok((writer, readers))
}

fn file_pool(connections: u32) -> SqlitePoolOptions {
    SqlitePoolOptions::new()
        .max_connections(connections)
        .acquire_timeout(Duration::from_secs(30))
        // A file is not lost like a link, and asking each time costs a third of a read.
        .test_before_acquire(false)
        .before_acquire(|connection, _| Box::pin(std::future::ready(Ok(is_outside_transactions(connection)))))
}

/// Whether the connection may be used again. On a full disk SQLite ends a transaction by itself; sqlx then
/// fails to end it, counts it as open for ever, and refuses every later one.
fn is_outside_transactions(connection: &SqliteConnection) -> bool {
    !connection.is_in_transaction()
}

/// Connections that a process needs which runs jobs: two hear what others tell, one takes deliveries, one writes.
const LEAST_CONNECTIONS: usize = 4;

/// Refuses a server that gives so few connections that runs would wait for each other's.
pub async fn check_room(options: &PgConnectOptions) -> Result<(), JobError> {
    let mut held = Vec::new();
    while held.len() < LEAST_CONNECTIONS {
        match PgConnection::connect_with(options).await {
            Ok(connection) => held.push(connection),
            Err(error) if held.is_empty() => return Err(error.into()),
            Err(error) => {
                let given = held.len();
                let needed = format!(
                    "{error}; a process that runs jobs needs {LEAST_CONNECTIONS} connections at least, and got {given}"
                );
                return Err(JobError::Migration(needed));
            }
        }
    }
    for connection in held {
        connection.close().await?;
    }
    Ok(())
}

/// Connects to a server.
pub async fn connect(options: &PgConnectOptions, connections: u32) -> Result<PgPool, JobError> {
    // A process that is frozen within a transaction would keep its locks, and with them all others.
    let options = options.clone().application_name("raceway").options([("idle_in_transaction_session_timeout", "10s")]);
    // A pool tries again and again, and does not say why in vain.
    PgConnection::connect_with(&options).await?.close().await?;
    let port = options.get_port();
    let pool = PgPoolOptions::new()
        .max_connections(connections)
        .after_connect(move |_, _| {
            #[cfg(target_os = "linux")]
            super::link::prepare(port);
            Box::pin(std::future::ready(Ok(())))
        })
        // Whoever waits for an answer does not wait longer for a server that is away.
        .acquire_timeout(Duration::from_secs(5))
        // Only a connection that has rested may have been cut meanwhile; asking each time would double the way of a query.
        .test_before_acquire(false)
        .before_acquire(|connection, rest| {
            Box::pin(async move {
                let rested = rest.idle_for > Duration::from_secs(1);
                Ok(!rested || answers(connection).await)
            })
        })
        // Before the pool asks the same without a limit.
        .after_release(|connection, _| {
            Box::pin(async move { if answers(connection).await { Ok(true) } else { Err(sqlx::Error::WorkerCrashed) } })
        });
    Ok(pool.connect_with(options).await?)
}

/// Whether a connection can be used.
async fn answers(connection: &mut PgConnection) -> bool {
    tokio::time::timeout(LONGEST_PING, connection.ping()).await.is_ok_and(|answer| answer.is_ok())
}

/// Time that a server has to answer a ping: less than a request waits for a connection, so that another one can still be had.
const LONGEST_PING: Duration = Duration::from_secs(2);

/// Brings our tables up to date; migrations are never edited once released.
pub async fn migrate(pool: &Pool) -> Result<(), JobError> {
    let failed = |error: sqlx::migrate::MigrateError| JobError::Migration(error.to_string());
    match pool {
        Pool::Sqlite(pool) => migrator(&SQLITE_MIGRATIONS).run(pool).await.map_err(failed),
        Pool::Postgres(pool) => migrator(&POSTGRES_MIGRATIONS).run(pool).await.map_err(failed),
    }
}

/// Whether all our migrations were made, and whole.
pub async fn is_up_to_date(pool: &Pool) -> Result<bool, JobError> {
    let (sql, all): (&str, &[_]) = match pool {
        Pool::Sqlite(_) => (
            "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = '_sqlx_migrations'",
            &SQLITE_MIGRATIONS,
        ),
        Pool::Postgres(_) => {
            ("SELECT count(*) FROM pg_tables WHERE tablename = '_sqlx_migrations'", &POSTGRES_MIGRATIONS)
        }
    };
    if statement(sql).value(pool).await? != Some(1_i64) {
        return Ok(false);
    }
    let made: Vec<i64> =
        statement("SELECT version FROM _sqlx_migrations WHERE success ORDER BY version").values(pool).await?;
    Ok(made.iter().eq(all.iter().map(|(version, ..)| version)))
}

fn migrator(migrations: &[(i64, &'static str, &'static str)]) -> Migrator {
    let migrations = migrations.iter().map(|(version, name, sql)| {
        Migration::new(*version, (*name).into(), MigrationType::Simple, sql.into_sql_str(), false)
    });
    Migrator::with_migrations(migrations.collect())
}

const SQLITE_MIGRATIONS: [(i64, &str, &str); 7] = [
    (1, "jobs", include_str!("../../../migrations/sqlite/0001_jobs.sql")),
    (2, "reports", include_str!("../../../migrations/sqlite/0002_reports.sql")),
    (3, "studies", include_str!("../../../migrations/sqlite/0003_studies.sql")),
    (4, "idempotency keys", include_str!("../../../migrations/sqlite/0004_idempotency_keys.sql")),
    (5, "views", include_str!("../../../migrations/sqlite/0005_views.sql")),
    (6, "workers", include_str!("../../../migrations/sqlite/0006_workers.sql")),
    (7, "tokens", include_str!("../../../migrations/sqlite/0007_tokens.sql")),
];

const POSTGRES_MIGRATIONS: [(i64, &str, &str); 2] = [
    (1, "records", include_str!("../../../migrations/postgres/0001_records.sql")),
    (2, "tokens", include_str!("../../../migrations/postgres/0002_tokens.sql")),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_that_go_as_one_keep_their_values() {
        let insert = |table: &str| statement(format!("INSERT INTO {table} VALUES ($1, $2)")).bind(1_i64).bind("a");
        let last = statement("UPDATE jobs SET a = $10, b = '$' WHERE id = $1").bind(2_i64);
        let before = [("a", insert("x")), ("b", insert("y"))];
        let whole = last.with(before.map(|(name, insert)| (name.to_owned(), insert)));
        assert_eq!(
            whole.sql.as_str(),
            "WITH a AS (INSERT INTO x VALUES ($2, $3)), b AS (INSERT INTO y VALUES ($4, $5)) \
             UPDATE jobs SET a = $10, b = '$' WHERE id = $1"
        );
        assert_eq!(whole.values.len(), 5);
    }
}
