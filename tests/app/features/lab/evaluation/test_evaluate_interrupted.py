"""Long work that is told to end: it leaves neither files nor processes."""

import os
import select
import signal
import subprocess
import sys
import textwrap

import pytest
from places import ROOT

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("told", [signal.SIGTERM, signal.SIGINT])
def test_an_experiment_that_is_told_to_end_leaves_nothing(tmp_path, told):
    """A model of the user's own tells through a pipe which process follows a drive, and stays."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    (tmp_path / "own.py").write_text(
        textwrap.dedent(f"""
            import os, threading

            class Own:
                def log_likelihood(self, poses, scan):
                    with open({str(pipe)!r}, "w") as file:
                        file.write(str(os.getpid()))
                    threading.Event().wait()
        """)
    )
    (tmp_path / "config.toml").write_text(f'sensor_model = "{tmp_path}/own.py:Own"\n')
    command = [
        sys.executable, "-m", "app", "evaluate", "--world", "kinematic", "--seeds", "1",
        "--laps", "1", "--workers", "1", "--config", str(tmp_path / "config.toml"),
        "--out", str(tmp_path / "out"),
    ]  # fmt: skip
    with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as program:
        worker = os.pidfd_open(int(pipe.read_text()))
        program.send_signal(told)
        _, complaint = program.communicate(timeout=60)
    assert select.select([worker], [], [], 30)[0], "the worker lives on"
    os.close(worker)
    assert (program.returncode, complaint) == (128 + told, "")
    assert list((tmp_path / "out").iterdir()) == []
