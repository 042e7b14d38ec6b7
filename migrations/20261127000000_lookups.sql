-- Lookups that must stay quick in a large database: jobs by the digests of their programs, the newest measurement of a machine, audit
-- entries by time, and the applications of a calibration run.

CREATE INDEX jobs_by_input ON jobs (input_sha256, seq);
CREATE INDEX jobs_by_written ON jobs (output_sha256, seq) WHERE output_sha256 IS NOT NULL;

CREATE INDEX calibrations_by_measurement ON calibrations (machine_id, measured_at);

CREATE INDEX audit_by_time ON audit (at, seq);
CREATE INDEX audit_of_applications ON audit (machine_id, revision_after) WHERE action = 'calibration-applied';
