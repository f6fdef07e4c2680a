"""``/lens``: the page, its live socket, and files to print and to download."""

from __future__ import annotations

from fastapi import APIRouter, HTTPException, Request, Response, WebSocket
from fastapi.responses import HTMLResponse

from app.engine.program import Program
from app.features.calibration.lens.calibrated import CalibratedLens
from app.features.calibration.lens.desk import LensDesk
from app.features.calibration.lens.messages import BoardMessage, LensMessage
from app.messages.answers import content, refusal
from app.page.language import page
from app.settings.config import FRONTEND
from robot.calibration.lens.board import Board
from robot.calibration.lens.board_page import lay_out
from robot.calibration.lens.page_files import pdf
from robot.description.urdf import SpecError
from robot.settings import SettingError

NO_LENS = refusal(404, "before the first calibration")
BOARD = content("application/pdf") | refusal(404, "no such board or paper")
CAMERA_INFO = content("application/yaml") | NO_LENS
PROFILE = (
    content("application/toml") | NO_LENS | refusal(503, "the profile that there is cannot be used")
)
USUAL = BoardMessage()


def lens_router(program: Program) -> APIRouter:
    """Calibrate the lens of a program's robot."""
    router, desk = APIRouter(), LensDesk(program)

    @router.get("/lens", include_in_schema=False)
    def lens_page(request: Request) -> HTMLResponse:
        return page(FRONTEND / "features" / "calibration" / "lens" / "lens.html", request)

    @router.websocket("/api/lens")
    async def follow(socket: WebSocket) -> None:
        await desk.serve(socket)

    _add_board(router)
    _add_files(router, desk)
    return router


def _add_board(router: APIRouter) -> None:
    @router.get("/api/board.pdf", response_class=Response, responses=BOARD)
    def board(
        kind: str = USUAL.kind,
        columns: int = USUAL.columns,
        rows: int = USUAL.rows,
        square: float = USUAL.square,
        marker: float = USUAL.marker,
        dictionary: str = USUAL.dictionary,
        paper: str = "a4",
    ) -> Response:
        """A board to print at 100 %, as ``brickpose calibrate board`` makes it; metres."""
        try:
            printed = pdf(lay_out(Board(kind, columns, rows, square, marker, dictionary), paper))
        except SettingError as error:
            raise HTTPException(404, str(error)) from error
        return Response(printed, media_type="application/pdf")


def _add_files(router: APIRouter, desk: LensDesk) -> None:
    def newest() -> CalibratedLens:
        if desk.calibrated is None:
            raise HTTPException(404, "No lens was calibrated yet.")
        return desk.calibrated

    @router.get("/api/lens", responses=NO_LENS)
    def lens() -> LensMessage:
        """The lens that was calibrated last."""
        return newest().message()

    @router.get("/api/lens/camera.yaml", response_class=Response, responses=CAMERA_INFO)
    def camera_info() -> Response:
        """That lens as ROS's ``camera_info``."""
        return _download(newest().camera_info(), "application/yaml", "camera.yaml")

    @router.get("/api/lens/profile.toml", response_class=Response, responses=PROFILE)
    def profile() -> Response:
        """The robot's profile with that lens."""
        try:
            text = newest().profile().to_toml()
        except (SpecError, OSError) as error:
            raise HTTPException(503, str(error)) from error
        return _download(text, "application/toml", "profile.toml")


def _download(text: str, media_type: str, name: str) -> Response:
    headers = {
        "Content-Disposition": f'attachment; filename="{name}"',
        "Cache-Control": "no-store",
    }
    return Response(text, media_type=media_type, headers=headers)
