"""The grader: the right cause of each mistake, no word about correct code, the same each time."""

from __future__ import annotations

import json
from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest
from course.correct import CORRECT
from course.mistakes import CODES, WRITINGS, pairs, written
from course.slips import SLIPS
from course.solutions import ARRAYS, BASES
from grader_trials import mutants

from app.command_line import main
from app.features.course.grader.causes.causes import CAUSES
from app.features.course.grading import grade, grade_often
from app.features.course.lesson import lesson_of, lessons
from app.features.course.reports import as_gradescope, as_json, as_junit
from app.features.course.source import read_source
from app.languages.catalogue import catalogue
from robot.settings import SettingError

ENGLISH = catalogue("en")


def test_all_causes_that_lessons_name_have_words():
    named = {item.cause for lesson in lessons() for item in lesson.checks.hypotheses}
    assert named <= set(CAUSES)
    assert set(CODES) <= set(CAUSES)
    assert len(CODES) == 22


@pytest.mark.parametrize(
    "number",
    [pytest.param(n, marks=pytest.mark.slow) if n == 4 else n for n in range(1, 11)],
)
def test_what_mistakes_give_in_each_case_can_be_said(number):
    """A student's program may be anything, so that any mistakes may have to explain any case."""
    checks = lesson_of(number).checks
    cases = checks.cases(1)
    thoughts = [(one,) for one in checks.hypotheses]
    if number == 8:  # where one mistake's numbers are another's
        thoughts += combinations(checks.hypotheses, 2)
    for thought in thoughts:
        for case in cases:
            given = checks.expected(case, frozenset(one.mistake for one in thought))
            assert np.asarray(given).ndim >= 1


@pytest.mark.slow
@pytest.mark.parametrize("code", CODES)
def test_a_mistake_is_named(code):
    # One writing each, by turns; `grader_trials.py bugs` tries all, 20 seeds each.
    trials = [writing for writing in WRITINGS if writing.code == code]
    writing = trials[CODES.index(code) % len(trials)]
    result = grade(writing.source, "mine.py", lesson_of(writing.lesson))
    assert [finding.cause for finding in result.findings][:1] == [code]
    finding = result.findings[0].to_json()
    assert all(finding[key] for key in ("symptom", "case", "seems", "next", "link"))


@pytest.mark.slow
@pytest.mark.parametrize(("cause", "number", "changes"), SLIPS)
def test_a_beginners_slip_is_named(cause, number, changes):
    result = grade(written("arrays", tuple(changes)), "mine.py", lesson_of(number))
    assert [finding.cause for finding in result.findings][:1] == [cause]


@pytest.mark.slow
@pytest.mark.parametrize("number", range(1, 9))
def test_nothing_is_said_about_correct_code(number):
    styles = list(CORRECT.items())
    for style, source in (styles[number % 3], styles[number % 10]):
        assert grade(source, f"{style}.py", lesson_of(number)).passed, style


def test_one_of_two_mistakes_is_named():
    for first, second, number, source in pairs()[::25]:
        (result,) = grade_often(source, "mine.py", lesson_of(number), (3,))
        assert {first, second} & {finding.cause for finding in result.findings}


@pytest.mark.slow
def test_changed_operators_and_numbers_are_found():
    # `grader_trials.py mutants` tries all of them.
    number_of = {name: item for item in lessons() for name in item.checks.functions}
    tried = [item for item in mutants(BASES["matrices"]) if item[0] in number_of][::40]
    survivors = [
        (function, words)
        for function, words, source in tried
        if grade(source, "mine.py", number_of[function]).passed
    ]
    assert len(survivors) <= len(tried) // 10, survivors


def test_grading_again_gives_the_same_bytes():
    writing = WRITINGS[3]
    told = [
        json.dumps(as_json([grade(writing.source, "mine.py", lesson_of(writing.lesson))], ENGLISH))
        for _ in range(2)
    ]
    assert told[0] == told[1]
    assert "<svg" in json.loads(told[0])["findings"][0]["picture"]


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("def odometry(:", "SyntaxError"),
        ("odometry = 3", "there is no function odometry"),
        ("def odometry(pose, left): return pose", "TypeError"),
        ("def odometry(pose, left, right, track):\n    return wheel", "line 2: NameError"),
        ("def odometry(pose, left, right, track):\n    x = 3", "None"),
        ("def odometry(pose, left, right, track): return pose[:2] * 1", "shape (2,); (3,) is due"),
        ("def odometry(pose, left, right, track): return [0, 0, float('nan')]", "nan"),
        ("def odometry(pose, left, right, track): return 'here'", "str"),
        ("\x00", "null bytes"),
    ],
)
def test_what_gives_no_result_is_told_with_its_reason(source, words):
    (finding,) = grade(source, "mine.py", lesson_of(1)).findings
    assert words in finding.case.say()


def test_arrays_that_were_given_stay_as_they_are():
    source = ARRAYS.replace(
        "    off = poses - best\n",
        "    off = poses - best\n    poses += 0.0\n    poses *= 1.5\n    poses /= 1.0\n",
    )
    findings = grade(source, "mine.py", lesson_of(7)).findings
    assert "altered" in [finding.cause for finding in findings]


def test_stubs_are_not_begun():
    source = "".join(lesson.stub() for lesson in lessons())
    for lesson in lessons():
        result = grade(source, "mine.py", lesson)
        assert not result.started
        assert not result.findings


def test_the_command_tells_and_writes(tmp_path, capsys):
    file = tmp_path / "mine.py"
    file.write_text(WRITINGS[3].source)
    files = ["--junit", str(tmp_path / "j.xml"), "--gradescope", str(tmp_path / "g.json")]
    assert main(["check", str(file), "--lesson", "1", "--json", *files]) == 1
    told = json.loads(capsys.readouterr().out)
    assert not told["passed"]
    assert told["findings"][0]["cause"] == WRITINGS[3].code
    suite = ElementTree.parse(tmp_path / "j.xml").getroot()
    assert suite.get("failures") == "1"
    assert json.loads((tmp_path / "g.json").read_text())["tests"][0]["score"] == 0
    file.write_text(ARRAYS)
    assert main(["check", str(file), "--lesson", "1"]) == 0
    assert "passed" in capsys.readouterr().out


def test_wrong_arguments_say_what_is_valid(tmp_path, capsys):
    file = tmp_path / "mine.py"
    assert main(["check", str(file)]) == 2
    assert "cannot be read" in capsys.readouterr().err
    file.write_text(ARRAYS)
    assert main(["check", str(file), "--lesson", "77"]) == 2
    assert "valid are 1, 2" in capsys.readouterr().err
    file.write_bytes(b"#" * 300_000)
    with pytest.raises(SettingError, match="valid are up to"):
        read_source(file)


def test_reports_hold_any_words():
    result = grade("def odometry(*a): raise ValueError('\\x00<&>\\ud800')", "m.py", lesson_of(1))
    assert ElementTree.fromstring(as_junit([result], ENGLISH).partition("?>")[2]) is not None
    assert json.loads(as_gradescope([result], ENGLISH))


BEGINNERS = [
    (
        "no-return", 3,
        ("seen = np.isfinite(ranges)", "seen = ranges > 0"),
    ),
    ("sum", 3, ("np.log(0.95 * fit + 0.05).sum", "(0.95 * fit + 0.05).sum")),
    ("motion-lost", 6, ("poses = parts.motion(poses, moved)", "parts.motion(poses, moved)")),
    (
        "order", 6,
        ("    poses = parts.motion(poses, moved)\n", ""),
        ("scan)\n", "scan)\n    poses = parts.motion(poses, moved)\n"),
    ),
]  # fmt: skip


@pytest.mark.parametrize(("code", "number", "changes"), [(c, n, w) for c, n, *w in BEGINNERS])
def test_what_a_beginner_did_is_named(code, number, changes):
    result = grade(written("arrays", tuple(changes)), "my_filter.py", lesson_of(number))
    assert [finding.cause for finding in result.findings] == [code]


KALMAN = """
def kalman(mean, sd, moved, moved_sd, seen, seen_sd):
    mean, variance = mean + moved, sd**2 + moved_sd**2
    k = variance / (variance + seen_sd**2)
    return mean + k * (seen - mean), ((1 - k) * variance) ** 0.5
"""


@pytest.mark.parametrize(
    ("cause", "changes"),
    [
        ("step-late", ("k = variance / (variance", "k = sd**2 / (sd**2")),
        ("step-late", ("((1 - k) * variance)", "((1 - k) * sd**2)")),
        ("step-sure", ("sd**2 + moved_sd**2", "sd**2")),
    ],
)
def test_a_variance_that_comes_late_is_not_one_that_is_missing(cause, changes):
    assert KALMAN.count(changes[0]) == 1
    (finding,) = grade(KALMAN.replace(*changes), "mine.py", lesson_of(9)).findings
    assert finding.cause == cause


@pytest.mark.parametrize(
    ("number", "changes", "cause"),
    [
        (
            5,
            ("return poses[drawn]", "return poses[drawn] + rng.normal(0, 0.01, (n, 3))"),
            "invented",
        ),
        (
            8,
            ("rng.random(len(poses)) < share", "np.full(len(poses), rng.random() < share)"),
            "all-new",
        ),
    ],
)
def test_what_follows_from_a_mistake_is_not_named_beside_it(number, changes, cause):
    assert ARRAYS.count(changes[0]) == 1
    findings = grade(ARRAYS.replace(*changes), "mine.py", lesson_of(number)).findings
    assert [finding.cause for finding in findings] == [cause]


def test_a_result_that_cannot_be_used_is_told_by_its_line_where_one_change_mends_it():
    source = BASES["loops"].replace(
        "    return weights\n\ndef motion", "        return weights\n\ndef motion"
    )
    assert source != BASES["loops"]
    (finding,) = grade(source, "mine.py", lesson_of(3)).findings
    lines = source.splitlines()
    assert (finding.cause, lines[finding.line - 1]) == ("slip-order", "        return weights")
    assert "(4,)" in finding.case.say(ENGLISH)


def test_a_result_that_no_change_makes_usable_is_told_by_its_form():
    source = "def resample(poses, weights, rng):\n    drawn = poses[0]\n"
    (finding,) = grade(source, "mine.py", lesson_of(5)).findings
    assert finding.cause == "form"
    assert "None" in finding.case.say(ENGLISH)


def test_a_slip_of_several_lines_is_told_with_all_of_them():
    source = BASES["arrays"] + (
        "def inject(poses, fit, memory, anywhere, rng):\n"
        "    memory.slow += 0.05 * fit - memory.slow\n"
        "    memory.fast += 0.5 * fit - memory.fast\n"
        "    share = max(0.0, 1 - memory.fast / memory.slow)\n"
        "    return np.array([anywhere(1)[0] if rng.random() < share else p for p in poses])\n"
    )
    (finding, *_) = grade(source, "mine.py", lesson_of(8)).findings
    first = source.splitlines().index("    memory.slow += 0.05 * fit - memory.slow") + 1
    assert (finding.cause, finding.line) == ("slip-brackets", first)
    assert f"Lines {first} and {first + 1} are where it happens" in finding.case.say(ENGLISH)


def test_a_division_by_nothing_is_no_result_of_another_form():
    source = BASES["arrays"] + (
        "def odometry(pose, left, right, track):\n"
        "    turn = np.float64(right - left) / track\n"
        "    radius = (left + right) / 2 / turn\n"
        "    x = pose[0] + radius * (np.sin(pose[2] + turn) - np.sin(pose[2]))\n"
        "    y = pose[1] - radius * (np.cos(pose[2] + turn) - np.cos(pose[2]))\n"
        "    return x, y, (pose[2] + turn + np.pi) % (2 * np.pi) - np.pi\n"
    )
    (finding, *_) = grade(source, "mine.py", lesson_of(1)).findings
    assert finding.cause == "no-number"
    assert "nan" in finding.case.say(ENGLISH)


def test_what_a_draw_is_given_sums_to_one():
    source = ARRAYS.replace("parts.resample(poses, weights)", "parts.resample(poses, 2 * weights)")
    assert source != ARRAYS
    findings = grade(source, "mine.py", lesson_of(6)).findings
    assert not {finding.cause for finding in findings} & {"threshold", "after-drawing"}
    assert findings
