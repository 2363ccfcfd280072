-- ../sqlite/0014_request_digests.sql
ALTER TABLE jobs ADD COLUMN request_digest BYTEA;
