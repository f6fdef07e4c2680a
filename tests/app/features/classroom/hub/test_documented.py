"""What docs/classroom.md says to a university's hub: the hub's own classes take it."""

from __future__ import annotations

import re
from unittest.mock import MagicMock

import yaml
from classes import needs_hub

from app.command_line import parse
from app.settings.config import DOCS

pytestmark = needs_hub
TEXT = (DOCS / "classroom.md").read_text(encoding="utf-8")
DOCKERFILE = DOCS.parent / "Dockerfile"
OF_CHART = {"cmd": "cmd", "defaultUrl": "default_url"}
"""Values of Zero to JupyterHub that it passes on to the spawner as they are."""


def written(language: str) -> list[str]:
    university = TEXT[TEXT.index("## On a university's hub") :]
    return re.findall(rf"```{language}\n(.*?)```", university, re.DOTALL)


def spawner_of(config):
    from jupyterhub.spawner import Spawner

    hub = MagicMock()
    return Spawner(config=config, orm_spawner=MagicMock(server=None), hub=hub)


def test_the_lines_for_any_hub_are_those_of_a_spawner():
    from traitlets.config import Config

    [text] = written("python")
    c = Config()
    exec(compile(text, "jupyterhub_config.py", "exec"), {"c": c})
    assert spawner_of(c).cmd == ["brickpose", "single-user"]
    assert parse(c.Spawner.cmd[1:]).command


def test_the_values_for_kubernetes_suit_spawner_image_and_limits():
    from traitlets.config import Config

    [text] = written("yaml")
    values = yaml.safe_load(text)
    single = values["singleuser"]
    c = Config({"Spawner": {ours: single[theirs] for theirs, ours in OF_CHART.items()}})
    c.Spawner.mem_limit = single["memory"]["limit"]
    c.Spawner.mem_guarantee = single["memory"]["guarantee"]
    c.Spawner.cpu_limit = float(single["cpu"]["limit"])
    spawner = spawner_of(c)
    assert spawner.mem_limit == 1500 << 20
    assert spawner.mem_guarantee < spawner.mem_limit
    # The image's own entry point comes before the command.
    image = DOCKERFILE.read_text(encoding="utf-8")
    assert re.search(r'^ENTRYPOINT \["brickpose"\]$', image, re.MULTILINE)
    assert parse(spawner.cmd).command
    assert f"--uid {single['uid']} " in image
    home = single["storage"]["homeMountPath"]
    assert f"WORKDIR {home}\n" in image
    cache = re.search(r"NUMBA_CACHE_DIR=(\S+)", image)[1]
    assert not cache.startswith(home), "the volume would hide what the image has compiled"
    assert values["cull"]["timeout"] > 0
