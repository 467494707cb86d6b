"""A terminal for tests: what a command writes to it, and what a person then sees."""

import os
import pty
import re
import subprocess
from pathlib import Path

CONTROL = re.compile(
    r"\x1b\[(?P<number>\d*)(?P<kind>[AK])|\x1b\[\?25[lh]|(?P<end>[\r\n])|(?P<text>.)"
)


def written(command: str | list[str], place: Path, columns: int = 200, **env: str) -> str:
    """Return what a command writes to its terminal, output and notes together."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        command,
        shell=isinstance(command, str),
        cwd=place,
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
    """Return what stands on the terminal in the end."""
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
