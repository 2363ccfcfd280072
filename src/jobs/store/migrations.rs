//! Our tables, brought up to date.

use sqlx::SqlSafeStr;
use sqlx::migrate::{Migration, MigrationType, Migrator};

use super::database::Pool;
use super::statement::statement;
use crate::jobs::JobError;

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
