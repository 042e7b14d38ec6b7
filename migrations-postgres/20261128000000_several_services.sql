-- Several services on one database: who they are, who computes which job and until when, and files in rows.

-- Where the files of this database are. A database that a service has used before this migration has them in a
-- directory.
ALTER TABLE service ADD COLUMN files TEXT COLLATE "C" NOT NULL DEFAULT ''
    CHECK (files IN ('', 'directory', 'postgres'));
UPDATE service SET files = 'directory' WHERE EXISTS (SELECT 1 FROM machines);

-- The services, by starts. All times here are those of the server.
CREATE TABLE instances (
    id         TEXT   COLLATE "C" NOT NULL PRIMARY KEY CHECK (length(id) BETWEEN 1 AND 64),
    version    TEXT   COLLATE "C" NOT NULL,
    host       TEXT   COLLATE "C" NOT NULL,
    process    BIGINT NOT NULL,
    began_at   TIMESTAMPTZ NOT NULL DEFAULT clock_timestamp(),
    -- A service that has not been seen for 30 s is dead, unless it has stopped in order.
    seen_at    TIMESTAMPTZ NOT NULL DEFAULT clock_timestamp(),
    stopped_at TIMESTAMPTZ
);

-- Who computes a running job, and until when it is left to it. The name of the lease is that in `jobs`.
CREATE TABLE job_leases (
    job_id      TEXT   COLLATE "C" NOT NULL PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    lease       TEXT   COLLATE "C" NOT NULL,
    holder      TEXT   COLLATE "C" NOT NULL,
    lease_until TIMESTAMPTZ NOT NULL,
    -- Whether it is computed beside others or alone; null until its computation begins, and then a death of the holder
    -- does not blame it.
    computed    TEXT   COLLATE "C" CHECK (computed IN ('beside', 'alone'))
);

CREATE INDEX job_leases_of_holder ON job_leases (holder);

-- A lease ends with the job's running, however that ends.
CREATE FUNCTION end_lease() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    DELETE FROM job_leases WHERE job_id = NEW.id;
    RETURN NULL;
END
$$;

CREATE TRIGGER jobs_end_their_lease AFTER UPDATE OF state ON jobs
    FOR EACH ROW WHEN (OLD.state = 'running' AND NEW.state <> 'running')
    EXECUTE FUNCTION end_lease();

-- Progress is stored while a job runs, for the other services, and goes with the computation.
CREATE FUNCTION forget_progress() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    NEW.progress := 0;
    RETURN NEW;
END
$$;

CREATE TRIGGER jobs_forget_progress BEFORE UPDATE OF state ON jobs
    FOR EACH ROW WHEN (OLD.state = 'running' AND NEW.state IN ('queued', 'failed', 'cancelled'))
    EXECUTE FUNCTION forget_progress();

-- Programs and results, in parts. The key of an object is its digest and a name that is never used again, so that a
-- removal cannot hit bytes that were kept again meanwhile.
CREATE TABLE files (
    object_key TEXT   COLLATE "C" NOT NULL PRIMARY KEY,
    sha256     TEXT   COLLATE "C" NOT NULL CHECK (length(sha256) = 64),
    length     BIGINT NOT NULL CHECK (length >= 0),
    -- Whether every part is there.
    whole      BIGINT NOT NULL DEFAULT 0 CHECK (whole IN (0, 1)),
    -- When it was last kept: nobody removes a file that was kept within a day.
    kept_at    TIMESTAMPTZ NOT NULL DEFAULT clock_timestamp()
);

CREATE UNIQUE INDEX files_whole ON files (sha256) WHERE whole = 1;

CREATE TABLE file_parts (
    object_key TEXT   COLLATE "C" NOT NULL REFERENCES files (object_key) ON DELETE CASCADE,
    part       BIGINT NOT NULL CHECK (part >= 0),
    bytes      BYTEA  NOT NULL,
    PRIMARY KEY (object_key, part)
);

CREATE INDEX jobs_by_surface ON jobs (surface_sha256) WHERE surface_sha256 IS NOT NULL;
CREATE INDEX jobs_by_changes ON jobs (changes_sha256) WHERE changes_sha256 IS NOT NULL;

-- A job names only files that are there, and holds them until it is stored. Who meets this begins again.
CREATE FUNCTION hold_files() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
    named TEXT;
BEGIN
    IF NOT EXISTS (SELECT 1 FROM service WHERE files = 'postgres') THEN
        RETURN NULL;
    END IF;
    FOREACH named IN ARRAY array_remove(
        ARRAY[NEW.input_sha256, NEW.surface_sha256, NEW.output_sha256, NEW.changes_sha256], NULL)
    LOOP
        PERFORM 1 FROM files WHERE sha256 = named AND whole = 1 FOR KEY SHARE;
        IF NOT FOUND THEN
            RAISE EXCEPTION USING ERRCODE = '40001', MESSAGE = 'a job names a file that is not kept: ' || named;
        END IF;
    END LOOP;
    RETURN NULL;
END
$$;

CREATE TRIGGER jobs_hold_new_files AFTER INSERT ON jobs FOR EACH ROW EXECUTE FUNCTION hold_files();
CREATE TRIGGER jobs_hold_their_files AFTER UPDATE OF output_sha256, changes_sha256 ON jobs
    FOR EACH ROW EXECUTE FUNCTION hold_files();

-- Tells the other services of this schema what has changed. They also look every second.
CREATE FUNCTION tell_services() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM pg_notify('trunnion_' || md5(TG_TABLE_SCHEMA), TG_ARGV[0] || ' ' || NEW.id);
    RETURN NULL;
END
$$;

CREATE TRIGGER jobs_tell_of_new_work AFTER INSERT ON jobs
    FOR EACH ROW WHEN (NEW.state = 'queued') EXECUTE FUNCTION tell_services('queued');
CREATE TRIGGER jobs_tell_of_work_again AFTER UPDATE OF state ON jobs
    FOR EACH ROW WHEN (NEW.state = 'queued') EXECUTE FUNCTION tell_services('queued');
CREATE TRIGGER jobs_tell_of_changes AFTER UPDATE OF state ON jobs
    FOR EACH ROW WHEN (NEW.state <> 'queued') EXECUTE FUNCTION tell_services('changed');
CREATE TRIGGER jobs_tell_of_cancels AFTER UPDATE OF cancel_requested ON jobs
    FOR EACH ROW WHEN (NEW.cancel_requested = 1) EXECUTE FUNCTION tell_services('cancelled');
CREATE TRIGGER api_keys_tell_of_new_keys AFTER INSERT ON api_keys
    FOR EACH ROW EXECUTE FUNCTION tell_services('key');
CREATE TRIGGER api_keys_tell_of_revoked_keys AFTER UPDATE OF revoked_at ON api_keys
    FOR EACH ROW EXECUTE FUNCTION tell_services('key');
