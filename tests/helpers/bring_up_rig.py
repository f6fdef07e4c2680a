"""A board and the start of it, both on the board's clock."""

from robot.hat.protocol.decoder import Decoder
from robot.hat.start.bring_up import BringUp
from robot.hat.start.firmware_image import EXPECTED_VERSION, FirmwareImage
from sim.hat.emulated_board import EmulatedBoard
from sim.hat.lego_motor import LegoMotor
from sim.hat.plants import FreeMotors

STEP = 0.01
IMAGE = FirmwareImage(EXPECTED_VERSION, bytes(range(256)) * 4, b"\x0d" * 64)
PROGRAM = b"port 0;port_plimit 1;pwm;set 1;select 2;selrate 10\r"


class Rig:
    """A board and the start of it, both on the board's clock."""

    def __init__(self, *, warm=True, version=EXPECTED_VERSION, image=lambda: IMAGE):
        plants = FreeMotors()
        motor = LegoMotor(0x30, plants.plant(0))
        self.board = EmulatedBoard(plants, {0: motor}, warm=warm, version=version)
        self.start = BringUp(image)
        self.decoder = Decoder()
        self.sent = []
        self.on_the_way_out = lambda data: data
        self.on_the_way_in = lambda data: data
        self.resets = True

    def begin(self):
        self._send(self.start.begin(self.board.now))

    def _send(self, data):
        if data:
            self.sent.append(data)
            self.board.receive(self.on_the_way_out(data))

    def step(self):
        heard = self.on_the_way_in(self.board.advance(STEP))
        now = self.board.now
        self._send(self.start.receive(self.decoder.feed(heard), now))
        self._send(self.start.tick(now))
        if self.start.wants_reset:
            if self.resets:
                self.board.reset()
                self.start.was_reset(now)
            else:
                self.start.cannot_reset("pin 4 is not free", now)

    def until(self, condition, limit):
        """Let time pass until something is so; how long it took [s]."""
        begin = self.board.now
        while not condition():
            assert self.board.now - begin < limit, (self.start.stage, self.start.trouble)
            self.step()
        return self.board.now - begin

    def ready(self):
        return self.start.ready

    def run(self, seconds):
        end = self.board.now + seconds
        self.until(lambda: self.board.now > end, seconds + 1)
