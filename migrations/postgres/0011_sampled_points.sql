-- ../sqlite/0016_sampled_points.sql
CREATE OR REPLACE FUNCTION count_unfinished() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
    single BIGINT := 0;
    of_studies BIGINT := 0;
    whose TEXT;
BEGIN
    IF TG_OP <> 'INSERT' THEN
        whose := old.owner;
        IF old.status IN ('queued', 'running') THEN
            single := single - CASE WHEN old.kind IN ('study', 'uncertainty') THEN 0 ELSE 1 END;
            of_studies := of_studies - old.points_left;
        END IF;
    END IF;
    IF TG_OP <> 'DELETE' THEN
        whose := new.owner;
        IF new.status IN ('queued', 'running') THEN
            single := single + CASE WHEN new.kind IN ('study', 'uncertainty') THEN 0 ELSE 1 END;
            of_studies := of_studies + new.points_left;
        END IF;
    END IF;
    IF single <> 0 OR of_studies <> 0 THEN
        INSERT INTO unfinished AS u (owner, part, jobs, points) VALUES (whose, pg_backend_pid(), single, of_studies)
        ON CONFLICT (owner, part) DO UPDATE SET jobs = u.jobs + excluded.jobs, points = u.points + excluded.points;
    END IF;
    RETURN NULL;
END $$;
