//! The tables of this program and of River, brought up to date.

use riverqueue::migrate::{PostgresMigrator, SqliteMigrator};
use sqlx::SqlSafeStr;
use sqlx::migrate::{Migration, MigrationType, Migrator};

use super::pool::Pool;
use super::statement::statement;
use crate::jobs::error::JobError;

/// Brings all tables up to date.
pub async fn migrate(pool: &Pool) -> Result<(), JobError> {
    migrate_queue(pool).await?;
    let failed = |error: sqlx::migrate::MigrateError| JobError::Migration(error.to_string());
    match pool {
        Pool::Sqlite(pool) => migrator(&SQLITE_MIGRATIONS).run(pool).await.map_err(failed),
        Pool::Postgres(pool) => migrator(&POSTGRES_MIGRATIONS).run(pool).await.map_err(failed),
    }
}

/// Returns whether every migration was applied successfully.
pub async fn is_up_to_date(pool: &Pool) -> Result<bool, JobError> {
    Ok(has_own_tables(pool).await? && has_queue_tables(pool).await?)
}

async fn has_own_tables(pool: &Pool) -> Result<bool, JobError> {
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
    let applied: Vec<i64> =
        statement("SELECT version FROM _sqlx_migrations WHERE success ORDER BY version").values(pool).await?;
    Ok(applied.iter().eq(all.iter().map(|(version, ..)| version)))
}

async fn migrate_queue(pool: &Pool) -> Result<(), JobError> {
    match pool {
        Pool::Sqlite(pool) => SqliteMigrator::new(pool.clone()).migrate_up().await,
        Pool::Postgres(pool) => PostgresMigrator::new(pool.clone()).migrate_up().await,
    }
    .map_err(|error| JobError::Migration(error.to_string()))?;
    Ok(())
}

/// Returns whether River's tables have the version that this build creates.
async fn has_queue_tables(pool: &Pool) -> Result<bool, JobError> {
    let (applied, all) = match pool {
        Pool::Sqlite(pool) => {
            (SqliteMigrator::new(pool.clone()).existing_versions().await, SqliteMigrator::all_versions().len())
        }
        Pool::Postgres(pool) => {
            (PostgresMigrator::new(pool.clone()).existing_versions().await, PostgresMigrator::all_versions().len())
        }
    };
    Ok(applied.map_err(|error| JobError::Migration(error.to_string()))?.len() == all)
}

fn migrator(migrations: &[(i64, &'static str, &'static str)]) -> Migrator {
    let migrations = migrations.iter().map(|(version, name, sql)| {
        Migration::new(*version, (*name).into(), MigrationType::Simple, sql.into_sql_str(), false)
    });
    Migrator::with_migrations(migrations.collect())
}

// A released file is never edited: sqlx compares a checksum of its whole text, comments included, with the applied one.
const SQLITE_MIGRATIONS: [(i64, &str, &str); 16] = [
    (1, "jobs", include_str!("../../../migrations/sqlite/0001_jobs.sql")),
    (2, "reports", include_str!("../../../migrations/sqlite/0002_reports.sql")),
    (3, "studies", include_str!("../../../migrations/sqlite/0003_studies.sql")),
    (4, "idempotency keys", include_str!("../../../migrations/sqlite/0004_idempotency_keys.sql")),
    (5, "views", include_str!("../../../migrations/sqlite/0005_views.sql")),
    (6, "workers", include_str!("../../../migrations/sqlite/0006_workers.sql")),
    (7, "tokens", include_str!("../../../migrations/sqlite/0007_tokens.sql")),
    (8, "turns", include_str!("../../../migrations/sqlite/0008_turns.sql")),
    (9, "digests", include_str!("../../../migrations/sqlite/0009_digests.sql")),
    (10, "job labels", include_str!("../../../migrations/sqlite/0010_job_labels.sql")),
    (11, "removed jobs", include_str!("../../../migrations/sqlite/0011_removed_jobs.sql")),
    (12, "series chunks", include_str!("../../../migrations/sqlite/0012_series_chunks.sql")),
    (13, "unfinished", include_str!("../../../migrations/sqlite/0013_unfinished.sql")),
    (14, "request digests", include_str!("../../../migrations/sqlite/0014_request_digests.sql")),
    (15, "uploaded series", include_str!("../../../migrations/sqlite/0015_uploaded_series.sql")),
    (16, "sampled points", include_str!("../../../migrations/sqlite/0016_sampled_points.sql")),
];

const POSTGRES_MIGRATIONS: [(i64, &str, &str); 11] = [
    (1, "records", include_str!("../../../migrations/postgres/0001_records.sql")),
    (2, "tokens", include_str!("../../../migrations/postgres/0002_tokens.sql")),
    (3, "turns", include_str!("../../../migrations/postgres/0003_turns.sql")),
    (4, "digests", include_str!("../../../migrations/postgres/0004_digests.sql")),
    (5, "job labels", include_str!("../../../migrations/postgres/0005_job_labels.sql")),
    (6, "removed jobs", include_str!("../../../migrations/postgres/0006_removed_jobs.sql")),
    (7, "series chunks", include_str!("../../../migrations/postgres/0007_series_chunks.sql")),
    (8, "unfinished", include_str!("../../../migrations/postgres/0008_unfinished.sql")),
    (9, "request digests", include_str!("../../../migrations/postgres/0009_request_digests.sql")),
    (10, "uploaded series", include_str!("../../../migrations/postgres/0010_uploaded_series.sql")),
    (11, "sampled points", include_str!("../../../migrations/postgres/0011_sampled_points.sql")),
];
