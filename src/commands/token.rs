//! `raceway token` and `raceway migrate`: commands on a database.

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use super::exit::{Exit, failed};
use crate::config::{ConfigError, DatabaseOptions, NewTokenOptions, RevokeOptions, TokenCommand};
use crate::jobs::tokens::{NewToken, Token, TokenBook};
use crate::jobs::{JobError, Location};

/// Reason why a command failed.
#[derive(Debug, thiserror::Error)]
enum CommandError {
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error(transparent)]
    Jobs(#[from] JobError),
    #[error("there is already a token {0}: choose another name; names of revoked tokens are not reused")]
    NameTaken(String),
    #[error("there is no token {0}; `raceway token list` shows all")]
    Unknown(String),
    #[error("there is no database {0}")]
    NoDatabase(Location),
}

/// Creates, lists or revokes tokens.
pub async fn run(command: TokenCommand) -> Exit {
    exit_of(match command {
        TokenCommand::Create(options) => create(options).await,
        TokenCommand::List(options) => list(&options).await,
        TokenCommand::Revoke(options) => revoke(&options).await,
    })
}

/// Brings the tables of a database up to date.
pub async fn migrate(options: DatabaseOptions) -> Exit {
    exit_of(migrated(&options).await)
}

fn exit_of(done: Result<(), CommandError>) -> Exit {
    match done {
        Ok(()) => Exit::Success,
        Err(error) => failed(&format!("raceway: {error}")),
    }
}

async fn create(options: NewTokenOptions) -> Result<(), CommandError> {
    let book = TokenBook::open(&options.database.location()?).await?;
    let name = options.name.unwrap_or_else(|| format!("token-{}", &Uuid::now_v7().simple().to_string()[24..]));
    let valid_for = options.expires_in_days.map(|days| SignedDuration::from_hours(24 * i64::from(days)));
    // Jobs that were created without tokens belong to the empty owner.
    let owner = if options.open_jobs { Some(String::new()) } else { options.owner };
    let new = NewToken { name: name.clone(), owner, valid_for };
    let created = book.create(new).await;
    book.close().await;
    let (secret, token) = created?.ok_or(CommandError::NameTaken(name))?;
    eprintln!("token {} of owner {}, shown this once:", token.name, display_name(&token.owner));
    println!("{}", secret.reveal());
    Ok(())
}

async fn list(options: &DatabaseOptions) -> Result<(), CommandError> {
    let book = existing(options).await?;
    let tokens = book.list().await;
    book.close().await;
    let tokens = tokens?;
    let width = |column: fn(&Token) -> &str, head: &str| {
        tokens.iter().map(|token| column(token).len()).chain([head.len()]).max().unwrap_or(0)
    };
    let (name, owner) = (width(|token| &token.name, "NAME"), width(|token| display_name(&token.owner), "OWNER"));
    println!("{:name$}  {:owner$}  {:36}  {:20}  {:20}  STATE", "NAME", "OWNER", "ID", "CREATED", "EXPIRES");
    for token in &tokens {
        let expires = token.expires_at.map_or_else(|| "never".to_owned(), seconds);
        let (created, state) = (seconds(token.created_at), state(token));
        let of = display_name(&token.owner);
        println!("{:name$}  {of:owner$}  {}  {created:20}  {expires:20}  {state}", token.name, token.id);
    }
    Ok(())
}

/// The name of an owner in lists.
fn display_name(owner: &str) -> &str {
    if owner.is_empty() { "(open)" } else { owner }
}

fn state(token: &Token) -> String {
    match token.revoked_at {
        Some(at) => format!("revoked {}", seconds(at)),
        None if token.is_valid(Timestamp::now()) => "valid".to_owned(),
        None => "expired".to_owned(),
    }
}

/// A time to the second (RFC 3339).
fn seconds(time: Timestamp) -> String {
    format!("{time:.0}")
}

async fn revoke(options: &RevokeOptions) -> Result<(), CommandError> {
    let book = existing(&options.database).await?;
    let revoked = book.revoke(&options.token).await;
    book.close().await;
    let token = revoked?.ok_or_else(|| CommandError::Unknown(options.token.clone()))?;
    eprintln!("token {} of owner {}: {}", token.name, display_name(&token.owner), state(&token));
    Ok(())
}

/// The tokens of an existing database: a mistyped name must not create one.
async fn existing(options: &DatabaseOptions) -> Result<TokenBook, CommandError> {
    let location = options.location()?;
    if matches!(&location, Location::File(path) if !path.exists()) {
        return Err(CommandError::NoDatabase(location));
    }
    Ok(TokenBook::open(&location).await?)
}

async fn migrated(options: &DatabaseOptions) -> Result<(), CommandError> {
    let location = options.location()?;
    TokenBook::open(&location).await?.close().await;
    eprintln!("the tables of {location} are up to date");
    Ok(())
}
