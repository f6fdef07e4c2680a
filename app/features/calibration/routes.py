"""Routes of the robot's calibration, and the progress of its drive."""

from __future__ import annotations

import math

from fastapi import APIRouter, HTTPException, Response

from app.engine.program import Program
from app.features.calibration.drive_calibrator import FEWEST_S, CalibrationDrive, DriveCalibrator
from app.features.calibration.messages import CalibrationMessage, UnknownMessage
from app.messages.answers import content, refusal
from app.messages.telemetry import CalibrationDriveMessage
from robot.calibration.calibrate import LEARNT, Calibration
from robot.calibration.programme import LONGEST_S
from robot.description.profile import Profile
from robot.description.spec import RobotSpec
from robot.description.unknowns import ROBOT, UNKNOWNS
from robot.estimation.fit_quality import FitQuality
from robot.geometry import Array

INTERVAL = 1.96
"""Half the width of a 95 % interval, in standard deviations."""


def drive_message(drive: CalibrationDrive | None, stamp: float) -> CalibrationDriveMessage | None:
    """Return the progress of a calibration's drive at a stamp [s]; None before the first drive."""
    if drive is None:
        return None
    return CalibrationDriveMessage(
        state=drive.state,
        seconds=drive.seconds(stamp),
        whole=LONGEST_S,
        fewest=FEWEST_S,
        adjusted=drive.adjusted,
        message=drive.words,
    )


def calibration_router(program: Program, calibrator: DriveCalibrator) -> APIRouter:
    """Return the routes of what is known of a program's robot."""
    router = APIRouter()

    def known() -> RobotSpec:
        latest = program.engine.latest.get()
        return latest.spec if latest else program.robot.spec

    @router.get("/api/calibration")
    def calibration() -> CalibrationMessage:
        """What is known of the robot, from the current drive or the last calibration."""
        return calibration_message(known(), calibrator)

    @router.get(
        "/api/profile",
        response_class=Response,
        responses=content("application/toml") | refusal(404, "a robot that nobody has calibrated"),
    )
    def robot_profile() -> Response:
        """The profile of the current calibration, as TOML; `brickpose run --profile` takes it."""
        spec = known()
        if not spec.measured:
            raise HTTPException(404, "Nobody has calibrated this robot.")
        headers = {"Content-Disposition": f'attachment; filename="{spec.name}.toml"'}
        return Response(spec.profile, media_type="application/toml", headers=headers)

    return router


def calibration_message(spec: RobotSpec, calibrator: DriveCalibrator) -> CalibrationMessage:
    """Return what is known of the robot, from the last drive or from its profile."""
    drive, profile = calibrator.drive, Profile.of(spec)
    values, sd, result = profile.values, profile.sd, None
    if drive is not None and drive.state != "failed" and drive.calibration is not None:
        result = drive.calibration
        values, sd = result.values, result.sd
    fit = FitQuality.of_table(profile.fit) if profile.fit else None
    quality = fit if result is None else result.quality
    said = result if result is not None else fit
    return CalibrationMessage(
        measured=spec.measured,
        undoable=calibrator.undoable,
        unknowns=_unknowns(values[:ROBOT], sd[:ROBOT]),
        position=None if result is None else _position(result),
        advice=[] if result is None else list(result.advice),
        facts=[] if quality is None else list(quality.facts),
        remarks=[] if said is None else list(said.remarks),
    )


def _unknowns(values: Array, sd: Array) -> list[UnknownMessage]:
    return [
        UnknownMessage(
            name=unknown.name,
            unit=unknown.unit,
            value=unknown.scale * value,
            interval=INTERVAL * unknown.scale * spread,
            prior=INTERVAL * unknown.scale * unknown.prior,
            learnt=spread <= LEARNT * unknown.prior,
        )
        for unknown, value, spread in zip(UNKNOWNS, values.tolist(), sd.tolist(), strict=False)
    ]


def _position(result: Calibration) -> float | None:
    bound = INTERVAL * result.position_sd
    return bound if math.isfinite(bound) else None
