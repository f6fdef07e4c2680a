"""A map is drawn while the robot drives: commanded, followed, finished, saved, gone on in."""

from __future__ import annotations

import errno
import math
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn_maps import LAP_S, LONGEST_S, MappingBench
from engine_runs import EIGHT, run

from app.engine.build import build_on_map
from app.features.mapping import map_files
from app.features.mapping.messages import NoMapError
from app.features.mapping.routes import drawing_message, mapping_message
from app.messages.driving_commands import DriveCommand
from app.settings.config import MAPS
from robot.errors import CommandError
from robot.fields.field_loading import load_field
from robot.fields.svg_field import field_of_drawing

pytestmark = pytest.mark.slow


@pytest.fixture
def bench() -> Iterator[MappingBench]:
    made = MappingBench()
    yield made
    made.close()


@pytest.fixture(scope="module")
def mapped() -> Iterator[MappingBench]:
    """A lap of which the map is done."""
    made = MappingBench()
    made.drawer.begin()
    made.drive(LAP_S)
    made.finish()
    yield made
    made.close()


def test_a_lap_becomes_a_map(mapped):
    drawing = mapped.drawer.drawing
    assert drawing.state == "done"
    message = drawing_message(drawing)
    assert len(message.strokes) == 4
    assert message.remarks == []
    assert all(stroke.interval < 0.003 for stroke in message.strokes)
    corners = {tuple(np.sign(point).astype(int)) for s in message.strokes for point in s.points}
    assert len(corners) == 4
    for stroke in message.strokes:
        assert np.abs(stroke.points) == pytest.approx(0.5, abs=0.002)


def test_the_robot_is_where_it_is_in_the_new_map(mapped):
    snapshot = run(mapped.program, 0.5, EIGHT)[-1]
    pose = mapping_message(mapped.drawer.drawing, snapshot).pose
    assert math.dist((pose.x, pose.y), (snapshot.truth.x, snapshot.truth.y)) < 0.003
    assert pose.theta == pytest.approx(snapshot.truth.theta, abs=0.01)


def test_the_robot_goes_on_in_the_saved_map(mapped, tmp_path):
    # The first map of a computer: its folder is not there yet.
    path = mapped.drawer.save("kitchen", tmp_path / "maps")
    assert sorted(file.suffix for file in path.parent.iterdir()) == [".pgm", ".svg", ".yaml"]
    # A switch stops the robot for a second; else the tick that it takes would be lost.
    before = run(mapped.program, 1.0)[-1]
    saved = load_field(str(path), MAPS)
    following = build_on_map(mapped.program, str(path), saved, mapped.drawer.place(before))
    assert following.field.name == "kitchen"
    assert following.robot is mapped.program.robot
    # A recording of it is replayed from there.
    begins = following.config.start_pose
    assert begins.set_initial_pose
    assert begins.initial_pose.pose.distance_to(before.truth) < 0.005
    errors = [
        snapshot.pose.distance_to(snapshot.truth)
        for snapshot in run(following, 4.0, EIGHT)
        if snapshot.pose
    ]
    assert max(errors) < 0.005


def test_a_stroke_that_is_deleted_is_not_in_the_map(mapped, tmp_path):
    drawer, before = mapped.drawer, mapped.drawer.drawing
    with pytest.raises(CommandError, match="valid is 0 to 3"):
        drawer.delete_stroke(4, before.version)
    with pytest.raises(CommandError, match=r"m from where the robot was; valid is up to 2 m"):
        drawer.move_end(0, True, (1000.0, 0.0), before.version)
    drawer.delete_stroke(1, before.version)
    with pytest.raises(CommandError, match="changed meanwhile"):
        drawer.delete_stroke(1, before.version)
    left = drawing_message(drawer.drawing)
    assert [stroke.points for stroke in left.strokes] == [
        stroke.points
        for number, stroke in enumerate(drawing_message(before).strokes)
        if number != 1
    ]
    field = field_of_drawing(drawer.drawing.result.drawing("three sides"), "three")
    assert len(field.edges) < 16
    drawer._shown.now = before


def test_what_is_said_of_a_map_is_of_the_map_as_it_was_changed(mapped):
    drawer, before = mapped.drawer, mapped.drawer.drawing
    drawer.delete_stroke(1, before.version)
    message = drawing_message(drawer.drawing)
    (remark,) = message.remarks
    assert remark.startswith("tape that was seen at")
    share = drawer.drawing.result.share
    assert 0.6 < share < 0.9
    assert f"{100 * share:.0f} % of the edges" in message.facts[1]
    assert message.changes == 1
    # An end that is put 120 mm farther in leaves tape out, and nobody measured where it is.
    drawer.undo_edit(before.version + 1)
    place, other = (np.array(drawing_message(before).strokes[0].points[k]) for k in (0, -1))
    moved = place + 0.12 * (other - place) / np.linalg.norm(other - place)
    drawer.move_end(0, False, tuple(moved), before.version + 2)
    words = drawing_message(drawer.drawing).remarks
    assert any("not in the map any more" in line for line in words)
    assert any("by hand" in line for line in words)
    drawer._shown.now = before


def test_changes_are_taken_back_one_by_one(mapped):
    drawer, before = mapped.drawer, mapped.drawer.drawing
    with pytest.raises(CommandError, match="nothing of the map was changed"):
        drawer.undo_edit(before.version)
    drawer.delete_stroke(1, before.version)
    drawer.delete_stroke(0, before.version + 1)
    for changes in (1, 0):
        drawer.undo_edit(drawer.drawing.version)
        assert drawing_message(drawer.drawing).changes == changes
    assert drawer.drawing.result is before.result
    with pytest.raises(CommandError, match="changed meanwhile"):
        drawer.undo_edit(before.version)
    assert not drawer.drawing.saved
    drawer._shown.now = before


def test_a_finished_map_is_not_lost_before_it_is_saved(mapped, tmp_path):
    drawer, before = mapped.drawer, replace(mapped.drawer.drawing, saved=False)
    drawer._shown.now = before
    for act in (drawer.begin, drawer.explore, drawer.require_none_lost):
        with pytest.raises(CommandError, match="a map is finished; save or discard it first"):
            act()
    drawer.save("kitchen", tmp_path)
    drawer.require_none_lost()
    # What is changed afterwards is in no file.
    drawer.delete_stroke(1, before.version)
    with pytest.raises(CommandError, match="save or discard it first"):
        drawer.require_none_lost()
    drawer._shown.now = before


@pytest.mark.parametrize("name", ["", "../up", "a/b", "x" * 61, ".hidden", "a b"])
def test_a_name_that_is_none_is_refused(mapped, tmp_path, name):
    with pytest.raises(CommandError, match="valid are 60 letters"):
        mapped.drawer.save(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_map_is_never_written_over(mapped, tmp_path):
    (tmp_path / "mine.svg").write_text("a drawing")
    with pytest.raises(CommandError, match="already"):
        mapped.drawer.save("mine", tmp_path)
    assert (tmp_path / "mine.svg").read_text() == "a drawing"


def test_a_map_that_contradicts_itself_is_saved_only_by_force(mapped, tmp_path):
    drawer, before = mapped.drawer, mapped.drawer.drawing
    doubted = replace(before.result.quality, converged=False)
    drawer._shown.now = replace(before, result=replace(before.result, quality=doubted))
    with pytest.raises(CommandError, match=r"contradicts itself.*did not come to an end"):
        drawer.save("doubted", tmp_path)
    assert list(tmp_path.iterdir()) == []
    shown = drawing_message(drawer.drawing)
    assert (tuple(shown.remarks), shown.contradictory) == (doubted.remarks, True)
    assert not drawing_message(before).contradictory
    assert "<desc data-fit=" in drawer.save("doubted", tmp_path, force=True).read_text()
    drawer._shown.now = before


def test_a_folder_that_cannot_be_written_loses_nothing(mapped, tmp_path):
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(CommandError, match="cannot be written"):
        mapped.drawer.save("kitchen", tmp_path / "file")
    assert mapped.drawer.drawing.state == "done"
    assert mapped.drawer.save("kitchen", tmp_path) == Path(tmp_path / "kitchen.svg")


@pytest.mark.parametrize("step", ["save_map_yaml", "atomic_file"])
def test_a_full_disk_loses_nothing(mapped, tmp_path, monkeypatch, step):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(map_files, step, full)
        with pytest.raises(CommandError, match=r"cannot be written.*No space left"):
            mapped.drawer.save("kitchen", tmp_path)
    assert mapped.drawer.drawing.state == "done"
    # The name is still free.
    assert mapped.drawer.save("kitchen", tmp_path) == tmp_path / "kitchen.svg"


def test_what_is_not_there_cannot_be_finished_saved_or_discarded(bench, tmp_path):
    for act in (bench.drawer.finish, bench.drawer.discard):
        with pytest.raises(CommandError):
            act()
    with pytest.raises(CommandError, match="no finished map"):
        bench.drawer.save("kitchen", tmp_path)


def test_one_map_at_a_time(bench):
    bench.drawer.begin()
    with pytest.raises(CommandError, match="a map is drawn; finish"):
        bench.drawer.begin()
    with pytest.raises(CommandError, match="nothing is drawn yet"):
        bench.drawer.finish()
    bench.drawer.discard()
    assert bench.drawer.drawing is None
    bench.drawer.begin()
    assert bench.drawer.drawing.state == "draw"


def test_a_map_is_saved_while_it_is_drawn_and_drawn_on(bench, tmp_path):
    bench.drawer.begin()
    bench.drive(8.0)
    before = bench.drawer.drawing
    saving = threading.Thread(target=bench.drawer.save, args=("half", tmp_path))
    saving.start()
    bench.drive(0.5)
    saving.join(LONGEST_S)
    assert load_field(str(tmp_path / "half.svg"), MAPS).tape_width == pytest.approx(0.05)
    assert bench.drawer.drawing.state == "draw"
    for _ in range(9):
        bench.catch_up(bench.drive(1.0))
    assert bench.drawer.drawing.version > before.version + 3
    assert len(bench.drawer.drawing.sketch.path) > len(before.sketch.path)
    bench.finish()
    assert len(bench.drawer.drawing.result.tidy.strokes) == 4


def test_what_waits_for_a_map_that_is_discarded_is_told(bench, tmp_path):
    bench.drawer.begin()
    bench.drive(3.0)
    said: list[str] = []

    def save() -> None:
        try:
            bench.drawer.save("half", tmp_path)
        except CommandError as error:
            said.append(str(error))

    # No tick comes: only the thread's end can answer.
    saving = threading.Thread(target=save)
    saving.start()
    for _ in range(1000):
        if len(bench.drawer._work.asked) or not saving.is_alive():
            break
        saving.join(0.01)
    bench.drawer.discard()
    saving.join(10)
    assert not saving.is_alive()
    assert said == ["the map was discarded"] or (tmp_path / "half.svg").exists()


def test_while_it_is_paused_the_wheels_tell_the_way_and_the_map_stays_straight():
    """Half of the lap is driven with a pause: nothing of it is seen, and nothing is bent."""
    bench = MappingBench()
    bench.drawer.begin()
    bench.drive(6.0)
    bench.drawer.pause()
    assert bench.drawer.drawing.paused
    edges = len(bench.drawer.drawing.sketch.edges)
    bench.drive(5.0)
    bench.drawer.pause()
    assert not bench.drawer.drawing.paused
    assert len(bench.drawer.drawing.sketch.edges) <= edges + 400
    bench.drive(LAP_S)
    bench.finish()
    drawn = bench.drawer.drawing.result
    assert drawn.fits
    assert drawn.moved_at is None
    looked = np.isfinite(drawn.seen.polygons[0]).all()
    assert looked
    for stroke in drawn.tidy.strokes:
        assert np.abs(stroke.points).max(axis=1) == pytest.approx(0.5, abs=0.003)
    bench.close()


def test_without_a_map_nothing_is_paused(bench):
    with pytest.raises(NoMapError, match="no map is drawn now"):
        bench.drawer.pause()


def test_a_map_that_grows_shows_tape_path_and_pose(bench):
    bench.drawer.begin()
    bench.drive(4.0)
    message = drawing_message(bench.drawer.drawing)
    assert message.version == bench.drawer.drawing.version > 0
    assert len(message.strokes) >= 2
    assert len(message.path) > 10
    assert message.edges


def test_a_robot_that_stands_is_no_map_and_says_why(bench):
    bench.drawer.begin()
    run(bench.program, 2.0)
    while bench.drawer.drawing.words is None:
        bench.drawer._follower.wait(0.05)
    assert "it has to drive" in bench.drawer.drawing.words


def test_long_without_tape_in_sight_it_says_so():
    bench = MappingBench(map="square")
    bench.drawer.begin()
    bench.drive(3.0)
    away = DriveCommand(type="drive", v=0.25, omega=0.0)
    run(bench.program, 14.0, away)
    while "no tape has been in sight" not in (bench.drawer.drawing.words or ""):
        bench.drawer._follower.wait(0.05)
        run(bench.program, 0.1, away)
    bench.close()
