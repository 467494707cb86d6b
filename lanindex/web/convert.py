"""What the screen Convert is given: profiles, limbs written down anew, the way of a limb."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from lanindex.compare import Comparison, Difference, compare
from lanindex.draw.picture import PIXEL
from lanindex.draw.staff import MARGIN, START
from lanindex.draw.strip import Staff
from lanindex.encoding.profile import Profile, load, made_of
from lanindex.errors import UsageError
from lanindex.film import tiles
from lanindex.model import Score, Symbol
from lanindex.pipeline import anew
from lanindex.pipeline.jobs import IngestJob
from lanindex.pipeline.kept import Latest
from lanindex.pipeline.prepare import processes
from lanindex.pipeline.profiles import Changes, Shelf, changed, record
from lanindex.web.jobs import Told, trouble
from lanindex.web.routes import Call

if TYPE_CHECKING:
    from lanindex.model import Capture
    from lanindex.pipeline.library import Library

RATE = 30
"""Points of a way a second, at most."""

LONGEST = 120.0
"""Seconds of a way in an answer, at most."""

_LISTED = 300  # differences in an answer, at most
_REASONS = 20  # files that could not be read, in an answer
_PARTS = 8  # parts that are written down at once, at most


@dataclass(frozen=True, slots=True, eq=False)
class Conversion:
    """A capture as it is stored, and as it is with other numbers."""

    profile: Profile
    score: Score
    found: Comparison
    staves: tuple[Staff, Staff]


class Workshop:
    """The profiles of a site, and the captures that were last written down with them."""

    def __init__(self, library: Library) -> None:
        self._library, self.shelf = library, Shelf(library.store.session.target)
        self._profiles = Latest[Profile](64)
        self._done = Latest[Conversion](8)

    def profile(self, name: str, changes: Any) -> Profile:
        """Return a profile with changes."""
        files = changed(self.shelf.files(name), Changes.read(changes))
        key = repr(sorted(files.items()))
        return self._profiles.made(key, lambda: made_of(files, name))

    def converted(
        self, capture: Capture, profile: Profile, parts: list[str], *, own_tempo: bool, zoom: float
    ) -> Conversion:
        """Return a capture with some parts written down by a profile; it is kept for a while."""
        stamp = self._library.stamp
        key = json.dumps([stamp, capture.id, profile.digest, parts, own_tempo, zoom])
        how: dict[str, Any] = {"own_tempo": own_tempo, "zoom": zoom}
        return self._done.made(key, lambda: self._made(capture, profile, parts, **how))

    def _made(
        self, capture: Capture, profile: Profile, parts: list[str], *, own_tempo: bool, zoom: float
    ) -> Conversion:
        store = self._library.store
        stored = store.score(capture.id)
        score = anew.encoded(store, capture, parts, profile, own_tempo=own_tempo)
        found = compare(stored, score, parts=parts)
        sides = ((stored, "one", "as it is stored"), (score, "other", "written down anew"))
        # seconds are equally high on both, whatever the tempo
        staves = [
            Staff(
                it,
                parts=parts,
                marked=_symbols(found, side),
                scale=zoom,
                stretch=min(max(float(stored.meter.speed / it.meter.speed), 0.1), 10.0),
                title=title,
            )
            for it, side, title in sides
        ]
        return Conversion(profile, score, found, (staves[0], staves[1]))


def _symbols(found: Comparison, side: str) -> list[Symbol]:
    """Return the symbols of one side that are not the same on the other."""
    timed = (getattr(it, side) for it in found.differences)
    return [it.symbol for it in timed if it is not None and it.stop > it.start]


def profiles(call: Call) -> dict[str, Any]:
    """Return the names of all profiles."""
    return {"profiles": call.site.workshop.shelf.names()}


def profile(call: Call) -> dict[str, Any]:
    """Return a profile: its numbers by part, with their units, meanings and limits."""
    return record(call.site.workshop.shelf.files(call.path["name"]))


def save(call: Call) -> dict[str, Any]:
    """Save a profile with changes under a name."""
    shelf = call.site.workshop.shelf
    files = changed(shelf.files(call.said("profile", str, "default")), _changes(call))
    replaces = call.body.get("replace") is True
    name = shelf.save(call.said("name", str, ""), files, replace_it=replaces)
    return {"name": name, "folder": shelf.place(name)}


def _changes(call: Call) -> Changes:
    return Changes.read(call.said("changes", dict, {}))


def _chosen(call: Call) -> tuple[Capture, Profile]:
    """Return the capture and the changed profile of a request."""
    capture = call.site.library.capture(call.path["number"])
    name, changes = call.said("profile", str, "default"), call.said("changes", dict, {})
    return capture, call.site.workshop.profile(name, changes)


def _window(call: Call, capture: Capture, longest: float) -> tuple[float, float]:
    """Return the seconds that a request asks for."""
    seconds = float(capture.frames / capture.rate)
    start, stop = (call.body.get(it, default) for it, default in (("from", 0), ("to", seconds)))
    for value in (start, stop):
        if isinstance(value, bool) or not isinstance(value, int | float) or not value >= 0:
            raise UsageError(f"{value!r:.20}", place="from, to", wanted="seconds from 0")
    stop = min(stop, seconds, start + longest)
    if not start < stop:
        raise UsageError(f"{start:g} s", place="from", wanted=f"less than {stop:g} s")
    return start, stop


def encode(call: Call) -> dict[str, Any]:
    """Write parts of a capture down anew, and return both staves of a window, and what differs."""
    capture, numbers = _chosen(call)
    parts = call.said("parts", list, [])
    if not 1 <= len(parts) <= _PARTS or not all(isinstance(it, str) for it in parts):
        raise UsageError(f"{parts!r:.40}", place="parts", wanted=f"1 to {_PARTS} parts")
    zoom = call.body.get("zoom", 1)
    if isinstance(zoom, bool) or not isinstance(zoom, int | float) or not 0.1 <= zoom <= 10:
        raise UsageError(f"{zoom!r:.20}", place="zoom", wanted="0.1 to 10")
    how: dict[str, Any] = {"own_tempo": call.body.get("own_tempo") is not False, "zoom": zoom}
    made = call.site.workshop.converted(capture, numbers, list(dict.fromkeys(parts)), **how)
    start, stop = _window(call, capture, tiles.SECONDS * 6)
    before, after = (_piece(it, start, stop) for it in made.staves)
    meter, found = made.score.meter, made.found
    return {
        "before": before,
        "after": after,
        "same": found.same,
        "changed": len(found.differences),
        "kinds": Counter(it.kind for it in found.differences),
        "differences": [_difference(it) for it in found.differences[:_LISTED]],
        "rules": {part: _used(made, part) for part in found.parts},
        "speed": round(float(meter.speed), 3),
        "rhythm": f"{meter.beats}/{meter.beat}",
        "division": meter.division,
    }


def _difference(it: Difference) -> dict[str, Any]:
    sides = {
        name: None if one is None else [one.symbol.words, round(one.start, 3), round(one.stop, 3)]
        for name, one in (("before", it.one), ("after", it.other))
    }
    return {"part": it.part, "kind": it.kind, **sides}


def _used(made: Conversion, part: str) -> list[int]:
    """Return how many symbols each rule of a part has deleted."""
    lines = Counter(made.score.tracks[part].symbols["rule"].tolist())
    return [lines[rule.line] for rule in made.profile.rules[part].all]


def _piece(staff: Staff, start: float, stop: float) -> dict[str, Any]:
    """Return a window of a staff, with the heights of its seconds."""
    times = np.linspace(start, stop, ceil((stop - start) * 4) + 1).tolist()
    unit, top = PIXEL / staff.scale, staff.y(stop)
    ys = [round((staff.y(it) - top) * unit, 1) for it in times]
    return {
        "svg": staff.svg(start, stop),
        "times": times,
        "ys": ys,
        "names": ys[0] + MARGIN + START,
    }


class Again(Told[IngestJob]):
    """A library that is written down anew."""

    def told(self) -> dict[str, Any]:
        """Return how far it is, and what could not be read."""
        state, outcomes = self.job.state, self.job.outcomes
        _, done, total = self.job.progress
        failed = [it.error for it in outcomes if it.status == "failed"]
        return {
            "state": state,
            "done": done,
            "total": total,
            "captures": sum(it.status == "added" for it in outcomes),
            "failed": len(failed),
            "reasons": failed[:_REASONS],
            "error": trouble(self.job.error),
        }


def asked_again(call: Call) -> dict[str, Any]:
    """Return how many captures would be written down anew by a profile."""
    site = call.site
    wanted = load(site.workshop.shelf.place(call.text("profile", "default"))).digest
    digests = [encoding.digest for _, encoding in site.library.store.known().values()]
    scores, same = digests.count(""), digests.count(wanted)
    return {"captures": len(digests) - scores - same, "same": same, "scores": scores}


def again(call: Call) -> dict[str, Any]:
    """Begin to write the library down anew by a profile."""
    site = call.site
    place = site.workshop.shelf.place(call.said("profile", str, "default"))
    jobs = processes(site.library.stats().captures, None)

    def make() -> Again:
        return Again(site.library.begin_encode(place, jobs=jobs))

    return {"job": site.jobs.begin(object(), make, goes_on="encode")}


def way(call: Call) -> dict[str, Any]:
    """Return where a limb points in a window: in its lengths, to the right, up and forward."""
    capture, numbers = _chosen(call)
    part = call.said("part", str, "")
    start, stop = _window(call, capture, LONGEST)
    rate = float(numbers.rate)
    step = max(round(rate / RATE), 1)
    times, points, length = list[float](), list[list[float]](), 0.0
    for group in anew.curves(call.site.library.store, capture, part, numbers):
        length = float(group.lengths[0])
        seconds = (np.arange(group.curve.shape[1]) + group.begin) / rate
        shown = np.flatnonzero((seconds >= start) & (seconds <= stop))[::step]
        times += np.round(seconds[shown], 4).tolist()
        points += np.round(group.curve[0, shown][:, [2, 1, 0]] / length, 4).tolist()
    return {"length": round(length, 1), "times": times, "points": points}


def tempo(call: Call) -> dict[str, Any]:
    """Return the tempo of a capture's movement."""
    capture, numbers = _chosen(call)
    found = anew.tempo(call.site.library.store, capture, numbers)
    if found is None:
        return {"speed": None, "says": "it is too short, or nothing moves"}
    return {"speed": float(found.speed), "clear": found.clear, "says": str(found)}
