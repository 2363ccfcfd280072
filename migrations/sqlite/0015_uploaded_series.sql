-- Series of a load, which requests name by their content hash. Each belongs to its owner.
CREATE TABLE uploaded_series (
    owner TEXT NOT NULL,
    -- SHA-256 of rate and values, in hexadecimal digits.
    hash TEXT NOT NULL,
    rate_hz REAL NOT NULL,
    -- Number of values.
    count INTEGER NOT NULL,
    -- Values as 64-bit floats with the lowest byte first, compressed with zlib. NULL after the expiry: the hash is remembered for a while.
    content BLOB,
    -- Length of the content, which counts for the owner.
    bytes INTEGER NOT NULL,
    created_at INTEGER NOT NULL,
    -- Put off whenever a job names the series.
    expires_at INTEGER NOT NULL,
    PRIMARY KEY (owner, hash)
) STRICT;

CREATE INDEX uploaded_series_by_expiry ON uploaded_series (expires_at);
