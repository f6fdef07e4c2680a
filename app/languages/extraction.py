"""Finds every text for people in the code: in Python, JavaScript and HTML."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from app.languages.docstrings import texts_of_docstrings
from app.languages.markup import translated
from app.languages.python_texts import texts_of_module
from app.languages.script_texts import texts_of_script

ROOT = Path(__file__).parents[2]
Text = str | tuple[str, str]
"""A text, or its singular and plural."""

TELLING = (
    "app/features/course/sandbox/student_process.py", "app/engine", "app/messages/commands.py",
    "app/messages/message.py", "app/page",
    "app/features/calibration", "app/features/field_editor", "app/features/kept_pose",
    "app/features/mapping", "app/features/navigation",
    "app/features/own_models",
    "app/features/recordings", "app/features/weighing",
    "app/result_files.py", "app/settings/conditions.py", "app/settings/faults.py",
    "app/settings/field_names.py", "robot/calibration", "robot/description/profile.py",
    "robot/description/unknowns.py", "robot/description/lens_table.py", "robot/cameras",
    "robot/fields", "robot/hat", "robot/interface.py", "robot/localization", "robot/mapping",
    "robot/navigation/planning.py", "robot/settings.py", "robot/toml_file.py",
    "sim/floor_camera.py", "sim/imperfections.py",
)  # fmt: skip
"""Where errors and settings come from that the page shows: what they say are texts."""
SPEAKING = (
    "app/engine/driver.py", "app/engine/drivers.py", "app/features/classroom/warm/watch.py",
    "app/features/mapping/drawing_work.py", "app/features/misplaced_tape/laid_watch.py",
    "app/features/misplaced_tape/watch.py",
    "app/features/course/grader/causes/", "app/features/course/grader/forms.py",
    "app/features/course/grading.py", "app/features/course/lessons/",
    "app/features/course/sandbox/audit.py", "app/features/own_models/own_models.py",
    "app/features/weighing/ray_profile.py", "app/features/recordings/files/file_kinds.py",
    "app/features/recordings/files/mcap_reader.py", "app/features/recordings/recorder.py",
    "app/features/recordings/replay/opening.py", "app/features/recordings/replay/position.py",
    "app/features/recordings/replay/recorded_robot.py",
    "app/features/recordings/replay/requests.py",
    "robot/calibration/calibrate.py", "robot/calibration/lens/coverage.py",
    "robot/calibration/lens/charuco.py", "robot/calibration/lens/chessboard.py",
    "robot/calibration/lens/guide.py", "robot/calibration/lens/lens_calibration.py",
    "robot/cameras/choice.py", "robot/cameras/files.py",
    "robot/cameras/grabber.py", "robot/fields/drawing/question.py", "robot/hat/board.py",
    "robot/hat/motor.py", "robot/navigation/looking_around.py",
    "robot/calibration/model_check.py", "robot/calibration/tracker.py",
    "robot/hat/start/troubles.py", "robot/hat/start/upload.py",
    "robot/localization/estimate.py", "robot/localization/monitoring/causes.py",
    "robot/estimation/fit_quality.py", "robot/mapping/pushed.py", "robot/mapping/tape_map.py",
    "robot/navigation/line_follower.py", "robot/navigation/lookout.py",
    "robot/navigation/arrival.py", "robot/navigation/navigator.py",
    "robot/navigation/next_way.py", "robot/navigation/planning.py", "robot/settings.py",
)  # fmt: skip
"""Modules and folders in which every sentence is a text, but their documentation."""
LESSONS = "app/features/course/lessons"
"""Where each lesson has a folder ``<number>_<name>``; the docstrings of its stub are texts."""
SILENT = (
    "app/languages", "app/features/help", "app/features/recordings/remote_robot.py",
    "robot/calibration/mounting", "robot/hat/settings.py",
    "robot/hat/start/firmware_image.py", "robot/hat/start/reset_line.py",
)  # fmt: skip
"""Modules that speak to whoever starts the program, not to the page."""


PYDANTICS = (
    "Extra inputs are not permitted",
    "Field required",
    "Input should be a finite number",
    "Input should be a valid boolean",
    "Input should be a valid dictionary",
    "Input should be a valid integer",
    "Input should be a valid list",
    "Input should be a valid number",
    "Input should be a valid string",
    "Input should be greater than or equal to {ge}",
    "Input should be greater than {gt}",
    "Input should be less than or equal to {le}",
    "Input should be less than {lt}",
    "Input should be {expected}",
    "Invalid JSON: {error}",
    "List should have at least {min_length} item after validation, not {actual_length}",
    "List should have at least {min_length} items after validation, not {actual_length}",
    "List should have at most {max_length} item after validation, not {actual_length}",
    "List should have at most {max_length} items after validation, not {actual_length}",
    "String should have at most {max_length} characters",
    "Unable to extract tag using discriminator 'type'",
    "Value error, {error}",
)
"""What pydantic says of messages that it refuses."""


def texts(root: Path = ROOT) -> set[Text]:
    """Return all of them."""
    ours = {*_in_pages(root), *_in_scripts(root), *_in_python(root), *_in_lessons(root)}
    return ours | set(PYDANTICS)


def _in_pages(root: Path) -> Iterator[Text]:
    for path in sorted((root / "frontend").rglob("*.html")):
        yield from texts_of_page(path.read_text(encoding="utf-8"))


def _in_scripts(root: Path) -> Iterator[Text]:
    for path in sorted((root / "frontend").rglob("*.js")):
        yield from texts_of_script(path.read_text(encoding="utf-8"))


def _in_python(root: Path) -> Iterator[Text]:
    for room in ("app", "robot", "sim"):
        for path in sorted((root / room).rglob("*.py")):
            way = path.relative_to(root).as_posix()
            if not way.startswith(SILENT):
                yield from texts_of_module(path, way.startswith(TELLING), way.startswith(SPEAKING))


def _in_lessons(root: Path) -> Iterator[Text]:
    for path in sorted((root / LESSONS).glob("*/stub.py")):
        yield path.parent.name.partition("_")[2].replace("_", " ")
        yield from texts_of_docstrings(path)
    yield from texts_of_docstrings(root / LESSONS / "dashboard.py")


def texts_of_page(page: str) -> list[str]:
    """Return the texts of a page in their order."""
    texts: list[str] = []

    def kept(text: str) -> str:
        texts.append(text)
        return text

    translated(page, kept)
    return texts
