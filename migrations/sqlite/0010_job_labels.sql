-- Labels of jobs, for lists: those of an owner with a label stand together, newest last, as in jobs_of_owner.
CREATE TABLE job_labels (
    owner TEXT NOT NULL,
    label TEXT NOT NULL,
    job BLOB NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    PRIMARY KEY (owner, label, job)
) STRICT, WITHOUT ROWID;

CREATE INDEX job_labels_of_job ON job_labels (job);

INSERT OR IGNORE INTO job_labels (owner, label, job)
SELECT jobs.owner, labels.value, jobs.id FROM jobs, json_each(jobs.labels) AS labels;

-- Lists by status.
CREATE INDEX jobs_by_status ON jobs (owner, status, id);
