"""MAE's score files: XML whose columns stand for limbs and whose measures hold beats.

Source: ``NOTATIONS.md``, "MAE"; the files of the MAE score editor.
"""

import re
from collections import defaultdict
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from xml.etree.ElementTree import Element, SubElement, register_namespace

from lanindex.errors import shown
from lanindex.model import Score
from lanindex.notation.markup import parse_xml, write_xml
from lanindex.notation.text import DECIMAL, number, refuse
from lanindex.notation.tiers import SECOND, TierEntry, duration, entries_of, score_of

_NAMED = "http://www.example.org/labanotation"
_SPACE = f"{{{_NAMED}}}"
_SCHEMA = "{http://www.w3.org/2001/XMLSchema-instance}schemaLocation"
_ARMS = {"4": "r_arm", "-4": "l_arm"}  # the columns that no file defines

_LIMBS = {
    **{"arm": "arm", "upper_arm": "upper_arm", "lower_arm": "forearm", "hand": "hand"},
    **{"leg": "leg", "upper_leg": "thigh", "lower_leg": "shank", "foot": "foot"},
}
"""What limbs are called in the definitions of columns, and here."""

PARTS = tuple(f"{side}_{limb}" for limb in _LIMBS.values() for side in "rl")  # what is written
_FIRST_DEFINED = 8  # the first column that a file may define
_BEAT, _BEATS = 200, 5  # milliseconds of a beat and beats of a measure, as its own files have them

_UNITS = {"millisecond": 1, "second": SECOND}
_LEVELS = {"low": "low", "middle": "mid", "high": "high"}
_COUNT = re.compile(r"\d{1,6}")
_SLIP = Fraction(1, 10)  # beats by which a movement may be drawn too long


def read(content: bytes, place: str) -> Score:
    """Read a score of MAE; signs other than of a direction are left out, with a warning."""
    root = parse_xml(content, place, f"{_SPACE}score")
    staff = root.find(f"{_SPACE}staff")
    if staff is None:
        refuse(place, "no staff", "a score of MAE")
    beat, beats = _timing(staff, place)
    parts = dict(_ARMS)
    for column in staff.iter(f"{_SPACE}columnDefinition"):
        limbs = (it.text or "" for it in column.iter(f"{_SPACE}limb") if not len(it))
        limb = next(limbs, "").strip()
        side = next((it.text or "" for it in column.iter(f"{_SPACE}side")), "").strip()
        known = limb in _LIMBS and side in ("left", "right")
        parts[_text(column, "index")] = f"{side[0]}_{_LIMBS[limb]}" if known else ""
    tiers: dict[str, list[TierEntry]] = defaultdict(list)
    warnings: dict[str, None] = {}
    for ordinal, movement in enumerate(staff.iter(f"{_SPACE}movement"), 1):
        where = f"{place}: movement {ordinal}"
        index = _text(movement, "column")
        part = parts.get(index, "")
        if not part:
            wanted = " ".join(name for name, it in parts.items() if it)
            refuse(where, f'the column "{shown(index)}"', wanted)
        direction = movement.find(f"{_SPACE}direction")
        if direction is None:
            if _text(movement, "hold") != "true":
                warnings["signs that are no directions: left out"] = None
            continue
        measure = _number(movement, "measure", where)
        start = (measure - 1) * beats + _number(movement, "beat", where)
        span = (start, start + _number(movement, "duration", where)) if measure else (0, 0)
        times = [int(time * beat + Fraction(1, 2)) for time in span]
        level, way = _text(direction, "vertical"), _text(direction, "horizontal")
        if level not in _LEVELS:
            refuse(where, f'the level "{shown(level)}"', " ".join(_LEVELS))
        side, _, depth = way.replace("backward", "back").rpartition("-")
        words = f"{f'{side[0]}_' if side else ''}{depth} {_LEVELS[level]}"
        tiers[part].append(TierEntry(words, times[0], times[1]))
    for part, entries in tiers.items():
        entries.sort(key=lambda it: (it.start, it.stop))
        for at, (one, two) in enumerate(pairwise(entries)):
            if one.start < two.start < one.stop <= two.start + beat * _SLIP:
                entries[at] = replace(one, stop=two.start)
                begin = one.start / SECOND
                warnings[f"{part}: what begins at {begin:g} s was drawn too long: cut"] = None
    count = _text(staff, "measures")
    length = int(count) * beats * beat if _COUNT.fullmatch(count) else 0
    return score_of(tiers, place, warnings, int(length))


def _text(element: Element, name: str) -> str:
    return (element.findtext(_SPACE + name) or "").strip()


def _number(element: Element, name: str, place: str) -> Fraction:
    text = _text(element, name)
    if not DECIMAL.fullmatch(text):
        refuse(place, f'the {name} "{shown(text)}"', "a number like 1.5")
    return Fraction(text)


def _timing(staff: Element, place: str) -> tuple[Fraction, Fraction]:
    """Return how long a beat lasts, in milliseconds, and how many beats a measure has."""
    timing = staff.find(f"{_SPACE}timing")
    unit = "" if timing is None else _text(timing, "timeUnit")
    if timing is None or unit not in _UNITS:
        refuse(place, f'the unit of time "{shown(unit)}"', " or ".join(_UNITS))
    found = {
        (_number(it, "beatDuration", place) * _UNITS[unit], _number(it, "beats", place))
        for it in timing.iterfind(f"{_SPACE}measure")
    }
    if len(found) != 1 or not all(min(found)):
        refuse(place, f"{len(found)} timings", "one for the whole score, and beats that last")
    return found.pop()


def write(score: Score) -> bytes:
    """Write the limbs of a score for MAE, in beats of 200 ms, five a measure."""
    register_namespace("laban", _NAMED)
    tiers = {part: entries for part, entries in entries_of(score).items() if part in PARTS}
    root = Element(f"{_SPACE}score", {_SCHEMA: f"{_NAMED} labanotation.xsd"})
    _add(root, version="0.5", author="LanIndex", title="", description="")
    staff = _add(root, "staff")
    _add(staff, measures=str(max(1, -(-duration(score) // (_BEAT * _BEATS)))))
    timing = _add(staff, "timing", timeUnit="millisecond")
    _add(timing, "measure", index="0", beatDuration=str(_BEAT), beats=str(_BEATS))
    columns = {part: column for column, part in _ARMS.items()}
    others = dict.fromkeys(part[2:] for part in tiers if part not in columns)
    defined = _add(staff, "columns") if others else None
    for column, limb in enumerate(others, _FIRST_DEFINED):
        for side, index in (("right", column), ("left", -column)):
            if defined is None or f"{side[0]}_{limb}" not in tiers:
                continue
            columns[f"{side[0]}_{limb}"] = str(index)
            definition = _add(defined, "columnDefinition", index=str(index))
            body = _add(_add(definition, "preSign"), "bodyPart")
            name = next(theirs for theirs, ours in _LIMBS.items() if ours == limb)
            _add(_add(_add(body, "limb"), "default"), limb=name)
            _add(body, side=side)
    movements = _add(staff, "movements")
    entries = [(it.start, it.stop, part, it.words) for part in tiers for it in tiers[part]]
    for start, stop, part, words in sorted(entries, key=lambda it: it[:2]):
        if stop == start > 0:
            continue
        measure, ahead = divmod(start, _BEAT * _BEATS)
        movement = _add(
            movements,
            "movement",
            column=columns[part],
            measure=str(measure + 1 if stop > start else 0),  # 0 holds starting positions
            beat=number(Fraction(ahead, _BEAT)),
            duration=number(Fraction(stop - start or _BEAT, _BEAT)),
            hold="false",
        )
        way, level = words.split()[:2]
        side, _, depth = way.rpartition("_")
        side = {"r": "right-", "l": "left-"}.get(side, "")
        horizontal = side + depth.replace("back", "backward")
        vertical = {"mid": "middle"}.get(level, level)
        _add(movement, "direction", vertical=vertical, horizontal=horizontal)
    return write_xml(root)


def _add(parent: Element, name: str = "", **texts: str) -> Element:
    """Add an element, if one is named, and elements of texts to it; return it."""
    element = SubElement(parent, _SPACE + name) if name else parent
    for child, text in texts.items():
        SubElement(element, _SPACE + child).text = text or None
    return element
