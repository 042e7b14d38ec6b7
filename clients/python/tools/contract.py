"""Writes src/trunnion/contract.py from the service's description: contract.py [--check] [OUT]

Only what the package uses is generated, and each root type is found by its operation, not by the name of a schema.
So a schema may be renamed or moved without a change of this package's names.
"""

from __future__ import annotations

import copy
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
DESCRIPTION = HERE.parents[2] / "openapi" / "trunnion.json"
TARGET = HERE.parent / "src" / "trunnion" / "contract.py"

# The public name, the operation, and where in the operation: the status of an answer, or the media type of a request.
# What follows are members on the way: "items" is the type of an array's items.
ROOTS: dict[str, tuple[str, ...]] = {
    "MachineProfile": ("put_machine", "application/json"),
    "MachineDocument": ("get_machine", "200"),
    "MachinePreset": ("list_machine_presets", "200", ".items", "items"),
    "DrivePreset": ("list_drive_presets", "200", ".items", "items"),
    "ToolProfile": ("put_tool", "application/json"),
    "ToolDocument": ("get_tool", "200"),
    "CcParameters": ("compensate_cc_path", "multipart/form-data", ".parameters"),
    "CcReport": ("compensate_cc_path", "200"),
    "ReportWarning": ("compensate_cc_path", "200", ".warnings", "items"),
    "Estimate": ("get_calibration", "200", ".iso_230", "additionalProperties"),
    "WearParameters": ("compensate_wear_of_program", "multipart/form-data", ".parameters"),
    "WearReport": ("compensate_wear_of_program", "200"),
    "CompensationParameters": ("compensate_program", "multipart/form-data", ".parameters"),
    "CompensationReport": ("compensate_program", "200"),
    "PostingParameters": ("post_program", "multipart/form-data", ".parameters"),
    "PostingReport": ("post_program", "200"),
    "VerificationParameters": ("verify_part", "multipart/form-data", ".parameters"),
    "VerificationReport": ("verify_part", "200"),
    "ServoProgramParameters": ("simulate_servo_program", "multipart/form-data", ".parameters"),
    "ServoReport": ("simulate_servo_program", "200"),
    "InterpretationParameters": ("interpret_program", "multipart/form-data", ".parameters"),
    "Interpretation": ("interpret_program", "200"),
    "InverseAnswer": ("solve_inverse_kinematics", "200"),
    "PoseWarning": ("solve_inverse_kinematics", "200", ".warnings", "items"),
    "ForwardAnswer": ("solve_forward_kinematics", "200"),
    "JobDocument": ("get_job", "200"),
    "JobState": ("get_job", "200", ".state"),
    "JobOperation": ("get_job", "200", ".operation"),
    "ProblemDocument": ("get_job", "404"),
    "CalibrationRun": ("create_calibration", "application/json"),
    "CalibrationDocument": ("get_calibration", "200"),
    "CalibrationDifference": ("compare_calibrations", "200"),
    "TrendDocument": ("get_calibration_trend", "200"),
    "SimulationRequest": ("simulate_servo", "application/json"),
    "ServoAnswer": ("simulate_servo", "200"),
    "SweepRequest": ("sweep_servo", "application/json"),
    "SweepAnswer": ("sweep_servo", "200"),
    "MatchingRequest": ("match_servo", "application/json"),
    "MatchingAnswer": ("match_servo", "200"),
    "ScallopRequest": ("compute_scallop_height", "application/json"),
    "ScallopAnswer": ("compute_scallop_height", "200"),
    "WearAdviceRequest": ("advise_wear", "application/json"),
    "WearAdvice": ("advise_wear", "200"),
    "WearEntry": ("get_wear_entry", "200"),
    "WearTrendDocument": ("get_wear_trend", "200"),
    "AuditEntry": ("list_audit_entries", "200", ".items", "items"),
    "Limit": ("list_limits", "200", ".items", "items"),
    "Version": ("get_version", "200"),
}
# One entry or several: the request's alternatives, of which the object is taken.
OBJECTS: dict[str, tuple[str, ...]] = {"WearEntryRequest": ("create_wear_entries", "application/json")}
# The query of a list: what it filters by. A filter that the service gets is a filter of the package after a renewal.
# The package goes through the pages of a list itself; axis and error of a trend are arguments of their own.
PAGES = {"limit", "cursor"}
QUERIES: dict[str, tuple[str, set[str]]] = {
    "JobFilters": ("list_jobs", PAGES),
    "AuditFilters": ("list_audit_entries", PAGES),
    "CalibrationFilters": ("list_calibrations", PAGES),
    "TrendFilters": ("get_calibration_trend", {"axis", "error"}),
}
# What says nothing about the type of a value, or would promise Python objects where JSON has text.
DROPPED = {
    "format",
    "example",
    "examples",
    "default",
    "minimum",
    "maximum",
    "exclusiveMinimum",
    "exclusiveMaximum",
    "minItems",
    "maxItems",
    "minLength",
    "maxLength",
    "pattern",
    "minProperties",
    "maxProperties",
    "uniqueItems",
}
# Types that need no name.
PLAIN = {"array", "boolean", "integer", "null", "number", "string"}
# Marks a time that a caller may give as a datetime; answers have text.
TIME = "x-time"
OPTIONS = (
    "--input-file-type=openapi",
    "--output-model-type=typing.TypedDict",
    "--target-python-version=3.10",
    "--enum-field-as-literal=all",
    "--use-union-operator",
    "--use-standard-collections",
    "--use-generic-container-types",
    "--use-schema-description",
    "--use-field-description",
    "--use-single-line-docstring",
    "--no-use-closed-typed-dict",
    "--formatters=builtin",
)
HEADER = '"""The documents of the service, generated from openapi/trunnion.json by tools/contract.py."""'
MEDIA = ("application/json", "application/problem+json")


class Contract:
    def __init__(self, description: dict[str, Any]) -> None:
        self.whole = description
        self.operations = {
            operation["operationId"]: operation
            for path in description["paths"].values()
            for operation in path.values()
            if isinstance(operation, dict) and "operationId" in operation
        }
        self.schemas: dict[str, Any] = {}
        # The name in the description, the name here.
        self.names: dict[str, str] = {}

    def resolve(self, node: Any) -> Any:
        """The node that a reference names, whatever it refers to."""
        while isinstance(node, dict) and "$ref" in node:
            target: Any = self.whole
            for step in node["$ref"].removeprefix("#/").split("/"):
                target = target[step.replace("~1", "/").replace("~0", "~")]
            node = target
        return node

    def place(self, place: tuple[str, ...]) -> Any:
        """The schema at a place, as a reference where the description has one."""
        operation, where, *steps = place
        if operation not in self.operations:
            raise SystemExit(f"the description has no operation {operation}; change ROOTS in {__file__}")
        found = self.operations[operation]
        if where.isdigit():
            content = self.resolve(found["responses"][where])["content"]
            schema = next(content[media]["schema"] for media in MEDIA if media in content)
        else:
            schema = self.resolve(found["requestBody"])["content"][where]["schema"]
        for step in steps:
            schema = unwrapped(self.resolve(schema))
            schema = self.resolve(schema)
            schema = self.member(schema, step[1:]) if step.startswith(".") else schema[step]
        return unwrapped(schema)

    def member(self, schema: Any, name: str) -> Any:
        """A member of an object or of one of its parts."""
        if name in schema.get("properties", {}):
            return schema["properties"][name]
        parts = [self.resolve(part) for part in schema.get("allOf", [])]
        return next(self.member(part, name) for part in parts if name in self.members(part))

    def members(self, schema: Any) -> set[str]:
        parts = [self.resolve(part) for part in schema.get("allOf", [])]
        return {*schema.get("properties", {})}.union(*map(self.members, parts))

    def add(self, public: str, schema: Any) -> None:
        if "$ref" in schema:
            self.names[schema["$ref"].rsplit("/", 1)[-1]] = public
        else:
            self.schemas[public] = schema

    def filters(self, operation: str, others: set[str]) -> Any:
        """The query of an operation, as an object. A time may be given as a time."""
        properties: dict[str, Any] = {}
        for parameter in map(self.resolve, self.operations[operation]["parameters"]):
            if parameter["in"] != "query" or parameter["name"] in others:
                continue
            schema = dict(parameter["schema"])
            described = parameter.get("description", "")
            if "RFC 3339" in described or self.resolve(schema).get("format") == "date-time":
                schema = {"oneOf": [{"type": "string"}, {TIME: True}]}
            properties[parameter["name"]] = {**schema, "description": described}
        return {"type": "object", "properties": properties, "description": f"The query of `{operation}`."}

    def trimmed(self) -> dict[str, Any]:
        for public, place in ROOTS.items():
            self.add(public, self.place(place))
        for public, place in OBJECTS.items():
            choices = self.resolve(self.place(place))
            choices = choices.get("oneOf") or choices.get("anyOf") or [choices]
            self.add(public, next(c for c in choices if self.resolve(c).get("type") == "object"))
        for public, query in QUERIES.items():
            self.add(public, self.filters(*query))
        done: dict[str, Any] = {}
        waiting = [*self.names]
        inline = list(self.schemas.items())
        for public, schema in inline:
            done[public] = self.cleaned(schema, waiting)
        seen = set()
        while waiting:
            name = waiting.pop()
            if name in seen:
                continue
            seen.add(name)
            public = self.name(name)
            done[public] = self.cleaned(self.whole["components"]["schemas"][name], waiting)
        return {
            "openapi": "3.1.0",
            "info": {"title": "trunnion", "version": "1"},
            "paths": {},
            "components": {"schemas": dict(sorted(done.items()))},
        }

    def name(self, name: str) -> str:
        if name in self.names:
            return self.names[name]
        return f"{name}_" if name in self.names.values() or name in self.schemas else name

    def cleaned(self, node: Any, waiting: list[str], inside_properties: bool = False) -> Any:
        if isinstance(node, list):
            return [self.cleaned(item, waiting) for item in node]
        if not isinstance(node, dict):
            return node
        if "$ref" in node and isinstance(node["$ref"], str):
            name = node["$ref"].rsplit("/", 1)[-1]
            if is_plain(self.whole["components"]["schemas"][name]):
                return self.cleaned(self.whole["components"]["schemas"][name], waiting)
            waiting.append(name)
            kept = {key: node[key] for key in ("description",) if key in node}
            return {"$ref": f"#/components/schemas/{self.name(name)}", **kept}
        if TIME in node:
            return {"type": "string", "customTypePath": "datetime.datetime"}
        kept = {}
        for key, value in node.items():
            # A property may be called "default" or "format".
            if not inside_properties and (key in DROPPED or key == "discriminator"):
                continue
            if inside_properties and "$ref" in value:
                # A member that says no more than its type: a reader of the package sees the words at both.
                words = self.resolve(value).get("description")
                value = {**({"description": words} if words else {}), **value}
            kept[key] = self.cleaned(value, waiting, key == "properties" and not inside_properties)
        return kept


def is_plain(schema: Any) -> bool:
    """A described number, text or list that several members refer to: it is written out, and makes no type."""
    named = schema.get("type", "object")
    kinds = {named} if isinstance(named, str) else set(named)
    return "description" in schema and "enum" not in schema and kinds <= PLAIN


def unwrapped(schema: Any) -> Any:
    """The one alternative that is not null."""
    for key in ("oneOf", "anyOf", "allOf"):
        choices = [choice for choice in schema.get(key, []) if choice.get("type") != "null"]
        if len(choices) == 1:
            return choices[0]
    return schema


def generated() -> str:
    tools = Path(sys.executable).parent
    contract = Contract(copy.deepcopy(json.loads(DESCRIPTION.read_text("utf-8")))).trimmed()
    with tempfile.TemporaryDirectory() as folder:
        source, made = Path(folder, "trunnion.json"), Path(folder, "contract.py")
        source.write_text(json.dumps(contract), "utf-8")
        subprocess.run(
            [
                str(tools / "datamodel-codegen"),
                f"--input={source}",
                f"--output={made}",
                *OPTIONS,
                f"--custom-file-header={HEADER}",
            ],
            check=True,
        )
        text = made.read_text("utf-8")
    command = [str(tools / "ruff"), "format", "--stdin-filename", str(TARGET), "-"]
    done = subprocess.run(command, input=text, stdout=subprocess.PIPE, text=True, check=True, cwd=HERE.parent)
    formatted: str = done.stdout
    return formatted


def main() -> None:
    text = generated()
    if sys.argv[1:] == ["--check"]:
        if TARGET.read_text("utf-8") != text:
            raise SystemExit(
                "src/trunnion/contract.py is not what openapi/trunnion.json says: "
                "run clients/python/check --renew and commit the file"
            )
        return
    TARGET.write_text(text, "utf-8")


if __name__ == "__main__":
    main()
