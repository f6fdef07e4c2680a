"""LastingProxy: a proxy that outlives the hub which has started it, so that open pages do, too."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

from jupyterhub.proxy import ConfigurableHTTPProxy
from tornado.ioloop import PeriodicCallback


class LastingProxy(ConfigurableHTTPProxy):
    """Goes on with the proxy of a hub that was killed; else it starts one.

    JupyterHub replaces it, and all pages lose their sockets for as long as a hub takes to start.
    Both need the same token, which is configured.
    """

    async def start(self) -> None:
        """Take over the proxy that runs, if it answers; else start one."""
        pid = self._running()
        if pid is not None:
            self.proxy_process = _OthersProcess(pid)
            try:
                await self.get_all_routes()
            except Exception as error:
                self.log.warning("the proxy %i is replaced: %s", pid, error)
            else:
                self.log.info("the proxy %i goes on", pid)
                self._look_after_it()
                return
        await super().start()

    async def check_running(self) -> None:
        """Start another proxy if this one has ended; ``start`` begins to look after that one."""
        if self.proxy_process.poll() is not None:
            self._check_running_callback.stop()
            try:
                await super().check_running()
            except Exception:
                self.log.exception("no proxy starts; it is tried again")
                self._look_after_it()

    def _running(self) -> int | None:
        try:
            pid = int(Path(self.pid_file).read_text().split()[0])
            command = Path(f"/proc/{pid}/cmdline").read_bytes()
        except (OSError, ValueError, IndexError):
            return None
        # The number may be another process's by now.
        return pid if os.fsencode(Path(self.command[-1]).name) in command else None

    def _look_after_it(self) -> None:
        callback = PeriodicCallback(self.check_running, 1e3 * self.check_running_interval)
        self._check_running_callback = callback
        callback.start()


class _OthersProcess:
    """A process that another one has started, with what ``subprocess.Popen`` has of it."""

    def __init__(self, pid: int) -> None:
        self.pid = pid

    def poll(self) -> int | None:
        """Return None while it runs."""
        try:
            state = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return -1
        return -1 if state == "Z" else None

    def terminate(self) -> None:
        """Have it end."""
        os.kill(self.pid, signal.SIGTERM)

    def wait(self, *_: Any) -> int:
        """Return its status, which is not known."""
        return -1
