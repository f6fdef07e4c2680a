"""The container's file: what it copies is there, and what it starts binds as the page promises."""

import re

import pytest
import yaml

from app.command_line import main
from app.settings.config import ROOT

FILE = (ROOT / "Dockerfile").read_text(encoding="utf-8")
IGNORED = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()


def test_what_is_copied_is_all_that_a_wheel_is_made_of():
    assert IGNORED[0] == "*"
    kept = {line.removeprefix("!") for line in IGNORED if line.startswith("!")}
    assert all((ROOT / name).exists() for name in kept)
    assert {"app", "docs", "frontend", "maps", "robot", "sim", "pyproject.toml"} <= kept
    assert set(re.findall(r"--requirement (\S+)", FILE)) <= kept


def test_a_hub_on_kubernetes_starts_what_the_page_says(capsys):
    text = (ROOT / "docs" / "classroom.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    values = yaml.safe_load(block)["singleuser"]
    (entry,) = re.findall(r'ENTRYPOINT \["([^"]+)"\]', FILE)
    assert entry == "brickpose"
    with pytest.raises(SystemExit) as ended:  # a pod's command comes after the entry point
        main([*values["cmd"], "--help"])
    assert ended.value.code == 0
    assert "single-user" in capsys.readouterr().out
    assert f"useradd --create-home --uid {values['uid']} driver" in FILE
    assert values["storage"]["homeMountPath"] == re.findall(r"WORKDIR (\S+)", FILE)[-1]


def test_it_is_nobody_s_root_and_serves_the_port_that_it_names(capsys):
    assert FILE.index("\nUSER 1000\n") < FILE.index("\nENTRYPOINT")
    command = re.findall(r'"([^"]+)"', FILE[FILE.index("ENTRYPOINT") :])
    assert command == ["brickpose", "run", "--host", "0.0.0.0"]
    (port,) = re.findall(r"EXPOSE (\d+)", FILE)
    with pytest.raises(SystemExit) as ended:
        main([*command[1:], "--help"])
    assert ended.value.code == 0
    assert f"(default: {port})" in capsys.readouterr().out
