"""Serves the dashboard with one robot until it is stopped."""

from __future__ import annotations

import argparse
from functools import partial

import cv2

from app.console import say
from app.engine.plugging import plug_in, plugged
from app.engine.robots import resolve_robot, robot_kind
from app.feature_search import Features
from app.page.access_options import announce, front_of, tokens_of
from app.page.first_start import compiled
from app.page.listening import listen
from app.page.serving import build_served, serve, serve_on
from app.settings.config import Config
from robot.settings import SettingError


def run_dashboard(
    parsed: argparse.Namespace, wanted: Config, features: Features, path: str = "/"
) -> int:
    """Serve until a signal; return 0.

    Args:
        parsed: options of ``add_serving``.
        wanted: settings, as these options and a file ask for them.
        features: what takes part.
        path: of the page whose address is printed.

    Raises:
        SettingError: an option has no effect with this robot, or a setting is invalid.
    """
    cv2.setNumThreads(1)  # its threads would not be in a fork, and one picture needs none
    features = plug_in(features)
    for failure in features.failures:
        say(failure)
    config, missing = resolve_robot(wanted)
    _refuse_without_effect(parsed, config)
    front = front_of(vars(parsed))
    with listen(config.host, config.port) as listening:
        guests = features.guests(config)
        port = listening.getsockname()[1]
        tokens = tokens_of(vars(parsed), listening, inviting=bool(guests))
        if missing:
            say(f"The kinematic robot drives, without forces: {missing}")
        ready = partial(announce, listening, tokens, front.scheme, guests=guests, path=path)
        with compiled(config, listening, tokens, front, ready) as start:
            if start is None:
                return 0
            program = build_served(config, alone=True)
            following = serve(program, start[0], tokens, front, start[1])
    if following is not None:
        serve_on(following, port, tokens, front)
    return 0


def _refuse_without_effect(parsed: argparse.Namespace, config: Config) -> None:
    kind, robots = robot_kind(config), plugged().robots.values()
    for name in dict.fromkeys(name for each in robots for name in each.options):
        if name in vars(parsed) and name not in kind.options:
            valid = ", ".join(each.name for each in robots if name in each.options)
            raise SettingError(
                f"--{name.replace('_', '-')} has no effect with --robot {kind.name}; valid is "
                f"{valid}"
            )
    if "condition" in parsed and not kind.is_simulated:
        valid = ", ".join(each.name for each in robots if each.is_simulated)
        raise SettingError(f"--condition has no effect with --robot {kind.name}; valid are {valid}")
