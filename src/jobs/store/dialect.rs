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

    /// Join that reads the job of each row of `job_labels`, in the order of these rows: no estimate of the database, which knows nothing
    /// about one owner, makes it begin with all jobs.
    pub fn jobs_of_labels(self) -> &'static str {
        match self {
            Self::Sqlite => "job_labels CROSS JOIN jobs ON jobs.id = job_labels.job",
            Self::Postgres => {
                "job_labels CROSS JOIN LATERAL (SELECT * FROM jobs WHERE jobs.id = job_labels.job OFFSET 0) AS jobs"
            }
        }
    }

    /// Condition: the job has the label of the owner ($1) that is bound at this place. It is tested for each job.
    pub fn has_label(self, place: &str) -> String {
        let each = match self {
            Self::Sqlite => "",
            Self::Postgres => " OFFSET 0",
        };
        format!(
            "EXISTS (SELECT 1 FROM job_labels AS l WHERE l.owner = $1 AND l.label = {place} AND l.job = jobs.id{each})"
        )
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
