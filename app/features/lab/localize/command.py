"""Carries out ``brickpose localize`` with its arguments."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from app.console import say
from app.features.lab.localize.laser_map import LaserMap
from app.features.lab.localize.localize import GivenStart, localize
from app.features.lab.localize.localized import Localized
from app.features.lab.localize.pictures.command import localize_pictures
from app.features.lab.localize.pictures.sequence import is_folder_of_pictures
from app.features.lab.localize.reading.bag import Bag
from app.features.lab.localize.reading.lasers import Lasers, find_lasers
from app.features.lab.localize.reading.pairing import Measurement, require_clock
from app.features.lab.localize.reading.sources import BagError
from app.features.lab.localize.results import (
    PATH,
    PICTURE,
    WITHDRAWN,
    LocalizeRequest,
    write_results,
)
from app.features.lab.localize.settings import LocalizeSettings, load_settings
from app.result_files import RESULTS, make_folder, require_new
from robot.fields.field import FieldError
from robot.geometry import Pose2
from robot.settings import SettingError


def localize_command(parsed: argparse.Namespace) -> int:
    """Follow the robot and write the results."""
    _check(parsed)
    if is_folder_of_pictures(parsed.bag):
        _refuse(parsed, BAG_ONLY, "a folder of pictures")
        return localize_pictures(parsed)
    _refuse(parsed, PICTURES_ONLY, "a bag")
    settings = load_settings(parsed.filter_config)
    enabled = LaserMap.load(parsed.map)
    start = _start(parsed, settings, enabled)
    folder = parsed.out or Path("localized") / parsed.bag.stem
    if not (parsed.force or (folder / RESULTS).exists()):
        require_new(*(folder / name for name in (PATH, WITHDRAWN, PICTURE)))
    with Bag(parsed.bag) as bag:
        lasers = find_lasers(bag, parsed)
        make_folder(folder)
        for line in (line for laser in lasers for line in laser.words):
            say(line)
        pairing = Lasers(bag, lasers, parsed.clock, enabled.across)
        result = localize(_shown(pairing), enabled, settings, start, parsed.seed)
        for words in bag.damages:
            say(f"in {parsed.bag}, {words}")
    if not result.scans:
        raise BagError(_nothing(pairing, parsed))
    asked = LocalizeRequest(
        parsed.bag, parsed.map, parsed.seed, settings, lasers,
        start.pose if start else None, parsed.clock,
    )  # fmt: skip
    write_results(folder, asked, result, enabled, pairing)
    for line in (*pairing.remarks, *pairing.left_out.lines()):
        say(line)
    _tell(result, folder)
    return 0


BAG_ONLY = (
    "scan_topic", "odom_topic", "odom_frame", "base_frame", "namespace", "laser_pose",
    "filter_config",
)  # fmt: skip
PICTURES_ONLY = (
    "camera", "camera_name", "profile", "odometry", "stamps", "overlays", "config",
)  # fmt: skip
"""Options that have an effect on one kind of recording only."""


def _refuse(parsed: argparse.Namespace, names: tuple[str, ...], given: str) -> None:
    for name in names:
        if getattr(parsed, name) is not None:
            raise SettingError(f"--{name.replace('_', '-')} has no effect with {given}")


def _check(parsed: argparse.Namespace) -> None:
    require_clock(parsed.clock)
    if not 0 <= parsed.seed < 2**32:
        raise SettingError(f"--seed is {parsed.seed}; valid is 0 to {2**32 - 1}")
    start = parsed.initial_pose
    if start is not None and not all(math.isfinite(value) for value in start):
        raise SettingError(f"--initial-pose is {start}; valid are three finite numbers")
    for name in ("sd_xy", "sd_theta"):
        value, option = getattr(parsed, name), f"--{name.replace('_', '-')}"
        if value is not None and not 0 < value < math.inf:
            raise SettingError(f"{option} is {value}; valid is more than 0")
        if value is not None and parsed.initial_pose is None:
            raise SettingError(f"{option} has no effect without --initial-pose")


def _start(
    parsed: argparse.Namespace, settings: LocalizeSettings, laser_map: LaserMap
) -> GivenStart | None:
    pose = _pose(parsed.initial_pose)
    if pose is None:
        return None
    try:
        laser_map.field.require_inside(laser_map.map_from_cells.inverse() @ pose)
    except FieldError as error:
        raise SettingError(
            f"--initial-pose ({pose.x:g}, {pose.y:g}) m is not on the map {parsed.map.name}"
        ) from error
    default = settings.localization.filter
    sd_xy = parsed.sd_xy or default.initial_sd_xy
    return GivenStart(pose, sd_xy, parsed.sd_theta or default.initial_sd_theta)


def _pose(values: list[float] | None) -> Pose2 | None:
    return None if values is None else Pose2(*values)


def _shown(pairing: Lasers) -> Iterator[Measurement]:
    """Yield the measurements and show the progress on a terminal."""
    with tqdm(total=pairing.total, unit="message", disable=None) as progress:
        for measurement in pairing.measurements():
            progress.update(pairing.messages - progress.n)
            yield measurement


def _nothing(pairing: Lasers, parsed: argparse.Namespace) -> str:
    """Return a message that says why no scan could be used."""
    given = f"no scan of {parsed.bag} could be used"
    spans = [f"{source} from {a:.3f} to {b:.3f} s" for source, (a, b) in pairing.clocks.items()]
    given = "; ".join([given, *pairing.remarks, *pairing.left_out.lines(), *spans])
    if pairing.left_out.without_odometry and parsed.clock == "header":
        given += "; if the clocks differ, --clock log takes when messages were recorded"
    return given


def _tell(localized: Localized, folder: Path) -> None:
    rate = localized.updates / localized.filter_s if localized.filter_s else math.inf
    say(f"{localized.scans} scans, {localized.updates} updates at {rate:.0f}/s")
    if localized.withdrawn:
        say(
            f"{localized.withdrawn_s:.1f} s that were told as certain are withdrawn: "
            f"their places turned out wrong ({folder / WITHDRAWN})"
        )
    if len(localized.standing) >= 2 and localized.final is not None:
        pose, sd = localized.final.pose, localized.final.covariance.diagonal() ** 0.5
        sure = (
            ""
            if localized.known
            else f"; at the end it was not sure any more, but {localized.state}"
        )
        say(
            f"it ends at {pose.x:.3f} m, {pose.y:.3f} m, {pose.theta:.3f} rad "
            f"(sd {sd[0]:.3f} m, {sd[1]:.3f} m, {sd[2]:.3f} rad){sure}"
        )
        say(f"its way is {folder / PATH}, on the map {folder / PICTURE}")
    else:
        sure = (
            "nothing of it stands"
            if localized.withdrawn
            else "it never was sure where the robot is"
        )
        say(f"{sure}; the places are in {folder / PICTURE}")
