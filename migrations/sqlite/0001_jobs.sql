-- Times are microseconds since 1970 (UTC): they sort, compare and subtract as numbers.

-- What a run left behind. Apart from jobs, so that several jobs may point to one result.
CREATE TABLE results (
    id BLOB PRIMARY KEY NOT NULL,
    -- The answer of GET …/metrics, as it is sent.
    metrics TEXT NOT NULL
) STRICT;

-- Spectra and series, one row a channel: a reader of one channel touches no other.
CREATE TABLE signals (
    result_id BLOB NOT NULL REFERENCES results (id) ON DELETE CASCADE,
    sort TEXT NOT NULL CHECK (sort IN ('amplitude', 'envelope', 'series')),
    channel TEXT NOT NULL,
    -- The answer as JSON, compressed with zlib.
    answer BLOB NOT NULL,
    PRIMARY KEY (result_id, sort, channel)
) STRICT;

-- The truth of the API. The queue's own tables only deliver; they never decide over these rows.
CREATE TABLE jobs (
    -- UUIDv7: the newest job has the greatest id, so that lists need no other order.
    id BLOB PRIMARY KEY NOT NULL,
    -- Who submitted it: the start of the token's digest, empty where there are no tokens.
    owner TEXT NOT NULL,
    kind TEXT NOT NULL,
    status TEXT NOT NULL CHECK (status IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    request TEXT NOT NULL,
    labels TEXT NOT NULL CHECK (json_valid(labels)),
    priority INTEGER NOT NULL CHECK (priority BETWEEN 1 AND 4),
    keep_for_s REAL,
    created_at INTEGER NOT NULL,
    started_at INTEGER,
    finished_at INTEGER,
    expires_at INTEGER,
    cancel_requested_at INTEGER,
    progress REAL NOT NULL DEFAULT 0,
    -- Counted up by each worker that takes the job. Progress and results are written only under the
    -- claim that computed them, so that a worker that comes back from the dead changes nothing.
    claim INTEGER NOT NULL DEFAULT 0,
    -- Sign of life of the worker that holds the claim.
    heartbeat_at INTEGER,
    -- Runs that ended with their process.
    lost INTEGER NOT NULL DEFAULT 0,
    -- The queue's row that delivers this job; older deliveries are void.
    delivery INTEGER,
    -- SHA-256 of all that determines the result.
    content_hash BLOB NOT NULL,
    -- Whether another job's result answered this one.
    reused INTEGER NOT NULL DEFAULT 0 CHECK (reused IN (0, 1)),
    result_id BLOB REFERENCES results (id),
    error_cause TEXT,
    error_detail TEXT,
    CHECK ((status IN ('succeeded', 'failed', 'cancelled')) = (finished_at IS NOT NULL)),
    CHECK ((status = 'succeeded') = (result_id IS NOT NULL)),
    CHECK ((status = 'failed') = (error_cause IS NOT NULL))
) STRICT;

CREATE INDEX jobs_of_owner ON jobs (owner, id);
-- Counts of the queue and the sweep read unfinished jobs only, however many have ended.
CREATE INDEX jobs_unfinished ON jobs (status) WHERE status IN ('queued', 'running');
CREATE INDEX jobs_by_content ON jobs (content_hash) WHERE status = 'succeeded';
CREATE INDEX jobs_by_result ON jobs (result_id) WHERE result_id IS NOT NULL;
CREATE INDEX jobs_by_expiry ON jobs (expires_at) WHERE expires_at IS NOT NULL;

-- One row that the service writes to find out whether the disk takes writes again.
CREATE TABLE writability (
    id INTEGER PRIMARY KEY CHECK (id = 1),
    written_at INTEGER NOT NULL
) STRICT;
