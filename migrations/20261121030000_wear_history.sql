-- Wear histories: what was measured of a cutter's edges, and what was withdrawn of it. An entry never changes and never
-- goes; a wrong one gets a withdrawal, which never changes and never goes either.

CREATE TABLE wear_entries (
    seq                     INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    id                      TEXT    NOT NULL UNIQUE CHECK (length(id) = 36),
    machine_id              TEXT    NOT NULL REFERENCES machines (machine_id),
    tool_id                 TEXT    NOT NULL CHECK (length(tool_id) BETWEEN 1 AND 100),
    cutter_id               TEXT    NOT NULL CHECK (length(cutter_id) BETWEEN 1 AND 100),
    -- Empty where the cutter was measured as a whole.
    edge                    TEXT    NOT NULL CHECK (length(edge) <= 100),
    quantity                TEXT    NOT NULL CHECK (quantity IN ('radius', 'flank')),
    parts_cut               INTEGER NOT NULL CHECK (parts_cut BETWEEN 0 AND 1000000000),
    wear_um                 REAL    NOT NULL CHECK (wear_um BETWEEN 0 AND 10000),
    standard_uncertainty_um REAL    CHECK (standard_uncertainty_um IS NULL OR standard_uncertainty_um > 0),
    measured_at             TEXT    NOT NULL CHECK (length(measured_at) = 24),
    created_at              TEXT    NOT NULL CHECK (length(created_at) = 24),
    note                    TEXT    CHECK (note IS NULL OR length(note) BETWEEN 1 AND 2000),
    -- The first entry of the request that brought this one.
    posted_with             TEXT    NOT NULL CHECK (length(posted_with) = 36)
) STRICT;

CREATE INDEX wear_entries_of_tool ON wear_entries (machine_id, tool_id, seq);
CREATE INDEX wear_entries_of_cutter ON wear_entries (machine_id, tool_id, cutter_id, edge, parts_cut, measured_at);
CREATE INDEX wear_entries_posted_with ON wear_entries (posted_with, seq);

CREATE TRIGGER wear_entries_never_change BEFORE UPDATE ON wear_entries
BEGIN
    SELECT RAISE (ABORT, 'a wear entry never changes');
END;

CREATE TRIGGER wear_entries_never_go BEFORE DELETE ON wear_entries
BEGIN
    SELECT RAISE (ABORT, 'a wear entry never goes');
END;

CREATE TABLE wear_withdrawals (
    entry_seq    INTEGER PRIMARY KEY NOT NULL REFERENCES wear_entries (seq),
    withdrawn_at TEXT    NOT NULL CHECK (length(withdrawn_at) = 24),
    reason       TEXT    NOT NULL CHECK (length(reason) BETWEEN 1 AND 2000)
) STRICT;

CREATE TRIGGER wear_withdrawals_never_change BEFORE UPDATE ON wear_withdrawals
BEGIN
    SELECT RAISE (ABORT, 'a withdrawal never changes');
END;

CREATE TRIGGER wear_withdrawals_never_go BEFORE DELETE ON wear_withdrawals
BEGIN
    SELECT RAISE (ABORT, 'a withdrawal never goes');
END;

-- A key may now also stand for the entries of one request, named by the first of them.
CREATE TABLE idempotency_keys_new (
    idempotency_key  TEXT    NOT NULL PRIMARY KEY CHECK (length(idempotency_key) BETWEEN 1 AND 255),
    fingerprint      TEXT    NOT NULL CHECK (length(fingerprint) = 64),
    job_id           TEXT    REFERENCES jobs (id),
    calibration_id   TEXT    REFERENCES calibrations (id),
    machine_id       TEXT,
    machine_revision INTEGER,
    wear_entry_id    TEXT    REFERENCES wear_entries (id),
    created_at       TEXT    NOT NULL CHECK (length(created_at) = 24),
    CHECK ((job_id IS NOT NULL) + (calibration_id IS NOT NULL) + (machine_revision IS NOT NULL)
        + (wear_entry_id IS NOT NULL) = 1),
    CHECK ((machine_id IS NULL) = (machine_revision IS NULL)),
    FOREIGN KEY (machine_id, machine_revision) REFERENCES machine_revisions (machine_id, revision)
) STRICT, WITHOUT ROWID;

INSERT INTO idempotency_keys_new
    (idempotency_key, fingerprint, job_id, calibration_id, machine_id, machine_revision, created_at)
    SELECT idempotency_key, fingerprint, job_id, calibration_id, machine_id, machine_revision, created_at
    FROM idempotency_keys;

DROP TABLE idempotency_keys;
ALTER TABLE idempotency_keys_new RENAME TO idempotency_keys;

CREATE INDEX idempotency_keys_by_age ON idempotency_keys (created_at);
