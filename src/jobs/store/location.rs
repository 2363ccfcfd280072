//! Where the database is: a file for SQLite, or a PostgreSQL server.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use sqlx::postgres::PgConnectOptions;

/// Where the records are.
#[derive(Clone)]
pub enum Location {
    File(PathBuf),
    Server(Box<PgConnectOptions>),
}

impl Location {
    /// A PostgreSQL server by its URL; `None` if the URL is not valid.
    pub fn server(url: &str) -> Option<Self> {
        PgConnectOptions::from_str(url).ok().map(|options| Self::Server(Box::new(options)))
    }

    /// The database product.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::File(_) => "SQLite",
            Self::Server(_) => "PostgreSQL",
        }
    }
}

/// Omits user and password.
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
