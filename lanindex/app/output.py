"""What reaches standard output and standard error, for people and for pipes.

Whatever comes from files, tables, names or arguments is escaped here, so that no character of it
can steer the terminal.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from time import monotonic
from typing import TYPE_CHECKING, Any, TextIO

from lanindex.errors import PatternError, UsageError

if TYPE_CHECKING:
    from lanindex.app.progress import Bar

_CONTROLS = (*range(0x20), *range(0x7F, 0xA0))
_UNSEEN = (0x061C, 0x200E, 0x200F, *range(0x2028, 0x202F), *range(0x2066, 0x206A))
ESCAPED = {code: f"\\x{code:02x}" for code in _CONTROLS} | {
    code: f"\\u{code:04x}" for code in _UNSEEN
}
ESCAPED |= {0xDC00 + byte: f"\\x{byte:02x}" for byte in range(0x80, 0x100)}
"""Characters that would steer a terminal (C0, DEL, C1) or invisibly turn and break its lines
(bidirectional marks, line and paragraph separators), and bytes of a file's name that are not UTF-8,
each with what is shown instead."""

_IN_JSON = {code: f"\\u{code:04x}" for code in ESCAPED if code >= 0x7F}

STYLES = {"path": "35", "place": "32", "match": "1;31", "dim": "2", "warn": "33"}
"""Terminal styles by meaning (ECMA-48)."""

PATIENCE = 0.5
"""Seconds before a job's progress is shown."""

_bars: list[Bar] = []


class Painted(str):
    """Text already escaped, with the program's own colours."""

    __slots__ = ()


def escaped(text: str) -> str:
    r"""Return text that is safe to print: what would steer a terminal is escaped.

    Examples
    --------
    >>> from lanindex.app.output import escaped
    >>> print(escaped("walk\x1b[31m.bvh"))
    walk\x1b[31m.bvh
    """
    return text if isinstance(text, Painted) or text.isprintable() else text.translate(ESCAPED)


@dataclass(frozen=True)
class Output:
    """What the user asked to see."""

    json: bool = False
    quiet: bool = False
    verbose: bool = False
    color: str = "auto"

    def __post_init__(self) -> None:
        """Check the choice of colour."""
        choice("--color", self.color, ("auto", "always", "never"))

    @property
    def terminal(self) -> bool:
        """Whether standard output is a terminal and not JSON."""
        return sys.stdout.isatty() and not self.json

    @property
    def unicode(self) -> bool:
        """Whether standard output can print every character."""
        return (sys.stdout.encoding or "").lower().startswith("utf")

    def paint(self, text: str, style: str) -> str:
        """Return text in a style, if colours are on."""
        wanted = self.color == "always" or (
            self.color == "auto" and self.terminal and not os.environ.get("NO_COLOR")
        )
        return Painted(f"\x1b[{STYLES[style]}m{escaped(text)}\x1b[0m") if wanted else text

    def line(self, *pieces: str) -> None:
        """Print a line of results, made of plain and painted pieces."""
        _say("".join(map(escaped, pieces)), sys.stdout)

    def text(self, text: str) -> None:
        """Print lines of results."""
        for line in text.split("\n"):
            self.line(line)

    def content(self, text: str) -> None:
        """Print a file: unchanged to a pipe, escaped to a terminal."""
        if self.terminal:
            self.text(text.removesuffix("\n"))
        else:
            _say(text.removesuffix("\n"), sys.stdout)

    def record(self, values: dict[str, Any]) -> None:
        """Print a result as a JSON line."""
        line = _encode(ascii=not self.unicode)(values)
        plain = line.isascii() and "\x7f" not in line  # JSON escapes all before the space
        if not plain and not line.isprintable():
            line = line.translate(_IN_JSON)
        _say(line, sys.stdout)

    def row(self, values: Iterable[Any]) -> None:
        """Print a result as tab-separated fields."""
        texts = list(map(str, values))
        if not "".join(texts).isprintable():
            texts = list(map(escaped, texts))
        _say("\t".join(texts), sys.stdout)

    def note(self, line: str) -> None:
        """Print a note on standard error, unless --quiet."""
        if not self.quiet:
            _say(escaped(line), sys.stderr)

    def detail(self, line: str) -> None:
        """Print a note on standard error if --verbose."""
        if self.verbose:
            _say(escaped(line), sys.stderr)

    def table(self, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
        """Print rows: as columns that fit the terminal, tab-separated to a pipe."""
        lines = [[escaped(str(cell)) for cell in row] for row in [head, *rows]]
        if not self.terminal:
            for line in lines:
                self.row(line)
            return
        from lanindex.app.columns import aligned

        for index, text in enumerate(aligned(lines)):
            self.line(self.paint(text, "dim") if index == 0 else text)

    def watch(self, noun: str, done: int, total: int) -> None:
        """Note how far a job is; show it on a terminal if the job takes a while."""
        _job.update(noun, done, total, shown=self.watched, colors=self.color != "never")

    @property
    def watched(self) -> bool:
        """Whether progress can be shown: on a terminal, unless --quiet."""
        return not self.quiet and sys.stderr.isatty() and os.environ.get("TERM") != "dumb"

    def progress(self, things: Iterator[Any], total: int, noun: str) -> Iterator[Any]:
        """Yield things, with a progress bar on standard error if that is a terminal."""
        if total < 2 or not self.watched:
            yield from things
            return
        from lanindex.app.progress import Bar

        bar = Bar(total, noun, colors=self.color != "never")
        _bars.append(bar)
        bar.show()
        try:
            for thing in things:
                bar.advance()
                yield thing
        finally:
            bar.hide()
            if bar in _bars:
                _bars.remove(bar)


class _Job:
    """The running job: how far it is, and the bar that shows it."""

    def __init__(self) -> None:
        self.noun, self.done, self.total = "", 0, 0
        self.begun: float | None = None
        self.bar: Bar | None = None

    def update(self, noun: str, done: int, total: int, *, shown: bool, colors: bool) -> None:
        """Note how far the job is, and show it after `PATIENCE`."""
        is_new, now = (noun, total) != (self.noun, self.total), monotonic()
        self.noun, self.done, self.total = noun, done, total
        self.begun = now if self.begun is None else self.begun
        if not shown or now - self.begun < PATIENCE:
            return
        if self.bar is None or is_new:
            from lanindex.app.progress import Bar

            self.hide()
            self.bar = Bar(total, noun, colors=colors)
            _bars.append(self.bar)
            self.bar.show()
        self.bar.reach(done)

    def hide(self) -> None:
        """Remove the bar from the terminal."""
        if self.bar is not None:
            self.bar.hide()
            if self.bar in _bars:
                _bars.remove(self.bar)
        self.bar = None

    def end(self) -> None:
        """Forget the job."""
        self.hide()
        self.noun, self.done, self.total, self.begun = "", 0, 0, None


_job = _Job()


def how_far() -> str:
    """Return how far the running job is: `` after 12 of 300 captures``; empty if there is none.

    Examples
    --------
    >>> from lanindex.app.output import Output, end_progress, how_far
    >>> Output(quiet=True).watch("captures", 12, 1300)
    >>> how_far()
    ' after 12 of 1,300 captures'
    >>> end_progress()
    >>> how_far()
    ''
    """
    return f" after {_job.done:,} of {_job.total:,} {_job.noun}" if _job.total > 1 else ""


def say_error(error: Exception | str) -> None:
    """Print an error on standard error: one line, or a pattern with a caret below the word."""
    text, drawing = str(error), error if isinstance(error, PatternError) else None
    if isinstance(error, Exception) and isinstance(error.__cause__, PatternError):
        drawing, text = error.__cause__, text.removesuffix(f"\n{error.__cause__}")
    if drawing is not error:
        _say(f"lanindex: {escaped(text)}", sys.stderr)
    if drawing is not None:
        _say(_drawn(drawing), sys.stderr)


def duration(seconds: float) -> str:
    """Return a readable time: 3.2 s, 4:05 min, 2:10 h."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02d} h"


def counted(number: int, noun: str) -> str:
    """Return ``1 hit``, ``2 hits``."""
    return f"{number:,} {noun}" + ("" if number == 1 else "s")


def end_progress() -> None:
    """Remove all progress from the terminal and forget the job."""
    for bar in _bars:
        bar.hide()
    _bars.clear()
    _job.end()


def choice(name: str, value: str, choices: Sequence[str]) -> str:
    """Return `value` if it is one of the choices."""
    if value not in choices:
        raise UsageError(f'"{value}"', place=name, wanted=" or ".join(choices))
    return value


def _say(line: str, stream: TextIO) -> None:
    for bar in _bars:  # bars step aside
        bar.hide()
    print(line, file=stream, flush=stream is sys.stderr or bool(_bars))
    for bar in _bars:
        bar.show()


@cache
def _encode(*, ascii: bool) -> Callable[[Any], str]:
    """Return a JSON encoder; `json.dumps` would make one for each value."""
    from json import JSONEncoder

    return JSONEncoder(ensure_ascii=ascii, check_circular=False).encode


def _drawn(error: PatternError) -> str:
    """Return a pattern error with its caret below the word, counting wide characters."""
    from lanindex.app.columns import width

    line, start, stop = error.line()
    before, meant = escaped(line[:start]), escaped(line[start:stop])
    caret = " " * width(before) + "^" * max(1, width(meant))
    place = f"{escaped(error.place)}:\n" if error.place else ""
    return f"{place}{before}{meant}{escaped(line[stop:])}\n{caret}\n{escaped(error.found)}"
