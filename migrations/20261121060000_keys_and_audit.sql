-- API keys: what each may do, and the digest of its secret, which is itself stored nowhere. A key is revoked, never
-- deleted: the audit log names it.
CREATE TABLE api_keys (
    seq             INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    id              TEXT    NOT NULL UNIQUE CHECK (length(id) BETWEEN 8 AND 32),
    secret_sha256   TEXT    NOT NULL CHECK (length(secret_sha256) = 64),
    name            TEXT    NOT NULL CHECK (length(name) BETWEEN 1 AND 200),
    -- Arrays of words; machines is null where the key reaches all.
    scopes          TEXT    NOT NULL CHECK (json_valid(scopes)),
    machines        TEXT    CHECK (machines IS NULL OR json_valid(machines)),
    created_at      TEXT    NOT NULL CHECK (length(created_at) = 24),
    expires_at      TEXT    CHECK (expires_at IS NULL OR length(expires_at) = 24),
    revoked_at      TEXT    CHECK (revoked_at IS NULL OR length(revoked_at) = 24),
    last_used_at    TEXT    CHECK (last_used_at IS NULL OR length(last_used_at) = 24),
    -- The idempotency key it was made under, as long as that is remembered, and the digest of the request.
    idempotency_key TEXT    UNIQUE CHECK (idempotency_key IS NULL OR length(idempotency_key) BETWEEN 1 AND 255),
    fingerprint     TEXT    CHECK (fingerprint IS NULL OR length(fingerprint) = 64),
    CHECK (idempotency_key IS NULL OR fingerprint IS NOT NULL)
) STRICT;

CREATE TRIGGER api_keys_never_go BEFORE DELETE ON api_keys
BEGIN
    SELECT RAISE (ABORT, 'an API key never goes; it is revoked');
END;

CREATE TRIGGER api_keys_stay_revoked BEFORE UPDATE OF revoked_at ON api_keys WHEN OLD.revoked_at IS NOT NULL
BEGIN
    SELECT RAISE (ABORT, 'a revoked key stays revoked');
END;

CREATE TRIGGER api_keys_allow_what_they_allowed
BEFORE UPDATE OF id, secret_sha256, name, scopes, machines, created_at, expires_at ON api_keys
BEGIN
    SELECT RAISE (ABORT, 'what a key allows never changes');
END;

-- Every change of what is stored: who made it, when, by which request, from which revision to which.
CREATE TABLE audit (
    seq             INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    at              TEXT    NOT NULL CHECK (length(at) = 24),
    -- By a request, by the command line, or by the service itself.
    origin          TEXT    NOT NULL CHECK (origin IN ('http', 'command-line', 'service')),
    -- Null where the service was open, and off HTTP.
    key_id          TEXT,
    action          TEXT    NOT NULL CHECK (length(action) BETWEEN 1 AND 64),
    method          TEXT,
    route           TEXT,
    request_id      TEXT,
    machine_id      TEXT,
    -- The address of what was changed.
    resource        TEXT    NOT NULL CHECK (length(resource) BETWEEN 1 AND 2000),
    revision_before INTEGER,
    revision_after  INTEGER
) STRICT;

CREATE INDEX audit_of_machine ON audit (machine_id, seq) WHERE machine_id IS NOT NULL;

CREATE TRIGGER audit_never_changes BEFORE UPDATE ON audit
BEGIN
    SELECT RAISE (ABORT, 'the audit log never changes');
END;

CREATE TRIGGER audit_never_goes BEFORE DELETE ON audit
BEGIN
    SELECT RAISE (ABORT, 'the audit log never goes');
END;
