"""Carries out ``brickpose localize`` with its arguments."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path

from tqdm import tqdm

from app.console import say
from app.files import make_folder
from app.lab.localize.laser_map import LaserMap
from app.lab.localize.localize import Start, localize
from app.lab.localize.localized import Localized
from app.lab.localize.pictures.command import localize_pictures
from app.lab.localize.pictures.sequence import is_folder_of_pictures
from app.lab.localize.reading.bag import Bag, BagError
from app.lab.localize.reading.layout import choose, find_layout
from app.lab.localize.reading.pairing import Measurement, Pairing, require_clock
from app.lab.localize.results import PATH, PICTURE, WITHDRAWN, LocalizeRequest, write_results
from app.lab.localize.settings import LocalizeSettings, load_settings
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
    with Bag(parsed.bag) as bag:
        chosen = choose(bag, parsed.scan_topic, parsed.odom_topic)
        layout = find_layout(bag, chosen, _pose(parsed.laser_pose))
        make_folder(folder)
        say(f"{chosen.scan} and {chosen.odometry or 'tf'}, laser as told by {layout.told_by}")
        if layout.assumed:
            say("so the laser is taken to sit at the robot's middle, looking ahead (--laser-pose)")
        pairing = Pairing(bag, chosen, layout, parsed.clock)
        result = localize(_shown(bag, pairing), enabled, settings, start, parsed.seed)
        for words in bag.damages:
            say(f"in {parsed.bag}, {words}")
    if not result.scans:
        raise BagError(_nothing(pairing, parsed))
    asked = LocalizeRequest(
        parsed.bag, parsed.map, parsed.seed, settings, chosen, layout,
        start.pose if start else None, parsed.clock,
    )  # fmt: skip
    write_results(folder, asked, result, enabled, pairing.left_out)
    for line in pairing.left_out.lines():
        say(line)
    _tell(result, folder)
    return 0


BAG_ONLY = ("scan_topic", "odom_topic", "laser_pose", "filter_config")
PICTURES_ONLY = ("camera", "profile", "odometry", "stamps", "overlays", "config")
"""Options that have an effect on one kind of recording only."""


def _refuse(parsed: argparse.Namespace, names: tuple[str, ...], given: str) -> None:
    for name in names:
        if getattr(parsed, name) is not None:
            raise SettingError(f"--{name.replace('_', '-')} has no effect with {given}")


def _check(parsed: argparse.Namespace) -> None:
    require_clock(parsed.clock)
    if not 0 <= parsed.seed < 2**32:
        raise SettingError(f"--seed is {parsed.seed}; valid is 0 to {2**32 - 1}")
    for name in ("initial_pose", "laser_pose"):
        values = getattr(parsed, name)
        if values is not None and not all(math.isfinite(value) for value in values):
            option = f"--{name.replace('_', '-')}"
            raise SettingError(f"{option} is {values}; valid are three finite numbers")
    for name in ("sd_xy", "sd_theta"):
        value, option = getattr(parsed, name), f"--{name.replace('_', '-')}"
        if value is not None and not 0 < value < math.inf:
            raise SettingError(f"{option} is {value}; valid is more than 0")
        if value is not None and parsed.initial_pose is None:
            raise SettingError(f"{option} has no effect without --initial-pose")


def _start(
    parsed: argparse.Namespace, settings: LocalizeSettings, laser_map: LaserMap
) -> Start | None:
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
    return Start(pose, sd_xy, parsed.sd_theta or default.initial_sd_theta)


def _pose(values: list[float] | None) -> Pose2 | None:
    return None if values is None else Pose2(*values)


def _shown(bag: Bag, pairing: Pairing) -> Iterator[Measurement]:
    """Yield the measurements and show the progress on a terminal."""
    total = bag.count(pairing.names)
    with tqdm(total=total, unit="message", disable=None) as progress:
        for measurement in pairing.measurements():
            progress.update(pairing.messages - progress.n)
            yield measurement


def _nothing(pairing: Pairing, parsed: argparse.Namespace) -> str:
    """Return a message that says why no scan could be used."""
    given = f"no scan of {parsed.bag} could be used"
    spans = [f"{source} from {a:.3f} to {b:.3f} s" for source, (a, b) in pairing.clocks.items()]
    given = "; ".join([given, *pairing.left_out.lines(), *spans])
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
