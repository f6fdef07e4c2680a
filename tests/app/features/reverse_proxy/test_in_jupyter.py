"""BrickPose in JupyterLab's launcher, behind a real Jupyter server's proxy, in a real Chromium."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import time
from urllib.request import urlopen

import pytest
from browsing import PATIENCE_MS
from reverse_proxies import free_ports

from app.settings.config import ROOT

HERE = all(importlib.util.find_spec(name) for name in ("jupyter_server", "jupyter_server_proxy"))
pytestmark = [
    pytest.mark.browser,
    pytest.mark.slow,
    pytest.mark.skipif(not HERE, reason="`python -m pip install jupyter-server-proxy` gets it"),
]
TOKEN = "of-jupyter"
START_S = 60.0


@pytest.fixture(scope="module")
def jupyter(tmp_path_factory):
    """The address of a Jupyter server that finds the entry of this checkout."""
    folder = tmp_path_factory.mktemp("jupyter")
    about = folder / "brickpose_entry-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: brickpose-entry\nVersion: 1\n")
    (about / "entry_points.txt").write_text(
        "[jupyter_serverproxy_servers]\nbrickpose = app.features.reverse_proxy.jupyter:server\n"
    )
    (port,) = free_ports(1)
    words = [
        "--no-browser", "--allow-root", f"--port={port}", f"--IdentityProvider.token={TOKEN}",
        "--ServerApp.jpserver_extensions={'jupyter_server_proxy': True}",
        f"--notebook-dir={folder}",
    ]  # fmt: skip
    paths = os.pathsep.join((str(folder), str(ROOT)))
    environment = os.environ | {"PYTHONPATH": paths, "JUPYTER_CONFIG_DIR": str(folder)}
    address = f"http://127.0.0.1:{port}"
    with subprocess.Popen(
        [sys.executable, "-m", "jupyter_server", *words], cwd=folder, env=environment,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    ) as process:  # fmt: skip
        end = time.monotonic() + START_S
        while not _answers(address):
            assert process.poll() is None
            assert time.monotonic() < end
            time.sleep(0.2)
        yield address
        process.terminate()


def _answers(address: str) -> bool:
    try:
        urlopen(f"{address}/api?token={TOKEN}", timeout=5).close()
    except OSError:
        return False
    return True


def test_the_launcher_has_it_and_the_page_works(jupyter, browser):
    with urlopen(f"{jupyter}/server-proxy/servers-info?token={TOKEN}", timeout=60) as answer:
        entries = json.load(answer)["server_processes"]
    # Where BrickPose is installed, too, there are two entries of one name.
    assert {(one["name"], one["launcher_entry"]["title"]) for one in entries} == {
        ("brickpose", "BrickPose")
    }
    page = browser.new_context().new_page()
    page.set_default_timeout(PATIENCE_MS)
    page.goto(f"{jupyter}/brickpose/?token={TOKEN}")
    page.wait_for_function("window.brickpose?.connected && window.brickpose?.telemetry?.estimate")
    page.keyboard.down("w")
    page.wait_for_function("Math.abs(brickpose.telemetry.twist.v) > 0.01")
    page.keyboard.up("w")
    assert page.url.startswith(f"{jupyter}/brickpose/")
    page.context.close()
