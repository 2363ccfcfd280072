-- Sign of life of a strand, as of a run: on a database that several machines share it may be lost with its worker.
ALTER TABLE strands ADD COLUMN heartbeat_at INTEGER;

-- Processes that run jobs, and how many at a time: a study has as many strands as there are places.
CREATE TABLE workers (
    id BLOB PRIMARY KEY NOT NULL,
    slots INTEGER NOT NULL,
    heartbeat_at INTEGER NOT NULL
) STRICT;
