"""Builds `sick.c` and steers it: the disk and the clock of one process, without being root."""

import mmap
import pathlib
import struct
import subprocess

SOURCE = pathlib.Path(__file__).with_name("sick.c")
WELL, READ_ONLY, FAILING, NOT_SYNCHRONISING, FULL = 0, ord("r"), ord("e"), ord("s"), ord("f")


class Sick:
    def __init__(self, folder, disk):
        folder = pathlib.Path(folder)
        library, control = folder / "sick.so", folder / "sick.control"
        call = ["cc", "-shared", "-fPIC", "-O1", "-Wall", "-Wextra", "-Werror", "-o", str(library), str(SOURCE), "-ldl"]
        subprocess.run(call, check=True)
        control.write_bytes(bytes(64))
        with control.open("r+b") as file:
            self.control = mmap.mmap(file.fileno(), 64)
        self.environment = {"LD_PRELOAD": str(library), "SICK_CONTROL": str(control), "SICK_DISK": str(disk)}

    def disk(self, state):
        self.control[0] = state

    def clock(self, wrong_s):
        self.control[8:16] = struct.pack("=q", wrong_s)
