"""The one exception for bad input; the command line prints it as one sentence, no traceback."""


class InputError(ValueError):
    """Something the user gave is wrong. The message names the file, the value and the remedy."""
