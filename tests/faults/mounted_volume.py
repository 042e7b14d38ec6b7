"""A backup is restored into a volume: an empty file system whose mount point is the data directory, as a container has
it. A mount point cannot be renamed over, and nothing beside it can be written.

    unshare --mount --map-root-user python3 tests/faults/mounted_volume.py target/release/trunnion

Needs a mount name space of its own.
"""

import subprocess
import sys

from service import BLADE, Service, workplace

PORT = 8933

with workplace() as folder:
    service = Service(sys.argv[1], folder / "data", PORT).start()
    answer = service.compensate(BLADE)
    assert answer.status == 200, answer
    job, written = answer.headers["Location"], answer.body
    made = service.command("backup", str(folder / "backup"))
    assert made.returncode == 0, made.stderr
    service.stop()

    # The parent of the mount point is another file system, which can only be read.
    place = folder / "place"
    volume = place / "volume"
    volume.mkdir(parents=True)
    mount = ["mount", "-t", "tmpfs", "-o"]
    subprocess.run([*mount, "size=1m", "tmpfs", str(place)], check=True)
    volume.mkdir()
    subprocess.run([*mount, "size=64m", "tmpfs", str(volume)], check=True)
    subprocess.run(["mount", "-o", "remount,ro", str(place)], check=True)
    (volume / "lost+found").mkdir()

    restored = Service(sys.argv[1], volume, PORT)
    done = restored.command("restore", str(folder / "backup"))
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in volume.iterdir()) == ["blobs", "lost+found", "trunnion.sqlite"]
    restored.doctor()
    restored.start()
    answer = restored.ask("GET", f"{job}/program")
    assert answer.status == 200 and answer.body == written, answer
    restored.stop()
    again = restored.command("restore", str(folder / "backup"))
    assert again.returncode == 2 and "is not empty" in again.stderr, again.stderr
    subprocess.run(["umount", str(volume)], check=True)
    subprocess.run(["umount", str(place)], check=True)
print("a backup was restored into a mounted volume, and is served from it")
