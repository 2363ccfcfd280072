-- Unfinished points of a study; 0 for other jobs.
ALTER TABLE jobs ADD COLUMN points_left INTEGER NOT NULL DEFAULT 0;
UPDATE jobs SET points_left = (SELECT points - ended FROM studies WHERE studies.job = jobs.id)
WHERE kind = 'study' AND status IN ('queued', 'running');

-- Unfinished single jobs and points of studies by owner, which limits compare: triggers count them, so that no submission does.
CREATE TABLE unfinished (
    owner TEXT NOT NULL,
    -- On PostgreSQL the connection that counted, so that no transaction waits for the count of another. Here always 0.
    part INTEGER NOT NULL,
    jobs INTEGER NOT NULL,
    points INTEGER NOT NULL,
    PRIMARY KEY (owner, part)
) STRICT;

INSERT INTO unfinished (owner, part, jobs, points)
SELECT owner, 0, count(*) FILTER (WHERE kind <> 'study'), sum(points_left) FROM jobs
WHERE status IN ('queued', 'running') GROUP BY owner;

CREATE TRIGGER jobs_count_insert AFTER INSERT ON jobs WHEN new.status IN ('queued', 'running') BEGIN
    INSERT INTO unfinished (owner, part, jobs, points) VALUES (new.owner, 0, new.kind <> 'study', new.points_left)
    ON CONFLICT (owner, part) DO UPDATE SET jobs = jobs + excluded.jobs, points = points + excluded.points;
END;

CREATE TRIGGER jobs_count_update AFTER UPDATE OF status, points_left ON jobs
WHEN (old.status IN ('queued', 'running'), old.points_left) IS NOT (new.status IN ('queued', 'running'), new.points_left) BEGIN
    INSERT INTO unfinished (owner, part, jobs, points) VALUES (new.owner, 0,
        (new.kind <> 'study') * ((new.status IN ('queued', 'running')) - (old.status IN ('queued', 'running'))),
        (new.status IN ('queued', 'running')) * new.points_left - (old.status IN ('queued', 'running')) * old.points_left)
    ON CONFLICT (owner, part) DO UPDATE SET jobs = jobs + excluded.jobs, points = points + excluded.points;
END;

CREATE TRIGGER jobs_count_delete AFTER DELETE ON jobs WHEN old.status IN ('queued', 'running') BEGIN
    UPDATE unfinished SET jobs = jobs - (old.kind <> 'study'), points = points - old.points_left WHERE owner = old.owner;
END;
