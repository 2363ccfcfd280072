//! SQL that differs between SQLite and PostgreSQL.

/// The SQL dialect of a database.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    Sqlite,
    Postgres,
}

impl Dialect {
    /// The database's own clock [µs since 1970]: it is the only clock that all machines share.
    pub fn now(self) -> &'static str {
        match self {
            Self::Sqlite => "CAST((julianday('now') - 2440587.5) * 86400000000.0 AS INTEGER)",
            Self::Postgres => "CAST(extract(epoch FROM clock_timestamp()) * 1000000 AS BIGINT)",
        }
    }

    /// Condition: a process that is no longer listed as a worker holds the delivery (`river_job`).
    ///
    /// On SQLite there is one process, which redelivers everything when it starts.
    pub fn is_orphaned(self) -> &'static str {
        match self {
            Self::Sqlite => "FALSE",
            Self::Postgres => {
                "river_job.state = 'running' AND NOT EXISTS (SELECT 1 FROM workers WHERE CAST(workers.id AS TEXT) \
                 = river_job.attempted_by[array_upper(river_job.attempted_by, 1)])"
            }
        }
    }

    /// Suffix that locks the rows of a query and leaves out those that another transaction has locked. SQLite has a single writer.
    pub fn for_update_of_free_rows(self) -> &'static str {
        match self {
            Self::Sqlite => "",
            Self::Postgres => " FOR UPDATE SKIP LOCKED",
        }
    }

    /// Suffix that locks the rows of a query against changes until the transaction ends. SQLite has a single writer.
    pub fn for_share(self) -> &'static str {
        match self {
            Self::Sqlite => "",
            Self::Postgres => " FOR SHARE",
        }
    }
}
