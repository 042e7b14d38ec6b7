-- Jobs that wait and run: what the queue needs of a job, and whose turn it is.

-- Computations begun. An orderly stop takes the one under way back; a process that dies does not.
ALTER TABLE jobs ADD COLUMN attempts INTEGER NOT NULL DEFAULT 1 CHECK (attempts >= 0);
-- Whom to tell of its end.
ALTER TABLE jobs ADD COLUMN callback_url TEXT CHECK (callback_url IS NULL OR length(callback_url) BETWEEN 1 AND 2048);
-- Its client wants it no more, and its computation has not stopped yet.
ALTER TABLE jobs ADD COLUMN cancel_requested INTEGER NOT NULL DEFAULT 0
    CHECK (cancel_requested IN (0, 1) AND (state <> 'failed' OR problem IS NOT NULL));
-- Who computes it: only the holder of the lease may end it.
ALTER TABLE jobs ADD COLUMN lease TEXT CHECK ((state = 'running') = (lease IS NOT NULL));

CREATE INDEX jobs_queued ON jobs (machine_id, seq) WHERE state = 'queued';
CREATE INDEX jobs_running ON jobs (seq) WHERE state = 'running';
CREATE INDEX jobs_by_end ON jobs (finished_at) WHERE finished_at IS NOT NULL;
CREATE INDEX idempotency_keys_by_job ON idempotency_keys (job_id) WHERE job_id IS NOT NULL;

CREATE TRIGGER jobs_end_once BEFORE UPDATE OF state ON jobs
WHEN OLD.state IN ('succeeded', 'failed', 'cancelled')
BEGIN
    SELECT RAISE (ABORT, 'a job ends once');
END;

-- When a machine's last job was taken from the queue: the one served longest ago is next.
CREATE TABLE job_turns (
    machine_id TEXT    NOT NULL PRIMARY KEY,
    turn       INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
