"""Praat's TextGrid: a tier of intervals a part, starting positions as tiers of points.

Source: ``NOTATIONS.md``, "Praat"; Praat's manual, "TextGrid file formats".
"""

import re
from collections import defaultdict

from lanindex.errors import NotationError, shown
from lanindex.model import Score
from lanindex.notation.text import decoded, refuse
from lanindex.notation.tiers import SECOND, TierEntry, duration, entries_of, is_part, score_of

_STARTS = " starts"  # ends the name of a tier of starting positions

_INTERVALS, _POINTS = "IntervalTier", "TextTier"

_TOKEN = re.compile(
    r'(?P<text>"(?:[^"]++|"")*+")|(?P<flag><\w+>)|(?P<comment>(?<!\S)![^\r\n]*)'
    r"|(?<!\S)(?P<number>-?\d+(?:\.\d*)?(?:[eE][-+]?\d{1,2})?)(?!\S)|(?P<open>\")"
)
"""What counts in a file: texts, flags and numbers that stand free; all else is for people."""

_LONGEST = 40  # characters of a number


class _Tokens:
    """What counts of a file, one after the other."""

    def __init__(self, text: str, place: str) -> None:
        self.text, self.place, self.at = text, place, 0
        self._left = (it for it in _TOKEN.finditer(text) if it.lastgroup != "comment")

    def fault(self, found: str, wanted: str) -> NotationError:
        line = self.text.count("\n", 0, self.at) + 1
        return NotationError(found, place=f"{self.place}:{line}", wanted=wanted)

    def take(self, kind: str, what: str) -> str:
        token = next(self._left, None)
        self.at = token.start() if token else len(self.text)
        if token is None or token.lastgroup != kind:
            found = f'"{shown(token[0].strip(chr(34)))}"' if token else "the end of the file"
            raise self.fault(found, what)
        return token[0]

    def word(self, what: str) -> str:
        """Return a text without its quotation marks."""
        return self.take("text", what)[1:-1].replace('""', '"')

    def number(self, what: str) -> float:
        number = self.take("number", what)
        if len(number) > _LONGEST:
            raise self.fault(shown(number), what)
        return float(number)

    def count(self, what: str) -> int:
        number = self.number(what)
        if number < 0 or number % 1:
            raise self.fault(f"{number:g}", what)
        return int(number)

    def time(self) -> int:
        """Return a time in milliseconds."""
        time = self.number("a time in seconds")
        if time < 0:
            raise self.fault(f"a time of {time:g} s", "0 or later")
        return int(time * SECOND + 0.5)


def read(content: bytes, place: str) -> Score:
    """Read the score of a TextGrid, in the long or the short form: tiers named as a part."""
    tokens = _Tokens(decoded(content, place, "a TextGrid"), place)
    for wanted in ("ooTextFile", "TextGrid"):
        if (word := tokens.word(f'"{wanted}"')) != wanted:
            raise tokens.fault(f'"{shown(word)}"', f'"{wanted}"')
    _, end = tokens.time(), tokens.time()
    tokens.take("flag", "<exists>")
    tiers: dict[str, list[TierEntry]] = defaultdict(list)
    warnings: list[str] = []
    number = tokens.count("how many tiers there are")
    for _ in range(number):
        if (kind := tokens.word("what kind of tier it is")) not in (_INTERVALS, _POINTS):
            raise tokens.fault(f'a tier of "{shown(kind)}"', f'"{_INTERVALS}" or "{_POINTS}"')
        name = tokens.word("a tier's name")
        part = name.removesuffix(_STARTS) if kind == _POINTS else name
        entries = []
        tokens.time(), tokens.time()
        for _ in range(tokens.count("how many entries there are")):
            start = tokens.time()
            stop = tokens.time() if kind == _INTERVALS else start
            words = tokens.word("what it says").strip()
            if kind == _INTERVALS and words and stop <= start:
                found = f'"{shown(words)}" from {start / SECOND:g} to {stop / SECOND:g} s'
                raise tokens.fault(found, "an end 1 ms behind its start, or later")
            if words:
                entries.append(TierEntry(words, start, stop))
        if not is_part(part):
            warnings.append(f'the tier "{shown(name)}" is no part of the body: left out')
        else:
            tiers[part] += entries
    if number and not tiers:
        refuse(place, "no tier of a part of the body", "one that is named as r_arm")
    return score_of(tiers, place, warnings, end)


def write(score: Score) -> str:
    """Write a score as a TextGrid, in the long form."""
    parts = entries_of(score)
    last = max([1, duration(score), *(it.stop for entries in parts.values() for it in entries)])
    tiers: list[tuple[str, str, list[TierEntry]]] = []
    for part, entries in parts.items():
        intervals, at = [], 0
        for it in entries:
            if it.start < it.stop:
                if at < it.start:  # empty intervals fill the gaps
                    intervals.append(TierEntry("", at, it.start))
                intervals.append(it)
                at = it.stop
        if at < last:
            intervals.append(TierEntry("", at, last))
        tiers.append((_INTERVALS, part, intervals))
        if starts := [it for it in entries if it.start == it.stop]:
            tiers.append((_POINTS, part + _STARTS, starts))
    span = ["xmin = 0", f"xmax = {_seconds(last)}"]
    lines = ['File type = "ooTextFile"', 'Object class = "TextGrid"', "", *span]
    lines += ["tiers? <exists>", f"size = {len(tiers)}", "item []:"]
    for number, (kind, name, entries) in enumerate(tiers, 1):
        what = "intervals" if kind == _INTERVALS else "points"
        tier = [f'class = "{kind}"', f'name = "{name}"', *span, f"{what}: size = {len(entries)}"]
        for entry, it in enumerate(entries, 1):
            tier.append(f"{what} [{entry}]:")
            if kind == _INTERVALS:
                tier += [f"    xmin = {_seconds(it.start)}", f"    xmax = {_seconds(it.stop)}"]
                tier.append(f'    text = "{it.words}"')
            else:
                tier += [f"    number = {_seconds(it.start)}", f'    mark = "{it.words}"']
        lines += [f"    item [{number}]:", *(f"        {line}" for line in tier)]
    return "\n".join(lines) + "\n"


def _seconds(time: int) -> str:
    return f"{time // SECOND}.{time % SECOND:03}".rstrip("0").rstrip(".")
