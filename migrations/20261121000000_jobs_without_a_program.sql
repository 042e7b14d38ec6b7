-- A job may succeed without making a program: a servo simulation answers a report alone. SQLite cannot change a
-- CHECK, so the table is made anew; the keys that point to it are moved along first, so that no reference is ever
-- left hanging.

CREATE TABLE jobs_new (
    seq              INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    id               TEXT    NOT NULL UNIQUE CHECK (length(id) = 36),
    machine_id       TEXT    NOT NULL,
    machine_revision INTEGER NOT NULL,
    operation        TEXT    NOT NULL CHECK (length(operation) BETWEEN 1 AND 64),
    parameters       TEXT    NOT NULL CHECK (json_valid(parameters)),
    state            TEXT    NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    progress         REAL    NOT NULL CHECK (progress BETWEEN 0 AND 1),
    file_name        TEXT    NOT NULL CHECK (length(file_name) BETWEEN 1 AND 255),
    input_sha256     TEXT    NOT NULL CHECK (length(input_sha256) = 64),
    output_sha256    TEXT    CHECK (output_sha256 IS NULL OR length(output_sha256) = 64),
    report           TEXT    CHECK (report IS NULL OR json_valid(report)),
    report_sha256    TEXT    CHECK (report_sha256 IS NULL OR length(report_sha256) = 64),
    problem          TEXT    CHECK (problem IS NULL OR json_valid(problem)),
    external_id      TEXT    CHECK (external_id IS NULL OR length(external_id) BETWEEN 1 AND 200),
    software_version TEXT    NOT NULL,
    created_at       TEXT    NOT NULL CHECK (length(created_at) = 24),
    started_at       TEXT    CHECK (started_at IS NULL OR length(started_at) = 24),
    finished_at      TEXT    CHECK (finished_at IS NULL OR length(finished_at) = 24),
    CHECK (state <> 'succeeded' OR (report IS NOT NULL AND report_sha256 IS NOT NULL)),
    CHECK (state <> 'succeeded' OR operation = 'servo-simulation' OR output_sha256 IS NOT NULL),
    FOREIGN KEY (machine_id, machine_revision) REFERENCES machine_revisions (machine_id, revision)
) STRICT;

INSERT INTO jobs_new SELECT * FROM jobs ORDER BY seq;

CREATE TABLE idempotency_keys_new (
    idempotency_key TEXT NOT NULL PRIMARY KEY CHECK (length(idempotency_key) BETWEEN 1 AND 255),
    fingerprint     TEXT NOT NULL CHECK (length(fingerprint) = 64),
    job_id          TEXT NOT NULL REFERENCES jobs_new (id),
    created_at      TEXT NOT NULL CHECK (length(created_at) = 24)
) STRICT, WITHOUT ROWID;

INSERT INTO idempotency_keys_new SELECT * FROM idempotency_keys;

DROP TABLE idempotency_keys;
DROP TABLE jobs;
-- Renaming carries the reference of the keys along.
ALTER TABLE jobs_new RENAME TO jobs;
ALTER TABLE idempotency_keys_new RENAME TO idempotency_keys;

CREATE INDEX jobs_of_machine ON jobs (machine_id, seq);
CREATE INDEX jobs_by_external_id ON jobs (external_id, seq) WHERE external_id IS NOT NULL;
