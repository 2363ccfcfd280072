-- Uncertainty jobs are run point by point, as studies: they count by their points, not as single jobs.
DROP TRIGGER jobs_count_insert;
DROP TRIGGER jobs_count_update;
DROP TRIGGER jobs_count_delete;

CREATE TRIGGER jobs_count_insert AFTER INSERT ON jobs WHEN new.status IN ('queued', 'running') BEGIN
    INSERT INTO unfinished (owner, part, jobs, points)
    VALUES (new.owner, 0, new.kind NOT IN ('study', 'uncertainty'), new.points_left)
    ON CONFLICT (owner, part) DO UPDATE SET jobs = jobs + excluded.jobs, points = points + excluded.points;
END;

CREATE TRIGGER jobs_count_update AFTER UPDATE OF status, points_left ON jobs
WHEN (old.status IN ('queued', 'running'), old.points_left) IS NOT (new.status IN ('queued', 'running'), new.points_left) BEGIN
    INSERT INTO unfinished (owner, part, jobs, points) VALUES (new.owner, 0,
        (new.kind NOT IN ('study', 'uncertainty')) * ((new.status IN ('queued', 'running')) - (old.status IN ('queued', 'running'))),
        (new.status IN ('queued', 'running')) * new.points_left - (old.status IN ('queued', 'running')) * old.points_left)
    ON CONFLICT (owner, part) DO UPDATE SET jobs = jobs + excluded.jobs, points = points + excluded.points;
END;

CREATE TRIGGER jobs_count_delete AFTER DELETE ON jobs WHEN old.status IN ('queued', 'running') BEGIN
    UPDATE unfinished SET jobs = jobs - (old.kind NOT IN ('study', 'uncertainty')), points = points - old.points_left
    WHERE owner = old.owner;
END;
