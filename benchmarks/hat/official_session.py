"""A session with Raspberry Pi's official library: a typical user program with LEGO motors.

``python -m benchmarks.hat.official_session DEVICE CONTROL PART...`` prints one line of JSON with
the findings of each part. The library is not modified. It resets the board by a pin of the Pi; here
this pin is a mock, and its edge is passed on to the emulator.
"""

from __future__ import annotations

import json
import math
import socket
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import gpiozero  # type: ignore[import-untyped]
from buildhat import Hat, Motor, MotorPair  # type: ignore[import-untyped]

RESET_PIN = 4
SETTLE = 0.3
"""Time in which a motor reaches a speed or stops [s]."""
FEWEST_MEASURED, MOST_MEASURED = 2, 8
STEADY, STEADY_SHARE = 5.0, 0.04
"""A speed changes no more if it differs from the last by less than this [degree/s], or a share."""

Findings = dict[str, Any]


def main() -> None:
    """Run the parts in one session."""
    device, control, *parts = sys.argv[1:]
    threading.Thread(target=pass_on_reset, args=(control,), daemon=True).start()
    start = time.monotonic()
    hat = Hat(device=device)
    findings: Findings = {"start": time.monotonic() - start}
    for part in parts:
        findings[part] = PARTS[part](hat)
    print(json.dumps(findings))


def pass_on_reset(control: str) -> None:
    """Wait for a low and then a high level on the reset pin, and reset the emulator."""
    factory = gpiozero.Device.pin_factory
    while factory is None:
        time.sleep(0.002)
        factory = gpiozero.Device.pin_factory
    pin = factory.pin(RESET_PIN)
    while [level.state for level in pin.states][-2:] != [False, True]:
        time.sleep(0.002)
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(control)
        connection.sendall(b"reset\n")
        connection.recv(100)


def hat_part(hat: Any) -> Findings:
    """Read the devices and the supply voltage of the board."""
    hat.set_leds("green")
    hat.set_leds("voltage")
    return {"devices": hat.get(), "vin": hat.get_vin()}


def position(motor: Any, do: Callable[[], None]) -> Findings:
    """Return how far [degree] and how long [s] a motor turns during a call."""
    before, start = motor.get_position(), time.monotonic()
    do()
    seconds = time.monotonic() - start
    time.sleep(SETTLE)
    return {"turned": motor.get_position() - before, "seconds": seconds}


def get_part(hat: Any) -> Findings:
    """Read a motor's position, absolute position and speed."""
    motor = Motor("A")
    return {
        "position": motor.get_position(),
        "aposition": motor.get_aposition(),
        "speed": motor.get_speed(),
    }


def seconds_part(hat: Any) -> Findings:
    """Test run_for_seconds: forth, back, and without waiting."""
    motor = Motor("A")
    findings = {
        "forth": position(motor, lambda: motor.run_for_seconds(1, 50)),
        "back": position(motor, lambda: motor.run_for_seconds(1, -50)),
    }
    start = time.monotonic()
    motor.run_for_seconds(0.5, 30, blocking=False)
    findings["queued"] = {"seconds": time.monotonic() - start}
    motor.stop()  # waits for queued calls
    findings["done"] = {"seconds": time.monotonic() - start}
    return findings


def degrees_part(hat: Any) -> Findings:
    """Test run_for_degrees and run_for_rotations."""
    motor = Motor("A")
    return {
        "forth": position(motor, lambda: motor.run_for_degrees(360, 20)),
        "back": position(motor, lambda: motor.run_for_degrees(-180, 20)),
        "rotations": position(motor, lambda: motor.run_for_rotations(1, -20)),
    }


def position_part(hat: Any) -> Findings:
    """Test run_to_position in each direction."""
    motor = Motor("A")
    findings = {}
    for degrees, direction in ((0, "shortest"), (120, "clockwise"), (-60, "anticlockwise")):
        motor.run_to_position(degrees, 20, direction=direction)
        time.sleep(SETTLE)
        findings[direction] = motor.get_aposition() - degrees
    return findings


def callback_part(hat: Any) -> Findings:
    """Test when_rotated while a motor turns."""
    motor, calls = Motor("A"), []

    def rotated(speed: int, place: int, absolute: int) -> None:
        calls.append((speed, place, absolute))

    motor.when_rotated = rotated
    turned = position(motor, lambda: motor.run_for_degrees(360, 20))["turned"]
    motor.when_rotated = None
    places = [place for _, place, _ in calls]
    absolutes = {(place - absolute) % 360 for _, place, absolute in calls}
    return {
        "count": len(calls),
        "span": max(places) - min(places),
        "turned": turned,
        "marks": len(absolutes),
    }


def free_speed(motor: Any) -> float:
    """Measure a motor's speed [degree/s] over half a second, when it changes no more.

    On a busy machine the emulated board is late by a second at times.
    """
    time.sleep(SETTLE)
    speed = math.nan
    for count in range(1, MOST_MEASURED + 1):
        last, before, start = speed, motor.get_position(), time.monotonic()
        time.sleep(0.5)
        speed = float((motor.get_position() - before) / (time.monotonic() - start))
        change = abs(speed - last)
        if count > FEWEST_MEASURED and change <= max(STEADY, STEADY_SHARE * abs(speed)):
            break
    return speed


def pwm_part(hat: Any) -> Findings:
    """Test pwm with power limits, and both ways to stop."""
    motor, findings = Motor("A"), {}
    for limit in (0.3, 1.0):
        motor.plimit(limit)
        motor.pwm(0.6)
        findings[f"limit {limit:g}"] = free_speed(motor)
    motor.pwm(-0.6)
    findings["back"] = free_speed(motor)
    motor.float()
    findings["float"] = free_speed(motor)
    motor.pwm(0.6)
    motor.coast()
    findings["coast"] = free_speed(motor)
    return findings


def rpm_part(hat: Any) -> Findings:
    """Test speeds in rotations per minute."""
    motor = Motor("A")
    motor.set_speed_unit_rpm(True)
    findings = {"seconds": position(motor, lambda: motor.run_for_seconds(2, 60))}
    motor.start(60)
    findings["speed"] = {"speed": free_speed(motor)}
    motor.stop()
    findings["degrees"] = position(motor, lambda: motor.run_for_degrees(180, 60))
    motor.set_speed_unit_rpm(False)
    return findings


def pair_part(hat: Any) -> Findings:
    """Test both motors at once."""
    pair = MotorPair("A", "B")
    motors = (pair._leftmotor, pair._rightmotor)
    before = [motor.get_position() for motor in motors]
    start = time.monotonic()
    pair.run_for_seconds(1, 50, -50)
    seconds = time.monotonic() - start
    time.sleep(SETTLE)
    after = [motor.get_position() for motor in motors]
    pair.run_for_degrees(180, 20, 20)
    time.sleep(SETTLE)
    last = [motor.get_position() for motor in motors]
    pair.run_to_position(30, -30, 20)
    time.sleep(SETTLE)
    return {
        "seconds": seconds,
        "left, right": [b - a for a, b in zip(before, after, strict=True)],
        "degrees": [b - a for a, b in zip(after, last, strict=True)],
        "off": [motors[0].get_aposition() - 30, motors[1].get_aposition() + 30],
    }


PARTS: dict[str, Callable[[Any], Findings]] = {
    "hat": hat_part,
    "get": get_part,
    "seconds": seconds_part,
    "degrees": degrees_part,
    "position": position_part,
    "callback": callback_part,
    "pwm": pwm_part,
    "rpm": rpm_part,
    "pair": pair_part,
}

if __name__ == "__main__":
    main()
