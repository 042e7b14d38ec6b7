-- Calibration runs: what was read, what it says about the machine, and the revision that it became. A run is never
-- changed and never goes.

CREATE TABLE calibrations (
    seq              INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    id               TEXT    NOT NULL UNIQUE CHECK (length(id) = 36),
    machine_id       TEXT    NOT NULL,
    machine_revision INTEGER NOT NULL,
    kind             TEXT    NOT NULL CHECK (length(kind) BETWEEN 1 AND 64),
    measured_at      TEXT    NOT NULL CHECK (length(measured_at) = 24),
    created_at       TEXT    NOT NULL CHECK (length(created_at) = 24),
    run              TEXT    NOT NULL CHECK (json_valid(run)),
    run_sha256       TEXT    NOT NULL CHECK (length(run_sha256) = 64),
    document         TEXT    NOT NULL CHECK (json_valid(document)),
    document_sha256  TEXT    NOT NULL CHECK (length(document_sha256) = 64),
    FOREIGN KEY (machine_id, machine_revision) REFERENCES machine_revisions (machine_id, revision)
) STRICT;

CREATE INDEX calibrations_of_machine ON calibrations (machine_id, seq);

CREATE TRIGGER calibrations_never_change BEFORE UPDATE ON calibrations
BEGIN
    SELECT RAISE (ABORT, 'a calibration never changes');
END;

CREATE TRIGGER calibrations_never_go BEFORE DELETE ON calibrations
BEGIN
    SELECT RAISE (ABORT, 'a calibration never goes');
END;

-- Every error of every run in a row of its own, in the order in which a trend reads them.
CREATE TABLE calibration_errors (
    machine_id           TEXT    NOT NULL,
    axis                 TEXT    NOT NULL CHECK (axis IN ('A', 'B', 'C')),
    error                TEXT    NOT NULL CHECK (length(error) BETWEEN 1 AND 16),
    measured_at          TEXT    NOT NULL CHECK (length(measured_at) = 24),
    calibration_seq      INTEGER NOT NULL REFERENCES calibrations (seq),
    calibration_id       TEXT    NOT NULL,
    machine_revision     INTEGER NOT NULL,
    value                REAL    NOT NULL,
    standard_uncertainty REAL,
    identifiable         INTEGER NOT NULL CHECK (identifiable IN (0, 1)),
    PRIMARY KEY (machine_id, axis, error, measured_at, calibration_seq)
) STRICT, WITHOUT ROWID;

CREATE TRIGGER calibration_errors_never_change BEFORE UPDATE ON calibration_errors
BEGIN
    SELECT RAISE (ABORT, 'a calibration never changes');
END;

CREATE TRIGGER calibration_errors_never_go BEFORE DELETE ON calibration_errors
BEGIN
    SELECT RAISE (ABORT, 'a calibration never goes');
END;

-- The calibration whose errors a revision carries.
ALTER TABLE machine_revisions ADD COLUMN calibration_id TEXT REFERENCES calibrations (id);

-- A key may now stand for a job, for a calibration, or for the revision that a calibration became.
CREATE TABLE idempotency_keys_new (
    idempotency_key  TEXT    NOT NULL PRIMARY KEY CHECK (length(idempotency_key) BETWEEN 1 AND 255),
    fingerprint      TEXT    NOT NULL CHECK (length(fingerprint) = 64),
    job_id           TEXT    REFERENCES jobs (id),
    calibration_id   TEXT    REFERENCES calibrations (id),
    machine_id       TEXT,
    machine_revision INTEGER,
    created_at       TEXT    NOT NULL CHECK (length(created_at) = 24),
    CHECK ((job_id IS NOT NULL) + (calibration_id IS NOT NULL) + (machine_revision IS NOT NULL) = 1),
    CHECK ((machine_id IS NULL) = (machine_revision IS NULL)),
    FOREIGN KEY (machine_id, machine_revision) REFERENCES machine_revisions (machine_id, revision)
) STRICT, WITHOUT ROWID;

INSERT INTO idempotency_keys_new (idempotency_key, fingerprint, job_id, created_at)
    SELECT idempotency_key, fingerprint, job_id, created_at FROM idempotency_keys;

DROP TABLE idempotency_keys;
ALTER TABLE idempotency_keys_new RENAME TO idempotency_keys;

CREATE INDEX idempotency_keys_by_age ON idempotency_keys (created_at);
