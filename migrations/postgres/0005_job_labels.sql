-- ../sqlite/0010_job_labels.sql
CREATE TABLE job_labels (
    owner TEXT NOT NULL,
    label TEXT NOT NULL,
    job UUID NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    PRIMARY KEY (owner, label, job)
);

CREATE INDEX job_labels_of_job ON job_labels (job);

INSERT INTO job_labels (owner, label, job)
SELECT jobs.owner, labels.value, jobs.id FROM jobs, jsonb_array_elements_text(CAST(jobs.labels AS JSONB)) AS labels (value)
ON CONFLICT DO NOTHING;

CREATE INDEX jobs_by_status ON jobs (owner, status, id);
