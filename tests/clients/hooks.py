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
