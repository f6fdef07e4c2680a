"""What the scanner saw along a ray, and why the ray counted or not."""

from __future__ import annotations

import math

import numpy as np
from fastapi import APIRouter, HTTPException

from app.engine.program import Program
from app.features.weighing.messages import ProfileMessage
from app.languages.marking import phrase
from app.messages.answers import refusal
from robot.errors import BrickPoseError
from robot.geometry import Array
from robot.scanning.along_rays import between
from robot.scanning.edge_search import differences
from robot.scanning.line_scanner import LineScan, LineScanner
from robot.scanning.tape_edges import Verdict

NO_PICTURE = refusal(503, "before the camera's first picture")


class RayError(BrickPoseError, IndexError):
    """There is no such ray."""


def ray_router(program: Program) -> APIRouter:
    """Serve what the scanner saw along single rays."""
    router = APIRouter()

    @router.get("/api/ray/{ray}", responses=NO_PICTURE | refusal(404, "no such ray"))
    def ray_profile(ray: int) -> ProfileMessage:
        """What the scanner saw along one ray of the newest picture, and why it counted or not."""
        program.engine.audience.visit()
        latest = program.engine.latest.get()
        if latest is None or latest.filter.line_scan is None or latest.filter.scanner is None:
            raise HTTPException(503, "The camera has sent no picture yet.")
        try:
            return profile(latest.filter.scanner, latest.filter.line_scan, ray)
        except RayError as error:
            raise HTTPException(404, str(error)) from error

    return router


def profile(scanner: LineScanner, line_scan: LineScan, ray: int) -> ProfileMessage:
    """Return what the scanner saw along one ray of a picture.

    Raises:
        RayError: there is no such ray.
    """
    rays = len(scanner.table.bearings)
    if not 0 <= ray < rays:
        raise RayError(f"there is no ray {ray}; valid is 0 to {rays - 1}")
    count = int(scanner.table.counts[ray])
    entry, leaving = (
        None if math.isnan(edge) else float(between(scanner.table.distances[ray], edge))
        for edge in line_scan.edges[ray]
    )
    verdict = Verdict(line_scan.verdicts[ray])
    width = line_scan.widths[ray]
    grey, response = along_rays(line_scan)
    return ProfileMessage(
        stamp=line_scan.scan.stamp,
        ray=ray,
        bearing=float(line_scan.scan.bearings[ray]),
        distances=scanner.table.distances[ray, :count].round(5).tolist(),
        grey=grey[ray, :count].tolist(),
        response=response[ray, :count].round(1).tolist(),
        threshold=scanner.settings.threshold,
        entry=entry,
        exit=leaving,
        width=None if math.isnan(width) else float(width),
        counted=verdict == Verdict.COUNTED,
        why=_why(scanner, verdict, float(width)),
    )


def along_rays(line_scan: LineScan) -> tuple[Array, Array]:
    """Return brightness and the edge kernel's response along the rays (k, m) [grey levels]."""
    table = line_scan.table
    grey = line_scan.picture.ravel()[table.pixel_indices].astype(np.int16)
    response = differences(grey, table.counts, line_scan.kernel) / line_scan.kernel
    return grey.astype(float), response


def _why(scanner: LineScanner, verdict: Verdict, width: float) -> str:
    wanted = scanner.settings
    darker, brighter = phrase("dark"), phrase("bright")
    if all(look.light for look in scanner.looks):
        darker, brighter = brighter, darker
    known = {width for look in scanner.looks for width in look.all_widths}
    widths = " or ".join(f"{width * 1e3:.0f}" for width in sorted(known))
    reasons = {
        Verdict.COUNTED: f"Counted: a straight {darker} line, {width * 1e3:.1f} mm wide.",
        Verdict.OUT_OF_SIGHT: "The camera does not see the floor along this ray.",
        Verdict.NO_EDGE: f"Nothing here gets {darker} and {brighter} again.",
        Verdict.NO_EXIT: (
            f"It gets {darker}, but where it gets {brighter} again is out of the picture."
        ),
        Verdict.TOO_SHORT: (
            f"A {darker} stripe, but its edge is seen on less than {wanted.support * 1e3:.0f} mm."
        ),
        Verdict.NOT_STRAIGHT: (
            f"A {darker} patch whose edge is not straight: its points lie more than "
            f"{wanted.straightness * 1e3:.1f} mm off a line."
        ),
        Verdict.WRONG_WIDTH: (
            f"A {darker} stripe, but {width * 1e3:.1f} mm wide; tape is "
            f"{widths} mm, give or take {wanted.width_tolerance * 1e3:.0f} mm."
        ),
    }
    return reasons[verdict]
