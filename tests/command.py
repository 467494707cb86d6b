"""The command `lanindex` for tests: called in this process, started as one, or on a terminal."""

import gc
import io
import os
import pty
import re
import subprocess
import sys
from contextlib import chdir
from pathlib import Path
from unittest import mock

from lanindex.app import cli, output

Done = subprocess.CompletedProcess[str]
COMMAND = [sys.executable, "-W", "error", "-m", "lanindex"]
CONTROL = re.compile(
    r"\x1b\[(?P<number>\d*)(?P<kind>[AK])|\x1b\[\?25[lh]|(?P<end>[\r\n])|(?P<text>.)"
)


class Terminal(io.TextIOWrapper):
    """A stream that looks like a terminal."""

    def isatty(self) -> bool:
        return True


def run(
    *words: str | Path,
    cwd: Path | str = ".",
    text: str | bytes = "",
    env: dict[str, str] | None = None,
) -> Done:
    """Call the command in this process, between pipes; `text` is its standard input."""
    out, errors = _stream(io.BytesIO()), _stream(io.BytesIO())
    code = _call(words, cwd, text, out, errors, {"NO_COLOR": "1", "COLUMNS": "80", **(env or {})})
    return Done(list(map(str, words)), code, _written(out), _written(errors))


def shown(*words: str | Path, cwd: Path | str = ".", columns: int = 200, **env: str) -> str:
    """Return what the command, called in this process, writes to a terminal."""
    out = _stream(io.BytesIO(), Terminal)
    known = {"TERM": "xterm", "NO_COLOR": "1", "COLUMNS": str(columns), **env}
    _call(words, cwd, "", out, out, known)
    return _written(out)


def start(
    *words: str | bytes | Path, cwd: Path | str = ".", text: str = "", env: dict | None = None
) -> Done:
    """Run the command in a process of its own, between pipes."""
    return subprocess.run(
        [*COMMAND, *words],
        cwd=cwd,
        input=text,
        capture_output=True,
        text=True,
        env={**os.environ, "NO_COLOR": "1", **(env or {})},
        check=False,
        timeout=120,
    )


def start_on_terminal(command: str | list[str], cwd: Path, columns: int = 200, **env: str) -> str:
    """Return what a process, or a line of a shell, writes to its terminal."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        command,
        shell=isinstance(command, str),
        cwd=cwd,
        stdin=subprocess.DEVNULL,
        stdout=theirs,
        stderr=theirs,
        env={**os.environ, "TERM": "xterm", "NO_COLOR": "1", "COLUMNS": str(columns), **env},
    )
    os.close(theirs)
    seen = b""
    while True:
        try:
            chunk = os.read(ours, 65536)
        except OSError:  # the other end is closed
            break
        if not chunk:
            break
        seen += chunk
    os.close(ours)
    process.wait()
    return seen.decode().replace("\r\n", "\n")


def screen(text: str) -> str:
    """Return what a terminal shows in the end of what was written to it."""
    lines, row, column = [""], 0, 0
    for match in CONTROL.finditer(text):
        if match["kind"] == "A":
            row = max(0, row - int(match["number"] or 1))
        elif match["kind"] == "K":
            lines[row] = "" if match["number"] == "2" else lines[row][:column]
        elif match["end"] == "\r":
            column = 0
        elif match["end"] == "\n":
            row, column = row + 1, 0
            lines += [""] * (row + 1 - len(lines))
        elif match["text"]:
            lines[row] = (
                lines[row][:column].ljust(column) + match["text"] + lines[row][column + 1 :]
            )
            column += 1
    return "\n".join(lines)


def _call(words, cwd, text: str | bytes, out, errors, env: dict[str, str]) -> int:
    """Call `main` as its console script would, and leave no trace of it in this process."""
    given = text if isinstance(text, bytes) else text.encode("utf-8")
    streams = {"stdin": _stream(io.BytesIO(given)), "stdout": out, "stderr": errors}
    argv = ["lanindex", *map(str, words)]
    thresholds = gc.get_threshold()
    try:
        held = mock.patch.multiple(sys, argv=argv, **streams)
        with chdir(cwd), mock.patch.dict(os.environ, env), held:
            cli.main()
    except SystemExit as exit:
        return exit.code if isinstance(exit.code, int) else int(exit.code is not None)
    finally:
        output.end_progress()
        gc.set_threshold(*thresholds)
    return 0


def _stream(raw: io.BytesIO, kind=io.TextIOWrapper) -> io.TextIOWrapper:
    return kind(raw, encoding="utf-8", write_through=True)


def _written(stream: io.TextIOWrapper) -> str:
    return stream.buffer.getvalue().decode("utf-8", "surrogateescape")
