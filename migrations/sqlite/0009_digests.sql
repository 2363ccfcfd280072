-- SHA-256 of each stored answer, computed when it is written and compared whenever it is read. Rows of earlier versions have none.
ALTER TABLE results ADD COLUMN digest BLOB;
ALTER TABLE signals ADD COLUMN digest BLOB;
ALTER TABLE reports ADD COLUMN digest BLOB;
ALTER TABLE views ADD COLUMN digest BLOB;
ALTER TABLE points ADD COLUMN digest BLOB;

-- Jobs with a stored answer that is not what was written. It answers no other job.
CREATE TABLE corrupt_results (
    job BLOB PRIMARY KEY NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    -- The first part that was found so.
    part TEXT NOT NULL,
    found_at INTEGER NOT NULL
) STRICT;
