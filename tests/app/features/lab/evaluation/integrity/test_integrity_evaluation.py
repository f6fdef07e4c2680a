"""``brickpose evaluate integrity``, from drives to the folder of results."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from app.command_line import main
from app.features.lab.evaluation.drives import EvaluationError
from app.features.lab.evaluation.integrity.claims import follow_claims
from app.features.lab.evaluation.integrity.command import evaluate_integrity
from app.features.lab.evaluation.integrity.drives import RADII, course_on, lap_drive
from app.features.lab.evaluation.integrity.experiment import IntegrityExperiment
from app.features.lab.evaluation.integrity.measures import measures, right
from app.features.lab.evaluation.integrity.oracle import decided_stamp, field_decides
from app.settings.config import MAPS, Config
from robot.driving.figure_eight import FigureEight
from robot.fields.field_loading import load_field
from robot.settings import SettingError

pytestmark = pytest.mark.slow

FAST = Config(robot="kinematic", figure_eight=FigureEight(speed=0.3))
SMALL = IntegrityExperiment(
    FAST, ("generated-8",), ("default", "noisy"), ("known", "scattered"), 3, 1
)
CONTRACT = {
    *("map", "condition", "start", "seed", "pictures", "right", "sure", "given", "misleading"),
    *("misleading_longest_s", "lost_again", "right_to_the_end", "alarm_while_right"),
    *("time_to_right_s", "ate_rmse_m", "nees_mean", "inside_95"),
}


class Here:
    """Does the jobs in this process."""

    count = 1

    def each(self, work, jobs):
        return ((place, work(job)) for place, job in enumerate(jobs))

    def close(self):
        pass


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("integrity")
    evaluate_integrity(SMALL, Here(), place)
    return place


@pytest.fixture(scope="module")
def stub_lap():
    return lap_drive(replace(FAST, map="stub", seed=2), 0.5)


def test_results_have_the_keys_of_the_contract(folder):
    results = json.loads((folder / "results.json").read_text())
    assert len(results["runs"]) == 4
    for run in results["runs"]:
        assert set(run) >= CONTRACT
        assert run["map"] == "generated-8" and run["seed"] == 3
        assert run["start"] != "known" or run["right"] == 1
    groups = [(one["condition"], one["start"]) for one in results["summary"]["groups"]]
    assert groups == [(c, s) for c in ("default", "noisy") for s in ("known", "scattered")]


def test_each_run_has_a_line_for_each_picture(folder):
    results = json.loads((folder / "results.json").read_text())
    for run in results["runs"]:
        name = f"{run['map']}-{run['condition']}-{run['start']}"
        lines = (folder / "runs" / name / f"{run['seed']}.csv").read_text().splitlines()
        assert len(lines) == run["pictures"] + 1


def test_the_report_stands_alone_and_links_to_runs(folder):
    page = (folder / "report.html").read_text()
    links = re.findall(r'(?:src|href)="(?!data:)([^"]+)"', page)
    assert links and all((folder / link).is_file() for link in links)
    for text in ("Stanford", "noisy", "scattered", "misleading", "prefers-color-scheme: dark"):
        assert text in page


class Tired(Here):
    """As ``Here``, but the first job fails."""

    def each(self, work, jobs):
        for place, job in enumerate(jobs):
            yield place, work(job) if place else ValueError("the\nbattery")


def test_a_drive_that_fails_is_told_and_the_rest_goes_on(tmp_path):
    two = replace(SMALL, starts=("known",))
    results = evaluate_integrity(two, Tired(), tmp_path)
    about = {"map": "generated-8", "condition": "default", "seed": 3, "error": "the battery"}
    assert results["failures"] == [about]
    assert [run["condition"] for run in results["runs"]] == ["noisy"]
    assert "the battery" in (tmp_path / "report.html").read_text()
    with pytest.raises(EvaluationError, match="the battery"):
        evaluate_integrity(replace(two, conditions=("default",)), Tired(), tmp_path)


def test_a_course_fits_its_field_and_is_no_faster_than_the_wheels():
    for name in ("generated-0", "square", "generated-38"):
        field = load_field(name, MAPS)
        course = course_on(field, FAST)
        assert RADII[0] <= course.eight.radius <= RADII[1]
        assert course.eight.speed <= 0.3
        assert course.eight.speed / course.eight.radius <= FAST.drive.max_angular_velocity
        assert field.contains(course.middle)
    assert (
        course_on(load_field("square", MAPS), FAST).middle.distance_to(
            load_field("square", MAPS).start
        )
        < 1e-6
    )


def test_a_drive_is_told_from_its_lookalikes_on_a_marked_field_only(stub_lap):
    assert 0 < field_decides(stub_lap.drive, -1.0) < stub_lap.drive.ticks[-1].stamp
    plain = lap_drive(replace(FAST, map="square", seed=2), 0.3)
    assert field_decides(plain.drive, -1.0) == np.inf


def test_a_known_start_decides_at_once_and_a_scattered_one_later(stub_lap):
    config = replace(FAST, map="stub", seed=2)
    known, scattered = (follow_claims(stub_lap, config, s) for s in ("known", "scattered"))
    assert decided_stamp(stub_lap, known, config, "known") == known.stamps[0]
    assert decided_stamp(stub_lap, scattered, config, "scattered") > scattered.stamps[0]
    assert measures(known)["right"] == 1
    assert not right(scattered)[0]


def test_a_robot_that_believes_in_another_field_does_not_fit(stub_lap):
    other = replace(stub_lap, drive=replace(stub_lap.drive, field=load_field("town", MAPS)))
    claims = follow_claims(other, replace(FAST, seed=2), "known")
    assert measures(claims)["right"] < 0.9


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"conditions": ("wet",)}, "no condition 'wet'; valid are default, noisy"),
        ({"starts": ("blind",)}, "no start 'blind'; valid are known, told-wrong, told-quarter"),
        ({"seeds": 0}, "seeds is 0; valid is 1 or more"),
        ({"first_seed": -1}, "first seed is -1"),
        ({"maps": ("square", str(MAPS / "square.svg"))}, "two maps have one name"),
    ],
)
def test_what_cannot_be_judged_is_refused(wrong, message):
    with pytest.raises(SettingError, match=re.escape(message)):
        replace(SMALL, **wrong)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["integrity", "--condition", "wet"], "no condition 'wet'"),
        (["integrity", "--map", "nowhere"], "there is no field 'nowhere'"),
        (["--offset", "0", "0", "0", "integrity"], "--offset does not go with integrity"),
    ],
)
def test_the_command_line_says_what_is_valid(arguments, message, capsys):
    assert main(["evaluate", *arguments]) == 2
    assert message in capsys.readouterr().err
