-- What is known of removed jobs. One that expired is answered with its last state; of one that was deleted only the id is known, so
-- that its idempotency key makes no other job.
CREATE TABLE removed_jobs (
    id BLOB PRIMARY KEY NOT NULL,
    owner TEXT NOT NULL,
    -- The last state; NULL if the job was deleted.
    kind TEXT,
    status TEXT,
    finished_at INTEGER,
    removed_at INTEGER NOT NULL,
    -- When row and key go.
    forget_at INTEGER NOT NULL
) STRICT;

CREATE INDEX removed_jobs_by_age ON removed_jobs (forget_at);

-- Keys go with the row of their job, which no search among all keys finds.
DROP INDEX idempotency_keys_by_age;
CREATE INDEX idempotency_keys_by_job ON idempotency_keys (job);

INSERT INTO removed_jobs (id, owner, removed_at, forget_at)
SELECT job, max(owner), max(created_at), max(created_at) + 86400000000 FROM idempotency_keys
WHERE NOT EXISTS (SELECT 1 FROM jobs WHERE id = job) GROUP BY job;
