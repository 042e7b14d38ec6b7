-- The tool table of a machine: tools with their immutable revisions. Wear entries name a tool by the same tool_id, whether it stands
-- in the table or not.

-- One row for each tool_id ever used on a machine. A deleted tool keeps its row and its revisions: reports name them, and a tool put
-- again under the same tool_id goes on counting.
CREATE TABLE tools (
    seq           INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
    machine_id    TEXT    NOT NULL REFERENCES machines (machine_id),
    tool_id       TEXT    NOT NULL CHECK (length(tool_id) BETWEEN 1 AND 100),
    last_revision INTEGER NOT NULL CHECK (last_revision >= 1),
    -- What programs call the tool by, of the last revision; the name as it is compared.
    number        INTEGER CHECK (number IS NULL OR number BETWEEN 0 AND 4294967295),
    name_key      TEXT    CHECK (name_key IS NULL OR length(name_key) BETWEEN 1 AND 64),
    deleted       INTEGER NOT NULL DEFAULT 0 CHECK (deleted IN (0, 1)),
    UNIQUE (machine_id, tool_id),
    CHECK (number IS NOT NULL OR name_key IS NOT NULL)
) STRICT;

-- A program's call means one tool.
CREATE UNIQUE INDEX tools_by_number ON tools (machine_id, number) WHERE deleted = 0 AND number IS NOT NULL;
CREATE UNIQUE INDEX tools_by_name ON tools (machine_id, name_key) WHERE deleted = 0 AND name_key IS NOT NULL;
CREATE INDEX tools_of_machine ON tools (machine_id, seq) WHERE deleted = 0;

CREATE TABLE tool_revisions (
    machine_id TEXT    NOT NULL,
    tool_id    TEXT    NOT NULL,
    revision   INTEGER NOT NULL CHECK (revision >= 1),
    document   TEXT    NOT NULL CHECK (json_valid(document)),
    sha256     TEXT    NOT NULL CHECK (length(sha256) = 64),
    created_at TEXT    NOT NULL CHECK (length(created_at) = 24),
    PRIMARY KEY (machine_id, tool_id, revision),
    FOREIGN KEY (machine_id, tool_id) REFERENCES tools (machine_id, tool_id)
) STRICT, WITHOUT ROWID;

CREATE TRIGGER tool_revisions_never_change BEFORE UPDATE ON tool_revisions
BEGIN
    SELECT RAISE (ABORT, 'a tool revision never changes');
END;

CREATE TRIGGER tool_revisions_never_go BEFORE DELETE ON tool_revisions
BEGIN
    SELECT RAISE (ABORT, 'a tool revision never goes');
END;
