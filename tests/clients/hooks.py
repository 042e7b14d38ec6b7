"""What schemathesis sends, mended where it is not what it made."""

import schemathesis

TAGS = ("If-Match", "If-None-Match")


@schemathesis.hook
def before_call(context, case, kwargs):
    """Entity tags have quotes, which schemathesis (4.32) takes off texts before it sends them in a header."""
    if case.headers and case.meta and case.meta.generation.mode.is_positive:
        for name in TAGS:
            value = case.headers.get(name)
            if isinstance(value, str) and value != "*" and '"' not in value:
                case.headers[name] = f'"{value}"'


def has_null(value):
    if isinstance(value, dict):
        return any(has_null(member) for member in value.values())
    if isinstance(value, list):
        return any(has_null(item) for item in value)
    return value is None


@schemathesis.hook
def filter_case(context, case):
    """A null in a request is a member that was left out: some clients write it so. The description does not offer it."""
    negative = case.meta is not None and case.meta.generation.mode.is_negative
    return not (negative and has_null(case.body))


# What a deleted machine or tool was stays readable, and so do the calibrations of a machine: jobs, reports and calibrations name
# revisions, and wear entries need no tool in the table. DELETE cancels a job and revokes a key; both stay listed, because records
# name them.
STAYS = {
    "list_calibrations",
    "get_calibration",
    "get_calibration_run",
    "get_calibration_trend",
    "compare_calibrations",
    "export_calibration",
    "get_machine_revision",
    "list_machine_revisions",
    "get_tool_revision",
    "list_tool_revisions",
    "create_wear_entries",
    "list_wear_entries",
    "get_wear_entry",
    "get_wear_trend",
    "withdraw_wear_entry",
    "get_job",
    "get_job_events",
    "cancel_job",
    "get_api_key",
    "revoke_api_key",
}


@schemathesis.check
def gone_after_delete(ctx, response, case):
    """use_after_free for every operation but those: exceptions of single operations do not reach the stateful phase."""
    # Not at the top: hooks are loaded while schemathesis itself is.
    from schemathesis.specs.openapi.checks import use_after_free

    if case.operation.definition.raw.get("operationId") in STAYS:
        return None
    return use_after_free(ctx, response, case)
