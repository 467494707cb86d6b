"""The command ``lanindex``: a table of verbs, each imported only when it is called."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from itertools import pairwise
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from lanindex.errors import LanindexError, UsageError

VERBS = {
    "demo": "See it all happen on the choreographies that come with it",
    "ingest": "Read captures and scores into the library",
    "search": "Find movement by pattern",
    "export": "Write hits as clips, in the format they came in",
    "show": "Show the symbols of a capture",
    "list": "List the captures of the library",
    "stats": "Say what the library holds",
    "remove": "Take captures out of the library",
    "inspect": "Say what a reader sees in a capture file",
    "convert": "Write a capture down as LND, without a library",
    "animate": "Let a standard body carry out a score",
    "evaluate": "Measure patterns against labelled captures",
    "db": "Look after the library: status, upgrade, check",
}
SETTINGS: dict[str, Any] = {
    "add_completion": False,
    "rich_markup_mode": None,
    "pretty_exceptions_enable": False,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}


class Verbs(TyperGroup):
    """The group of all verbs; imports a verb when it is called."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the verbs in the order of the table."""
        return list(VERBS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Import a verb's module and return its command."""
        if cmd_name not in VERBS:
            return None
        module = import_module(f"lanindex.app.commands.{cmd_name}")
        if hasattr(module, "app"):
            app = module.app
        else:
            app = typer.Typer(**SETTINGS)
            app.command(cmd_name)(module.run)
        command = typer.main.get_command(app)
        command.name = cmd_name
        return command

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the table of verbs without importing any."""
        with formatter.section("Verbs"):
            formatter.write_dl(list(VERBS.items()))

    def invoke(self, ctx: Any) -> Any:
        """Run a verb; turn errors into one message and an exit code."""
        try:
            _refuse_empty(ctx.args)
            result = super().invoke(ctx)
            sys.stdout.flush()
            return result
        except LanindexError as error:
            say_error(str(error))
            raise typer.Exit(2) from error
        except BrokenPipeError as error:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(0) from error
        except OSError as error:
            say_error(f"standard output: cannot be written ({error.strerror})")
            raise typer.Exit(2) from error
        except KeyboardInterrupt as error:
            kept = "; what was finished is kept" if ctx.invoked_subcommand == "ingest" else ""
            say_error(f"interrupted{kept}")
            raise typer.Exit(130) from error


def _refuse_empty(words: Sequence[str]) -> None:
    """Refuse an empty argument: mostly a variable of the shell that is not set."""
    for before, word in pairwise(["", *words]):
        if not word or (word.startswith("--") and word.endswith("=")):
            option = (word or before).rstrip("=")
            place = option if option.startswith("-") else ""
            raise UsageError("an empty argument", place=place, wanted="something in it")


def say_error(message: str) -> None:
    """Print an error as users see it, on standard error; a drawing stands by itself."""
    print(message if "\n" in message else f"lanindex: {message}", file=sys.stderr)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"lanindex {version('lanindex')}")
        raise typer.Exit


app = typer.Typer(cls=Verbs, no_args_is_help=True, **SETTINGS)


@app.callback()
def lanindex(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Say which version."),
    ] = False,
) -> None:
    """Find human movement by what it is.

    Motion captures are written down as Labanotation; a pattern such as "r_arm right mid -> high"
    finds the clips, to the frame.
    """


def main() -> None:
    """Run the command."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # the caller has closed it
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 (lasts as long as we do)
        getattr(sys, name).reconfigure(errors="backslashreplace")
    words = (f" {word}" if word.startswith("->") else word for word in sys.argv[1:])
    app(list(words), prog_name="lanindex")  # a pattern may begin with an arrow, and is no option
