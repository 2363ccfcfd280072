//! SQL statements that run on both databases, with the places `$1`, `$2`, … for bound values.

use sqlx::postgres::{PgArguments, PgPool, PgRow};
use sqlx::sqlite::{SqliteArguments, SqlitePool, SqliteRow};
use sqlx::{Arguments, AssertSqlSafe, FromRow, PgConnection, Postgres, SqlSafeStr, Sqlite, SqliteConnection};
use uuid::Uuid;

use super::pool::{Pool, Tx};
use crate::jobs::error::JobError;

/// The pool or transaction in which a statement runs.
pub enum Executor<'a> {
    SqlitePool(&'a SqlitePool),
    SqliteTx(&'a mut SqliteConnection),
    PgPool(&'a PgPool),
    PgTx(&'a mut PgConnection),
}

impl<'a> From<&'a Pool> for Executor<'a> {
    fn from(pool: &'a Pool) -> Self {
        match pool {
            Pool::Sqlite(pool) => Self::SqlitePool(pool),
            Pool::Postgres(pool) => Self::PgPool(pool),
        }
    }
}

impl<'a> From<&'a mut Tx> for Executor<'a> {
    fn from(tx: &'a mut Tx) -> Self {
        match tx {
            Tx::Sqlite(tx) => Self::SqliteTx(tx),
            Tx::Postgres(tx) => Self::PgTx(tx),
        }
    }
}

/// A type that can be read from a row of either database.
pub trait Record: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin {}
impl<T: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin> Record for T {}

/// A bound value.
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

/// A statement with its bound values.
#[derive(Debug)]
pub struct Statement {
    sql: sqlx::SqlStr,
    values: Vec<Value>,
}

/// A statement. Assembled SQL text must not contain input from outside.
pub fn statement(sql: impl Into<std::borrow::Cow<'static, str>>) -> Statement {
    let sql = match sql.into() {
        std::borrow::Cow::Borrowed(sql) => sql.into_sql_str(),
        std::borrow::Cow::Owned(sql) => AssertSqlSafe(sql).into_sql_str(),
    };
    Statement { sql, values: Vec::new() }
}

/// SQL whose places `$1`, `$2`, … are shifted by a number.
fn shifted(sql: &str, by: usize) -> String {
    let mut parts = sql.split('$');
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let digits = part.find(|c: char| !c.is_ascii_digit()).unwrap_or(part.len());
        let place = part[..digits].parse::<usize>().map_or_else(|_| String::new(), |place| (place + by).to_string());
        format!("{text}${place}{}", &part[digits..])
    })
}

/// Instantiates the body for each database; `Db` is the sqlx type of the database.
macro_rules! for_database {
    ($statement:ident, $place:expr, |$sql:ident, $arguments:ident, $executor:ident| $body:expr) => {
        match $place.into() {
            Executor::SqlitePool($executor) => {
                type Db = Sqlite;
                let ($sql, $arguments) = $statement.arguments::<SqliteArguments, Db>()?;
                $body
            }
            Executor::SqliteTx($executor) => {
                type Db = Sqlite;
                let ($sql, $arguments) = $statement.arguments::<SqliteArguments, Db>()?;
                $body
            }
            Executor::PgPool($executor) => {
                type Db = Postgres;
                let ($sql, $arguments) = $statement.arguments::<PgArguments, Db>()?;
                $body
            }
            Executor::PgTx($executor) => {
                type Db = Postgres;
                let ($sql, $arguments) = $statement.arguments::<PgArguments, Db>()?;
                $body
            }
        }
    };
}

impl Statement {
    /// This statement as an explanation of its plan.
    #[cfg(test)]
    pub fn explained(self, prefix: &str) -> Self {
        let sql = format!("{prefix} {}", self.sql.as_str());
        Self { sql: AssertSqlSafe(sql).into_sql_str(), ..self }
    }

    /// Binds a value to the next place.
    #[must_use]
    pub fn bind(mut self, value: impl Into<Value>) -> Self {
        self.values.push(value.into());
        self
    }

    /// This statement with common table expressions before it, each by a name that later ones may query (PostgreSQL).
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

    /// Runs the statement and returns the number of changed rows.
    pub async fn run<'a>(self, place: impl Into<Executor<'a>>) -> Result<u64, JobError> {
        for_database!(self, place, |sql, arguments, executor| {
            Ok(sqlx::query_with::<Db, _>(sql, arguments).execute(executor).await?.rows_affected())
        })
    }

    /// The first row, if any. All rows are read, because a statement outside a transaction is committed after its last row.
    pub async fn optional<'a, T: Record>(self, place: impl Into<Executor<'a>>) -> Result<Option<T>, JobError> {
        Ok(self.all(place).await?.into_iter().next())
    }

    /// The only row; an error if there is no row.
    pub async fn one<'a, T: Record>(self, place: impl Into<Executor<'a>>) -> Result<T, JobError> {
        self.optional(place).await?.ok_or(JobError::Database(sqlx::Error::RowNotFound))
    }

    /// All rows.
    pub async fn all<'a, T: Record>(self, place: impl Into<Executor<'a>>) -> Result<Vec<T>, JobError> {
        for_database!(self, place, |sql, arguments, executor| {
            Ok(sqlx::query_as_with::<Db, T, _>(sql, arguments).fetch_all(executor).await?)
        })
    }

    /// Passes row after row to a function, until the function returns false.
    pub async fn each<'a, T: Record>(
        self,
        place: impl Into<Executor<'a>>,
        mut takes_more: impl FnMut(T) -> Result<bool, JobError>,
    ) -> Result<(), JobError> {
        use futures_util::TryStreamExt;
        for_database!(self, place, |sql, arguments, executor| {
            let mut rows = sqlx::query_as_with::<Db, T, _>(sql, arguments).fetch(executor);
            while let Some(row) = rows.try_next().await? {
                if !takes_more(row)? {
                    break;
                }
            }
            Ok(())
        })
    }

    /// The first column of the first row, if any.
    pub async fn value<'a, T>(self, place: impl Into<Executor<'a>>) -> Result<Option<T>, JobError>
    where
        (T,): Record,
    {
        Ok(self.optional::<(T,)>(place).await?.map(|row| row.0))
    }

    /// The first column of every row.
    pub async fn values<'a, T>(self, place: impl Into<Executor<'a>>) -> Result<Vec<T>, JobError>
    where
        (T,): Record,
    {
        Ok(self.all::<(T,)>(place).await?.into_iter().map(|row| row.0).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn combined_statements_keep_their_values() {
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
