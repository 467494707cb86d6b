"""Where results and notes go: standard output and standard error, for people and for pipes."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from lanindex.errors import UsageError

ESCAPED = {code: f"\\x{code:02x}" for code in (*range(32), 127)}
"""Control characters, as they are shown where a line is a record."""

STYLES = {"path": "35", "place": "32", "match": "1;31", "dim": "2", "warn": "33"}
"""Terminal styles by meaning (ECMA-48)."""


@dataclass(frozen=True)
class Output:
    """What the user asked to see.

    Attributes
    ----------
    json : bool
        JSON lines on standard output.
    quiet, verbose : bool
        Less or more on standard error.
    color : str
        ``auto``, ``always`` or ``never``.
    """

    json: bool = False
    quiet: bool = False
    verbose: bool = False
    color: str = "auto"

    def __post_init__(self) -> None:
        """Check the choice of colour."""
        one_of("--color", self.color, ("auto", "always", "never"))

    @property
    def terminal(self) -> bool:
        """Whether a person reads standard output as it is."""
        return sys.stdout.isatty() and not self.json

    def paint(self, text: str, style: str) -> str:
        """Return text in a style, where colours are wanted."""
        wanted = self.color == "always" or (
            self.color == "auto" and self.terminal and not os.environ.get("NO_COLOR")
        )
        return f"\x1b[{STYLES[style]}m{text}\x1b[0m" if wanted else text

    def line(self, line: str = "") -> None:
        """Print a line of results."""
        print(line)

    def record(self, values: dict[str, Any]) -> None:
        """Print a result as a line of JSON."""
        print(json.dumps(values, ensure_ascii=False))

    def row(self, values: Iterable[Any]) -> None:
        """Print a result as fields between tabs."""
        print("\t".join(str(value).translate(ESCAPED) for value in values))

    def note(self, line: str) -> None:
        """Say something beside the results, unless it shall be quiet."""
        if not self.quiet:
            print(line, file=sys.stderr, flush=True)

    def detail(self, line: str) -> None:
        """Say something that only the curious want to know."""
        if self.verbose:
            print(line, file=sys.stderr, flush=True)

    def table(self, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
        """Print rows in columns, numbers to the right; tab-separated in a pipe."""
        lines = [[str(cell) for cell in row] for row in rows]
        if not self.terminal:
            for line in [list(head), *lines]:
                self.row(line)
            return
        widths = [max(map(len, column)) for column in zip(head, *lines, strict=True)]
        for index, line in enumerate([list(head), *lines]):
            cells = [
                cell.rjust(width) if _numeric(cell) else cell.ljust(width)
                for cell, width in zip(line, widths, strict=True)
            ]
            text = "  ".join(cells).rstrip()
            self.line(self.paint(text, "dim") if index == 0 else text)

    def progress(self, things: Iterator[Any], total: int, noun: str) -> Iterator[Any]:
        """Yield things and, on a terminal, keep count of them on standard error."""
        shown = sys.stderr.isatty() and not self.quiet
        try:
            for index, thing in enumerate(things, 1):
                if shown:
                    print(f"\r{index}/{total} {noun}", end="", file=sys.stderr, flush=True)
                yield thing
        finally:
            if shown:
                print("\r\x1b[K", end="", file=sys.stderr, flush=True)


def _numeric(cell: str) -> bool:
    return cell.replace(".", "", 1).lstrip("-").isdigit()


def one_of(name: str, value: str, choices: Sequence[str]) -> str:
    """Return `value` if it is one of the choices.

    Raises
    ------
    UsageError
        Where it is not.
    """
    if value not in choices:
        raise UsageError(f'"{value}"', place=name, wanted=" or ".join(choices))
    return value
