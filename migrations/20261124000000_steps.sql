-- What a compensation did to a program, so that nothing is done to it twice; and what a job was accepted with beside its parameters.

-- The steps that changed the program, separated by commas; empty where none did, NULL where the operation has no steps.
ALTER TABLE jobs ADD COLUMN steps TEXT CHECK (steps IS NULL OR (length(steps) <= 200 AND state = 'succeeded'));
-- Motions of a compensated program that were looked at.
ALTER TABLE jobs ADD COLUMN motions_checked INTEGER CHECK (motions_checked IS NULL OR motions_checked >= 0);
-- Tools of the machine's table with their revisions, and wear, as they were when the job was accepted.
ALTER TABLE jobs ADD COLUMN accepted TEXT CHECK (accepted IS NULL OR json_valid(accepted));

-- Of jobs from before: the steps that were asked for, where the answer is not the upload.
UPDATE jobs SET steps =
    CASE
        WHEN output_sha256 = input_sha256 THEN ''
        WHEN operation = 'wear-compensation' THEN 'wear'
        WHEN operation = 'cc-compensation' THEN
            CASE WHEN coalesce(json_extract(parameters, '$.singularity'), 'report') = 'report'
                THEN 'cc' ELSE 'cc,singularity' END
        ELSE trim(
            CASE WHEN json_type(parameters, '$.wear') = 'object' THEN 'wear,' ELSE '' END
            || CASE WHEN json_extract(parameters, '$.location_errors') THEN 'location_errors,' ELSE '' END
            || CASE WHEN json_type(parameters, '$.cc') = 'object' THEN 'cc,' ELSE '' END
            || CASE WHEN coalesce(json_extract(parameters, '$.singularity'), 'report') = 'report'
                THEN '' ELSE 'singularity' END, ',')
    END,
    motions_checked =
    CASE operation
        WHEN 'cc-compensation' THEN json_extract(report, '$.motions_checked')
        WHEN 'wear-compensation' THEN json_extract(report, '$.contacts_kept')
        ELSE max(coalesce(json_extract(report, '$.cc.motions_checked'), 0),
            coalesce(json_extract(report, '$.wear.contacts_kept'), 0),
            coalesce(json_extract(report, '$.location_errors.motions_posted'), 0))
    END
WHERE state = 'succeeded' AND output_sha256 IS NOT NULL
    AND operation IN ('cc-compensation', 'wear-compensation', 'compensation');

CREATE INDEX jobs_by_output ON jobs (output_sha256) WHERE steps <> '';
