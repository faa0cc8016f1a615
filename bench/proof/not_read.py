"""What is raised where C, or a program, is not followed."""


class NotRead(Exception):
    """The C holds something that is not read; the message says what."""
