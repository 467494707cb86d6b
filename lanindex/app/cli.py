"""The command ``lanindex``: a table of verbs, each imported only when it is called."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from itertools import pairwise
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from lanindex.app.output import end_progress, escaped, how_far, say_error
from lanindex.errors import LanindexError, UsageError, guess

VERBS = {
    "demo": "See it all happen on the choreographies that come with it",
    "ingest": "Read captures and scores into the library",
    "search": "Find movement by pattern",
    "similar": "Group the captures that are like each other",
    "motifs": "List the sequences of symbols that recur",
    "export": "Write hits as clips, in the format they came in",
    "show": "Show the symbols of a capture",
    "score": "Draw a capture or a score as a staff of Labanotation",
    "diff": "Say what two captures or scores differ in",
    "play": "Let a stick figure move beside its staff, as a film",
    "list": "List the captures of the library",
    "stats": "Say what the library holds",
    "remove": "Take captures out of the library",
    "inspect": "Say what a reader sees in a capture file",
    "convert": "Write a capture down as LND, without a library",
    "animate": "Let a standard body carry out a score",
    "evaluate": "Measure patterns against labelled captures",
    "db": "Look after the library: status, upgrade, check",
    "words": "Show the dictionary of movement: names for patterns",
    "language": "Show the language of patterns on a page",
    "guide": "Read the guide, a topic at a time",
}
SETTINGS: dict[str, Any] = {
    "add_completion": False,
    "rich_markup_mode": None,
    "pretty_exceptions_enable": False,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}


RARELY = 100_000
"""Objects after which Python looks for garbage: rows and hits by the thousand hold none."""

COMPLETE = "_LANINDEX_COMPLETE"
"""The variable in which a shell asks what may come next."""

_BAD_CALL: Any = typer.BadParameter.__base__
"""What the parser of arguments raises; only its child has a public name."""


class Verbs(TyperGroup):
    """The group of all verbs; imports a verb when it is called."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the verbs in the order of the table."""
        return list(VERBS)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the verb that was typed; refuse what is none with the nearest one."""
        if args and args[0] not in VERBS and not ctx.resilient_parsing:
            near = guess(args[0].lower(), VERBS)
            remedy = f"Did you mean {near}?" if near else "All are shown by: lanindex --help"
            raise UsageError(f'"{args[0]}" is no verb', remedy=remedy)
        return super().resolve_command(ctx, args)

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

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the options that stand before the verb."""
        with _told(ctx):
            return list(super().parse_args(ctx, args))

    def invoke(self, ctx: Any) -> Any:
        """Run a verb; turn errors into one message and an exit code."""
        with _told(ctx):
            _refuse_empty(ctx.args)
            result = super().invoke(ctx)
            sys.stdout.flush()
            return result


@contextmanager
def _told(ctx: Any) -> Iterator[None]:
    """Tell errors in one message, and escape what the parser repeats of the arguments."""
    try:
        yield
    except _BAD_CALL as error:
        lines = (error.message or "").split("\n")  # where nothing was asked, the help is in it
        error.message = "\n".join(map(escaped, lines))
        raise
    except (LanindexError, MemoryError, OSError, KeyboardInterrupt) as error:
        far = how_far()
        end_progress()
        raise typer.Exit(_reported(error, ctx.invoked_subcommand, far)) from error


def _reported(error: BaseException, verb: str | None, far: str) -> int:
    """Say what broke a verb off, and return its exit code."""
    match error:
        case LanindexError():
            say_error(error)
            return 2
        case MemoryError():
            say_error(f"out of memory{far}. Do it in parts: --in, --where or fewer files.")
            return 2
        case BrokenPipeError():
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        case OSError():
            say_error(f"standard output: cannot be written ({error.strerror})")
            return 2
        case _:
            kept = "; what was finished is kept" if verb == "ingest" else ""
            say_error(f"interrupted{far}{kept}")
            return 130


def _refuse_empty(words: Sequence[str]) -> None:
    """Refuse an empty argument: mostly a variable of the shell that is not set."""
    for before, word in pairwise(["", *words]):
        if not word or (word.startswith("--") and word.find("=") == len(word) - 1):
            option = (word or before).rstrip("=")
            place = option if option.startswith("-") else ""
            raise UsageError("an empty argument", place=place, wanted="something in it")


def _version(wanted: bool) -> None:
    if wanted:
        import lanindex

        print(f"lanindex {lanindex.__version__}")
        raise typer.Exit


def _complete(doing: str) -> Callable[[bool], None]:
    """Return what installs or shows the completion of a shell."""

    def act(wanted: bool) -> None:
        if wanted:
            from lanindex.app import completion

            getattr(completion, doing)()
            raise typer.Exit

    return act


app = typer.Typer(cls=Verbs, no_args_is_help=True, **SETTINGS)


@app.callback()
def lanindex(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Say which version."),
    ] = False,
    install_completion: Annotated[
        bool,
        typer.Option(
            "--install-completion",
            callback=_complete("install"),
            is_eager=True,
            help="Let your shell complete verbs and options.",
        ),
    ] = False,
    show_completion: Annotated[
        bool,
        typer.Option(
            "--show-completion",
            callback=_complete("show"),
            is_eager=True,
            help="Show what that installs.",
        ),
    ] = False,
) -> None:
    """Find human movement by what it is.

    Motion captures are written down as Labanotation; a pattern such as "r_arm right mid -> high"
    finds the clips, to the frame.
    """


def _read_as_unicode() -> None:
    """Begin again where the locale cannot spell what archives hold: names beyond ASCII."""
    if sys.getfilesystemencoding() == "ascii" and "utf8" not in sys._xoptions:
        os.execv(sys.executable, [sys.executable, "-X", "utf8", *sys.orig_argv[1:]])


def main() -> None:
    """Run the command."""
    _read_as_unicode()
    gc.set_threshold(RARELY)
    if COMPLETE in os.environ:
        from typer._completion_classes import completion_init

        completion_init()
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # the caller has closed it
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 (lasts as long as we do)
        getattr(sys, name).reconfigure(errors="backslashreplace")
    words = (f" {word}" if word.startswith("->") else word for word in sys.argv[1:])
    app(list(words), prog_name="lanindex")  # a pattern may begin with an arrow, and is no option
