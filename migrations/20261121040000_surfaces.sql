-- The part's surface that came with a job's program, as a file named by its digest.
ALTER TABLE jobs ADD COLUMN surface_sha256 TEXT CHECK (surface_sha256 IS NULL OR length(surface_sha256) = 64);
