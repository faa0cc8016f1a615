"""Text of --help: each command on a line of its own, and a description of each option."""

import click
import pytest
from click.testing import CliRunner

from bench.__main__ import REPEATED, cli

COMMANDS = cli.list_commands(click.Context(cli))


def test_each_command_has_a_whole_sentence_on_its_line_of_80_columns() -> None:
    shown = CliRunner().invoke(cli, ["--help"], terminal_width=80).output.partition("Commands:\n")[2]
    lines = dict(line.split(maxsplit=1) for line in shown.splitlines())
    assert sorted(lines) == COMMANDS
    assert {name: said for name, said in lines.items() if said.endswith("...")} == {}


@pytest.mark.parametrize("name", COMMANDS)
def test_each_option_says_what_it_does_and_whether_it_may_be_repeated(name: str) -> None:
    for _ in range(2):  # a second look at a command adds nothing
        command = cli.get_command(click.Context(cli), name)
        assert command is not None
        for option in command.params:
            if isinstance(option, click.Option):
                assert option.help, option.name
                assert option.help.count(REPEATED) == option.multiple, option.name
