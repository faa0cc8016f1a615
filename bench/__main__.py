"""The command line. Each file in ``bench/commands`` is one command, found by its name."""

import os
import pkgutil
import signal
import sys
from collections import Counter
from importlib import import_module
from io import TextIOWrapper
from typing import Any

import click

import bench.commands

REPEATED = " Repeatable."
"""Note in ``--help`` on an option that may be given more than once."""


NAMED = ("vehicle", "method")
"""Options of which none that a user gives is left out."""


class Commands(click.Group):
    """Finds commands by file name and imports only the one that is called (or all, for --help)."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of all commands."""
        return sorted(m.name.strip("_") for m in pkgutil.iter_modules(bench.commands.__path__))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of that name; a file whose name would be a keyword of Python ends in an underscore."""
        for name in (cmd_name, f"{cmd_name}_"):
            if any(m.name == name for m in pkgutil.iter_modules(bench.commands.__path__)):
                command: click.Command = import_module(f"bench.commands.{name}").command
                for option in command.params:
                    if isinstance(option, click.Option) and option.multiple and option.help:
                        option.help = f"{option.help.removesuffix(REPEATED)}{REPEATED}"
                return command
        return None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; raises UsageError where one takes a single vehicle or method, and two are named.

        click takes the last, and the other would be dropped without a word. Of numbers the last is meant.
        """
        name, command, rest = super().resolve_command(ctx, args)
        if command is not None:
            own = click.Context(command, parent=ctx, info_name=name, **command.context_settings)
            try:
                *_, order = command.make_parser(own).parse_args(args=list(rest))
            except click.UsageError as error:
                error.ctx = error.ctx or own  # click names no command of an option without its value
                raise
            for option, times in Counter(order).items():
                one = isinstance(option, click.Option) and option.name in NAMED and not option.multiple
                if one and times > 1:
                    raise click.UsageError(f"{option.opts[-1]} takes one value; {times} are given", own)
        return name, command, rest

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; raises ReaderLeft where click and rich would end with 1, the gate's regression."""
        try:
            return super().invoke(ctx)
        except (BrokenPipeError, SystemExit) as error:
            if BrokenPipeError in (type(error), type(error.__context__)):  # rich raises SystemExit from it
                raise ReaderLeft from None
            raise


class ReaderLeft(Exception):
    """The program that read our output has closed it, as `| head` does."""


@click.command(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="thrustbench")
def cli() -> None:
    """Cost of constrained thrust allocation on an onboard computer, and its worth, measured."""


def open_closed_streams() -> None:
    """Open the null device in place of standard streams that the caller closed, as ``>&-`` does.

    Python has None in their place; and the next file that is opened would get the stream's number, and
    with it what a library prints.
    """
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        if getattr(sys, name) is None:
            null = os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
            if null != number:
                os.dup2(null, number)
                os.close(null)
            os.set_inheritable(number, True)  # standard streams are
            setattr(sys, name, os.fdopen(number, mode, closefd=False))


def _refuse(line: str) -> None:
    """Print an error on one line; a file's name in it, or what somebody's code raised, may hold anything."""
    from bench.commands import echo

    echo(line.replace("\n", " "), err=True)


def main() -> None:
    """Run the command line; bad input ends with exit code 2 and one line on stderr."""
    open_closed_streams()
    if isinstance(sys.stdout, TextIOWrapper):  # a letter that the terminal lacks is printed as its number
        sys.stdout.reconfigure(errors="backslashreplace")
    # sys.exit ends worker processes and removes temporary folders on the way out, as Ctrl-C does.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    try:
        code = cli.main(standalone_mode=False)
        sys.stdout.flush()
    except click.exceptions.Abort:
        code = 130
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        place = context.command_path if context else "thrustbench"
        message = " ".join(error.format_message().split()).removesuffix(".")
        _refuse(f"{place}: {message}; see '{place} --help'")
        code = 2
    except (ReaderLeft, BrokenPipeError):
        # Python flushes the rest of the buffer as it ends, which must not fail once more.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 128 + signal.SIGPIPE  # the shell's code for a program ended by SIGPIPE: no verdict
    except OSError as error:  # a full disk, a folder in a file's place: the machine's fault
        where = f"{error.filename}: " if error.filename else ""
        reason = (error.strerror or str(error)).lower()
        _refuse(f"thrustbench: {where}{reason}; make room there or name another place")
        code = 2
    except MemoryError:
        _refuse("thrustbench: out of memory; ask for fewer demands, or give a smaller file")
        code = 2
    except Exception as error:
        from alloc import AllocError

        if not isinstance(error, AllocError):
            raise
        _refuse(f"thrustbench: {error}")
        code = 2
    sys.exit(code if isinstance(code, int) else 0)


if __name__ == "__main__":
    main()
