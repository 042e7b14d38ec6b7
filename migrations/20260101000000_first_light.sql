-- Machines with their immutable revisions, jobs with what they answered, idempotency keys.
-- Times are RFC 3339, UTC, milliseconds, so that they sort as text. Digests are lower-case hex SHA-256.

-- One row for each slug ever used. A deleted machine keeps its row and its revisions: jobs name them, and a
-- machine created again under the same slug goes on counting.
CREATE TABLE machines (
    seq           INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    machine_id    TEXT    NOT NULL UNIQUE CHECK (length(machine_id) BETWEEN 1 AND 64),
    last_revision INTEGER NOT NULL CHECK (last_revision >= 1),
    deleted       INTEGER NOT NULL DEFAULT 0 CHECK (deleted IN (0, 1))
) STRICT;

CREATE TABLE machine_revisions (
    machine_id TEXT    NOT NULL REFERENCES machines (machine_id),
    revision   INTEGER NOT NULL CHECK (revision >= 1),
    profile    TEXT    NOT NULL CHECK (json_valid(profile)),
    sha256     TEXT    NOT NULL CHECK (length(sha256) = 64),
    created_at TEXT    NOT NULL CHECK (length(created_at) = 24),
    PRIMARY KEY (machine_id, revision)
) STRICT, WITHOUT ROWID;

CREATE TRIGGER machine_revisions_never_change BEFORE UPDATE ON machine_revisions
BEGIN
    SELECT RAISE (ABORT, 'a machine revision never changes');
END;

CREATE TRIGGER machine_revisions_never_go BEFORE DELETE ON machine_revisions
BEGIN
    SELECT RAISE (ABORT, 'a machine revision never goes');
END;

CREATE TABLE jobs (
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
    CHECK (state <> 'succeeded' OR (output_sha256 IS NOT NULL AND report IS NOT NULL AND report_sha256 IS NOT NULL)),
    FOREIGN KEY (machine_id, machine_revision) REFERENCES machine_revisions (machine_id, revision)
) STRICT;

CREATE INDEX jobs_of_machine ON jobs (machine_id, seq);
CREATE INDEX jobs_by_external_id ON jobs (external_id, seq) WHERE external_id IS NOT NULL;

-- What a key was first used for. The fingerprint covers method, path, query and body.
CREATE TABLE idempotency_keys (
    idempotency_key TEXT NOT NULL PRIMARY KEY CHECK (length(idempotency_key) BETWEEN 1 AND 255),
    fingerprint     TEXT NOT NULL CHECK (length(fingerprint) = 64),
    job_id          TEXT NOT NULL REFERENCES jobs (id),
    created_at      TEXT NOT NULL CHECK (length(created_at) = 24)
) STRICT, WITHOUT ROWID;
