"""The service that starts the robot with the Pi."""

from __future__ import annotations

import configparser
import shutil
import subprocess
from pathlib import Path

import pytest

from app.command_line import parse
from app.options import config_from
from app.settings.config import ROOT


def test_the_service_stops_the_motors_however_it_ends() -> None:
    unit = configparser.ConfigParser(strict=False)
    unit.optionxform = str  # type: ignore[assignment,method-assign]
    unit.read(ROOT / "docs/brickpose.service")
    service = unit["Service"]
    assert service["ExecStopPost"].endswith("brickpose stop-motors")
    assert service["KillSignal"] == "SIGTERM"
    assert service["SuccessExitStatus"].split() == ["143", "130"]
    assert service["Restart"] == "on-failure"
    command = service["ExecStart"].split()
    assert config_from(parse(command[1:])).robot == "buildhat"


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="there is no systemd")
def test_systemd_takes_the_service(tmp_path: Path) -> None:
    unit = (
        (ROOT / "docs/brickpose.service").read_text().replace("/home/pi/brickpose", str(tmp_path))
    )
    program = tmp_path / ".venv/bin/brickpose"
    program.parent.mkdir(parents=True)
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    (tmp_path / "brickpose.service").write_text(unit.replace("User=pi", "User=root"))
    said = subprocess.run(
        ["systemd-analyze", "verify", str(tmp_path / "brickpose.service")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert said.returncode == 0, said.stderr
    assert "brickpose" not in said.stderr
