"""Posts mutated programs, tables and documents to a running service: never a 500, never a closed connection.

    python3 .ci/fuzz.py http://127.0.0.1:8917 COUNT SEED

Same seed, same requests. Every compensated program that comes back is posted again with the same parameters: what the
service writes, it reads, and it finds nothing over tolerance.
"""
import http.client
import json
import pathlib
import random
import sys
import urllib.parse

base, count, seed = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
random.seed(seed)
server = urllib.parse.urlparse(base)
root = pathlib.Path(__file__).resolve().parent.parent
document = json.loads((root / "openapi" / "trunnion.json").read_text())
machine = "/v1/machines/example-ac-table"

WORDS = [b"G0", b"G1", b"G2", b"G90", b"G91", b"G93", b"G94", b"G95", b"G20", b"G21", b"G43.4 H1", b"G49", b"G68.2", b"G41", b"G54",
         b"G10", b"G92", b"M30", b"M98 P1", b"M99", b"%", b"(", b")", b";", b"/", b"N1", b"#1=2", b"[1+", b"X", b"X-", b"X.", b"X1e9",
         b"X--1", b"X0.00000000000001", b"A999999", b"A-120.001", b"C1e308", b"F0", b"F-1", b"F1e-9", b"U1 V2 W3", b"I1", b"\xff\xfe", b"\0",
         b"\r", b"\n\n", b"\n", b"999999999999999999999999", b"-0", b"Y.5.5", b"E1", b"B1", b"O100", b"O<x> call", b"T1 M6"]
NUMBERS = ["0", "-0.0", "1e308", "1e999", "-1", "1e-320", "NaN", "null", "\"1\"", "[]", "{}", "0.1", "123456789012345678901234567890", "true"]


def mutate_bytes(text):
    lines = text.split(b"\n")
    for _ in range(random.randint(1, 6)):
        kind = random.randrange(6)
        at = random.randrange(len(lines))
        if kind == 0:
            del lines[at]
        elif kind == 1:
            lines.insert(at, random.choice(WORDS))
        elif kind == 2:
            lines[at] += b" " + random.choice(WORDS)
        elif kind == 3:
            lines[at], lines[-1 - at] = lines[-1 - at], lines[at]
        elif kind == 4 and lines[at]:
            cut = random.randrange(len(lines[at]))
            lines[at] = lines[at][:cut] + bytes([random.randrange(256)]) + lines[at][cut + 1:]
        elif kind == 5:
            lines.insert(at, lines[at])
        lines = lines or [b""]
    return b"\n".join(lines)


def mutate_json(text):
    out = list(text)
    numbers = [k for k, c in enumerate(out) if c.isdigit() and (k == 0 or not (out[k - 1].isalnum() or out[k - 1] in "._-\""))]
    for _ in range(random.randint(1, 3)):
        kind = random.randrange(4)
        at = random.randrange(len(out))
        if kind == 0 and numbers:
            start = random.choice(numbers)
            end = start
            while end < len(out) and (out[end].isalnum() or out[end] in "+-."):
                end += 1
            out[start:end] = [random.choice(NUMBERS)] + [""] * (end - start - 1)
        elif kind == 1:
            out[at] = random.choice("{}[],:\"0aX-\\\u00e9")
        elif kind == 2:
            del out[at]
        else:
            out.insert(at, random.choice(NUMBERS))
    return "".join(out).encode()


def ask(method, path, body, kind):
    connection = http.client.HTTPConnection(server.hostname, server.port, timeout=120)
    try:
        connection.request(method, path, body, {"Content-Type": kind, "Accept": "*/*", "If-Match": "*"})
        answer = connection.getresponse()
        return answer.status, answer.read()
    finally:
        connection.close()


examples = []
for path, item in document["paths"].items():
    for method, operation in item.items():
        for kind, media in operation.get("requestBody", {}).get("content", {}).items():
            if kind == "application/json":
                examples.append((method.upper(), path.replace("{machine_id}", "fuzzed"), json.dumps(media["example"]), kind))
            elif kind == "text/csv":
                examples.append((method.upper(), path.replace("{machine_id}", "example-ac-table"), media["example"], kind))
blade = (root / "docs" / "examples" / "blade.nc").read_bytes()
ask("PUT", "/v1/machines/fuzzed", next(body for method, path, body, _ in examples if method == "PUT"), "application/json")
statuses, again = {}, 0
for n in range(count):
    if n % 3 == 0:
        operation = random.choice([
            "cc-compensation?tool_radius_mm=5&work_offset_mm=12,-7,35",
            "cc-compensation?tool_radius_mm=5&corner_radius_mm=1&contact=feed-plane&interpolation=tcp",
            "cc-compensation?contact=tip&output=interpolated&correction=seed",
            "servo-simulation?plane=xy",
        ])
        request = ("POST", f"{machine}/{operation}", mutate_bytes(blade), "text/plain")
    else:
        method, path, body, kind = random.choice(examples)
        body = mutate_bytes(body.encode()) if kind == "text/csv" else mutate_json(body)
        request = (method, path, body, kind)
    status, answer = ask(*request)
    statuses[status] = statuses.get(status, 0) + 1
    if status >= 500:
        sys.exit(f"request {n} of seed {seed} answers {status}: {request!r}\n{answer[:500]!r}")
    if status >= 400 and not answer.startswith(b'{"type":"/problems/'):
        sys.exit(f"request {n} of seed {seed} answers {status} without a problem document: {answer[:200]!r}")
    if status == 200 and "tool_radius_mm=5&work" in request[1]:
        again += 1
        status, report = ask("POST", request[1] + "&tolerance_um=10.001", answer, "text/plain")
        if status != 200:
            sys.exit(f"request {n} of seed {seed}: what was written is not taken back: {status} {report[:300]!r}\n{request!r}")
        if report != answer:
            sys.exit(f"request {n} of seed {seed}: what was written is over tolerance when it is read again\n{request!r}")
status, _ = ask("GET", "/readyz", None, "text/plain")
if status != 200:
    sys.exit("the service is no longer ready")
print(f"{count} requests: {dict(sorted(statuses.items()))}; {again} written programs taken back unchanged")
