-- What pictures of a simulation show, thinned: motions, orbits and loads, where any signal was asked for.
CREATE TABLE views (
    result_id BLOB PRIMARY KEY NOT NULL REFERENCES results (id) ON DELETE CASCADE,
    -- As JSON, compressed with zlib.
    answer BLOB NOT NULL
) STRICT;
