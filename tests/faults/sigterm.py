"""SIGTERM while work runs that would take minutes: the process ends with status 0 within 8 s, the jobs wait in the queue
again, and after the next start they are finished.

    sigterm.py PATH_OF_TRUNNION
"""

import pathlib
import shutil
import socket
import sqlite3
import sys
import threading
import time

from service import MACHINE, Service, cc_job, program, workplace

PORT = 8924
LIMIT_S = 8.0
BLOCKS = 5_000_000


def runaway(external_id):
    return cc_job(external_id, contact="feed-plane", tolerance_um=0.5)


def states(directory):
    """Jobs as they are stored, from a copy: nobody but the service opens its database."""
    copy = pathlib.Path(directory).with_name("copy.sqlite")
    shutil.copy(pathlib.Path(directory) / "trunnion.sqlite", copy)
    rows = sqlite3.connect(copy).execute("SELECT id, state, attempts, lease FROM jobs").fetchall()
    return {id: rest for id, *rest in rows}


def half_open(port, head, count):
    """Clients in the middle of something, who will not finish it."""
    clients = []
    for _ in range(count):
        client = socket.create_connection(("127.0.0.1", port))
        client.sendall(head)
        clients.append(client)
    return clients


def quietly(ask, *arguments):
    try:
        ask(*arguments)
    except OSError:
        pass


def main():
    text = program(BLOCKS)
    with workplace() as folder:
        data = folder / "data"
        arguments = ["--max-cost-s", "100000", "--max-body-bytes", str(1 << 30), "--max-computations", "2"]
        service = Service(sys.argv[1], data, PORT, *arguments).start()
        ids = [service.post_job(runaway(f"runaway-{k}"), text).document["id"] for k in range(3)]
        service.until(ids[0], "running")
        # A request computes too, its client waits for it; uploads and headers are half there; a job is followed.
        query = "tool_radius_mm=5&work_offset_mm=12,-7,35&contact=feed-plane&tolerance_um=0.5"
        waiting = threading.Thread(target=quietly, args=(service.compensate, text, query), daemon=True)
        waiting.start()
        long = f"POST /v1/machines/{MACHINE}/cc-compensation?tool_radius_mm=5&work_offset_mm=12,-7,35 HTTP/1.1\r\nHost: localhost\r\n"
        clients = half_open(PORT, (long + "Content-Length: 1000000\r\n\r\nG1 X0").encode(), 8)
        clients += half_open(PORT, long.encode(), 8)
        clients += half_open(PORT, f"GET /v1/jobs/{ids[0]}/events HTTP/1.1\r\nHost: localhost\r\n\r\n".encode(), 8)
        time.sleep(2.0)
        assert service.job(ids[0])["state"] == "running"
        took_s = service.stop(within_s=60)
        assert took_s < LIMIT_S, f"{took_s:.1f} s"
        for client in clients:
            client.close()
        left = states(data)
        assert set(left) == set(ids), left
        assert all(rest == ["queued", 0, None] for rest in left.values()), left
        service.nothing_half_done()
        service.doctor()
        service.start()
        began = time.monotonic()
        for id in ids:
            job = service.ended(id, within_s=1800)
            assert job["state"] == "succeeded" and job["attempts"] == 1, job
            if id == ids[0]:
                lasts_s = time.monotonic() - began
        quick_s = service.stop()
        service.doctor()
        print(
            f"ended {took_s:.1f} s after SIGTERM with work under way that took {lasts_s:.0f} s afterwards; "
            f"{quick_s:.1f} s with nothing under way"
        )
        assert quick_s < LIMIT_S and lasts_s > LIMIT_S, "the work was too short to prove anything"


main()
