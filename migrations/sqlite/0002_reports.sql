-- What a job of another kind than simulation leaves behind: one answer. Its row in results has an empty text for metrics.
CREATE TABLE reports (
    result_id BLOB PRIMARY KEY NOT NULL REFERENCES results (id) ON DELETE CASCADE,
    -- The answer as JSON, compressed with zlib.
    answer BLOB NOT NULL
) STRICT;
