#!/usr/bin/env python3
"""Prometheus reads a service with a key, and every query of the alerts and of the dashboard works: metrics.py TRUNNION DEPLOY

The configuration is the one of compose.yaml, but for the target, the key's file and a shorter interval. Every query of the dashboard
must have an answer, except those named below; every rule must be sound; and no alert may fire on a service that is well.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request

TRUNNION, DEPLOY = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
ROOT = DEPLOY.parent
PORT = int(os.environ.get("TRUNNION_METRICS_PORT", "8943"))
SERVICE, PROMETHEUS = f"127.0.0.1:{PORT}", f"127.0.0.1:{PORT + 1}"
# A new service has measured no machine, and its first check of stored data comes after ten minutes.
WITHOUT_ANSWER = ("trunnion_calibration_age_days", "trunnion_scrub_last_timestamp_seconds")


def ask(address, path, body=None, **headers):
    with urllib.request.urlopen(urllib.request.Request(f"http://{address}{path}", body, headers), timeout=60) as answer:
        return answer.read()


def until(what, seconds, done):
    for _ in range(seconds * 10):
        try:
            if done():
                return
        except OSError:
            pass
        time.sleep(0.1)
    sys.exit(f"not within {seconds} s: {what}")


def query(expression):
    said = json.loads(ask(PROMETHEUS, "/api/v1/query?" + urllib.parse.urlencode({"query": expression})))
    return said["data"]["result"]


def work(key):
    """A little of everything that the dashboard shows."""
    authorization = {"Authorization": f"Bearer {key}"}
    program = (ROOT / "docs/examples/blade.nc").read_bytes()
    cc = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5&work_offset_mm=12,-7,35"
    ask(SERVICE, cc, program, **authorization, **{"Content-Type": "text/plain"})
    poses = b'{"poses": [{"x": 10, "y": 20, "z": 30, "i": 0.3, "j": -0.2, "k": 0.93}], "work_offset_mm": [70, -40, 95]}'
    ask(SERVICE, "/v1/machines/example-ac-table/inverse-kinematics", poses, **authorization, **{"Content-Type": "application/json"})


def look(folder, key):
    configuration = (DEPLOY / "prometheus/prometheus.yml").read_text()
    changed = configuration.replace("trunnion:8080", SERVICE).replace("/run/secrets/trunnion_read_key", str(folder / "key"))
    changed = changed.replace("interval: 15s", "interval: 1s").replace("alerts.yml", str(DEPLOY / "prometheus/alerts.yml"))
    assert changed.count(SERVICE) == changed.count(str(folder / "key")) == 1 and changed.count("interval: 1s") == 2, changed
    (folder / "prometheus.yml").write_text(changed)
    (folder / "key").write_text(key)
    words = [f"--config.file={folder}/prometheus.yml", f"--storage.tsdb.path={folder}/series", f"--web.listen-address={PROMETHEUS}"]
    with open(folder / "prometheus.log", "w") as log:
        prometheus = subprocess.Popen(["prometheus", *words], stdout=log, stderr=log)
    try:
        until("Prometheus reads the service", 30, lambda: query('up{job="trunnion"} == 1'))
        for _ in range(5):
            work(key)
            time.sleep(1)
        judge()
    finally:
        prometheus.terminate()
        prometheus.wait(timeout=30)


def judge():
    panels = json.loads((DEPLOY / "grafana/trunnion.json").read_text())["panels"]
    asked = 0
    for panel in panels:
        for target in panel.get("targets", []):
            expression = target["expr"].replace("$instance", ".*").replace("$__rate_interval", "1m")
            found = query(expression)
            asked += 1
            if any(name in expression for name in WITHOUT_ANSWER) == bool(found):
                sys.exit(f"the panel {panel['title']!r} has {len(found)} series: {expression}")
    rules = [rule for group in json.loads(ask(PROMETHEUS, "/api/v1/rules"))["data"]["groups"] for rule in group["rules"]]
    # What other work does to the disk of this computer is no fault of the rules.
    ill = [rule for rule in rules if rule["health"] != "ok" or rule["state"] != "inactive" and "Disk" not in rule["name"]]
    if ill:
        sys.exit(f"rules that are not sound, or fire on a sound service: {ill}")
    if len(rules) < 10 or asked < 30:
        sys.exit(f"only {len(rules)} rules and {asked} queries were found")
    print(f"{asked} queries of the dashboard have an answer, {len(rules)} alerts are sound and silent")


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        at = ["--data-dir", str(folder / "data"), "--listen", SERVICE]
        scopes = ["--scopes", "read,compute,machines,calibrations,admin"]
        made = subprocess.run([TRUNNION, "keys", "create", "--name", "check", *scopes, *at], capture_output=True, text=True, check=True)
        assert re.fullmatch(r"trn_\w+", made.stdout.strip()), made
        with open(folder / "log", "w") as log:
            service = subprocess.Popen([TRUNNION, "serve", *at], stdout=log, stderr=log)
        try:
            until("the service is ready", 30, lambda: ask(SERVICE, "/readyz"))
            look(folder, made.stdout.strip())
        finally:
            service.terminate()
            service.wait(timeout=30)


main()
