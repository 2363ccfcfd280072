//! `raceway token` and `raceway migrate`.

use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use super::Ended;
use crate::config::{ConfigError, DatabaseOptions, NewTokenOptions, RevokeOptions, TokenCommand};
use crate::jobs::tokens::{NewToken, Token, TokenBook};
use crate::jobs::{JobError, Location};

/// Why a command about tokens did nothing.
#[derive(Debug, thiserror::Error)]
enum Refused {
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error(transparent)]
    Jobs(#[from] JobError),
    #[error("there is a token {0} already: choose another name; names of revoked tokens are not used again")]
    NameTaken(String),
    #[error("there is no token {0}; `raceway token list` shows all")]
    Unknown(String),
    #[error("there is no database {0}")]
    NoDatabase(Location),
}

/// Makes, lists or revokes tokens.
pub async fn run(command: TokenCommand) -> Ended {
    told(match command {
        TokenCommand::Create(options) => create(options).await,
        TokenCommand::List(options) => list(&options).await,
        TokenCommand::Revoke(options) => revoke(&options).await,
    })
}

/// Brings the tables of a database up to date.
pub async fn migrate(options: DatabaseOptions) -> Ended {
    told(migrated(&options).await)
}

fn told(done: Result<(), Refused>) -> Ended {
    match done {
        Ok(()) => Ended::Well,
        Err(error) => {
            eprintln!("raceway: {error}");
            Ended::Badly
        }
    }
}

async fn create(options: NewTokenOptions) -> Result<(), Refused> {
    let book = TokenBook::open(&options.database.location()?).await?;
    let name = options.name.unwrap_or_else(|| format!("token-{}", &Uuid::now_v7().simple().to_string()[24..]));
    let holds_for = options.expires_in_days.map(|days| SignedDuration::from_hours(24 * i64::from(days)));
    // Without tokens, jobs are of the owner without a name.
    let owner = if options.open_jobs { Some(String::new()) } else { options.owner };
    let new = NewToken { name: name.clone(), owner, holds_for };
    let made = book.create(new).await;
    book.close().await;
    let (secret, token) = made?.ok_or(Refused::NameTaken(name))?;
    eprintln!("token {} of owner {}, shown this once:", token.name, named(&token.owner));
    println!("{}", secret.reveal());
    Ok(())
}

async fn list(options: &DatabaseOptions) -> Result<(), Refused> {
    let book = existing(options).await?;
    let tokens = book.list().await;
    book.close().await;
    let tokens = tokens?;
    let width = |column: fn(&Token) -> &str, head: &str| {
        tokens.iter().map(|token| column(token).len()).chain([head.len()]).max().unwrap_or(0)
    };
    let (name, owner) = (width(|token| &token.name, "NAME"), width(|token| named(&token.owner), "OWNER"));
    println!("{:name$}  {:owner$}  {:36}  {:20}  {:20}  STATE", "NAME", "OWNER", "ID", "CREATED", "EXPIRES");
    for token in &tokens {
        let expires = token.expires_at.map_or_else(|| "never".to_owned(), seconds);
        let (created, state) = (seconds(token.created_at), state(token));
        let of = named(&token.owner);
        println!("{:name$}  {of:owner$}  {}  {created:20}  {expires:20}  {state}", token.name, token.id);
    }
    Ok(())
}

/// An owner as the lists show it.
fn named(owner: &str) -> &str {
    if owner.is_empty() { "(open)" } else { owner }
}

fn state(token: &Token) -> String {
    match token.revoked_at {
        Some(at) => format!("revoked {}", seconds(at)),
        None if token.holds(Timestamp::now()) => "holds".to_owned(),
        None => "expired".to_owned(),
    }
}

/// A time to the second (RFC 3339).
fn seconds(time: Timestamp) -> String {
    format!("{time:.0}")
}

async fn revoke(options: &RevokeOptions) -> Result<(), Refused> {
    let book = existing(&options.database).await?;
    let revoked = book.revoke(&options.token).await;
    book.close().await;
    let token = revoked?.ok_or_else(|| Refused::Unknown(options.token.clone()))?;
    eprintln!("token {} of owner {}: {}", token.name, named(&token.owner), state(&token));
    Ok(())
}

/// The tokens of a database that is there: a slip in its name must not make one.
async fn existing(options: &DatabaseOptions) -> Result<TokenBook, Refused> {
    let location = options.location()?;
    if matches!(&location, Location::File(path) if !path.exists()) {
        return Err(Refused::NoDatabase(location));
    }
    Ok(TokenBook::open(&location).await?)
}

async fn migrated(options: &DatabaseOptions) -> Result<(), Refused> {
    let location = options.location()?;
    TokenBook::open(&location).await?.close().await;
    eprintln!("the tables of {location} are up to date");
    Ok(())
}
