-- Bearer tokens that were made by command. A token that was revoked or has expired stays: a service that once had tokens is never
-- open to everybody again.
CREATE TABLE tokens (
    id BLOB PRIMARY KEY NOT NULL,
    name TEXT NOT NULL UNIQUE,
    -- Whose jobs it sees.
    owner TEXT NOT NULL,
    -- SHA-256 of the token, which is not kept.
    digest BLOB NOT NULL UNIQUE,
    created_at INTEGER NOT NULL,
    expires_at INTEGER,
    revoked_at INTEGER
) STRICT;

-- The queue is counted for each owner.
DROP INDEX jobs_unfinished;
CREATE INDEX jobs_unfinished ON jobs (status, owner) WHERE status IN ('queued', 'running');
