-- Webhooks: the ends of jobs that somebody is to be told of, every attempt to tell them, and the secrets that sign it.

-- One row for every end that is to be told.
CREATE TABLE deliveries (
    job_id     TEXT    NOT NULL PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    -- Host and port as they stand in the address, lower case: those who share one share their places.
    receiver   TEXT    NOT NULL CHECK (length(receiver) >= 1),
    state      TEXT    NOT NULL CHECK (state IN ('waiting', 'delivered', 'given-up')),
    -- A client that asks for the end once more begins a new round.
    round      INTEGER NOT NULL DEFAULT 1 CHECK (round >= 1),
    -- Attempts of this round.
    attempts   INTEGER NOT NULL DEFAULT 0 CHECK (attempts >= 0),
    due_at     TEXT    CHECK ((state = 'waiting') = (due_at IS NOT NULL)),
    -- When the job ended.
    created_at TEXT    NOT NULL CHECK (length(created_at) = 24)
) STRICT, WITHOUT ROWID;

CREATE INDEX deliveries_due ON deliveries (due_at, receiver) WHERE state = 'waiting';
CREATE INDEX deliveries_by_age ON deliveries (created_at) WHERE state = 'waiting';

CREATE TABLE delivery_attempts (
    seq         INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    job_id      TEXT    NOT NULL REFERENCES deliveries (job_id) ON DELETE CASCADE,
    started_at  TEXT    NOT NULL CHECK (length(started_at) = 24),
    duration_ms INTEGER NOT NULL CHECK (duration_ms >= 0),
    -- The receiver's answer; null where there was none.
    status      INTEGER CHECK (status IS NULL OR status BETWEEN 100 AND 999),
    outcome     TEXT    NOT NULL CHECK (length(outcome) BETWEEN 1 AND 64),
    detail      TEXT    NOT NULL
) STRICT;

CREATE INDEX delivery_attempts_of_job ON delivery_attempts (job_id, seq);

CREATE TRIGGER delivery_attempts_never_change BEFORE UPDATE ON delivery_attempts
BEGIN
    SELECT RAISE (ABORT, 'an attempt never changes');
END;

-- Whatever ends a job, what is to be told of it comes with the end or not at all.
CREATE TRIGGER jobs_are_told AFTER UPDATE OF state ON jobs
WHEN NEW.state IN ('succeeded', 'failed', 'cancelled') AND NEW.callback_url IS NOT NULL
BEGIN
    INSERT INTO deliveries (job_id, receiver, state, due_at, created_at)
        SELECT NEW.id, substr(authority, 1, instr(authority || '?', '?') - 1), 'waiting', NEW.finished_at, NEW.finished_at
        FROM (
            SELECT substr(rest, 1, instr(rest || '/', '/') - 1) AS authority
            FROM (SELECT lower(substr(NEW.callback_url, instr(NEW.callback_url, '://') + 3)) AS rest)
        );
END;

-- Jobs that ended before this was there: nobody was told, and who wants to be may ask.
INSERT INTO deliveries (job_id, receiver, state, due_at, created_at)
    SELECT id, substr(authority, 1, instr(authority || '?', '?') - 1), 'given-up', NULL, finished_at
    FROM (
        SELECT id, finished_at, substr(rest, 1, instr(rest || '/', '/') - 1) AS authority
        FROM (
            SELECT id, finished_at, lower(substr(callback_url, instr(callback_url, '://') + 3)) AS rest
            FROM jobs WHERE callback_url IS NOT NULL AND state IN ('succeeded', 'failed', 'cancelled')
        )
    );

-- What deliveries are signed with. The newest has no end; the ones before it sign beside it for a while.
CREATE TABLE webhook_secrets (
    seq             INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    secret          TEXT    NOT NULL CHECK (length(secret) BETWEEN 38 AND 94),
    created_at      TEXT    NOT NULL CHECK (length(created_at) = 24),
    signs_until     TEXT    CHECK (signs_until IS NULL OR length(signs_until) = 24),
    -- The idempotency key it was made under, as long as that is remembered, and the digest of the request.
    idempotency_key TEXT    UNIQUE CHECK (idempotency_key IS NULL OR length(idempotency_key) BETWEEN 1 AND 255),
    fingerprint     TEXT    CHECK (fingerprint IS NULL OR length(fingerprint) = 64),
    CHECK (idempotency_key IS NULL OR fingerprint IS NOT NULL)
) STRICT;

CREATE UNIQUE INDEX webhook_secrets_newest ON webhook_secrets (signs_until IS NULL) WHERE signs_until IS NULL;
