-- ../sqlite/0011_removed_jobs.sql
CREATE TABLE removed_jobs (
    id UUID PRIMARY KEY,
    owner TEXT NOT NULL,
    kind TEXT,
    status TEXT,
    finished_at BIGINT,
    removed_at BIGINT NOT NULL,
    forget_at BIGINT NOT NULL
);

CREATE INDEX removed_jobs_by_age ON removed_jobs (forget_at);

DROP INDEX idempotency_keys_by_age;
CREATE INDEX idempotency_keys_by_job ON idempotency_keys (job);

INSERT INTO removed_jobs (id, owner, removed_at, forget_at)
SELECT job, max(owner), max(created_at), max(created_at) + 86400000000 FROM idempotency_keys
WHERE NOT EXISTS (SELECT 1 FROM jobs WHERE id = job) GROUP BY job;
