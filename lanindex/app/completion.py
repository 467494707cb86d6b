"""The completion of verbs and options by a shell, installed or shown where that is asked for."""

from __future__ import annotations

import os

from lanindex.app.cli import COMPLETE
from lanindex.app.output import Output
from lanindex.errors import LanindexError, UsageError

SHELLS = ("bash", "zsh", "fish", "powershell", "pwsh")


def install() -> None:
    """Install it for the shell that runs this."""
    from typer._completion_shared import install

    try:
        shell, path = install(shell=_shell(), prog_name="lanindex", complete_var=COMPLETE)
    except OSError as error:
        raise LanindexError(
            f"cannot be written ({error.strerror})", place=str(error.filename)
        ) from error
    Output().note(f"{path}: completes lanindex in {shell} from its next start on")


def show() -> None:
    """Print what `install` would install."""
    from typer._completion_shared import get_completion_script

    script = get_completion_script(prog_name="lanindex", complete_var=COMPLETE, shell=_shell())
    Output().text(script)


def _shell() -> str:
    from shellingham import ShellDetectionFailure, detect_shell

    try:
        found = str(detect_shell()[0])
    except ShellDetectionFailure:
        found = os.path.basename(os.environ.get("SHELL", ""))
    if found not in SHELLS:
        raise UsageError(f'no shell that is known ("{found}")', wanted=" or ".join(SHELLS))
    return found
