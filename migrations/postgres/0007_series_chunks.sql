-- ../sqlite/0012_series_chunks.sql
CREATE TABLE series_chunks (
    result_id UUID NOT NULL REFERENCES results (id) ON DELETE CASCADE,
    series BIGINT NOT NULL,
    number BIGINT NOT NULL,
    content BYTEA NOT NULL,
    digest BYTEA NOT NULL,
    PRIMARY KEY (result_id, series, number)
);

-- Compressed already.
ALTER TABLE series_chunks ALTER COLUMN content SET STORAGE EXTERNAL;

CREATE TABLE recordings (
    result_id UUID PRIMARY KEY REFERENCES results (id) ON DELETE CASCADE,
    job UUID NOT NULL,
    claim BIGINT NOT NULL
);
