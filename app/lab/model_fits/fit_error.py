"""What every fit refuses with."""


class FitError(ValueError):
    """The data do not tell what is asked of them; the message says what is needed."""
