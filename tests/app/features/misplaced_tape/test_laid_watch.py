"""A robot on tape that was laid by hand says so, and keeps its place."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from app.features.lab.evaluation.drives import follow_drive
from app.features.lab.evaluation.integrity.claims import entries_over
from app.features.lab.evaluation.integrity.drives import lap_drive
from app.features.lab.evaluation.integrity.mishaps import MISHAPS, apply_any_condition
from app.features.misplaced_tape.laid_watch import LaidWatch, tape_watches
from app.settings.config import MAPS, Config
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.localization.estimate import BOUNDED, Cause, Integrity, State
from robot.scan import Scan

KNOWN = np.diag([1e-4, 1e-4, 9e-4])


def watch_of(localization):
    return next(each for each in localization.added if isinstance(each, LaidWatch))


def drive_on(name, condition, seed):
    """What a robot on such a floor claims, picture by picture, from a known start."""
    config = apply_any_condition(replace(Config(), map=name, seed=seed), condition)
    drive = lap_drive(config, 1.5, MISHAPS[condition]).drive
    field, start = load_field(name, MAPS), drive.ticks[0].truth
    entries = entries_over(field, config)
    for tick, odometry, localization in follow_drive(
        drive, config, lambda begun: begun.set_pose(start, KNOWN), believed=field, entries=entries
    ):
        if localization.belief is not None:
            error = localization.belief.pose(odometry).distance_to(drive.truth_at(tick.scan.stamp))
            yield tick.scan.stamp, error, localization.integrity, watch_of(localization)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "condition", "seed", "words"),
    [
        ("tee", "hand-laid", 20400, "tape lies beside its drawing, most of all around x"),
        ("square", "enlarged", 20400, "% larger than its drawing"),
        ("town", "shrunk", 20400, "% smaller than its drawing"),
    ],
)
def test_a_robot_on_tape_laid_by_hand_keeps_its_place(name, condition, seed, words):
    """It was in doubt for nine tenths of the drive, and lost."""
    named, errors, bounded, misleading = None, [], [], []
    for stamp, error, integrity, watch in drive_on(name, condition, seed):
        told = [alert for alert in watch.alerts if alert.cause is Cause.MAP]
        if not told:
            assert not watch.unsure.any()
            continue
        named = named or stamp
        assert integrity.alerts[0] == told[0]
        if stamp > named + 2.0:
            errors.append(error)
            bounded.append(integrity.state in BOUNDED)
            misleading.append(bounded[-1] and error > integrity.radius)
    assert named is not None and named < 15
    assert any(words in alert.text for alert in watch.alerts)
    assert np.quantile(errors, 0.95) < 0.02
    assert np.mean(bounded) > 0.8
    assert np.mean(misleading) < 0.002
    again = pickle.loads(pickle.dumps(watch.memory))
    assert again.laid.finding == watch.memory.laid.finding


def scan_at(stamp):
    return Scan(stamp, np.zeros(3), np.full(3, np.inf))


def test_a_search_begins_where_the_place_was_last_known():
    watch = LaidWatch(load_field("square", MAPS))
    known, doubt = Integrity(State.CERTAIN, 0.02, 0.05), Integrity(State.APPROXIMATE)
    for number in range(20):
        assert watch.cleared(scan_at(number / 30), Pose2(0.01 * number)) is watch.memory.newest
        watch.look(known, Pose2(0.01 * number), KNOWN, Pose2(0.01 * number))
    assert watch.memory.search is None
    watch.cleared(scan_at(1.0), Pose2(0.2))
    watch.look(doubt, Pose2(0.2), KNOWN, Pose2(0.2))
    assert watch.memory.search is not None
    assert watch.place(State.LOST, None, Pose2(0.2)) is None
    watch.forget()
    assert watch.memory.search is None and not watch.memory.recent


def test_nothing_is_searched_before_a_place_was_known():
    watch = LaidWatch(load_field("square", MAPS))
    for number in range(20):
        watch.cleared(scan_at(number / 30), Pose2())
        watch.look(Integrity(State.SEARCHING), Pose2(), KNOWN, Pose2())
    assert watch.memory.search is None
    assert watch.alerts == () and not watch.unsure.any()


def test_drawings_of_very_much_tape_are_taken_as_they_are():
    field = load_field("town", MAPS)
    assert any(isinstance(each, LaidWatch) for each in tape_watches(Config(), field))
    larger = replace(field, edges=np.tile(field.edges, (20, 1)))
    assert not tape_watches(Config(), larger)


def test_what_was_learnt_of_the_robot_is_forgotten_once():
    """It was forgotten with each scan, if the place was lost right after the first correction."""
    watch = LaidWatch(load_field("square", MAPS))
    watch.memory.is_new = True
    watch.cleared(scan_at(0.0), Pose2())
    assert not watch.memory.is_new
