"""The timeline of a replay: the filter moves forward by ticks, and back by checkpoints.

Apart from the viewer's commands, the filter's state depends only on the recording, the settings,
the seed and the time. It does not depend on earlier seeks.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from app.engine.checkpoint import Checkpoint, CheckpointError, CheckpointWriter
from app.engine.command_row import Repeat
from app.engine.commands import row_of
from app.engine.engine import Engine
from app.engine.snapshot import Snapshot
from app.features.recordings.replay.position import ReadPosition
from app.features.recordings.replay.preview import Preview, picture_before, preview
from app.features.recordings.replay.recorded_robot import RecordedRobot
from app.features.recordings.replay.requests import ReplaySettings, refused
from app.messages.commands import Command, ResetCommand, SetParametersCommand
from robot.fields.field import Field
from robot.geometry import Pose2
from robot.localization.models.entry_field import EntryField

MOST_BYTES = 100_000_000
"""Largest size of all checkpoints together; beyond it, every second one is dropped."""

SPACING_NS = 2_000_000_000
"""Initial interval between two checkpoints [ns]."""
NEAR_NS = 2_000_000_000
"""A shorter seek forward needs no checkpoint [ns]."""
LONGEST_STEP_NS = 2_000_000_000
"""Longest step from picture to picture [ns]."""
Then = tuple[Pose2, Pose2]
"""A recorded estimate, and dead reckoning at its stamp."""


@dataclass(frozen=True, slots=True, order=True)
class StoredCheckpoint:
    """A checkpoint, taken after the tick at a time."""

    log_ns: int
    checkpoint: Checkpoint = field(compare=False)


class Checkpoints:
    """Checkpoints by time; all belong to the same settings."""

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._kept: list[StoredCheckpoint] = []
        self._spacing_ns = SPACING_NS

    def __len__(self) -> int:
        return len(self._kept)

    @property
    def size(self) -> int:
        """Size of all checkpoints [bytes]; a block that several of them share counts once."""
        blocks = {id(b): len(b.content) for each in self._kept for b in each.checkpoint.blocks}
        return sum(len(item.checkpoint.content) for item in self._kept) + sum(blocks.values())

    def due(self, log_ns: int) -> bool:
        """Whether a checkpoint is due at a time, because none is near it."""
        after = bisect_left(self._kept, log_ns, key=lambda item: item.log_ns)
        near = self._kept[max(after - 1, 0) : after + 1]
        return all(abs(each.log_ns - log_ns) >= self._spacing_ns for each in near)

    def add(self, log_ns: int, checkpoint: Checkpoint) -> None:
        """Store a checkpoint; drop every second one if they are too large together."""
        insort(self._kept, StoredCheckpoint(log_ns, checkpoint))
        while len(self._kept) > 1 and self.size > self._most_bytes:
            del self._kept[1::2]
            self._spacing_ns *= 2

    def before(self, log_ns: int) -> StoredCheckpoint | None:
        """The last checkpoint before a time; None if there is none."""
        result = bisect_left(self._kept, log_ns, key=lambda item: item.log_ns)
        return self._kept[result - 1] if result else None

    def clear(self) -> None:
        """Drop all checkpoints, because the settings changed."""
        self._kept.clear()
        self._spacing_ns = SPACING_NS


class Timeline:
    """Owns the engine's state; for one thread."""

    def __init__(
        self,
        engine: Engine,
        robot: RecordedRobot,
        field: Field,
        settings: ReplaySettings,
        begin: Callable[[dict[str, Any], EntryField | None], Engine],
    ) -> None:
        """Start at the beginning, before the first tick.

        Args:
            engine: an engine in its initial state.
            begin: makes an engine in its initial state, with some parameters changed. It takes the
                table of the field if there is one already, which saves some seconds.
        """
        self.engine = engine
        self.robot = robot
        self.checkpoints = Checkpoints()
        self._field = field
        self._settings = settings
        self._begin = begin
        self._recorded_estimate: Then | None = None
        self._pure = True
        """Whether the state depends only on the recording, the settings and the time."""
        self._can_keep = True
        self._added = engine.localization.added
        self._reloads = engine.controls.reloads
        self._keeper = CheckpointWriter([field, field.edges, *self._added])
        self._memories = self._keeper.keep([models.memory for models in self._added])
        """What the models of features remember before the first scan."""

    @property
    def log_ns(self) -> int:
        """Time of the last tick [ns since 1970]."""
        return self.robot.at.log_ns

    @property
    def pure(self) -> bool:
        """Whether the state depends only on the recording, the settings and the time."""
        return self._pure

    def estimate_then(self, snapshot: Snapshot) -> Pose2 | None:
        """The recorded estimate, carried forward by the wheels; None if there is none yet."""
        if self._recorded_estimate is None:
            return None
        pose, odom_then = self._recorded_estimate
        return pose @ (odom_then.inverse() @ snapshot.odom_from_robot)

    def tick(self, commands: tuple[Command, ...] = ()) -> Snapshot:
        """Run the next tick; there must be one.

        Args:
            commands: the viewer's commands now, in addition to the recorded ones.
        """
        recorded = [item for command in self.robot.commands() for item in self._repeated(command)]
        self._note(commands)
        snapshot = self.engine.advance((*recorded, *commands))
        if self.robot.recorded_estimate is not None:
            self._recorded_estimate = self._recorded_estimate_of(*self.robot.recorded_estimate)
        self._mind_reloads()
        self._keep()
        return snapshot

    def apply_between_ticks(self, commands: tuple[Command, ...]) -> Snapshot:
        """Carry out commands between two ticks."""
        self._note(commands)
        snapshot = self.engine.apply_between_ticks(commands)
        self._mind_reloads()
        return snapshot

    def forget(self) -> None:
        """Drop all checkpoints because of new settings: the next seek starts from the beginning."""
        self.checkpoints.clear()
        self._pure = False

    def change(self, command: SetParametersCommand | ResetCommand) -> None:
        """Change settings, with effect from the next ``go_near`` on."""
        self._settings.change(command)
        self.forget()

    def look(self, log_ns: int) -> Preview | None:
        """Return what was recorded last up to a time; None if there is nothing."""
        lens = self.robot.spec.lens
        size = lens.height, lens.width
        return preview(self.robot.reader, self.robot.topics, log_ns, size)

    def go_near(self, log_ns: int) -> Preview | None:
        """Go to the nearest known state before a time; ``ticks_up_to`` does the rest.

        Returns:
            What was recorded at that time, if it had to be looked up.
        """
        ahead = log_ns - self.log_ns
        if self._pure and 0 <= ahead < NEAR_NS:
            return None
        target = self.look(log_ns)
        picture_ns = target.picture_log_ns if target else None
        # At least one picture has to come between them, because a checkpoint holds no picture.
        kept = self.checkpoints.before(picture_ns if picture_ns is not None else -1)
        if self._pure and ahead >= 0 and (kept is None or kept.log_ns <= self.log_ns):
            return target
        if kept is None:
            self._start_anew()
        else:
            state, in_use, place, self._recorded_estimate = kept.checkpoint.restore()
            self.engine.controls.restore(state)
            for models, (kept_models, memory) in zip(self._added, in_use, strict=True):
                models.memory = memory
                models.put_back(kept_models, state.localization.parameters)
            self.robot.go_to(place)
        self._pure = True
        return target

    def ticks_up_to(self, log_ns: int) -> Iterator[Snapshot]:
        """Run the ticks from here to a time."""
        while (following := self.robot.next_ns) is not None and following <= log_ns:
            yield self.tick()

    def ticks_with_pictures(self, pictures: int) -> Iterator[Snapshot]:
        """Run the ticks from here to the one that brings the last of ``pictures`` new pictures."""
        quiet_ns = self.log_ns
        while pictures > 0 and (following := self.robot.next_ns) is not None:
            # If no picture comes for a long time, the step ends there.
            if following - quiet_ns > LONGEST_STEP_NS and quiet_ns != self.log_ns:
                return
            snapshot = self.tick()
            if snapshot.reading.frame is not None:
                pictures -= 1
                quiet_ns = self.log_ns
            yield snapshot

    def picture_before(self, pictures: int) -> int:
        """Time of the tick with the picture ``pictures`` before the last one [ns since 1970]."""
        robot = self.robot
        return picture_before(
            robot.reader, robot.topics, robot.at.picture_log_ns, pictures, robot.start_ns
        )

    def _start_anew(self) -> None:
        engine = self.engine
        self.robot.go_to(ReadPosition())
        fresh = self._begin(self._settings.changed, engine.localization.models.entries)
        engine.controls.restore(fresh.controls.state)
        for models, memory in zip(self._added, self._memories.restore(), strict=True):
            models.memory = memory
        self._recorded_estimate = None

    def _repeated(self, command: Command) -> tuple[Command, ...]:
        why = refused(command, self._field)
        if why is not None:
            self.engine.note(why)
            return ()
        return self._settings.repeated(command)

    def _note(self, commands: tuple[Command, ...]) -> None:
        for command in commands:
            if isinstance(command, (SetParametersCommand, ResetCommand)):
                self.change(command)
            if row_of(command).repeat is Repeat.MOMENT:
                self._pure = False

    def _recorded_estimate_of(self, stamp: float, pose: Pose2) -> Then | None:
        try:
            return pose, self.engine.controls.odometry.at(stamp).odom_from_robot
        except LookupError:
            return self._recorded_estimate  # the stamp is older than the stored odometry

    def _mind_reloads(self) -> None:
        """Treat a model in use that was saved again as a change of settings."""
        reloads = self.engine.controls.reloads
        if reloads != self._reloads:
            self._reloads = reloads
            self.forget()

    def _keep(self) -> None:
        log_ns = self.log_ns
        if not (self._pure and self._can_keep and self.checkpoints.due(log_ns)):
            return
        try:
            state = self.engine.controls.state
            in_use = [(models.in_use, models.memory) for models in self._added]
            kept = self._keeper.keep((state, in_use, self.robot.at, self._recorded_estimate))
        except CheckpointError as error:
            self._can_keep = False
            self.engine.note(f"To go back takes long: {error}.")
        else:
            self.checkpoints.add(log_ns, kept)
