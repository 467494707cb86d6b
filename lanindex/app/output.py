"""Where results and notes go: standard output and standard error, for people and for pipes.

This is the one place that decides what reaches a terminal: whatever comes from files, tables,
names or arguments is escaped here, so that no character of it can steer the terminal.
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
"""Characters that would steer a terminal (C0, DEL, C1) or turn and break its lines without being
seen (bidirectional marks, line and paragraph separators), bytes of a file's name that are no UTF-8,
and how they are shown instead."""

_IN_JSON = {code: f"\\u{code:04x}" for code in ESCAPED if code >= 0x7F}

STYLES = {"path": "35", "place": "32", "match": "1;31", "dim": "2", "warn": "33"}
"""Terminal styles by meaning (ECMA-48)."""

PATIENCE = 0.5
"""Seconds after which it is shown how far a job is."""

_bars: list[Bar] = []


class Painted(str):
    """Text that is escaped already and carries the program's own colours."""

    __slots__ = ()


def escaped(text: str) -> str:
    r"""Return text that may be printed: what would steer a terminal is escaped.

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
        one_of("--color", self.color, ("auto", "always", "never"))

    @property
    def terminal(self) -> bool:
        """Whether a person reads standard output as it is."""
        return sys.stdout.isatty() and not self.json

    @property
    def unicode(self) -> bool:
        """Whether standard output has all characters."""
        return _unicode(sys.stdout)

    def paint(self, text: str, style: str) -> str:
        """Return text in a style, where colours are wanted."""
        wanted = self.color == "always" or (
            self.color == "auto" and self.terminal and not os.environ.get("NO_COLOR")
        )
        return Painted(f"\x1b[{STYLES[style]}m{escaped(text)}\x1b[0m") if wanted else text

    def line(self, *pieces: str) -> None:
        """Print a line of results; a painted piece stands by itself among the others."""
        _say("".join(map(escaped, pieces)), sys.stdout)

    def text(self, text: str) -> None:
        """Print lines of results."""
        for line in text.split("\n"):
            self.line(line)

    def content(self, text: str) -> None:
        """Print a file: as it is in a pipe, as lines where a person reads it."""
        if self.terminal:
            self.text(text.removesuffix("\n"))
        else:
            _say(text.removesuffix("\n"), sys.stdout)

    def record(self, values: dict[str, Any]) -> None:
        """Print a result as a line of JSON."""
        spelled = _encode(ascii=not self.unicode)(values)
        plain = spelled.isascii() and "\x7f" not in spelled  # JSON escapes all before the space
        if not plain and not spelled.isprintable():
            spelled = spelled.translate(_IN_JSON)
        _say(spelled, sys.stdout)

    def row(self, values: Iterable[Any]) -> None:
        """Print a result as fields between tabs."""
        texts = list(map(str, values))
        if not "".join(texts).isprintable():
            texts = list(map(escaped, texts))
        _say("\t".join(texts), sys.stdout)

    def note(self, line: str) -> None:
        """Say something beside the results, unless it shall be quiet."""
        if not self.quiet:
            _say(escaped(line), sys.stderr)

    def detail(self, line: str) -> None:
        """Say something that only the curious want to know."""
        if self.verbose:
            _say(escaped(line), sys.stderr)

    def table(self, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
        """Print rows in columns as wide as the terminal; tab-separated in a pipe."""
        lines = [[escaped(str(cell)) for cell in row] for row in [head, *rows]]
        if not self.terminal:
            for line in lines:
                self.row(line)
            return
        from lanindex.app.columns import laid_out

        for index, text in enumerate(laid_out(lines)):
            self.line(self.paint(text, "dim") if index == 0 else text)

    def watch(self, noun: str, done: int, total: int) -> None:
        """Take note of how far a job is, and show it if it takes a while and a person looks on."""
        _job.told(noun, done, total, shown=self.watched, colors=self.color != "never")

    @property
    def watched(self) -> bool:
        """Whether a person sees what goes on."""
        return not self.quiet and sys.stderr.isatty() and os.environ.get("TERM") != "dumb"

    def progress(self, things: Iterator[Any], total: int, noun: str) -> Iterator[Any]:
        """Yield things and, on a terminal, show on standard error how far they are."""
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
    """The long job that goes on: how far it is, and the bar that shows it."""

    def __init__(self) -> None:
        self.noun, self.done, self.total = "", 0, 0
        self.begun: float | None = None
        self.bar: Bar | None = None

    def told(self, noun: str, done: int, total: int, *, shown: bool, colors: bool) -> None:
        """Take note of how far it is; what goes on for a while is shown on a terminal."""
        other, now = (noun, total) != (self.noun, self.total), monotonic()
        self.noun, self.done, self.total = noun, done, total
        self.begun = now if self.begun is None else self.begun
        if not shown or now - self.begun < PATIENCE:
            return
        if self.bar is None or other:
            from lanindex.app.progress import Bar

            self.hide()
            self.bar = Bar(total, noun, colors=colors)
            _bars.append(self.bar)
            self.bar.show()
        self.bar.reach(done)

    def hide(self) -> None:
        """Take it from the terminal."""
        if self.bar is not None:
            self.bar.hide()
            if self.bar in _bars:
                _bars.remove(self.bar)
        self.bar = None

    def end(self) -> None:
        """Forget it."""
        self.hide()
        self.noun, self.done, self.total, self.begun = "", 0, 0, None


_job = _Job()


def how_far() -> str:
    """Return how far the job is that goes on: `` after 12 of 300 captures``; empty: there is none.

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
    """Print an error as people see it, on standard error: one line, or a pattern's drawing."""
    said, drawing = str(error), error if isinstance(error, PatternError) else None
    if isinstance(error, Exception) and isinstance(error.__cause__, PatternError):
        drawing, said = error.__cause__, said.removesuffix(f"\n{error.__cause__}")
    if drawing is not error:
        _say(f"lanindex: {escaped(said)}", sys.stderr)
    if drawing is not None:
        _say(_drawn(drawing), sys.stderr)


def end_progress() -> None:
    """Take what is shown of a job's progress from the terminal: it will not go on."""
    for bar in _bars:
        bar.hide()
    _bars.clear()
    _job.end()


def one_of(name: str, value: str, choices: Sequence[str]) -> str:
    """Return `value` if it is one of the choices."""
    if value not in choices:
        raise UsageError(f'"{value}"', place=name, wanted=" or ".join(choices))
    return value


def _say(line: str, stream: TextIO) -> None:
    for bar in _bars:  # what tells progress steps aside
        bar.hide()
    print(line, file=stream, flush=stream is sys.stderr or bool(_bars))
    for bar in _bars:
        bar.show()


@cache
def _encode(*, ascii: bool) -> Callable[[Any], str]:
    """Return what spells a value as JSON; `json.dumps` makes it anew for each one."""
    from json import JSONEncoder

    return JSONEncoder(ensure_ascii=ascii, check_circular=False).encode


def _unicode(stream: TextIO) -> bool:
    return (stream.encoding or "").lower().startswith("utf")


def _drawn(error: PatternError) -> str:
    """Return a pattern error with its caret below the word, however wide that is shown."""
    from lanindex.app.columns import width

    line, start, stop = error.line()
    before, meant = escaped(line[:start]), escaped(line[start:stop])
    caret = " " * width(before) + "^" * max(1, width(meant))
    place = f"{escaped(error.place)}:\n" if error.place else ""
    return f"{place}{before}{meant}{escaped(line[stop:])}\n{caret}\n{escaped(error.found)}"
