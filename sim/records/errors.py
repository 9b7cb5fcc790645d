"""The error of input that cannot be used: a file, a folder, an option."""


class InputError(ValueError):
    """Bad input. The message names the given and the allowed values."""
