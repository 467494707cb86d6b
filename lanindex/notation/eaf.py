"""ELAN's annotation files: a tier for each part, an annotation for each symbol.

Source: ``NOTATIONS.md``, "ELAN"; the schema EAFv3.0 of the Max Planck Institute for
Psycholinguistics.
"""

import os
import re
from bisect import bisect_left
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from itertools import count, pairwise
from mimetypes import guess_type
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from lanindex.errors import ExportError, NotationError, shown
from lanindex.model import Score
from lanindex.notation.markup import parse_xml, write_xml
from lanindex.notation.text import refuse
from lanindex.notation.tiers import SECOND, TierEntry, duration, entries_of, is_part, score_of

TYPE = "labanotation"  # the linguistic type of our tiers
HITS = "lanindex-hits"  # the linguistic type of tiers that hold hits

_ROOT = "ANNOTATION_DOCUMENT"
_XSI = "{http://www.w3.org/2001/XMLSchema-instance}"
_SCHEMA = "http://www.mpi.nl/tools/elan/EAFv3.0.xsd"
_STARTS, _LENGTH, _LAST = "lanindex.starts.", "lanindex.milliseconds", "lastUsedAnnotationId"
"""Properties: starting positions, by part; how long the score is; ELAN's own count."""

_START = re.compile(r"\s*(\d{1,9}) (.*)")
_NUMBERED = re.compile(r"(?:a|ts)(\d{1,15})")
_EPOCH = re.compile(r"[0-9]{1,11}")
_TIME = re.compile(r"\s*\d{1,12}\s*")
_BEHIND_TIERS = (
    *("LINGUISTIC_TYPE", "LOCALE", "LANGUAGE", "CONSTRAINT", "CONTROLLED_VOCABULARY"),
    *("LEXICON_REF", "REF_LINK_SET", "EXTERNAL_REF"),
)
"""What follows the tiers of a file, in order."""


def read(content: bytes, place: str) -> Score:
    """Read the score of an ELAN file: tiers of the type ``labanotation``, or named as a part."""
    root = _document(content, place)
    slots = {slot.get("TIME_SLOT_ID"): slot.get("TIME_VALUE") for slot in root.iter("TIME_SLOT")}
    properties = {it.get("NAME", ""): it.text or "" for it in root.iterfind("HEADER/PROPERTY")}
    tiers: dict[str, list[TierEntry]] = {}
    warnings: list[str] = []
    for tier in root.iterfind("TIER"):
        name, ours = tier.get("TIER_ID", ""), tier.get("LINGUISTIC_TYPE_REF") == TYPE
        if not ours and not is_part(name):
            warnings.append(f'the tier "{shown(name)}" is no part of the body: left out')
            continue
        try:
            entries = list(_annotations(tier, slots, f"{place}: {shown(name)}"))
            if not ours:
                score_of({name: entries}, place)
        except NotationError as error:
            if ours:
                raise
            warnings.append(f'the tier "{name}" is left out: {error.found} is no symbol')
            continue
        tiers[name] = list(entries)
        entries.sort(key=lambda it: it.start)
        for text in filter(str.strip, properties.get(_STARTS + name, "").split(";")):
            match = _START.fullmatch(text)
            if match is None:
                found = f'the starting position "{shown(text.strip())}"'
                refuse(f"{place}: {name}", found, "one like 0 place low")
            time = int(match[1])
            before = bisect_left(entries, time, key=lambda it: it.start) - 1
            if before >= 0 and time < entries[before].stop:
                warnings.append(f"{name}: a starting position at {time / SECOND:g} s is left out, "
                            "an annotation lies over it")  # fmt: skip
            else:
                tiers[name].append(TierEntry(match[2], time, time))
    if not tiers and _LENGTH not in properties:
        refuse(place, "no tier of a part of the body", f"one of the type {TYPE}, or named as r_arm")
    return score_of(tiers, place, warnings, _number(properties.get(_LENGTH)))


def _document(content: bytes, place: str) -> Element:
    root = parse_xml(content, place, _ROOT)
    header, order = root.find("HEADER"), root.find("TIME_ORDER")
    if header is None or order is None:
        refuse(place, "no header or no time slots", "an ELAN file")
    unit = header.get("TIME_UNITS", "milliseconds")
    if unit != "milliseconds":
        refuse(place, f"times in {shown(unit)}", "milliseconds")
    return root


def _annotations(
    tier: Element, slots: dict[str | None, str | None], place: str
) -> Iterator[TierEntry]:
    for one in tier.iterfind("ANNOTATION/*"):
        words = one.findtext("ANNOTATION_VALUE") or ""
        if one.tag != "ALIGNABLE_ANNOTATION":
            refuse(place, "an annotation without times of its own", "a tier without a parent")
        times = [slots.get(one.get(f"TIME_SLOT_REF{end}")) or "" for end in (1, 2)]
        if not all(map(_TIME.fullmatch, times)):
            found = f'"{shown(words)}" at {shown("-".join(times))}'
            refuse(place, found, "times in milliseconds from 0")
        start, stop = map(int, times)
        if stop <= start:
            found = f'"{shown(words)}" from {start / SECOND:g} to {stop / SECOND:g} s'
            refuse(place, found, "an end behind its start")
        yield TierEntry(words, start, stop)


def _number(text: str | None) -> int:
    """Return the number that a property holds, 0 if it holds none."""
    return int(text) if text and _TIME.fullmatch(text) else 0


def write(
    score: Score,
    *,
    into: bytes | None = None,
    place: str = "",
    force: bool = False,
    media: Path | None = None,
) -> bytes:
    """Write a score as an ELAN file, or into one."""
    if into is not None:
        root = _document(into, place)
    else:
        # the schema wants a date; this variable makes the same file again (reproducible-builds.org)
        told = _EPOCH.fullmatch(os.environ.get("SOURCE_DATE_EPOCH", ""))
        date = datetime.fromtimestamp(int(told[0]), UTC) if told else datetime.now(UTC)
        attributes = {"AUTHOR": "LanIndex", "DATE": date.isoformat(timespec="seconds")}
        attributes |= {"FORMAT": "3.0", "VERSION": "3.0"}
        root = Element(_ROOT, {**attributes, f"{_XSI}noNamespaceSchemaLocation": _SCHEMA})
        SubElement(root, "HEADER", {"MEDIA_FILE": "", "TIME_UNITS": "milliseconds"})
        SubElement(root, "TIME_ORDER")
    header = next(root.iter("HEADER"))
    tiers = entries_of(score)
    _put(root, tiers, TYPE, force, place)
    if media is not None:  # before what else the header says
        kind = guess_type(media.name)[0] or "application/octet-stream"
        attributes = {"MEDIA_URL": media.absolute().as_uri(), "MIME_TYPE": kind}
        header.insert(0, Element("MEDIA_DESCRIPTOR", attributes))
    for part, entries in tiers.items():
        starts = "; ".join(f"{it.start} {it.words}" for it in entries if it.start == it.stop)
        _set_property(header, _STARTS + part, starts)
    length = max(_number(header.findtext(f"PROPERTY[@NAME='{_LENGTH}']")), duration(score))
    _set_property(header, _LENGTH, str(length))
    return write_xml(root)


def mark(
    into: bytes, tier: str, entries: list[TierEntry], *, place: str, force: bool = False
) -> bytes:
    """Return an ELAN file with one more tier of entries."""
    root = _document(into, place)
    if is_part(tier) or not tier.strip() or not tier.isprintable():
        wanted = "a name that can be read, and no part's"
        raise ExportError(f'the tier "{shown(tier)}"', place=place, wanted=wanted)
    ordered = sorted(entries, key=lambda it: (it.start, it.stop))
    for one, two in pairwise(ordered):
        if two.start < one.stop:
            times = f"{one.start / SECOND:g} and {two.start / SECOND:g} s"
            found = f"what begins at {times} shares time"
            raise ExportError(found, place=f"{place}: {shown(tier)}", wanted="one at a time")
    _put(root, {tier: ordered}, HITS, force, place)
    return write_xml(root)


def _put(
    root: Element, tiers: Mapping[str, list[TierEntry]], kind: str, force: bool, place: str
) -> None:
    """Put tiers of a type behind those that are there, numbered behind all others."""
    for name in tiers:
        _make_room(root, name, force, place)
    known = [it for it in root.iterfind("LINGUISTIC_TYPE") if it.get("LINGUISTIC_TYPE_ID") == kind]
    if known and (known[0].get("CONSTRAINTS") or known[0].get("TIME_ALIGNABLE") == "false"):
        found = f"has a type {kind} that is bound to a parent"
        raise ExportError(found, place=place, wanted="one that is aligned with time, or none")
    if not known:
        attributes = {"GRAPHIC_REFERENCES": "false", "LINGUISTIC_TYPE_ID": kind}
        last = [at for at, it in enumerate(root) if it.tag not in _BEHIND_TIERS[1:]]
        root.insert(last[-1] + 1, Element("LINGUISTIC_TYPE", attributes, TIME_ALIGNABLE="true"))
    ids = (it.get(key, "") for it in root.iter() for key in ("TIME_SLOT_ID", "ANNOTATION_ID"))
    used = (int(match[1]) for match in map(_NUMBERED.fullmatch, ids) if match)
    last_used = _number(root.findtext(f"HEADER/PROPERTY[@NAME='{_LAST}']"))
    numbers = count(max([last_used, *used]) + 1)
    slots: list[tuple[int, Element]] = []
    elements = []
    for name, entries in tiers.items():
        elements.append(tier := Element("TIER", {"LINGUISTIC_TYPE_REF": kind, "TIER_ID": name}))
        for it in entries:
            if it.start == it.stop:
                continue
            names = [f"ts{next(numbers)}" for _ in range(2)]
            for time, slot_id in zip((it.start, it.stop), names, strict=True):
                attributes = {"TIME_SLOT_ID": slot_id, "TIME_VALUE": str(time)}
                slots.append((time, Element("TIME_SLOT", attributes)))
            attributes = {"ANNOTATION_ID": f"a{next(numbers)}"}
            attributes |= {"TIME_SLOT_REF1": names[0], "TIME_SLOT_REF2": names[1]}
            annotation = SubElement(tier, "ANNOTATION")
            annotation = SubElement(annotation, "ALIGNABLE_ANNOTATION", attributes)
            SubElement(annotation, "ANNOTATION_VALUE").text = it.words
    index = next((at for at, it in enumerate(root) if it.tag in _BEHIND_TIERS), len(root))
    root[index:index] = elements
    slots.sort(key=lambda pair: pair[0])
    slots.reverse()
    order, merged = next(root.iter("TIME_ORDER")), list[Element]()
    for slot in order:  # one without a time stays where it is
        value = slot.get("TIME_VALUE", "")
        while slots and _TIME.fullmatch(value) and slots[-1][0] < int(value):
            merged.append(slots.pop()[1])
        merged.append(slot)
    order[:] = [*merged, *(slot for _, slot in reversed(slots))]
    _set_property(next(root.iter("HEADER")), _LAST, str(next(numbers) - 1))


def _make_room(root: Element, part: str, force: bool, place: str) -> None:
    """Take away a tier that is to be replaced, with the time slots that were its own."""
    tier = next((it for it in root.iterfind("TIER") if it.get("TIER_ID") == part), None)
    if tier is None:
        return
    if not force:
        remedy = "--force, in Python force=True, replaces it."
        raise ExportError(f"has a tier {part} already", place=place, wanted="none", remedy=remedy)
    for other in root.iterfind("TIER"):
        if other.get("PARENT_REF") == part:
            found = f'the tier "{shown(other.get("TIER_ID", ""))}" hangs on {part}'
            raise ExportError(found, place=place, wanted="none that would lose what it is about")
    root.remove(tier)
    gone = _slots_of(tier) - _slots_of(root)
    order = next(root.iter("TIME_ORDER"))
    order[:] = [slot for slot in order if slot.get("TIME_SLOT_ID") not in gone]


def _slots_of(element: Element) -> set[str | None]:
    used = element.iter("ALIGNABLE_ANNOTATION")
    return {one.get(f"TIME_SLOT_REF{end}") for one in used for end in (1, 2)}


def _set_property(header: Element, name: str, value: str) -> None:
    """Set a property; an empty one is not added."""
    found = next((it for it in header.iterfind("PROPERTY") if it.get("NAME") == name), None)
    if found is not None:
        found.text = value
    elif value:
        SubElement(header, "PROPERTY", NAME=name).text = value
