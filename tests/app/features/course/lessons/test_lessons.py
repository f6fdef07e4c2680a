"""Lessons: complete in each language, short, and what is written in them drives the robot."""

from __future__ import annotations

import ast
import json
import re
from html import unescape

import numpy as np
import pytest
from course.solutions import ARRAYS

from app.engine.build import build_program
from app.engine.commands import parse
from app.features.course.lesson import LESSONS, lesson_of, lessons, starting_file
from app.features.course.lesson_text import parsed, rendered
from app.languages.catalogue import languages
from app.messages.driving_commands import FigureEightCommand
from app.settings.config import MAPS, Config, with_settings
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.settings import SettingError
from sim.simulated import PERIOD

MOST_LINES, MOST_IN_ALL = 12, 80
ALL = lessons()
COMMAND = re.compile(r'data-command="([^"]*)"')


@pytest.mark.parametrize("lesson", ALL, ids=lambda lesson: lesson.folder.name)
def test_a_lesson_says_the_same_in_each_language(lesson):
    texts = [parsed((lesson.folder / f"{code}.md").read_text()) for code in languages()]
    assert all(text.title for text in texts)
    for text in texts:
        assert len(text.sections) == len(texts[0].sections) == 5
        assert len(text.sections[0].choices) == len(texts[0].sections[0].choices) >= 3
        for one, other in zip(text.sections, texts[0].sections, strict=True):
            assert COMMAND.findall(one.html) == COMMAND.findall(other.html)


@pytest.mark.parametrize("lesson", ALL, ids=lambda lesson: lesson.folder.name)
def test_the_buttons_of_a_lesson_are_commands(lesson):
    for section in parsed(lesson.text("en")).sections:
        for command in map(unescape, COMMAND.findall(section.html)):
            assert json.loads(command)["type"] == "back_to_start" or parse(command)


def test_functions_are_short():
    wanted = {name for lesson in ALL if lesson.number <= 8 for name in lesson.checks.functions}
    lines = {
        item.name: sum(1 for line in ast.unparse(item).splitlines() if line.strip()) - 1
        for item in ast.parse(ARRAYS).body
        if isinstance(item, ast.FunctionDef) and item.name in wanted
    }
    assert set(lines) == wanted
    assert max(lines.values()) <= MOST_LINES
    assert sum(lines.values()) <= MOST_IN_ALL


def test_links_of_a_lesson_lead_nowhere_else():
    assert "href" not in rendered("[x](javascript:alert)")
    assert "<script>" not in rendered("<script>x</script>")
    assert json.loads(
        unescape(COMMAND.findall(rendered("[x](do:set_parameters?alpha1=0.2)"))[0])
    ) == {
        "type": "set_parameters",
        "values": {"alpha1": 0.2},
    }


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["sensor", "motion"])
def test_the_students_file_follows_the_robot(tmp_path, kind):
    """From a start known to 20 mm: the students' field does not tell the tape's two edges apart.

    They are 50 mm apart, so that a start that may be wrong by more fits the wrong edge in one drive
    of five.
    """
    file = tmp_path / "my_filter.py"
    file.write_text(starting_file(ALL).partition("def odometry")[0] + ARRAYS + given())
    model = f"{file}:My{kind.capitalize()}"
    config = with_settings(
        Config(robot="kinematic", map="square", **{f"{kind}_model": model}),
        {"localization.filter.initial_sd_xy": 0.02, "localization.filter.initial_sd_theta": 0.05},
    )
    program = build_program(config)
    shown = []
    for _ in range(round(8 / PERIOD)):
        program.engine.commands.put(FigureEightCommand(type="figure_eight"))
        shown.append(program.engine.step())
    assert {one.filter.fault for one in shown} == {None}
    errors = [one.pose.distance_to(one.truth) for one in shown if one.stamp > 2]
    assert np.mean(errors) < 0.01
    assert max(errors) < 0.03


def given() -> str:
    return "\n\n" + (LESSONS / "dashboard.py").read_text()


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_dashboard_can_show_each_situation(seed):
    field = load_field("square", MAPS)
    shown = [
        lesson.checks.situation(case)
        for lesson in ALL
        if lesson.checks.situation is not None
        for case in lesson.checks.cases(seed)
    ]
    assert len(shown) > 40
    for situation in shown:
        for name in {"", "guess_"} & {key.removesuffix("x") for key in situation}:
            pose = Pose2(situation[f"{name}x"], situation[f"{name}y"], situation[f"{name}theta"])
            xmin, ymin, xmax, ymax = field.drive_area
            assert xmin < pose.x < xmax
            assert ymin < pose.y < ymax


def test_a_teachers_lesson_is_a_folder(tmp_path):
    folder = tmp_path / "12_my_own"
    folder.mkdir()
    (folder / "en.md").write_text("# Why?\n\n## Predict\n\n- a\n- b\n")
    known = [lesson.number for lesson in lessons(tmp_path)]
    assert known[-1] == 12
    lesson = lesson_of(12, tmp_path)
    assert parsed(lesson.text("de")).sections[0].choices == ("a", "b")
    with pytest.raises(SettingError, match="no checks"):
        _ = lesson.checks
    (folder / "checks.py").write_text("CHECKS = 3\n")
    with pytest.raises(SettingError, match="no CHECKS"):
        _ = lesson_of(12, tmp_path).checks
