"""A measured lens as a file, with what it was measured by."""

from __future__ import annotations

import json
from dataclasses import replace

from robot.calibration.lens.board import Board
from robot.calibration.lens.lens_calibration import LensCalibration
from robot.lens_files.camera_info import camera_info


def camera_info_of(result: LensCalibration, board: Board, readout: float) -> str:
    """Return a lens as the content of ROS's ``camera_info`` YAML.

    The readout [s] of a rolling shutter was not measured: it is that of the robot's description.
    """
    title = (
        f"Calibrated by BrickPose from {len(result.seen)} pictures of a {board.words};\n"
        f"held-out corners lie {result.chosen.rms:.3f} px off (root mean square)."
    )
    title += "".join(f"\nThe adjustment: {words}." for words in result.quality.facts)
    title += f"\nfit: {json.dumps(result.quality.table())}"
    if readout:
        title += "\nThe readout was not measured: it is that of the robot's description."
    return camera_info(replace(result.lens, readout=readout), result.sd, title)
