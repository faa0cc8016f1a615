"""The command line. Each file in ``bench/commands`` is one command, found by its name."""

import pkgutil
import sys
from importlib import import_module

import click

import bench.commands


class Commands(click.Group):
    """Finds commands by file name and imports only the one that is called (or all, for --help)."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of all commands."""
        return sorted(m.name.strip("_") for m in pkgutil.iter_modules(bench.commands.__path__))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of that name; a trailing underscore in the file name dodges Python's keywords."""
        for name in (cmd_name, f"{cmd_name}_"):
            if any(m.name == name for m in pkgutil.iter_modules(bench.commands.__path__)):
                command: click.Command = import_module(f"bench.commands.{name}").command
                return command
        return None


@click.command(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="thrustbench")
def cli() -> None:
    """What constrained thrust allocation costs on an onboard computer, and what it buys, measured."""


def main() -> None:
    """Run the command line; bad input ends with exit code 2 and one line on stderr."""
    try:
        code = cli.main(standalone_mode=False)
    except click.exceptions.Abort:
        code = 130
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        place = context.command_path if context else "thrustbench"
        message = " ".join(error.format_message().split())
        print(f"{place}: {message}; see '{place} --help'", file=sys.stderr)
        code = 2
    except BrokenPipeError:  # the reader of our output left early, as `| head` does
        sys.stderr.close()
        code = 0
    except Exception as error:
        from alloc import AllocError

        if not isinstance(error, AllocError):
            raise
        print("thrustbench:", str(error).replace("\n", " "), file=sys.stderr)  # a file's name may have one
        code = 2
    sys.exit(code if isinstance(code, int) else 0)


if __name__ == "__main__":
    main()
