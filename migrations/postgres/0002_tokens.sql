-- ../sqlite/0007_tokens.sql
CREATE TABLE tokens (
    id UUID PRIMARY KEY,
    name TEXT NOT NULL UNIQUE,
    owner TEXT NOT NULL,
    digest BYTEA NOT NULL UNIQUE,
    created_at BIGINT NOT NULL,
    expires_at BIGINT,
    revoked_at BIGINT
);

-- The queue is counted for each owner.
DROP INDEX jobs_unfinished;
CREATE INDEX jobs_unfinished ON jobs (status, owner) WHERE status IN ('queued', 'running');
