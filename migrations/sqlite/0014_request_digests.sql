-- Digest of the request with its job, owner and work, computed when it is written and compared whenever it is read. Rows of earlier
-- versions have none.
ALTER TABLE jobs ADD COLUMN request_digest BLOB;
