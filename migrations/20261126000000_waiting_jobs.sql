-- All that the queue asks of a waiting job, so that a thousand of them are counted and ordered without opening their documents.

DROP INDEX jobs_queued;
CREATE INDEX jobs_queued ON jobs (machine_id, seq, caller, deaths, lone_deaths, id) WHERE state = 'queued';
