-- ../sqlite/0015_uploaded_series.sql
CREATE TABLE uploaded_series (
    owner TEXT NOT NULL,
    -- SHA-256 of rate and values, in hexadecimal digits.
    hash TEXT NOT NULL,
    rate_hz DOUBLE PRECISION NOT NULL,
    -- Number of values.
    count BIGINT NOT NULL,
    -- Values as 64-bit floats with the lowest byte first, compressed with zlib. NULL after the expiry: the hash is remembered for a while.
    content BYTEA,
    -- Length of the content, which counts for the owner.
    bytes BIGINT NOT NULL,
    created_at BIGINT NOT NULL,
    -- Put off whenever a job names the series.
    expires_at BIGINT NOT NULL,
    PRIMARY KEY (owner, hash)
);

CREATE INDEX uploaded_series_by_expiry ON uploaded_series (expires_at);
