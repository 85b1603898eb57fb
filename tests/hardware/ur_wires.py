"""Small clients of a UR controller's ports, written from the maker's guides and not from the stand-in: they share no code with it."""

import socket
import struct

LAYOUT = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
    "VECTOR6UINT32": "6I",
}


class Wire:
    """A connection that is read in whole pieces."""

    def __init__(self, host, port):
        self.socket = socket.create_connection((host, port), timeout=10)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def read(self, size):
        data = b""
        while len(data) < size:
            more = self.socket.recv(size - len(data))
            assert more, "the controller ended the connection"
            data += more
        return data


class RtdeClient(Wire):
    """RTDE of one version of its protocol."""

    def __init__(self, host, protocol):
        super().__init__(host, 30004)
        self.protocol, self.kinds = protocol, []
        if protocol != 1:
            assert self.ask("V", struct.pack(">H", protocol)) == b"\x01"

    def send(self, kind, payload=b""):
        self.socket.sendall(struct.pack(">HB", 3 + len(payload), ord(kind)) + payload)

    def take(self, kind):
        while True:
            size, found = struct.unpack(">HB", self.read(3))
            payload = self.read(size - 3)
            if chr(found) == kind:
                return payload

    def ask(self, kind, payload=b""):
        self.send(kind, payload)
        return self.take(kind)

    def outputs(self, names, rate=125.0):
        head = b"" if self.protocol == 1 else struct.pack(">d", rate)
        answer = self.ask("O", head + ",".join(names).encode())
        self.kinds = answer[0 if self.protocol == 1 else 1 :].decode().split(",")
        return self.kinds

    def inputs(self, names):
        answer = self.ask("I", ",".join(names).encode())
        return answer[0], answer[1:].decode().split(",")

    def start(self):
        return self.ask("S") == b"\x01"

    def pause(self):
        return self.ask("P") == b"\x01"

    def values(self):
        payload = self.take("U")
        data = payload if self.protocol == 1 else payload[1:]
        layout = ">" + "".join(LAYOUT[kind] for kind in self.kinds)
        assert len(data) == struct.calcsize(layout)
        flat = iter(struct.unpack(layout, data))
        sizes = [int(LAYOUT[kind][0]) if len(LAYOUT[kind]) > 1 else 0 for kind in self.kinds]
        return [tuple(next(flat) for _ in range(size)) if size else next(flat) for size in sizes]

    def read_until(self, right):
        """Return the first values that are right."""
        for _ in range(2000):
            values = self.values()
            if right(values):
                return values
        raise AssertionError(f"never right: {values}")


def messages(wire):
    """Yield the messages of a primary or secondary port: type and what follows it."""
    while True:
        size, kind = struct.unpack(">iB", wire.read(5))
        yield kind, wire.read(size - 5)


def parts(state):
    """Return the parts of a state of the robot by their types, without their heads."""
    made = {}
    while state:
        size, kind = struct.unpack_from(">iB", state)
        made[kind], state = state[5:size], state[size:]
    return made


def states(wire):
    """Yield the states of the robot of a primary or secondary port."""
    return (parts(body) for kind, body in messages(wire) if kind == 16)
