"""Sweep files for tests."""

import textwrap


def write(tmp_path, text):
    path = tmp_path / "trial.toml"
    path.write_text(textwrap.dedent(text))
    return path
