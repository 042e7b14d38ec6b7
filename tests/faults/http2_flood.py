"""A client of HTTP/2 that sends as many requests at once on a connection as it may, as fast as it may, and takes no answer."""

import collections
import itertools
import socket
import struct

PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
DATA, HEADERS, RST_STREAM, SETTINGS, GOAWAY, WINDOW_UPDATE = 0, 1, 3, 4, 7, 8
END_STREAM, END_HEADERS, ACK = 1, 4, 1
# RFC 9113 §6.5.2 and §6.9.2.
MAX_CONCURRENT_STREAMS, INITIAL_WINDOW_SIZE, DEFAULT_WINDOW = 3, 4, 65_535
LARGEST_FRAME = 16_384
# Requests open on a connection, where the service allows as many.
STREAMS = 64


def frame(kind, flags, stream, payload=b""):
    return len(payload).to_bytes(3, "big") + bytes([kind, flags]) + struct.pack(">I", stream) + payload


def literal(index, value):
    """A field of the static table with another value, not to be remembered (RFC 7541 §6.2.2)."""
    name = bytes([index]) if index < 15 else bytes([15, index - 15])
    length = bytes([len(value)]) if len(value) < 127 else bytes([127, len(value) - 127])
    return name + length + value.encode()


def head(path, kind, key, coding=None):
    # 3 and 6 of the static table: POST and http; 1 and 4: authority and path; 23, 26, 31: key, coding, type of the content.
    fields = bytes([0x83, 0x86]) + literal(1, "localhost") + literal(4, path) + literal(23, f"Bearer {key}") + literal(31, kind)
    return fields + (literal(26, coding) if coding else b"")


class Http2Client:
    """Keeps as many requests open as it may for as long as it lives; `requests` are taken in turn: header, body, whether it ends."""

    def __init__(self, address, port, requests):
        self.requests, self.next_id, self.streams = itertools.cycle(requests), 1, STREAMS
        self.left, self.windows, self.window, self.initial = {}, collections.Counter(), DEFAULT_WINDOW, DEFAULT_WINDOW
        self.told, self.got = collections.Counter(), b""
        # A window of nothing: no byte of a body is taken.
        self.out = bytearray(PREFACE + frame(SETTINGS, 0, 0, struct.pack(">HI", INITIAL_WINDOW_SIZE, 0)))
        self.socket = socket.socket()
        self.socket.bind((address, 0))
        self.socket.connect(("127.0.0.1", port))
        self.socket.setblocking(False)

    def ask(self):
        fields, body, ends = next(self.requests)
        self.out += frame(HEADERS, END_HEADERS, self.next_id, fields)
        self.left[self.next_id], self.windows[self.next_id] = (memoryview(body), ends), self.initial
        self.next_id += 2

    def send_bodies(self):
        for stream, (body, ends) in self.left.items():
            while body and self.window > 0 and self.windows[stream] > 0 and len(self.out) < 1 << 17:
                size = min(len(body), self.window, self.windows[stream], LARGEST_FRAME)
                part, body = body[:size], body[size:]
                self.window, self.windows[stream] = self.window - size, self.windows[stream] - size
                self.out += frame(DATA, END_STREAM if ends and not body else 0, stream, bytes(part))
            self.left[stream] = (body, ends)

    def take(self, kind, flags, stream, payload):
        self.told[kind] += 1
        if kind == SETTINGS and not flags & ACK:
            for at in range(0, len(payload), 6):
                name, value = struct.unpack(">HI", payload[at:at + 6])
                if name == INITIAL_WINDOW_SIZE:
                    for known in self.left:
                        self.windows[known] += value - self.initial
                    self.initial = value
                elif name == MAX_CONCURRENT_STREAMS:
                    self.streams = min(STREAMS, value)
            self.out += frame(SETTINGS, ACK, 0)
        elif kind == WINDOW_UPDATE:
            more = struct.unpack(">I", payload)[0]
            if stream == 0:
                self.window += more
            else:
                self.windows[stream] += more
        elif kind == RST_STREAM or (kind in (HEADERS, DATA) and flags & END_STREAM):
            self.left.pop(stream, None)

    def go_on(self):
        """Whether the connection is still there."""
        while len(self.left) < self.streams and len(self.out) < 1 << 17:
            self.ask()
        self.send_bodies()
        try:
            if self.out:
                del self.out[:self.socket.send(self.out)]
        except BlockingIOError:
            pass
        except OSError:
            return False
        try:
            piece = self.socket.recv(65_536)
            if not piece:
                return False
            self.got += piece
        except BlockingIOError:
            pass
        except OSError:
            return False
        while len(self.got) >= 9:
            length = int.from_bytes(self.got[:3], "big")
            if len(self.got) < 9 + length:
                break
            kind, flags, stream = self.got[3], self.got[4], struct.unpack(">I", self.got[5:9])[0] & 0x7FFF_FFFF
            payload, self.got = self.got[9:9 + length], self.got[9 + length:]
            self.take(kind, flags, stream, payload)
        return True
