"""The process is killed at random moments while it tells the ends of jobs; every acknowledged job's end is told.

A receiver refuses half of what it is sent. Every round starts the service on the same directory, posts jobs that name the
receiver, and kills the process without warning. At the end the receiver takes everything, and each job that was
acknowledged must have been told under its own id, signed, and be written down as delivered.

Usage: webhooks.py PATH_OF_TRUNNION; TRUNNION_KILLS (60) rounds, TRUNNION_KILL_SEED (1).
"""

import base64
import hashlib
import hmac
import http.server
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
import uuid

KILLS = int(os.environ.get("TRUNNION_KILLS", "60"))
SEED = int(os.environ.get("TRUNNION_KILL_SEED", "1"))
# Longest life of a process.
LIFE_S = 0.7
# Longest wait for everything to be told at the end.
TOLD_S = 600
PAUSES = ",".join(["0.2"] * 4 + ["1"] * 30)
JOB = {"machine_id": "example-ac-table", "operation": "cc-compensation",
       "parameters": {"tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [12, -7, 35]}}
PROGRAM = "G90 G21 G94\nG1 X10.000 Y0.000 Z5.000 A10.000 C20.000 F1000\nG1 X20.000 Y0.000 Z5.000 A25.000 C60.000\nM30\n"

with socket.create_server(("127.0.0.1", 0)) as free:
    PORT = free.getsockname()[1]
base = f"http://127.0.0.1:{PORT}"
told, refusing, chance = {}, True, random.Random(SEED)
secret = b""


class Receiver(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["content-length"]))
        name = self.headers["webhook-id"]
        signed = f'{name}.{self.headers["webhook-timestamp"]}.'.encode() + body
        mine = "v1," + base64.b64encode(hmac.new(secret, signed, hashlib.sha256).digest()).decode()
        if self.headers["webhook-signature"] != mine:
            told.setdefault("wrong signature", []).append(name)
        refused = refusing and chance.random() < 0.5
        if not refused:
            told.setdefault(name, []).append(json.loads(body))
        self.send_response(500 if refused else 204)
        self.end_headers()

    def log_message(self, *_):
        pass


def get(path):
    with urllib.request.urlopen(base + path, timeout=30) as answer:
        return answer.read()


def start(data):
    process = subprocess.Popen(
        [sys.argv[1], "--listen", f"127.0.0.1:{PORT}", "--data-dir", str(data), "--log", "error",
         "--webhook-allow", "127.0.0.1", f"--webhook-pauses-s={PAUSES}"], stdout=subprocess.DEVNULL)
    for _ in range(500):
        if process.poll() is not None:
            sys.exit("the service does not start")
        try:
            get("/readyz")
            return process
        except OSError:
            time.sleep(0.02)
    sys.exit("the service does not get ready")


def post(receiver):
    border = uuid.uuid4().hex
    job = json.dumps(JOB | {"callback_url": receiver})
    body = (
        f'--{border}\r\nContent-Disposition: form-data; name="job"\r\n\r\n{job}\r\n'
        f'--{border}\r\nContent-Disposition: form-data; name="program"; filename="a.nc"\r\n\r\n{PROGRAM}\r\n--{border}--\r\n'
    )
    headers = {"content-type": f"multipart/form-data; boundary={border}"}
    request = urllib.request.Request(f"{base}/v1/jobs", data=body.encode(), headers=headers)
    with urllib.request.urlopen(request, timeout=30) as answer:
        return json.load(answer)["id"]


def waiting():
    names = ("trunnion_webhooks_waiting ", "trunnion_jobs_queued ", "trunnion_jobs_running ")
    lines = get("/metrics").decode().splitlines()
    return sum(float(line.split()[1]) for line in lines if line.startswith(names))


def main():
    global refusing, secret
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Receiver)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    receiver = f"http://127.0.0.1:{server.server_address[1]}/trunnion"
    data = pathlib.Path(tempfile.mkdtemp())
    shown = subprocess.run([sys.argv[1], "--data-dir", str(data), "webhooks", "secret"], check=True, capture_output=True)
    secret = base64.b64decode(shown.stdout.decode().strip().removeprefix("whsec_"))
    acknowledged = []
    for _ in range(KILLS):
        process = start(data)
        killer = threading.Timer(chance.uniform(0.02, LIFE_S), process.kill)
        killer.start()
        try:
            while True:
                acknowledged.append(post(receiver))
        except OSError:
            pass
        killer.join()
        process.wait()
    refusing = False
    process = start(data)
    end = time.monotonic() + TOLD_S
    while waiting() > 0 and time.monotonic() < end:
        time.sleep(0.2)
    faults = list(told.pop("wrong signature", []))
    for job in acknowledged:
        events = told.get(f"msg_{job}", [])
        log = json.loads(get(f"/v1/jobs/{job}/deliveries"))
        if not events or log["delivery"]["state"] != "delivered" or any(event["data"]["id"] != job for event in events):
            faults.append(job)
    process.send_signal(signal.SIGTERM)
    if process.wait(30) != 0:
        faults.append("the service did not stop in order")
    repeated = sum(len(events) - 1 for events in told.values())
    print(f"{KILLS} kills, {len(acknowledged)} jobs acknowledged, {len(told)} told, {repeated} of them once more, "
          f"{len(faults)} faults")
    shutil.rmtree(data)
    if faults or len(acknowledged) < KILLS:
        sys.exit(f"not told as they should be: {faults[:20]}")


if __name__ == "__main__":
    main()
