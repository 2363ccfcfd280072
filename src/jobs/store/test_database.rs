//! A new database of a test on PostgreSQL.

use sqlx::{Connection, Executor};
use uuid::Uuid;

use super::location::Location;

/// A new database on the server that `RACEWAY_TEST_POSTGRES` names, with parameters for its URL; `None` without a server, so that the test is
/// skipped.
pub fn new_on_postgres(parameters: &str) -> Option<Location> {
    let server = std::env::var("RACEWAY_TEST_POSTGRES").ok()?;
    let name = format!("raceway_{}", Uuid::now_v7().simple());
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    runtime.block_on(async {
        let mut connection = sqlx::PgConnection::connect(&server).await.expect("the server is there");
        let create = sqlx::AssertSqlSafe(format!("CREATE DATABASE {name}"));
        connection.execute(create).await.expect("a database can be made");
    });
    let (server, _) = server.rsplit_once('/').expect("a URL with a database");
    Some(Location::server(&format!("{server}/{name}{parameters}")).expect("a URL"))
}
