"""The command ``lanindex``: the table of verbs, how they are called, how errors are reported."""

import gc
import os
import re
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from itertools import pairwise
from threading import Timer
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from lanindex import compiled
from lanindex.app.options import flag, ungrouped
from lanindex.app.output import Output, end_progress, escaped, how_far, say_error
from lanindex.data import shipped
from lanindex.errors import LanindexError, UsageError, did_you_mean

VERBS: dict[str, list[str]] = shipped("app/verbs.toml")["verbs"]
"""For each verb, its function in `lanindex.app.commands` and a summary for the help."""

SECTIONS: dict[str, str] = shipped("app/verbs.toml")["sections"]
"""The sections of a help, in order, with the options that are not a verb's own."""

SETTINGS: dict[str, Any] = {
    "add_completion": False,
    "rich_markup_mode": None,
    "pretty_exceptions_enable": False,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}

COMPLETION = "_LANINDEX_COMPLETE"
"""The environment variable in which a shell asks for completions."""

SHELLS = ("bash", "zsh", "fish", "powershell", "pwsh")

GARBAGE_THRESHOLD = 100_000
"""How many new objects start a garbage collection: thousands of rows and hits hold no cycles."""

INTERRUPTED = 130
"""The code with which a command ends that was interrupted."""

_GRACE = 3.0  # seconds that its threads have then

_APART = re.compile(r"""("[^"]*"?|'[^']*'?)| ([:=]+)(?: |$)""")
"""What is quoted, or signs at which bash ends a word, with the blanks around them."""

_ParserError: Any = typer.BadParameter.__base__
"""The base class of the argument parser's errors, which typer exports only by its subclass."""


class Verb(TyperCommand):
    """A verb, whose help has its options by what they are about."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the sections of the help."""
        titles = {name: title for title, names in SECTIONS.items() for name in names.split()}
        sections: dict[str, list[tuple[str, str]]] = {title: [] for title in SECTIONS}
        for parameter in self.get_params(ctx):
            own = "Options" if parameter.param_type_name == "option" else "Arguments"
            own = getattr(parameter, "rich_help_panel", None) or own
            if record := parameter.get_help_record(ctx):
                sections[titles.get(str(parameter.name), own)].append(record)
        for title, records in sections.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)


class Verbs(TyperGroup):
    """The group of all verbs, which imports the module of a verb only when the verb is called."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the verbs in the order of the table."""
        return list(VERBS)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the verb; for an unknown one, raise an error that suggests the most similar."""
        if args and args[0] not in VERBS and not ctx.resilient_parsing:
            remedy = did_you_mean(args[0].lower(), VERBS) or "All are shown by: lanindex --help"
            raise UsageError(f'"{args[0]}" is not a verb', remedy=remedy)
        return super().resolve_command(ctx, args)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Import a verb's module and return its command."""
        if cmd_name not in VERBS:
            return None
        module, _, function = VERBS[cmd_name][0].partition(".")
        verb = getattr(import_module(f"lanindex.app.commands.{module}"), function)
        app = typer.Typer(**SETTINGS)
        for name, run in verb.items() if isinstance(verb, dict) else [(cmd_name, verb)]:
            app.command(name, cls=Verb)(ungrouped(run))
        if isinstance(verb, dict):  # a group of verbs, such as db
            app.info.no_args_is_help = True
            app.info.help = VERBS[cmd_name][1] + "."
        command = typer.main.get_command(app)
        command.name = cmd_name
        return command

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the table of verbs, without importing their modules."""
        with formatter.section("Verbs"):
            formatter.write_dl([(verb, summary) for verb, (_, summary) in VERBS.items()])

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the options before the verb."""
        with _errors_reported(ctx):
            return list(super().parse_args(ctx, args))

    def invoke(self, ctx: Any) -> Any:
        """Run a verb; turn an error into one message and an exit code."""
        with _errors_reported(ctx):
            _refuse_empty_arguments(ctx.args)
            result = super().invoke(ctx)
            sys.stdout.flush()
            return result


@contextmanager
def _errors_reported(ctx: Any) -> Iterator[None]:
    """Report an error as one message; escape the arguments that the parser's message repeats."""
    try:
        yield
    except _ParserError as error:
        lines = (error.message or "").split("\n")  # the help, if there are no arguments
        error.message = "\n".join(map(escaped, lines))
        raise
    except BrokenPipeError:
        end_progress()
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit from None
    except (LanindexError, MemoryError, OSError, KeyboardInterrupt) as error:
        progress = how_far()
        end_progress()
        say_error(error if isinstance(error, LanindexError) else _message(error, ctx, progress))
        raise typer.Exit(INTERRUPTED if isinstance(error, KeyboardInterrupt) else 2) from error


def _message(error: BaseException, ctx: Any, progress: str) -> str:
    """Return the message for an error that is not one of LanIndex."""
    if isinstance(error, MemoryError):
        return f"out of memory{progress}. Do it in parts: --in, --where or fewer files."
    if isinstance(error, OSError):
        return f"standard output: cannot be written ({error.strerror})"
    kept = "; what was finished is kept" if ctx.invoked_subcommand == "ingest" else ""
    return f"interrupted{progress}{kept}"


def _refuse_empty_arguments(arguments: Sequence[str]) -> None:
    """Refuse an empty argument, which usually comes from an unset variable of the shell."""
    for before, word in pairwise(["", *arguments]):
        if not word or (word.startswith("--") and word.find("=") == len(word) - 1):
            option = (word or before).rstrip("=")
            place = option if option.startswith("-") else ""
            raise UsageError("an empty argument", place=place, wanted="a value")


app = typer.Typer(cls=Verbs, no_args_is_help=True, invoke_without_command=True, **SETTINGS)


@app.callback()
def lanindex(
    version: bool = flag("--version", "Print the version."),
    install_completion: bool = flag("--install-completion", "Install completion for your shell."),
    show_completion: bool = flag("--show-completion", "Print the script for completion."),
) -> None:
    """Find human movement by what it is.

    Motion captures are written as Labanotation; a pattern such as "r_arm right mid -> high"
    finds the clips, to the frame.
    """
    if version:
        from lanindex import __version__

        print(f"lanindex {__version__}")
    elif install_completion:
        _install_completion()
    elif show_completion:
        from typer._completion_shared import get_completion_script

        names = {"prog_name": "lanindex", "complete_var": COMPLETION}
        Output().text(get_completion_script(**names, shell=_shell()))
    else:
        return
    raise typer.Exit


def _install_completion() -> None:
    from typer._completion_shared import install

    try:
        shell, path = install(shell=_shell(), prog_name="lanindex", complete_var=COMPLETION)
    except OSError as error:
        raise LanindexError(
            f"cannot be written ({error.strerror})", place=str(error.filename)
        ) from error
    Output().note(f"{path}: completes lanindex in {shell} from its next start on")


def _shell() -> str:
    from shellingham import ShellDetectionFailure, detect_shell

    try:
        shell = str(detect_shell()[0])
    except ShellDetectionFailure:
        shell = os.path.basename(os.environ.get("SHELL", ""))
    if shell not in SHELLS:
        raise UsageError(f'no shell that is known ("{shell}")', wanted=" or ".join(SHELLS))
    return shell


def _join_words() -> None:
    """Join what bash takes apart at : = and @, such as the address of a library."""
    typed, at = os.environ.get("COMP_WORDS", ""), os.environ.get("COMP_CWORD", "")
    if at:
        joined = _APART.sub(lambda found: found[1] or found[2], typed)
        joined = re.sub(r"(://\S*) @ ", r"\1@", joined)
        at = str(int(at) - (len(typed) - len(joined)))  # a blank less is a word less
        os.environ.update({"COMP_WORDS": joined, "COMP_CWORD": at})


def run(arguments: Sequence[str]) -> int:
    """Run the command in this process and return its exit code."""
    # a pattern that begins with an arrow is not an option
    words = (f" {word}" if word.startswith("->") else word for word in arguments)
    try:
        app(list(words), prog_name="lanindex")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return 0


def main() -> None:
    """Run the command as the entry point of a process."""
    if sys.getfilesystemencoding() == "ascii" and "utf8" not in sys._xoptions:
        # this locale cannot encode the non-ASCII file names of archives: restart with UTF-8
        os.execv(sys.executable, [sys.executable, "-X", "utf8", *sys.orig_argv[1:]])
    gc.set_threshold(GARBAGE_THRESHOLD)
    compiled.without_scipy()
    # who asks it to end asks as Ctrl-C does: temporary files and folders go
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    if COMPLETION in os.environ:  # the shell calls for completions
        from typer._completion_classes import completion_init

        _join_words()
        completion_init()
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # the caller closed the stream
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 (open until the process ends)
        getattr(sys, name).reconfigure(errors="backslashreplace")
    code = run(sys.argv[1:])
    if code == INTERRUPTED:  # a thread that works on for nobody is not waited for
        end = Timer(_GRACE, os._exit, [code])
        end.daemon = True
        end.start()
    sys.exit(code)
