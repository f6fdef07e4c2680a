"""A terminal at the emulated bootloader, and an image to give it."""

from __future__ import annotations

from sim.hat.bootloader import Bootloader, checksum

IMAGE = bytes(range(256)) * 3 + b"\x02\x03\r"
SIGNATURE = bytes(range(100, 164))
STX, ETX = b"\x02", b"\x03"


class Terminal:
    """A bootloader and what has come out of it since it was last looked at."""

    def __init__(self) -> None:
        self.out = b""
        self.bootloader = Bootloader(self._put)
        self.greeting = self.take()
        self.wait(0.011)

    def _put(self, data: bytes) -> None:
        self.out += data

    def take(self) -> str:
        out, self.out = self.out, b""
        return out.decode("latin-1")

    def send(self, data: str | bytes) -> str:
        for byte in data.encode("latin-1") if isinstance(data, str) else data:
            self.bootloader.receive(byte)
        return self.take()

    def wait(self, seconds: float) -> str:
        for _ in range(round(seconds * 1000)):
            self.bootloader.tick(0.001)
        return self.take()


def loaded(terminal: Terminal, image: bytes = IMAGE) -> Terminal:
    terminal.send(f"load {len(image)} {checksum(image)}\r")
    terminal.send(STX + image + ETX)
    return terminal
