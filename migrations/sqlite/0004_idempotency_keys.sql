-- A submission with a key is made once: the same key again answers with the job that the first one made. Kept as long as that
-- job, and a day at least, so that a job which is deleted at once is not made a second time by a late repetition.
CREATE TABLE idempotency_keys (
    owner TEXT NOT NULL,
    key TEXT NOT NULL,
    -- SHA-256 of the body: another body under the same key is refused.
    fingerprint BLOB NOT NULL,
    job BLOB NOT NULL,
    created_at INTEGER NOT NULL,
    -- Whether a result that was there answered the job, and until when that was to be kept: what the first answer said.
    reused INTEGER NOT NULL CHECK (reused IN (0, 1)),
    expires_at INTEGER,
    PRIMARY KEY (owner, key)
) STRICT;

CREATE INDEX idempotency_keys_by_age ON idempotency_keys (created_at);
