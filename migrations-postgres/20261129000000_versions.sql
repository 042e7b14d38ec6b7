-- Services of two versions on one database, while a plant is updated.

-- The newest schema that a service knows. Those that do not say it were made before this.
ALTER TABLE instances ADD COLUMN knows BIGINT NOT NULL DEFAULT 20261128000000;

-- The oldest schema that a service must know to use this database. A migration that only adds leaves it as it is.
ALTER TABLE service ADD COLUMN usable_from BIGINT NOT NULL DEFAULT 20261128000000;

-- For a migration that removes or changes what earlier versions use: from now on a service must know this schema. It is
-- refused while a service lives that does not.
CREATE FUNCTION only_usable_from(oldest BIGINT) RETURNS void LANGUAGE plpgsql AS $$
DECLARE
    living TEXT;
BEGIN
    SELECT string_agg(format('trunnion %s on %s (process %s)', version, host, process), ', ' ORDER BY began_at) INTO living
    FROM instances
    WHERE knows < oldest AND stopped_at IS NULL AND seen_at > clock_timestamp() - INTERVAL '30 s';
    IF living IS NOT NULL THEN
        RAISE EXCEPTION USING ERRCODE = '55006',
            MESSAGE = 'these services cannot use the new schema, stop them first: ' || living;
    END IF;
    UPDATE service SET usable_from = greatest(usable_from, oldest);
END
$$;
