-- The same rule in words that the server prints alike before and after a dump is restored. It prints a comparison of rows
-- with other brackets then, and the doctor would take it for another rule.
DROP TRIGGER audit_never_changes ON audit;
CREATE TRIGGER audit_never_changes BEFORE UPDATE ON audit
    FOR EACH ROW WHEN (OLD.sha256 IS NOT NULL OR NEW.sha256 IS NULL
        OR NEW.seq IS DISTINCT FROM OLD.seq OR NEW.at IS DISTINCT FROM OLD.at
        OR NEW.origin IS DISTINCT FROM OLD.origin OR NEW.key_id IS DISTINCT FROM OLD.key_id
        OR NEW.action IS DISTINCT FROM OLD.action OR NEW.method IS DISTINCT FROM OLD.method
        OR NEW.route IS DISTINCT FROM OLD.route OR NEW.request_id IS DISTINCT FROM OLD.request_id
        OR NEW.machine_id IS DISTINCT FROM OLD.machine_id OR NEW.resource IS DISTINCT FROM OLD.resource
        OR NEW.revision_before IS DISTINCT FROM OLD.revision_before
        OR NEW.revision_after IS DISTINCT FROM OLD.revision_after)
    EXECUTE FUNCTION refuse_change('the audit log never changes');
