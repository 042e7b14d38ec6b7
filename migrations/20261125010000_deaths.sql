-- What a job has met of deaths of the process, and who asked for it.

-- Deaths of the process while the job was computed beside others: nobody knows whose fault they were.
ALTER TABLE jobs ADD COLUMN deaths INTEGER NOT NULL DEFAULT 0 CHECK (deaths >= 0);
-- Deaths while it was computed and nothing else was.
ALTER TABLE jobs ADD COLUMN lone_deaths INTEGER NOT NULL DEFAULT 0 CHECK (lone_deaths >= 0);
-- Who asked: a key or an address, for turns and shares in the queue. Forgotten with the job's end.
ALTER TABLE jobs ADD COLUMN caller TEXT CHECK (caller IS NULL OR length(caller) BETWEEN 1 AND 128);

CREATE TRIGGER jobs_forget_caller AFTER UPDATE OF state ON jobs
WHEN NEW.state IN ('succeeded', 'failed', 'cancelled') AND NEW.caller IS NOT NULL
BEGIN
    UPDATE jobs SET caller = NULL WHERE id = NEW.id;
END;

-- When a caller's last job was taken from the queue: the one served longest ago is next.
CREATE TABLE caller_turns (
    caller TEXT    NOT NULL PRIMARY KEY,
    turn   INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
