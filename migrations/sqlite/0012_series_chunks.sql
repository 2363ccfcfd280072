-- Values of time series, which a run writes while it computes. Their result is there from the first chunk on, without metrics.
CREATE TABLE series_chunks (
    result_id BLOB NOT NULL REFERENCES results (id) ON DELETE CASCADE,
    -- Number of the series in the order of the request.
    series INTEGER NOT NULL,
    -- Number of the chunk in the series.
    number INTEGER NOT NULL,
    content BLOB NOT NULL,
    -- SHA-256 of the content.
    digest BLOB NOT NULL,
    PRIMARY KEY (result_id, series, number)
) STRICT;

-- Results that a run is still writing. When that claim of the job no longer runs, the run was lost, and the result goes.
CREATE TABLE recordings (
    result_id BLOB PRIMARY KEY NOT NULL REFERENCES results (id) ON DELETE CASCADE,
    job BLOB NOT NULL,
    claim INTEGER NOT NULL
) STRICT;
