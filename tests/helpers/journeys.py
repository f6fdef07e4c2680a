"""Programs that drive to goals, stepped without a clock, as their page or a client sends them."""

from __future__ import annotations

from dataclasses import replace

from engine_runs import PERFECT, kinematic, run

from app.engine.driver import Driver
from app.engine.snapshot import Snapshot
from app.features.navigation.messages import GoalMessage, NavigateCommand
from app.messages.commands import Command, SetPoseCommand
from app.page.outlets import Outlets
from robot.navigation.navigation_status import NavigationStatus
from sim.simulated import PERIOD

PAGE, OTHER = Driver("page 1"), Driver("page 2")
RENEW = NavigateCommand(type="navigate")
KNOWN = SetPoseCommand(type="set_pose", x=0.0, y=0.0, theta=0.0, sd_xy=0.005, sd_theta=0.01)


def goal(x: float, y: float, theta: float | None = None, **more) -> NavigateCommand:
    """A journey that the sender renews itself."""
    poses = [GoalMessage(x=x, y=y, theta=theta)]
    return NavigateCommand(type="navigate", poses=poses, renewed=True, **more)


class JourneyBench:
    """A kinematic robot at the square's middle, which knows that, and all that is around it."""

    def __init__(self, *, imperfect: bool = False, **settings) -> None:
        sim = {} if imperfect else {"sim": replace(PERFECT)}
        self.program = kinematic(**sim, **settings)
        self.outlets = Outlets(self.program)
        self.program.engine.commands.put(KNOWN)
        self.now = run(self.program, 0.4)[-1]
        # Who drives goes by the robot's clock: ticks are not in step with the wall's.
        self.outlets.drivers._clock = lambda: self.now.stamp

    @property
    def status(self) -> NavigationStatus | None:
        return self.now.added.get("navigation")

    def send(self, command: Command, driver: Driver = PAGE) -> None:
        """As the page's server does with a command."""
        self.outlets.drivers.check(driver, command, self.program)
        self.outlets.carry_out(driver, command)

    def go(self, seconds: float, *, renew: bool = True) -> list[Snapshot]:
        """Drive on for a time, or until the journey is over."""
        shown = []
        for _ in range(round(seconds / PERIOD)):
            if renew:
                self.outlets.drivers.renew(PAGE, RENEW)
            self.now = self.program.engine.step()
            shown.append(self.now)
            if self.status is not None and not self.status.active:
                break
        return shown

    def close(self) -> None:
        self.outlets.close()
        self.program.engine._companions.close()
