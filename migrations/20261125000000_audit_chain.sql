-- The audit log becomes a chain: every entry has the digest of its content and of the entry before it (store::audit_chain says in which
-- form). Entries of before get theirs at the first start, in one transaction: SQL has no SHA-256.
ALTER TABLE audit ADD COLUMN sha256 TEXT CHECK (sha256 IS NULL OR length(sha256) = 64);

-- An entry without a digest may be given one, once; nothing else about it changes.
DROP TRIGGER audit_never_changes;

CREATE TRIGGER audit_never_changes BEFORE UPDATE ON audit
WHEN OLD.sha256 IS NOT NULL OR NEW.sha256 IS NULL
    OR (NEW.seq, NEW.at, NEW.origin, NEW.key_id, NEW.action, NEW.method, NEW.route, NEW.request_id, NEW.machine_id,
        NEW.resource, NEW.revision_before, NEW.revision_after)
    IS NOT (OLD.seq, OLD.at, OLD.origin, OLD.key_id, OLD.action, OLD.method, OLD.route, OLD.request_id, OLD.machine_id,
        OLD.resource, OLD.revision_before, OLD.revision_after)
BEGIN
    SELECT RAISE (ABORT, 'the audit log never changes');
END;
