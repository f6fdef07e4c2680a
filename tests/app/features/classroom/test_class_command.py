"""``brickpose class``: what is wrong is said before anything starts."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import socket
import sys

import pytest
from classes import four_ports, needs_hub

from app.command_line import main
from app.features.classroom import class_command
from app.features.classroom.roster import TEACHER


@pytest.fixture
def students(tmp_path):
    path = tmp_path / "students.csv"
    path.write_text("Ada\nBo\n")
    return path


@pytest.fixture
def installed(monkeypatch):
    """As if all packages were there, JupyterHub in a version."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name)
    versions = {"jupyterhub": "6.1.1"}
    monkeypatch.setattr(importlib.metadata, "version", lambda name: versions[name])
    return versions


def refused(capsys, *words: str) -> tuple[int, str]:
    code = main(["class", *map(str, words)])
    return code, capsys.readouterr().err


def test_configuration_and_links_are_written(students, installed, capsys):
    assert main(["class", str(students), "--write-only", "--port", "9100", "--memory", "700",
                 "--disk", "50"]) == 0  # fmt: skip
    folder = students.with_suffix(".class")
    text = (folder / "jupyterhub_config.py").read_text()
    compile(text, "jupyterhub_config.py", "exec")
    assert "port=9100" in text
    assert "memory_mb=700" in text
    assert "disk_mb=50" in text
    assert str(folder / "links.html") in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--port", "65534"), "--port is 65534; valid are 1 to 65531"),
        (("--memory", "10"), "--memory is 10; valid are 300 to"),
        (("--disk", "5"), "--disk is 5; valid are 10 to"),
        (("--idle", "0"), "--idle is 0; valid are 1 to"),
        (("--address", "school"), "--address is 'school'; valid is http://NAME:PORT"),
    ],
)
def test_a_wrong_option_is_refused(words, told, students, installed, capsys):
    code, err = refused(capsys, students, *words)
    assert (code, told in err) == (2, True), err
    assert not students.with_suffix(".class").exists()


def test_notebooks_of_root_are_refused_and_others_written(students, installed, capsys, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    code, err = refused(capsys, students, "--notebook", "--write-only")
    assert code == 1
    assert "--notebook as root would make each student root; valid is another user" in err
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    assert main(["class", str(students), "--notebook", "--write-only"]) == 0
    text = (students.with_suffix(".class") / "jupyterhub_config.py").read_text()
    assert "notebook=True" in text


@pytest.mark.parametrize("number", range(4))
def test_a_taken_port_is_named_with_its_use(number, students, installed, capsys):
    first = four_ports()
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", first + number))
        taken.listen()
        code, err = refused(capsys, students, "--host", "127.0.0.1", "--port", first)
    assert code == 1
    assert f"port {first + number}, for the " in err
    assert "four free ports one after the other are chosen by --port" in err
    assert not students.with_suffix(".class").exists()


@pytest.mark.parametrize("missing", ["jupyterhub", "configurable_http_proxy"])
def test_a_missing_package_is_named_with_its_cure(missing, students, monkeypatch, capsys):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == missing else name)
    code, err = refused(capsys, students)
    assert code == 1
    assert f"the package {missing.replace('_', '-')} is missing: python -m pip install" in err


@pytest.mark.parametrize("missing", ["jupyterlab", "jupyter_server_proxy"])
def test_what_notebooks_need_is_named_with_its_cure(missing, students, monkeypatch, capsys):
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == missing else name)
    code, err = refused(capsys, students, "--notebook")
    assert code == 1
    package = missing.replace("_", "-")
    cure = "python -m pip install jupyterlab jupyter-server-proxy"
    assert f"the package {package} is missing: {cure}" in err


@pytest.mark.parametrize("notebook", [False, True])
def test_students_servers_are_started_by_the_same_python(notebook, tmp_path):
    """The environment's programs need not be on the path."""
    config = pytest.importorskip("traitlets.config").Config()
    pytest.importorskip("jupyterhub")
    from app.features.classroom.hub.configuration import configure

    configure(
        config, str(tmp_path), host="127.0.0.1", port=9100, memory_mb=700, disk_mb=50, idle_s=60,
        notebook=notebook,
    )  # fmt: skip
    module = "jupyterhub.singleuser" if notebook else "app"
    assert config.Spawner.cmd[:3] == [sys.executable, "-m", module]


@pytest.mark.parametrize("version", ["4.1.6", "7.0.0", "none"])
def test_a_hub_of_another_version_is_refused(version, students, installed, capsys):
    installed["jupyterhub"] = version
    code, err = refused(capsys, students)
    assert code == 1
    assert f"JupyterHub {version} is installed; valid is 5 up to, but without, 7" in err


def test_a_proxy_that_is_not_there_or_has_no_node_is_told(
    students, installed, capsys, monkeypatch, tmp_path
):
    monkeypatch.setenv(class_command.OTHER_PROXY, "no-such-proxy --log-level debug")
    code, err = refused(capsys, students)
    assert code == 1
    assert "BRICKPOSE_PROXY is 'no-such-proxy', and there is no such program" in err
    script = tmp_path / "npms-proxy"
    script.write_text("#!/usr/bin/env node\n")
    script.chmod(0o755)
    monkeypatch.setenv(class_command.OTHER_PROXY, str(script))
    monkeypatch.setenv("PATH", str(tmp_path))
    code, err = refused(capsys, students)
    assert code == 1
    assert "which needs node, and node is not there" in err
    (tmp_path / "node").symlink_to("/bin/true")
    assert main(["class", str(students), "--write-only"]) == 0


@pytest.mark.slow
@needs_hub
def test_a_hub_that_ends_at_once_is_told_with_its_log(students, monkeypatch, tmp_path):
    folder = class_command.ClassFolder(tmp_path / "class")
    folder.make()
    folder.config.write_text("raise SystemExit(3)")
    monkeypatch.setattr(class_command, "start_parent", lambda place: None)
    with pytest.raises(class_command.ClassError, match=r"ends at once; .*hub\.log says why"):
        class_command._keep_running(folder, "http://x", (), TEACHER, four_ports())
