"""The error of an analysis that can't follow C, or a program."""


class NotRead(Exception):
    """The C holds something that is not read; the message says what."""
