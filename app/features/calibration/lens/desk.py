"""Calibrates the lens with the running camera, for all open pages."""

from __future__ import annotations

import dataclasses
from collections import deque

import anyio
import anyio.to_thread
import cv2
import numpy as np
from pydantic import ValidationError
from starlette.websockets import WebSocket

from app.engine.mailboxes.latest import Latest
from app.engine.mailboxes.websocket_writer import WebsocketWriter
from app.engine.program import Program
from app.features.calibration.lens.calibrated import CalibratedLens, outline, pixels, saved_profile
from app.features.calibration.lens.messages import (
    LENS_REQUEST,
    BoardMessage,
    LensBarsMessage,
    LensCalibrateRequest,
    LensLookMessage,
    LensSaveRequest,
    LensStartRequest,
    LensStatusMessage,
)
from app.messages.commands import ErrorMessage, in_words
from app.page.live import WATCHES
from app.page.token_guard import role_in
from app.page.tokens import Role
from robot.calibration.lens.board import Board
from robot.calibration.lens.coverage import Coverage
from robot.calibration.lens.guide import BoardView, LensGuide
from robot.calibration.lens.lens_calibration import LEAST_PICTURES
from robot.calibration.lens.sighting import Grey
from robot.errors import BrickPoseError, CommandError
from robot.interface import Frame

PERIOD_S = 0.25
"""Least time between two pictures that are examined [s]."""
LONGEST = 2000
"""Longest request [characters]."""
POLICY = 1008
"""Close code for a client that may not use the socket."""
Request = LensStartRequest | LensCalibrateRequest | LensSaveRequest


class LensDesk:
    """One calibration, which all pages show and control together.

    A separate thread examines one picture at a time, and only while a page is open whose link may
    drive. The pictures taken so far stay when the last page closes.
    """

    def __init__(self, program: Program) -> None:
        self._program = program
        self._asked: deque[Request] = deque(maxlen=10)
        self._guide: LensGuide | None = None
        self._look: BoardView | None = None
        self._problem = ""
        self._count = 0
        self._saved = False
        self.calibrated: CalibratedLens | None = None
        """The newest lens; None before the first."""
        self._status = Latest[str]()
        self._turn = anyio.Lock()
        """The socket that holds it does the work for all."""

    async def serve(self, socket: WebSocket) -> None:
        """Send the progress to one page, and take its requests, until it closes."""
        await socket.accept()
        outgoing = WebsocketWriter(socket)
        if role_in(socket.scope) is Role.WATCH:
            await outgoing.send(ErrorMessage(id=None, message=WATCHES).model_dump_json())
            await socket.close(POLICY)
            return
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._tell, outgoing)
            tasks.start_soon(self._work)
            await self._take(socket, outgoing)
            tasks.cancel_scope.cancel()

    async def _tell(self, outgoing: WebsocketWriter) -> None:
        with self._status.subscribe() as subscription:
            while await outgoing.send(await subscription.next()):
                pass

    async def _take(self, socket: WebSocket, outgoing: WebsocketWriter) -> None:
        while (message := await socket.receive())["type"] != "websocket.disconnect":
            try:
                self._asked.append(self._checked(message.get("text") or ""))
            except BrickPoseError as error:
                await outgoing.send(ErrorMessage(id=None, message=str(error)).model_dump_json())

    def _checked(self, text: str) -> Request:
        """Return a request that can be carried out.

        Raises:
            BrickPoseError: it cannot be carried out; says why.
        """
        if len(text) > LONGEST:
            raise CommandError(f"a request has at most {LONGEST} characters")
        try:
            request = LENS_REQUEST.validate_json(text)
        except ValidationError as error:
            raise CommandError(in_words(error)) from error
        if isinstance(request, LensStartRequest):
            board_of(request.board)
        if isinstance(request, LensSaveRequest) and saved_profile(self._program) is None:
            raise CommandError("only a real robot has a profile of its own; download the lens")
        return request

    async def _work(self) -> None:
        """Carry out requests and examine pictures while this socket holds the lock."""
        async with self._turn:
            # Whoever moves a board before a robot that stands wants more pictures than a page does.
            with self._program.engine.audience.joined():
                while True:
                    due = anyio.current_time() + PERIOD_S
                    while self._asked:
                        await self._carry_out(self._asked.popleft())
                    await self._look_at_newest()
                    self._publish()
                    await anyio.sleep_until(due)

    async def _carry_out(self, request: Request) -> None:
        self._problem = ""
        try:
            if isinstance(request, LensStartRequest):
                self._guide, self._look = LensGuide(board_of(request.board)), None
            elif isinstance(request, LensCalibrateRequest):
                self._publish(busy=True)
                await self._calibrate()
            else:
                await self._save()
        except (BrickPoseError, OSError) as error:
            self._problem = str(error)

    async def _calibrate(self) -> None:
        guide = self._guide
        if guide is None:
            raise CommandError("there are no pictures yet; start first")
        result = await anyio.to_thread.run_sync(guide.collection.calibrate)
        self.calibrated = CalibratedLens(self._program, result, guide.board)
        self._count += 1
        self._saved = False

    async def _save(self) -> None:
        if self.calibrated is None:
            raise CommandError("there is no lens yet; calibrate first")
        await anyio.to_thread.run_sync(self.calibrated.save)
        self._saved = True

    async def _look_at_newest(self) -> None:
        latest, guide = self._program.engine.latest.get(), self._guide
        frame = latest.frame if latest else None
        if guide is None or frame is None:
            return
        if self._look is None or self._look.stamp != frame.stamp:
            self._look = await anyio.to_thread.run_sync(_look, guide, frame)

    def _publish(self, *, busy: bool = False) -> None:
        text = self._message(busy).model_dump_json()
        if text != self._status.get():
            self._status.put(text)

    def _message(self, busy: bool) -> LensStatusMessage:
        guide, profile = self._guide, saved_profile(self._program)
        board = guide.board if guide else board_of(BoardMessage())
        seen = list(guide.collection.seen.values()) if guide else []
        coverage = guide.coverage if guide else Coverage.of([], board)
        return LensStatusMessage(
            board=BoardMessage(**dataclasses.asdict(board)) if guide else None,
            look=_look_message(self._look) if self._look else None,
            taken=len(seen),
            least=LEAST_PICTURES,
            outlines=[outline(sighting) for sighting in seen],
            parts=coverage.parts.tolist(),
            bars=LensBarsMessage(**coverage.bars),
            next_steps=guide.next_steps if guide else [],
            busy=busy,
            problem=self._problem,
            calibrations=self._count,
            profile=None if profile is None else str(profile),
            saved=self._saved,
        )


def board_of(message: BoardMessage) -> Board:
    """Return the board that a message describes.

    Raises:
        SettingError: there is no such board; says what is valid.
    """
    return Board(**message.model_dump())


def _look(guide: LensGuide, frame: Frame) -> BoardView:
    return guide.look(frame.stamp, _grey(frame))


def _grey(frame: Frame) -> Grey:
    image = frame.image
    if image.ndim == 2:
        return image
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)


def _look_message(look: BoardView) -> LensLookMessage:
    found_corners = pixels(look.sighting.pixels) if look.sighting else []
    return LensLookMessage(
        stamp=look.stamp, corners=found_corners, verdict=look.verdict, words=look.words
    )
