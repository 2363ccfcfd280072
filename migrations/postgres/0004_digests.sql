-- ../sqlite/0009_digests.sql
ALTER TABLE results ADD COLUMN digest BYTEA;
ALTER TABLE signals ADD COLUMN digest BYTEA;
ALTER TABLE reports ADD COLUMN digest BYTEA;
ALTER TABLE views ADD COLUMN digest BYTEA;
ALTER TABLE points ADD COLUMN digest BYTEA;

CREATE TABLE corrupt_results (
    job UUID PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    part TEXT NOT NULL,
    found_at BIGINT NOT NULL
);
