"""Holder of one user's model of one kind (sensor or motion): empty, or kept up to date."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Generic, Protocol, TypeVar

from app.features.own_models.error_messages import OwnModelError
from app.features.own_models.guards import Guard
from app.features.own_models.model_file import ModelFile, build, load
from app.features.own_models.watch import FileWatch
from robot.geometry import Pose2


class Guarded(Protocol):
    """A user's model behind its guard."""

    guard: Guard
    made_of: Mapping[str, object] | None

    def try_out(self, start: Pose2) -> None:
        """Call the model once."""
        ...


G = TypeVar("G", bound=Guarded)


class Slot(Generic[G]):
    """Holds the chosen model, if it is one of the user's own."""

    def __init__(
        self,
        wrap: Callable[[ModelFile, object, str | None], G],
        start: Pose2,
        judge: Callable[[G], str | None] = lambda _: None,
    ) -> None:
        """Begin empty; ``judge`` says what is doubtful of a model that works, or None."""
        self.model: G | None = None
        """None while one of the program's own models is chosen."""
        self.file: ModelFile | None = None
        self.doubt: str | None = None
        """What the trial before its use has shown."""
        self._judge = judge
        self._wrap = wrap
        self._start = start
        self._class: Callable[..., Any] | None = None
        self._watch: FileWatch | None = None

    @property
    def name(self) -> str:
        """The model's name on the page; empty while there is no model."""
        return self.file.name if self.file else ""

    @property
    def fault(self) -> str | None:
        """What is wrong with the model, with file and line."""
        return self.model.guard.fault if self.model else None

    @property
    def trace(self) -> str:
        """The calls that led to the fault, as far as they are the user's."""
        return self.model.guard.trace if self.model else ""

    def choose(self, file: ModelFile | None) -> None:
        """Choose a file, or None to empty the slot; call ``make`` next."""
        self.file = file
        self.model = None
        self.doubt = None
        # The watch begins before the file is read, so that a save in between is not missed.
        self._watch = FileWatch(file.path) if file else None

    def saved(self) -> bool:
        """Return whether the file was saved, so that it is to be made anew."""
        return self._watch is not None and self._watch.saved()

    def make(self, offered: Mapping[str, object], *, fresh: bool) -> None:
        """Make the model, of the file as it was read, or ``fresh`` as it is."""
        if self.file is None:
            return
        if fresh:
            self._load(self.file)
        if self._class is not None:
            # If it had failed, its new parameters may be the cure.
            self._make(self.file, self._class, offered, try_out=fresh or self.fault is not None)

    def _load(self, file: ModelFile) -> None:
        self._class = None
        try:
            self._class = load(file)
        except OwnModelError as error:
            self._fail(file, error)

    def _make(
        self,
        file: ModelFile,
        made: Callable[..., Any],
        offered: Mapping[str, object],
        *,
        try_out: bool,
    ) -> None:
        try:
            if try_out:
                # Try out a model and throw it away, as it may remember the trial.
                tried = self._made(file, made, offered)
                tried.try_out(self._start)
                self.doubt = self._judge(tried)
                if tried.guard.fault is not None:
                    self.model = tried
                    return
            self.model = self._made(file, made, offered)
        except OwnModelError as error:
            self._fail(file, error)

    def _made(self, file: ModelFile, made: Callable[..., Any], offered: Mapping[str, object]) -> G:
        model = self._wrap(file, build(file, made, offered), None)
        model.made_of = offered
        return model

    def _fail(self, file: ModelFile, error: OwnModelError) -> None:
        self.model = self._wrap(file, None, str(error))
        self.model.guard.trace = error.trace
