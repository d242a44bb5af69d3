"""The error of this package."""


class Error(RuntimeError):
    """A file that cannot be read: str() names the file and the reason."""
