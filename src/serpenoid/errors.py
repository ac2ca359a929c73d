"""The package's own exceptions: few, and each says what to do."""


class InputError(ValueError):
    """Something the user wrote is wrong: the message names the place, the rule, the value and the remedy."""


class StopRequested(Exception):
    """The user pressed Ctrl-C: what was reached so far is kept, and the command exits with 130."""
