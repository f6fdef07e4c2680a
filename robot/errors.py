"""The errors that the program tells its users; any other exception is a defect of the program."""


class BrickPoseError(Exception):
    """Something that a user can put right; the message says what is wrong and what is valid.

    Each subclass derives from a standard exception too.
    """


class CommandError(BrickPoseError, ValueError):
    """A command is invalid, or cannot be carried out now; the message says what is valid."""


class PackageError(BrickPoseError, ImportError):
    """An optional package is missing; the message says how to install it."""


class PortError(BrickPoseError, OSError):
    """A serial port, a network port or a socket cannot be used; the message says what to do."""
