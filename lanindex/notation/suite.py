"""LabanotationSuite's JSON: positions of the arms at times, which robots go through.

Source: ``NOTATIONS.md``, "LabanotationSuite"; the files and the editor of Microsoft's
LabanotationSuite.
"""

import json
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import pairwise, product
from math import asin, atan2, cos, degrees, hypot, radians, sin
from typing import Any, NamedTuple

from lanindex.alphabet import DIRECTION_CODES, DIRECTIONS, LEVEL_CODES, LEVELS
from lanindex.data import shipped
from lanindex.errors import shown
from lanindex.model import Score
from lanindex.notation.text import DECIMAL, decoded, refuse, unique_keys
from lanindex.notation.tiers import SECOND, TierEntry, duration, entries_of, score_of

_TABLE = shipped("notation/suite.toml")
ARMS: dict[str, list[str]] = _TABLE["arms"]
"""Their columns, and what each is here."""

PARTS = (*dict.fromkeys(part for parts in ARMS.values() for part in parts), "body_turn")
"""What is written."""

_TIMES = _TIME, _LASTS = "start time", "duration"
_HEAD, _TURN, _MARKS = "head", "rotation", "lanindex"
_UNKNOWN, _AWAY, _AGAIN, _ANEW = "unknown", "on its way", "again", "anew"
"""Marks beside a column whose position alone would be ambiguous."""

_POSITION = re.compile(r"Position(\d{1,9})")
_DEGREES = re.compile(r"-?\d{1,6}(\.\d{0,9})?")
_SETTLED = "place low"
_NOWHERE = 1e-6


def _suite_words(words: str) -> tuple[str, str]:
    """Return a direction and a level as LabanotationSuite writes them."""
    way, level = words.split()[:2]
    side, _, depth = way.rpartition("_")
    way = _TABLE["sides"].get(side, "") + depth.title().replace("Back", "Backward")
    return way, _TABLE["levels"][level]


_CELLS = {_suite_words(it): it for it in map(" ".join, product(DIRECTIONS, LEVELS))}
"""Our words for each direction and level of LabanotationSuite."""


class _Position(NamedTuple):
    """The words of a column at a time (a direction and a level, or degrees), and our mark."""

    time: int
    words: str
    mark: str = ""


def read(content: bytes, place: str) -> Score:
    """Read a gesture of LabanotationSuite: parts move where successive positions differ."""
    columns: dict[str, list[_Position]] = defaultdict(list)
    warnings: dict[str, None] = {}
    positions = list(_positions(content, place))
    times = [time for _, time, _ in positions] or [0]
    for name, time, position in positions:
        where, marks = f"{place}: {name}", position.pop(_MARKS, {})
        if not isinstance(marks, dict):
            refuse(where, f"{_MARKS} {shown(str(marks))}", "an object")
        for column, value in position.items():
            if column not in (*ARMS, _HEAD, _TURN):
                warnings[f'the column "{shown(column)}" is no part of the body: left out'] = None
                continue
            words = _our_words(column, value, f"{where}, {column}")
            columns[column].append(_Position(time, words, str(marks.get(column, ""))))
    tiers = {part: _moves(columns[name], times[0]) for name, (part, _) in ARMS.items()}
    tiers["body_turn"] = _turns(columns[_TURN])
    if len({face.words for face in columns[_HEAD]}) > 1:
        nods, pans = [], []
        for face in columns[_HEAD]:
            direction, level = face.words.split()
            if direction not in _TABLE["pans"]:
                warnings["a face that looks back or to its place: left out"] = None
                continue
            nods.append(_Position(face.time, _TABLE["nods"][level]))
            pans.append(_Position(face.time, _TABLE["pans"][direction]))
        tiers["head"], tiers["head_turn"] = _moves(nods, times[0]), _moves(pans, times[0])
    return score_of({part: it for part, it in tiers.items() if it}, place, warnings, times[-1])


def _positions(content: bytes, place: str) -> Iterator[tuple[str, int, dict[str, Any]]]:
    """Yield name, time in milliseconds and other columns of each position, by number."""
    text = decoded(content, place, "a gesture of LabanotationSuite")
    try:
        gestures = json.loads(text, object_pairs_hook=unique_keys, parse_constant=float)
    except json.JSONDecodeError as error:
        refuse(f"{place}:{error.lineno}", f"damaged JSON ({error.msg})")
    except (ValueError, RecursionError) as error:
        refuse(place, shown(f"JSON that cannot be read ({error})", 200), "a whole file")
    wanted = "an object with one gesture, which holds Position0, Position1 ..."
    if not isinstance(gestures, dict):
        refuse(place, "no gesture", wanted)
    if len(gestures) != 1:
        refuse(place, f"{len(gestures)} gestures", wanted)
    ((name, gesture),) = gestures.items()
    if not isinstance(gesture, dict):
        refuse(place, f'"{shown(name)}" is no gesture', wanted)
    numbers: dict[str, int] = {}
    for name, position in gesture.items():
        match = _POSITION.fullmatch(name)
        if match is None or not isinstance(position, dict):
            found = f'"{shown(name)}"' if match is None else f"{name} is no position"
            refuse(place, found, "Position0, Position1 ... with columns")
        numbers[name] = int(match[1])
    before = -1
    for name in sorted(numbers, key=lambda name: numbers[name]):
        where, position = f"{place}: {name}", gesture[name]
        text = _words(position.get(_TIME), 1)[0]
        if not DECIMAL.fullmatch(text):
            refuse(where, f'the start time "{shown(text)}"', "milliseconds from 0")
        time = int(float(text) + 0.5)
        if time < before or (time == before and _ANEW not in str(position.get(_MARKS))):
            found = f"at {time / SECOND:g} s, not behind the position before it"
            refuse(where, found, "times that rise")
        before = time
        yield name, time, {key: value for key, value in position.items() if key not in _TIMES}


def _words(value: Any, count: int) -> list[str]:
    """Return a list as `count` texts, empty ones if it is something else."""
    if isinstance(value, list) and len(value) == count:
        return [str(it).strip() for it in value]
    return [""] * count


def _our_words(column: str, value: Any, place: str) -> str:
    """Return a direction and a level, or degrees to the left."""
    direction, amount = _words(value, 2)
    if column == _TURN:
        if _DEGREES.fullmatch(amount) and direction in ("ToLeft", "ToRight"):
            return f"{direction} {round(float(amount)) * (1 if direction == 'ToLeft' else -1)}"
        wanted = '["ToLeft", degrees] or ["ToRight", degrees]'
    else:
        if words := _CELLS.get((" ".join(direction.title().split()), amount.title())):
            return words
        wanted = 'a direction and a level like ["Left Forward", "Normal"]'
    refuse(place, shown(json.dumps(value)), wanted)


def _moves(column: Iterable[_Position], opens: int) -> list[TierEntry]:
    """Return starting positions, and movements between positions that differ."""
    entries: list[TierEntry] = []
    before, since = "", opens
    for time, words, mark in column:
        if mark == _AWAY:
            continue
        if mark == _ANEW or not (before or mark in (_AGAIN, _UNKNOWN)):
            begin = time if time > opens else 0
            entries.append(TierEntry(words, begin, begin))
        elif mark == _AGAIN or (mark != _UNKNOWN and words != before):
            entries.append(TierEntry(words, since, time))
        before, since = "" if mark == _UNKNOWN else words, time
    return entries


def _turns(column: Iterable[_Position]) -> list[TierEntry]:
    """Return turns from one facing to the next."""
    entries: list[TierEntry] = []
    facing = since = 0
    for time, words, mark in column:
        if mark == _AWAY:
            continue
        direction, number = words.split()
        turn, facing = int(number) - facing, int(number)
        if turn or mark == _AGAIN:
            left = direction == "ToLeft" if mark == _AGAIN else turn > 0
            entries.append(TierEntry(f"{'left' if left else 'right'} {abs(turn)}deg", since, time))
        since = time
    return entries


def write(score: Score) -> str:
    """Write arms and facing of a score as a gesture of LabanotationSuite."""
    tiers = entries_of(score)
    arms = {
        column: next((tiers[part] for part in parts if part in tiers), [])
        for column, parts in ARMS.items()
    }
    turns = [it for it in tiers.get("body_turn", []) if it.start < it.stop]
    moments = {(0, 0), (duration(score), 0)}
    for entries in (*arms.values(), turns):
        moments |= {(time, 0) for it in entries for time in (it.start, it.stop)}
        seams = pairwise(entries)  # a starting position where a movement ends: a second position
        moments |= {(two.start, 1) for one, two in seams if one.stop == two.start == two.stop}
    times = [time for time, _ in sorted(moments)]
    columns = {name: list(_positions_of(entries, times)) for name, entries in arms.items()}
    columns[_TURN] = list(_facings(turns, times))
    lines = []
    for number, time in enumerate(times):
        row = {name: column[number] for name, column in columns.items()}
        position: dict[str, Any] = {
            **{_TIME: [str(time)], _LASTS: ["-1" if number == len(times) - 1 else "1"]},
            _HEAD: ["Forward", "Normal"],
            **{name: _suite_words(it.words) for name, it in row.items() if name != _TURN},
            _TURN: row[_TURN].words.split(),
        }
        if marks := {name: it.mark for name, it in row.items() if it.mark}:
            position[_MARKS] = marks
        lines.append(f'    "Position{number}": {json.dumps(position)}')
    return '{\n  "gesture": {\n' + ",\n".join(lines) + "\n  }\n}\n"


def _positions_of(entries: list[TierEntry], times: Iterable[int]) -> Iterator[_Position]:
    """Yield where a part is at each time."""
    left = [*entries, TierEntry("", 1 << 62, 1 << 62)][::-1]
    before = ""
    for time in times:
        it = left[-1]
        if it.start < time < it.stop:
            yield _Position(time, _between(before or it.words, it, time), _AWAY)
        elif time < it.stop:
            yield _Position(time, before or _SETTLED, "" if before else _UNKNOWN)
        else:
            mark = "" if before and before != it.words else _AGAIN
            if it.start == it.stop:
                mark = _ANEW if time else ""
            before = left.pop().words
            yield _Position(time, before, mark)


def _between(before: str, move: TierEntry, time: int) -> str:
    """Return the direction that is nearest on the straight way of a movement."""
    share = (time - move.start) / (move.stop - move.start)
    ends = zip(_vector(before), _vector(move.words), strict=True)
    return _nearest(*(one + (two - one) * share for one, two in ends)) or move.words


def _nearest(x: float, y: float, z: float) -> str:
    """Return the direction and level nearest to a vector (right, forward, up), "" for none."""
    size = hypot(x, y, z)
    if size < _NOWHERE:
        return ""
    rise = round(degrees(asin(max(-1.0, min(1.0, z / size)))) / 45)
    way = "place" if abs(rise) == 2 else DIRECTIONS[round(degrees(atan2(y, x)) / 45) % 8]
    return f"{way} {LEVELS[max(-1, min(1, rise)) + 1]}"


def _vector(words: str) -> tuple[float, float, float]:
    """Return the vector (right, forward, up) of a direction and a level; 0 at place mid."""
    way, level = words.split()[:2]
    rise = LEVEL_CODES[level] - 1
    if way == "place":
        return 0, 0, rise
    high, round_ = radians(45 * rise), radians(45 * DIRECTION_CODES[way])
    return cos(high) * cos(round_), cos(high) * sin(round_), sin(high)


def _facings(turns: list[TierEntry], times: Iterable[int]) -> Iterator[_Position]:
    """Yield where the body faces at each time: degrees to the left of its beginning."""
    left = [*turns, TierEntry("left 0deg", 1 << 62, 1 << 62)][::-1]
    facing, way = 0, "ToLeft"
    for time in times:
        it, mark, here = left[-1], "", facing
        side, _, amount = it.words.partition(" ")
        turn = int(amount.removesuffix("deg") or 0) * (1 if side == "left" else -1)
        if it.stop <= time:
            left.pop()
            facing = here = facing + turn
            way, mark = f"To{side.title()}", "" if turn else _AGAIN
        elif it.start < time:
            here += round(turn * (time - it.start) / (it.stop - it.start))
            mark = _AWAY
        yield _Position(time, f"{way} {here if way == 'ToLeft' else -here}", mark)
