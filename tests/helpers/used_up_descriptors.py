"""A listening socket in a process that has used up its descriptors; tells what became of it."""

import json
import os
import socket
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from app.page.listening import listen


def main() -> None:
    listening = listen("127.0.0.1", 0)
    waiting = socket.create_connection(listening.getsockname())
    waiting.settimeout(10)
    opened = []
    try:
        while True:
            opened.append(os.open(os.devnull, os.O_RDONLY))
    except OSError:
        pass
    told = {}
    try:
        listening.accept()
    except BlockingIOError as error:
        told["raised"] = type(error).__name__
    told["closed"] = waiting.recv(1) == b""
    os.close(opened.pop())
    os.close(opened.pop())
    later = socket.create_connection(listening.getsockname())
    listening.accept()[0].sendall(b"hello")
    told["later"] = later.recv(5) == b"hello"
    sys.stdout.write(json.dumps(told))


main()
