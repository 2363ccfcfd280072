-- Start-time fair queueing: whose work the next free place takes. The virtual time of an owner that has a turn starts at the greater
-- of its end and the latest start of all owners; processor time that its work uses moves the end on. The least start is due.
CREATE TABLE turns (
    owner TEXT PRIMARY KEY NOT NULL,
    -- Virtual start of the owner's last turn [s].
    started REAL NOT NULL,
    -- The same, plus the processor time used since [s].
    ended REAL NOT NULL
) STRICT;

CREATE INDEX turns_by_start ON turns (started);

-- Waiting work by owner, in the order in which it is due within the owner. A job that was returned without a delivery gets one first.
CREATE INDEX jobs_waiting ON jobs (owner, priority, id) WHERE status = 'queued' AND delivery IS NOT NULL;
CREATE INDEX jobs_by_delivery ON jobs (delivery) WHERE status IN ('queued', 'running');

-- Shards without points left used to stay.
DELETE FROM strands WHERE NOT EXISTS (
    SELECT 1 FROM river_job WHERE id = strands.delivery AND state NOT IN ('completed', 'cancelled', 'discarded')
);
ALTER TABLE strands ADD COLUMN owner TEXT NOT NULL DEFAULT '';
-- Since when a shard waits for a turn; NULL while it runs points.
ALTER TABLE strands ADD COLUMN waiting_since INTEGER;
UPDATE strands SET owner = (SELECT owner FROM jobs WHERE jobs.id = strands.job),
    waiting_since = CASE WHEN heartbeat_at IS NULL THEN 0 END;

CREATE INDEX strands_waiting ON strands (owner, waiting_since, delivery) WHERE waiting_since IS NOT NULL;

-- Limits count unfinished single jobs of each owner, and unfinished points of its studies.
DROP INDEX jobs_unfinished;
CREATE INDEX jobs_unfinished ON jobs (kind, owner, status) WHERE status IN ('queued', 'running');
