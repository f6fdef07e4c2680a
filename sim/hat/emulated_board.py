"""Emulated Build HAT: bytes in, bytes out, with its own clock."""

from __future__ import annotations

from collections.abc import Mapping

from sim.hat.firmware.connection import SetupFault
from sim.hat.firmware.drive import STEPS
from sim.hat.firmware.power import Power
from sim.hat.lego_motor import LegoMotor
from sim.hat.main_loop import Firmware
from sim.hat.motor_figures import DeviceError
from sim.hat.plants import PORTS, Plants
from sim.hat.processor import TICK, VERSION, Processor
from sim.hat.transmitter import Noise, Receiver, Transmitter


class EmulatedBoard:
    """The board with its plugged-in devices; it keeps its state when the host disconnects.

    Time passes only in ``advance``, in whole milliseconds; the rest is kept for the next call.
    """

    def __init__(
        self,
        plants: Plants,
        devices: Mapping[int, LegoMotor],
        *,
        warm: bool = True,
        version: int = VERSION,
        seed: int = 0,
    ) -> None:
        """Switch it on.

        Args:
            plants: the motors that its drivers turn.
            devices: the plugged-in devices, by port 0..3.
            warm: True: its firmware runs and knows the devices; False: its bootloader waits.
            version: version of the firmware that runs.
            seed: seed of ``garble``, ``garble_in`` and ``loss``.

        Raises:
            DeviceError: a port outside 0..3.
        """
        self._plants = plants
        self._ticks = 0
        self._rest = 0.0
        self._transmitter = Transmitter()
        self._receiver = Receiver()
        self._noise = Noise(seed)
        self._loss = Noise(seed + 1, kinds=1)
        self._noise_in = Noise(seed + 2)
        self.power = Power()
        self.supply_v = self.power.supply_v
        self.silent = False
        """Whether the serial line is dead in both directions."""
        self._devices: dict[int, LegoMotor] = {}
        self._driven: list[int | None] = [None] * PORTS
        self._processor = Processor(self._transmitter, self.power, self._devices)
        for port, device in devices.items():
            self.plug(port, device)
        if warm:
            self._processor.run_warm(version)

    @property
    def now(self) -> float:
        """Time of the board's own clock [s]."""
        return self._ticks * TICK + self._rest

    @property
    def supply_v(self) -> float:
        """Supply voltage of the board [V]."""
        return self.power.supply_v

    @supply_v.setter
    def supply_v(self, volts: float) -> None:
        self.power.supply_v = volts
        self._plants.supply_v = volts

    @property
    def garble(self) -> float:
        """Probability that an outgoing byte is lost, doubled, zeroed or changed by one bit."""
        return self._noise.probability

    @garble.setter
    def garble(self, probability: float) -> None:
        self._noise.probability = _probability("garble", probability)

    @property
    def garble_in(self) -> float:
        """Probability that an incoming byte is lost, doubled, zeroed or changed by one bit."""
        return self._noise_in.probability

    @garble_in.setter
    def garble_in(self, probability: float) -> None:
        self._noise_in.probability = _probability("garble_in", probability)

    @property
    def loss(self) -> float:
        """Probability that an incoming byte is lost, as in an upload on a busy processor."""
        return self._loss.probability

    @loss.setter
    def loss(self, probability: float) -> None:
        self._loss.probability = _probability("loss", probability)

    @property
    def devices(self) -> Mapping[int, LegoMotor]:
        """The plugged-in devices, by port."""
        return self._devices

    @property
    def in_bootloader(self) -> bool:
        """Whether no firmware runs."""
        return self._processor.firmware is None

    def duty(self, port: int) -> float | None:
        """Return the output of a port's driver, -1..1; None: it is switched off.

        Raises:
            DeviceError: a port outside 0..3.
        """
        _check(port)
        firmware = self._processor.firmware
        return None if firmware is None else firmware.ports[port].bridge.duty

    def plug(self, port: int, device: LegoMotor) -> None:
        """Plug a device in, replacing any other; it gets power and starts.

        Raises:
            DeviceError: a port outside 0..3.
        """
        _check(port)
        device.power_up()
        self._devices[port] = device
        if self._processor.firmware is not None:
            self._processor.firmware.plug(port, device)

    def unplug(self, port: int) -> None:
        """Unplug the device at a port, if there is one; its motor coasts.

        Raises:
            DeviceError: a port outside 0..3.
        """
        _check(port)
        self._devices.pop(port, None)
        if self._processor.firmware is not None:
            self._processor.firmware.unplug(port)
        self._drive()

    def reset(self) -> None:
        """Pulse the RESET pin: the firmware is lost, the motors coast, the devices lose power.

        Output that waits in the board is also lost.
        """
        self._processor.reset()
        self._drive()

    def setup_fails(self, port: int, how: SetupFault | str) -> None:
        """Make the next setup of a device on a port fail: "framing", "checksum" or "silence".

        Raises:
            DeviceError: an unknown fault, a port outside 0..3, or no firmware runs.
        """
        _check(port)
        names = {fault.name.lower(): fault for fault in SetupFault}
        fault = how if isinstance(how, SetupFault) else names.get(how)
        if fault is None:
            raise DeviceError(f"setup cannot fail by {how!r}; valid are {', '.join(names)}")
        self._firmware_that_runs.fail_setup(port, fault)

    def data_fails(self, port: int, framing: int = 0, checksum: int = 6) -> None:
        """Set the numbers of errors in a device's data; more than five in total disconnect it.

        Raises:
            DeviceError: a port outside 0..3, or no firmware runs.
        """
        _check(port)
        self._firmware_that_runs.fail_data(port, framing, checksum)

    def late(self, milliseconds: int) -> None:
        """Set the duration of the firmware's next pass; above 2 ms the firmware reports it.

        Raises:
            DeviceError: less than 1 ms.
        """
        if milliseconds < 1:
            raise DeviceError(f"a pass takes {milliseconds} ms; valid is 1 or more")
        self._processor.stall(milliseconds)

    def print_text(self, text: str) -> None:
        """Print a text at once, as the firmware does on an error of its inner bus."""
        self._transmitter.put(text.encode())

    def receive(self, data: bytes) -> None:
        """Take what the host writes; it arrives byte by byte while time passes."""
        self._receiver.put(data)

    def advance(self, seconds: float) -> bytes:
        """Let time pass [s]; return the bytes that have left the board meanwhile.

        Raises:
            DeviceError: the time is negative.
        """
        if not seconds >= 0:
            raise DeviceError(f"{seconds} s cannot pass; valid is 0 or more")
        # The small term makes ten steps of 0.1 ms one tick, in spite of rounding.
        ticks = int((self._rest + seconds) / TICK + 1e-6)
        self._rest = max(self._rest + seconds - ticks * TICK, 0.0)
        left = b"".join([self._tick() for _ in range(ticks)])
        return self._noise.over(left)

    def _tick(self) -> bytes:
        self._plants.step(TICK)
        self._ticks += 1
        arrived = self._receiver.advance(TICK)
        heard = b"" if self.silent else self._noise_in.over(self._loss.over(arrived))
        self._processor.passed(heard, self._ticks * TICK)
        self._drive()
        sent = self._transmitter.advance(TICK)
        return b"" if self.silent else sent

    @property
    def _firmware_that_runs(self) -> Firmware:
        if self._processor.firmware is None:
            raise DeviceError("no firmware runs; the bootloader waits for one")
        return self._processor.firmware

    def _drive(self) -> None:
        """Pass the drivers' outputs to the motors; a port without a device drives nothing."""
        firmware = self._processor.firmware
        for port in range(PORTS):
            steps = None
            if firmware is not None and port in self._devices:
                steps = firmware.ports[port].bridge.steps
            if steps != self._driven[port]:
                self._driven[port] = steps
                self._plants.plant(port).drive(None if steps is None else steps / STEPS)


def _probability(name: str, value: float) -> float:
    if not 0 <= value <= 1:
        raise DeviceError(f"{name} is {value}; valid is a probability, 0 to 1")
    return value


def _check(port: int) -> None:
    if not 0 <= port < PORTS:
        raise DeviceError(f"port is {port}; valid are 0 to {PORTS - 1}")
