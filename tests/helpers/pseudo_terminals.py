"""Pseudo-terminals in the place of a serial port, and what they may not leave behind."""

import os
import select
import tty
from pathlib import Path

PATIENCE = 10.0
FDS = Path("/proc/self/fd")


class Pty:
    """Both ends of a pseudo-terminal; the test is the board."""

    def __init__(self):
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.name = os.ttyname(self.slave)

    def read(self, count):
        """So many bytes that the link sent."""
        read = b""
        while len(read) < count:
            assert select.select([self.master], [], [], PATIENCE)[0], read
            read += os.read(self.master, count - len(read))
        return read

    def write(self, data):
        os.write(self.master, data)

    def close(self):
        for end in (self.master, self.slave):
            if end is not None:
                os.close(end)
        self.master = self.slave = None
