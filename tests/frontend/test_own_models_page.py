"""The examples of docs/own_models.md, as they stand there."""

import numpy as np
import pytest
from own_model_examples import EXAMPLES, PAGE

from app.engine.build import build_program
from app.features.own_models.model_file import ModelFile, build, load
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import Config
from sim.simulated import PERIOD

EIGHT = FigureEightCommand(type="figure_eight")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mine")
    for name, text in EXAMPLES.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def test_all_examples_are_found():
    assert sorted(EXAMPLES) == ["my_model.py", "my_motion.py"]
    assert PAGE.count("```python") == 2


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_an_example_is_short(name):
    lines = [line for line in EXAMPLES[name].splitlines() if line.strip()]
    assert len(lines) <= 15
    assert max(map(len, lines)) <= 100


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sensor", "motion"])
def test_the_example_finds_the_robot(files, kind):
    name = {"sensor": "my_model.py:MyModel", "motion": "my_motion.py:MyMotion"}[kind]
    program = build_program(Config(robot="kinematic", **{f"{kind}_model": f"{files}/{name}"}))
    shown = []
    for _ in range(round(8 / PERIOD)):
        program.engine.commands.put(EIGHT)
        shown.append(program.engine.step())
    assert {one.filter.fault for one in shown} == {None}
    errors = [one.pose.distance_to(one.truth) for one in shown if one.stamp > 2]
    assert np.mean(errors) < 0.005
    assert max(errors) < 0.02


def test_the_sensor_example_prefers_the_true_pose(files):
    program = build_program(Config(robot="kinematic"))
    for _ in range(20):
        shown = program.engine.step()
    model = ModelFile(files / "my_model.py", "MyModel")
    mine = build(model, load(model), {"field": program.field})
    truth = shown.truth.to_array()
    offsets = np.array([[0, 0, 0], [0.02, 0, 0], [0, 0, 0.1], [0.1, 0.2, 2.0]])
    weights = mine.log_likelihood(truth + offsets, shown.filter.line_scan.scan)
    assert weights.argmax() == 0
    assert weights.shape == (4,)
