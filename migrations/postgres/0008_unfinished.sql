-- ../sqlite/0013_unfinished.sql
ALTER TABLE jobs ADD COLUMN points_left BIGINT NOT NULL DEFAULT 0;
UPDATE jobs SET points_left = (SELECT points - ended FROM studies WHERE studies.job = jobs.id)
WHERE kind = 'study' AND status IN ('queued', 'running');

CREATE TABLE unfinished (
    owner TEXT NOT NULL,
    part BIGINT NOT NULL,
    jobs BIGINT NOT NULL,
    points BIGINT NOT NULL,
    PRIMARY KEY (owner, part)
) WITH (fillfactor = 50);

INSERT INTO unfinished (owner, part, jobs, points)
SELECT owner, 0, count(*) FILTER (WHERE kind <> 'study'), sum(points_left) FROM jobs
WHERE status IN ('queued', 'running') GROUP BY owner;

CREATE FUNCTION count_unfinished() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
    single BIGINT := 0;
    of_studies BIGINT := 0;
    whose TEXT;
BEGIN
    IF TG_OP <> 'INSERT' THEN
        whose := old.owner;
        IF old.status IN ('queued', 'running') THEN
            single := single - CASE WHEN old.kind = 'study' THEN 0 ELSE 1 END;
            of_studies := of_studies - old.points_left;
        END IF;
    END IF;
    IF TG_OP <> 'DELETE' THEN
        whose := new.owner;
        IF new.status IN ('queued', 'running') THEN
            single := single + CASE WHEN new.kind = 'study' THEN 0 ELSE 1 END;
            of_studies := of_studies + new.points_left;
        END IF;
    END IF;
    IF single <> 0 OR of_studies <> 0 THEN
        INSERT INTO unfinished AS u (owner, part, jobs, points) VALUES (whose, pg_backend_pid(), single, of_studies)
        ON CONFLICT (owner, part) DO UPDATE SET jobs = u.jobs + excluded.jobs, points = u.points + excluded.points;
    END IF;
    RETURN NULL;
END $$;

CREATE TRIGGER jobs_count AFTER INSERT OR DELETE OR UPDATE OF status, points_left ON jobs
FOR EACH ROW EXECUTE FUNCTION count_unfinished();
