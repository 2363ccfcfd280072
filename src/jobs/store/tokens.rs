//! Bearer tokens. A token is printed once, when it is created; only its digest is stored.

use jiff::Timestamp;
use sqlx::FromRow;
use uuid::Uuid;

use super::database::Store;
use super::statement::statement;
use super::stored_time::{stored, time};
use crate::jobs::error::JobError;

/// A token without its secret.
#[derive(Debug, Clone)]
pub struct Token {
    pub id: Uuid,
    pub name: String,
    /// Owner of the jobs that the token gives access to; several tokens can have one owner.
    pub owner: String,
    /// SHA-256 of the token.
    pub digest: Vec<u8>,
    pub created_at: Timestamp,
    pub expires_at: Option<Timestamp>,
    pub revoked_at: Option<Timestamp>,
}

impl Token {
    /// Returns whether the token is neither revoked nor expired at this time.
    pub fn is_valid(&self, now: Timestamp) -> bool {
        self.revoked_at.is_none() && self.expires_at.is_none_or(|end| now < end)
    }
}

#[derive(FromRow)]
struct Row {
    id: Uuid,
    name: String,
    owner: String,
    digest: Vec<u8>,
    created_at: i64,
    expires_at: Option<i64>,
    revoked_at: Option<i64>,
}

impl TryFrom<Row> for Token {
    type Error = JobError;

    fn try_from(row: Row) -> Result<Self, JobError> {
        Ok(Self {
            id: row.id,
            name: row.name,
            owner: row.owner,
            digest: row.digest,
            created_at: time(row.created_at)?,
            expires_at: row.expires_at.map(time).transpose()?,
            revoked_at: row.revoked_at.map(time).transpose()?,
        })
    }
}

impl Store {
    /// All tokens, revoked and expired ones included, oldest first.
    pub async fn tokens(&self) -> Result<Vec<Token>, JobError> {
        let sql =
            "SELECT id, name, owner, digest, created_at, expires_at, revoked_at FROM tokens ORDER BY created_at, id";
        let rows: Vec<Row> = statement(sql).all(&self.readers).await?;
        rows.into_iter().map(Token::try_from).collect()
    }

    /// Inserts a token unless its name is taken; returns whether it was inserted.
    pub async fn add_token(&self, token: &Token) -> Result<bool, JobError> {
        let sql = "INSERT INTO tokens (id, name, owner, digest, created_at, expires_at) \
                   VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT (name) DO NOTHING";
        let added = statement(sql)
            .bind(token.id)
            .bind(&token.name)
            .bind(&token.owner)
            .bind(&token.digest)
            .bind(stored(token.created_at))
            .bind(token.expires_at.map(stored))
            .run(&self.writer)
            .await?;
        Ok(added == 1)
    }

    /// Revokes the token with this name or id; `None`: not found. An earlier revocation keeps its time.
    pub async fn revoke_token(&self, which: &str) -> Result<Option<Token>, JobError> {
        let mut tx = self.begin().await?;
        let sql = "UPDATE tokens SET revoked_at = COALESCE(revoked_at, $3) WHERE name = $1 OR id = $2 \
                   RETURNING id, name, owner, digest, created_at, expires_at, revoked_at";
        let revoked: Option<Row> = statement(sql)
            .bind(which)
            .bind(which.parse::<Uuid>().ok())
            .bind(stored(Timestamp::now()))
            .optional(&mut tx)
            .await?;
        tx.commit().await?;
        revoked.map(Token::try_from).transpose()
    }
}
