-- A study is a job that no worker holds. Its points are run by strands: deliveries of the queue that each take point after
-- point, and give way to other jobs between two of them.
CREATE TABLE studies (
    job BLOB PRIMARY KEY NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    points INTEGER NOT NULL,
    ended INTEGER NOT NULL DEFAULT 0,
    succeeded INTEGER NOT NULL DEFAULT 0
) STRICT;

CREATE TABLE points (
    job BLOB NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    number INTEGER NOT NULL,
    status TEXT NOT NULL DEFAULT 'queued' CHECK (status IN ('queued', 'running', 'succeeded', 'failed')),
    -- Counted up by each strand that takes the point: an end is written only under the claim that computed it.
    claim INTEGER NOT NULL DEFAULT 0,
    -- The delivery of the strand that took it last.
    strand INTEGER,
    -- Runs that ended with their process.
    lost INTEGER NOT NULL DEFAULT 0,
    reused INTEGER NOT NULL DEFAULT 0 CHECK (reused IN (0, 1)),
    -- SHA-256 of all that determines the result; of points that succeeded.
    content_hash BLOB,
    -- Why it failed, as one word.
    cause TEXT,
    -- Metrics or error as JSON, compressed with zlib.
    answer BLOB,
    PRIMARY KEY (job, number),
    CHECK ((status IN ('succeeded', 'failed')) = (answer IS NOT NULL))
) STRICT;

CREATE INDEX points_waiting ON points (job, number) WHERE status = 'queued';
CREATE INDEX points_running ON points (strand) WHERE status = 'running';
CREATE INDEX points_by_content ON points (content_hash) WHERE status = 'succeeded';

-- Deliveries that run the points of a study; others of the same study are void.
CREATE TABLE strands (
    delivery INTEGER PRIMARY KEY NOT NULL,
    job BLOB NOT NULL REFERENCES jobs (id) ON DELETE CASCADE
) STRICT;

CREATE INDEX strands_of_job ON strands (job);
