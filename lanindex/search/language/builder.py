"""Patterns built in Python, read by the parser after each call, which refuses what has no text."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lanindex.errors import UsageError
from lanindex.search.language.parser import parse
from lanindex.search.language.query import Bracket, Choice, Item, Line, Query, Step


@dataclass(frozen=True, slots=True, repr=False)
class Pattern:
    """A pattern; each method returns another one. Made by `part`.

    `lasting`, `times`, `optional` and `labelled` speak of the last step. After lines side by
    side, `group` or ``|`` the whole pattern is one step, in brackets.

    Examples
    --------
    >>> from lanindex import part
    >>> wave = part("r_arm").to("left").then("right").group().times("3+")
    >>> print(wave.with_(part("l_arm").hold("low")).either_side())
    (r_arm left -> right) x3+ with l_arm hold low either side
    """

    query: Query

    def __str__(self) -> str:
        return str(self.query)

    def __repr__(self) -> str:
        return f"<Pattern {self}>"

    def to(self, *words: str, direction: str = "", level: str = "") -> Pattern:
        """Move there: ``"right", "mid"``; ``"not low"``; ``"right/left"``."""
        return self._step(*words, direction, level)

    def at(self, *words: str, direction: str = "", level: str = "") -> Pattern:
        """Be there."""
        return self._step("at", *words, direction, level)

    def hold(self, *words: str, direction: str = "", level: str = "") -> Pattern:
        """Rest, there or anywhere."""
        return self._step("hold", *words, direction, level)

    def still(self, *words: str, direction: str = "", level: str = "") -> Pattern:
        """Rest without swings, there or anywhere."""
        return self._step("still", *words, direction, level)

    def via(self, *words: str, direction: str = "", level: str = "") -> Pattern:
        """Go through there."""
        return self._step("via", *words, direction, level)

    def then(
        self, *words: str | Pattern, direction: str = "", level: str = "", within: str = ""
    ) -> Pattern:
        """Go on with the next movement, or with a pattern; `within` a time: ``"<1s"``."""
        return self._followed_by("->", within, *words, direction, level)

    def later(
        self, *words: str | Pattern, direction: str = "", level: str = "", within: str = ""
    ) -> Pattern:
        """Go on with a later movement; `within` may also count those skipped: ``"<=2"``."""
        return self._followed_by("...", within, *words, direction, level)

    def lasting(self, length: str) -> Pattern:
        """Limit the length of the last step: ``"<0.3s"``, ``"1s..2s"``, ``"2s+"``."""
        return self._read(f"{self._line()} {length}")

    def times(self, count: int | str) -> Pattern:
        """Repeat the last step: ``3``, ``"2..4"``, ``"3+"``."""
        return self._read(f"{self._line()} x{count}")

    def optional(self) -> Pattern:
        """Let the last step be left out."""
        return self._read(f"{self._line()}?")

    def labelled(self, label: str) -> Pattern:
        """Give the last step a label, to speak of it in `where`."""
        line = self._line()
        named = replace(line.items[-1], label=label)
        return self._read(str(replace(line, items=(*line.items[:-1], named))))

    def group(self) -> Pattern:
        """Put the pattern in brackets, as one step."""
        return self._read(f"({self.query.pattern})")

    def mirrored(self) -> Pattern:
        """Return the mirror image."""
        return self._read(f"mirror({self.query.pattern})")

    def from_start(self) -> Pattern:
        """Begin with the capture."""
        return self._read(f"start -> {self._line()}")

    def to_end(self) -> Pattern:
        """End with the capture: the last movement in it."""
        return self._read(f"{self._line()} -> end")

    def with_(self, other: Pattern, *, within: str = "") -> Pattern:
        """Share a frame with another line, or lie less than a time apart: ``"1s"``."""
        return self._beside("with", other, within)

    def overlapping(self, other: Pattern) -> Pattern:
        """Share at least half of the frames of another line."""
        return self._beside("overlapping", other)

    def during(self, other: Pattern) -> Pattern:
        """Lie inside another line."""
        return self._beside("during", other)

    def starting_with(self, other: Pattern) -> Pattern:
        """Begin together with another line."""
        return self._beside("starting with", other)

    def ending_with(self, other: Pattern) -> Pattern:
        """End together with another line."""
        return self._beside("ending with", other)

    def exactly_with(self, other: Pattern) -> Pattern:
        """Begin and end together with another line."""
        return self._beside("exactly with", other)

    def after(self, other: Pattern, *, within: str = "") -> Pattern:
        """Come after another line, within a time: ``"<1s"``."""
        return self._beside("after", other, within)

    def before(self, other: Pattern, *, within: str = "") -> Pattern:
        """Come before another line, within a time: ``"<1s"``."""
        return self._beside("before", other, within)

    def without(self, other: Pattern, *, within: str = "") -> Pattern:
        """Happen while another line does not, nor less than a time away: ``"1s"``."""
        return self._beside("without", other, within)

    def never(self, other: Pattern) -> Pattern:
        """Happen where another line is nowhere in the capture."""
        return self._beside("never", other)

    def __or__(self, other: Pattern) -> Pattern:
        """Find either of two patterns."""
        return _parsed(f"{self._bare()} or {other._bare()}")

    def either_side(self) -> Pattern:
        """Let the mirror image do as well."""
        return Pattern(replace(self.query, either_side=True))

    def rhythm(self, *numbers: float) -> Pattern:
        """Let the steps of the first line last in this proportion."""
        without = Pattern(replace(self.query, rhythm=()))
        return without._read(f"{self.query.pattern} rhythm {':'.join(map(str, numbers))}")

    def where(self, condition: str) -> Pattern:
        """Add a condition: ``"a.start > 1s"``."""
        conditions = " and ".join([*map(str, self.query.where), condition])
        without = Pattern(replace(self.query, where=()))
        return without._read(f"{self.query.pattern} where {conditions}")

    def sort_by(self, field: str) -> Pattern:
        """Sort the hits by a field: ``"match.length"``, ``"clip.label"``."""
        return _parsed(f"{self} | sort by {field}")

    def first(self, count: int) -> Pattern:
        """Keep the first hits, or counts."""
        return _parsed(f"{self} | first {count}")

    def count(self, by: str = "") -> Pattern:
        """Count the hits, or how many there are for each value of a field."""
        return _parsed(f"{self} | count{f' by {by}' if by else ''}")

    @property
    def _behind(self) -> str:
        """The clauses and stages, as text."""
        return str(self.query).removeprefix(str(self.query.pattern))

    def _read(self, pattern: str) -> Pattern:
        """Return another pattern with the clauses and stages of this one."""
        return _parsed(f"{pattern}{self._behind}")

    def _line(self) -> Line:
        pattern = self.query.pattern
        lines = pattern.alternatives[0]
        single = len(pattern.alternatives) == 1 and not lines.others
        return lines.first if single else Line((Item(Bracket(pattern)),))

    def _bare(self) -> Choice:
        """Return the pattern; refuse clauses and stages."""
        if self._behind:
            found = f'"{self._behind.strip()}" in a part of a pattern'
            raise UsageError(found, wanted="it behind the whole pattern, as it speaks of all of it")
        return self.query.pattern

    def _step(self, *words: str) -> Pattern:
        line = self._line()
        last = line.items[-1]
        bare = isinstance(last.unit, Step) and str(last).endswith(str(last.unit.mover))
        arrow = "" if bare and not line.end else "-> "
        return self._read(f"{line} {arrow}{' '.join(filter(None, words))}")

    def _followed_by(self, arrow: str, within: str, *words: str | Pattern) -> Pattern:
        texts = [str(it._unit()) if isinstance(it, Pattern) else it for it in words]
        arrow += within and f"[{within}]"
        return self._read(f"{self._line()} {arrow} {' '.join(filter(None, texts))}")

    def _unit(self) -> Item:
        """Return the pattern as a step of another one."""
        pattern, line = self._bare(), self._line()
        single = len(line.items) == 1 and not line.start and not line.end
        return line.items[0] if single else Item(Bracket(pattern))

    def _beside(self, relation: str, other: Pattern, within: str = "") -> Pattern:
        pattern = self.query.pattern
        first = f"({pattern})" if len(pattern.alternatives) > 1 else str(pattern)
        other._bare()
        relation += within and f"[{within}]"
        return self._read(f"{first} {relation} {other._line()}")


def _parsed(text: str) -> Pattern:
    return Pattern(parse(text))


def part(name: str) -> Pattern:
    """Begin a pattern with a part of the body.

    Parameters
    ----------
    name : str
        ``r_arm``, ``arm`` (either one), ``arms`` (both at once), ``head`` ...

    Raises
    ------
    PatternError
        There is no such part, or the language cannot say what a method adds.
    UsageError
        A part of a pattern has clauses or stages.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex import part
    >>> bow = part("torso").to("forward", "high").hold().lasting("1s+")
    >>> with lanindex.open_library("dance.db") as library:
    ...     len(library.search(bow))
    1
    """
    return _parsed(name)
