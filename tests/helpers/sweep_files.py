"""Sweep files for tests."""

import textwrap

KINEMATIC = """
    [sweep]
    seeds = 2
    worlds = ["kinematic"]

    [settings]
    localization.sensor.sigma_hit = [0.003, 5.0]
    localization.filter.min_particles = [100, 200]
"""


def write(tmp_path, text):
    path = tmp_path / "trial.toml"
    path.write_text(textwrap.dedent(text))
    return path
