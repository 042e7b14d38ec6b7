-- The table of what each step of a compensation did to every motion, as a file named by its digest.
ALTER TABLE jobs ADD COLUMN changes_sha256 TEXT CHECK (changes_sha256 IS NULL OR length(changes_sha256) = 64);
