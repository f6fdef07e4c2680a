"""The public front: each name is there, documented, typed, and imported only when asked for."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import brickpose

SOURCE = Path(brickpose.__file__).read_text(encoding="utf-8")
EXAMPLE = 310
"""Most modules of ours that README's example loads; fewer are better."""


def typed():
    """Where type checkers find each name."""
    (block,) = (node for node in ast.parse(SOURCE).body if isinstance(node, ast.If))
    return {name.name: node.module for node in block.body for name in node.names}


def test_type_checkers_and_programs_find_the_same():
    assert typed() == brickpose._HOMES
    assert sorted(brickpose.__all__) == sorted(brickpose._HOMES)
    assert dir(brickpose) == sorted(brickpose.__all__)


@pytest.mark.parametrize("name", brickpose.__all__)
def test_a_name_is_there_and_says_what_it_is(name):
    value = getattr(brickpose, name)
    assert isinstance(value, Path) or len(value.__doc__) > 15


def test_a_name_that_is_not_there_is_told_with_those_that_are():
    with pytest.raises(AttributeError, match=r"no 'Filtre'; it has MAPS, .*Filter"):
        _ = brickpose.Filtre


def test_the_front_alone_loads_nothing_else():
    script = "import sys, brickpose; print(*(m for m in sys.modules if m in ('app', 'numpy')))"
    done = subprocess.run(
        [sys.executable, "-c", script], check=True, capture_output=True, text=True, timeout=60
    )
    assert done.stdout == "\n"


def test_the_readmes_example_loads_little_of_the_program():
    script = (
        "import sys; from brickpose import Config, FigureEightCommand, build_program\n"
        "program = build_program(Config(map='stub', seed=1))\n"
        "program.engine.commands.put(FigureEightCommand(type='figure_eight'))\n"
        "program.engine.step()\n"
        "program.robot.close()\n"
        "ours = ('app', 'robot', 'sim', 'brickpose')\n"
        "print(*(name for name in sys.modules if name.split('.')[0] in ours))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], check=True, capture_output=True, text=True, timeout=120
    )
    loaded = done.stdout.split()
    assert len(loaded) <= EXAMPLE
    assert "app.page.server" not in loaded
