"""A sensor model of one's own is tried at known poses before it is used; its faults are traced."""

from __future__ import annotations

import json
from pathlib import Path
from urllib.request import urlopen

import pytest
from browsing import opened
from nonsense_models import GOOD, NONSENSE
from own_model_examples import EXAMPLES
from playwright.sync_api import expect
from serving import serving, until

from app.features.own_models.guards import OwnSensor
from app.features.own_models.model_file import ModelFile, build, load
from app.features.own_models.own_models import OwnModels
from app.features.own_models.trial import LONGEST_S, doubt_of
from app.settings.config import MAPS
from robot.fields.field_loading import load_field
from robot.localization.parameters import LocalizationParameters

pytestmark = pytest.mark.slow

FIELDS = {name: load_field(name, MAPS) for name in ("square", "stub", "town", "tee")}
MORE_NONSENSE = {
    "the mean for the sum": (
        "    def answer(self, log_likelihood):\n        return log_likelihood / 30\n"
    ),
    "x and y exchanged": "",
}
CLASS = "\n\nclass Nonsense(Model):\n    pass\n"


def source(kind: str) -> str:
    text = GOOD if kind != "x and y exchanged" else GOOD.replace("[::5].T", "[::5].T[::-1]")
    return text + CLASS + (NONSENSE | MORE_NONSENSE)[kind]


def sensor_of(path: Path, name: str, field: str) -> OwnSensor:
    file, known = ModelFile(path, name), FIELDS[field]
    return OwnSensor(file, build(file, load(file), {"field": known, "edges": known.edges}))


@pytest.fixture(autouse=True)
def in_time(monkeypatch):
    """What is compiled first, and a busy machine, end no trial early here."""
    monkeypatch.setattr("app.features.own_models.trial.LONGEST_S", 60.0)


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("kind", [*NONSENSE, *MORE_NONSENSE])
def test_a_bad_model_is_told_before_the_robot_drives(save, kind, field) -> None:
    doubt = doubt_of(sensor_of(save(source(kind)), "Nonsense", field), FIELDS[field])
    assert doubt is not None and "beside the true one" in doubt


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize(("text", "name"), [(GOOD, "Model"), (EXAMPLES["my_model.py"], "MyModel")])
def test_a_good_model_is_not_doubted(save, text, name, field) -> None:
    assert doubt_of(sensor_of(save(text), name, field), FIELDS[field]) is None


def test_a_slow_model_is_not_asked_for_long(save, monkeypatch) -> None:
    monkeypatch.setattr("app.features.own_models.trial.LONGEST_S", LONGEST_S)
    path = save("""
        import time
        import numpy as np

        class Slow:
            calls = 0

            def log_likelihood(self, poses, scan):
                Slow.calls += 1
                time.sleep(0.15)
                return np.zeros(len(poses))
    """)
    sensor = sensor_of(path, "Slow", "square")
    assert doubt_of(sensor, FIELDS["square"]) is not None
    assert sensor.guard._method.__self__.calls <= 2


def test_a_mended_model_is_doubted_no_more(save) -> None:
    parameters = LocalizationParameters()
    path = save(source("a constant"))
    own = OwnModels(FIELDS["square"], sensor=f"{path}:Nonsense")
    own.make(parameters, fresh=True)
    assert own.fault is None
    doubt = own.problems["doubtful models"]
    assert doubt is not None and doubt.startswith("mine.py:Nonsense: In ")
    save(GOOD + CLASS)
    own.make(parameters, fresh=True)
    assert own.problems["doubtful models"] is None


def test_a_fault_is_traced_from_the_users_file_on(save) -> None:
    path = save("""
        import numpy as np

        class Broken:
            def log_likelihood(self, poses, scan):
                return self.sum_of(poses)

            def sum_of(self, poses):
                return np.zeros(len(poses)) @ poses.point
    """)
    own = OwnModels(FIELDS["square"], sensor=f"{path}:Broken")
    own.make(LocalizationParameters(), fresh=True)
    assert own.fault is not None and own.fault.startswith("mine.py line 9: AttributeError")
    first, call, second, line, error = own.trace.splitlines()
    assert (first, second) == ("mine.py line 6, in log_likelihood", "mine.py line 9, in sum_of")
    assert call.strip() == "return self.sum_of(poses)"
    assert line.strip() == "return np.zeros(len(poses)) @ poses.point"
    assert error.startswith("AttributeError")


@pytest.mark.browser
def test_the_page_shows_the_calls_on_demand(browser, save) -> None:
    broken = (
        GOOD
        + "\n\nclass Nonsense(Model):\n    def answer(self, one):\n        return one.least()\n"
    )
    path = save(broken)
    options = ("--robot", "kinematic", "--map", "square", "--sensor-model", f"{path}:Nonsense")
    with serving(*options) as server:
        for page in opened(browser, server, width=1100, height=720, view=False):
            expect(page.locator("#banner")).to_contain_text("AttributeError")
            page.locator("#problems").click()
            calls = page.locator("#problems-items .trace")
            calls.locator("summary").click()
            expect(calls.locator("pre")).to_contain_text("return one.least()")
            save(source("a constant"))
            expect(page.locator("#banner")).to_contain_text("mine.py:Nonsense: In ")
            with urlopen(f"{server.url}/api/problems") as answer:
                assert json.load(answer)["trace"] == ""
            save(GOOD + CLASS)
            with server.live() as live:
                until(live, lambda now: "beside the true one" not in " ".join(now["problems"]))
