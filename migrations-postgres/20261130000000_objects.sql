-- Programs and results as objects in a bucket of S3. Their rows in `files` are those of files in parts, without the parts.

-- The place of the files may be a bucket with a prefix.
ALTER TABLE service DROP CONSTRAINT service_files_check;
ALTER TABLE service ADD CONSTRAINT service_files_check
    CHECK (files IN ('', 'directory', 'postgres') OR files LIKE 's3://_%');

-- The upload in parts that makes an object, until its row is whole: who removes the row ends the upload.
ALTER TABLE files ADD COLUMN upload_id TEXT COLLATE "C";

-- A job names only files that are there, and holds them until it is stored. Who meets this begins again.
CREATE OR REPLACE FUNCTION hold_files() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
    named TEXT;
BEGIN
    IF NOT EXISTS (SELECT 1 FROM service WHERE files NOT IN ('', 'directory')) THEN
        RETURN NULL;
    END IF;
    FOREACH named IN ARRAY array_remove(
        ARRAY[NEW.input_sha256, NEW.surface_sha256, NEW.output_sha256, NEW.changes_sha256], NULL)
    LOOP
        PERFORM 1 FROM files WHERE sha256 = named AND whole = 1 FOR KEY SHARE;
        IF NOT FOUND THEN
            RAISE EXCEPTION USING ERRCODE = '40001', MESSAGE = 'a job names a file that is not kept: ' || named;
        END IF;
    END LOOP;
    RETURN NULL;
END
$$;
