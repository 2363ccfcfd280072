-- The tables of ../sqlite, up to date as of 0006, where each column is explained. Times are microseconds since 1970 (UTC).

CREATE TABLE results (
    id UUID PRIMARY KEY,
    metrics TEXT NOT NULL
);

CREATE TABLE signals (
    -- Channels are listed in the order in which they were added.
    number BIGINT GENERATED ALWAYS AS IDENTITY,
    result_id UUID NOT NULL REFERENCES results (id) ON DELETE CASCADE,
    sort TEXT NOT NULL CHECK (sort IN ('amplitude', 'envelope', 'series')),
    channel TEXT NOT NULL,
    answer BYTEA NOT NULL,
    PRIMARY KEY (result_id, sort, channel)
);

CREATE TABLE reports (
    result_id UUID PRIMARY KEY REFERENCES results (id) ON DELETE CASCADE,
    answer BYTEA NOT NULL
);

CREATE TABLE views (
    result_id UUID PRIMARY KEY REFERENCES results (id) ON DELETE CASCADE,
    answer BYTEA NOT NULL
);

-- Compressed already.
ALTER TABLE signals ALTER COLUMN answer SET STORAGE EXTERNAL;
ALTER TABLE reports ALTER COLUMN answer SET STORAGE EXTERNAL;
ALTER TABLE views ALTER COLUMN answer SET STORAGE EXTERNAL;

CREATE TABLE jobs (
    id UUID PRIMARY KEY,
    owner TEXT NOT NULL,
    kind TEXT NOT NULL,
    status TEXT NOT NULL CHECK (status IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    request TEXT NOT NULL,
    labels TEXT NOT NULL,
    priority BIGINT NOT NULL CHECK (priority BETWEEN 1 AND 4),
    keep_for_s DOUBLE PRECISION,
    created_at BIGINT NOT NULL,
    started_at BIGINT,
    finished_at BIGINT,
    expires_at BIGINT,
    cancel_requested_at BIGINT,
    progress DOUBLE PRECISION NOT NULL DEFAULT 0,
    claim BIGINT NOT NULL DEFAULT 0,
    heartbeat_at BIGINT,
    lost BIGINT NOT NULL DEFAULT 0,
    delivery BIGINT,
    content_hash BYTEA NOT NULL,
    reused BOOLEAN NOT NULL DEFAULT FALSE,
    result_id UUID REFERENCES results (id),
    error_cause TEXT,
    error_detail TEXT,
    CHECK ((status IN ('succeeded', 'failed', 'cancelled')) = (finished_at IS NOT NULL)),
    CHECK ((status = 'succeeded') = (result_id IS NOT NULL)),
    CHECK ((status = 'failed') = (error_cause IS NOT NULL))
);

CREATE INDEX jobs_of_owner ON jobs (owner, id);
CREATE INDEX jobs_unfinished ON jobs (status) WHERE status IN ('queued', 'running');
CREATE INDEX jobs_by_content ON jobs (content_hash) WHERE status = 'succeeded';
CREATE INDEX jobs_by_result ON jobs (result_id) WHERE result_id IS NOT NULL;
CREATE INDEX jobs_by_expiry ON jobs (expires_at) WHERE expires_at IS NOT NULL;

CREATE TABLE studies (
    job UUID PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    points BIGINT NOT NULL,
    ended BIGINT NOT NULL DEFAULT 0,
    succeeded BIGINT NOT NULL DEFAULT 0
);

CREATE TABLE points (
    job UUID NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    number BIGINT NOT NULL,
    status TEXT NOT NULL DEFAULT 'queued' CHECK (status IN ('queued', 'running', 'succeeded', 'failed')),
    claim BIGINT NOT NULL DEFAULT 0,
    strand BIGINT,
    lost BIGINT NOT NULL DEFAULT 0,
    reused BOOLEAN NOT NULL DEFAULT FALSE,
    content_hash BYTEA,
    cause TEXT,
    answer BYTEA,
    PRIMARY KEY (job, number),
    CHECK ((status IN ('succeeded', 'failed')) = (answer IS NOT NULL))
);

CREATE INDEX points_waiting ON points (job, number) WHERE status = 'queued';
CREATE INDEX points_running ON points (strand) WHERE status = 'running';
CREATE INDEX points_by_content ON points (content_hash) WHERE status = 'succeeded';

CREATE TABLE strands (
    delivery BIGINT PRIMARY KEY,
    job UUID NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    heartbeat_at BIGINT
);

CREATE INDEX strands_of_job ON strands (job);

CREATE TABLE workers (
    id UUID PRIMARY KEY,
    slots BIGINT NOT NULL,
    heartbeat_at BIGINT NOT NULL
);

CREATE TABLE idempotency_keys (
    owner TEXT NOT NULL,
    key TEXT NOT NULL,
    fingerprint BYTEA NOT NULL,
    job UUID NOT NULL,
    created_at BIGINT NOT NULL,
    reused BOOLEAN NOT NULL,
    expires_at BIGINT,
    PRIMARY KEY (owner, key)
);

CREATE INDEX idempotency_keys_by_age ON idempotency_keys (created_at);

CREATE TABLE writability (
    id BIGINT PRIMARY KEY CHECK (id = 1),
    written_at BIGINT NOT NULL
);
