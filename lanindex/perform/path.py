"""Where the standard body and its feet come to, step after step and rest after rest.

Source: ``encode/BODY.md``, read backwards. Places over the ground are forward and right of where
the body began.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import HIGH, LOW, PLACE
from lanindex.perform.figure import Body
from lanindex.perform.legs import SIDES, Size, hip, toward
from lanindex.perform.reach import minimum_jerk
from lanindex.perform.resting import Rest, part

Floats = NDArray[np.float64]

STRIDE, SHORT = 0.45, 0.22
"""Lengths of a leg that a step takes the body, at most and at least."""

HANGS = 0.03
"""Lengths of a leg that the toe may hang above the floor which a step leaves behind: steps back,
and to the side on the toes, are shorter."""

SINKS, HEELS = 0.16, 0.11
"""Lengths of a leg that the body sinks for a low step, and that heels rise for a high one."""

HEIGHT = {LOW: -SINKS, HIGH: HEELS}
"""Lengths of a leg that a step takes the body up, by its level."""

REACHES = 0.995
"""Part of its length that a leg that carries has from hip to ankle."""

BRIEF = 0.1
"""Seconds: a step that begins so soon after a rest begins at once."""

DRAWN = 12.0
"""Lengths of a leg a second squared: how bodies fall."""


@dataclass(frozen=True, slots=True)
class Move:
    """Something that takes its time, in seconds, and takes the body along."""

    start: float  # When
    stop: float
    direction: int  # Codes of the alphabet; -1: none
    level: int
    feet: str  # Sides of the feet that stand anew
    flies: bool = False  # Whether the body is in the air
    # (2,) mm: where a foot is drawn that is not lifted, while the body goes nowhere
    to: Floats | None = None

    @property
    def steps(self) -> bool:
        """Whether a foot is lifted, and stands anew."""
        return not self.flies and self.to is None

    def share(self, times: Floats, longer: float = 0.0) -> Floats:
        """Return how much of it is done, if it takes longer by some part of its time."""
        length = max((1 + longer) * (self.stop - self.start), 1e-9)
        part = np.clip((times - self.start) / length, 0, 1)
        return part if self.flies else minimum_jerk(part)

    def within(self, times: Floats) -> tuple[slice, Floats]:
        """Return the frames that it takes, and how much of it is done in them."""
        some = slice(*np.searchsorted(times, (self.start, self.stop)).tolist())
        return some, self.share(times[some])


def add(steps: Floats, some: slice, done: Floats, whole: Any) -> None:
    """Add to the steps of a sum, frame by frame, what comes to it over some frames."""
    if len(done):
        steps[some] += np.diff(done, axis=0, prepend=0 * done[:1])
        whole = whole - done[-1]
    if some.stop < len(steps):
        steps[some.stop] += whole


@dataclass(slots=True, eq=False)
class Path:
    """Where body and feet have come to, event after event."""

    body: Body  # Who goes
    times: Floats  # (T,) seconds, and radians that it has turned to the left
    front: Floats
    steps: Floats  # (T, 2) mm: how far steps, and rests, take the hips from frame to frame
    shift: Floats
    high: Floats  # (T,) lengths of a leg: how high it flies
    drawn: list[Move]  # Feet that are drawn up while the body rests, or behind it as it rises
    _now: Floats
    _feet: dict[str, Floats]
    _until: float = -np.inf

    @classmethod
    def of(cls, body: Body, times: Floats, front: Floats) -> Path:
        """Return a path on which nothing has happened yet."""
        steps, shift = np.zeros((2, len(times), 2))
        feet = {side: hip(body, side)[2] * toward(0.0) for side in SIDES}
        return cls(body, times, front, steps, shift, np.zeros(len(times)), [], np.zeros(2), feet)

    def follow(
        self, moves: Sequence[Move], rests: Sequence[Rest], placed: Sequence[dict[str, Floats]]
    ) -> None:
        """Take body and feet along.

        `placed`: By rest and side, where a leg has its foot that goes as told.
        """
        both: list[Move | tuple[Rest, dict[str, Floats]]] = [
            *moves,
            *zip(rests, placed, strict=True),
        ]
        for one in sorted(both, key=lambda it: it.stop if isinstance(it, Move) else it[0].stop):
            if isinstance(one, tuple):
                if not moves:  # its feet have turned along
                    self._feet = self._joints(self._front(one[0].start))
                self._rest(*one)
            else:
                self._move(one)

    def _front(self, time: float) -> float:
        return float(np.interp(time, self.times, self.front))

    def _joints(self, turned: float) -> dict[str, Floats]:
        """Return where both hips are over the ground."""
        return {side: self._now + hip(self.body, side)[2] * toward(turned) for side in SIDES}

    def _rest(self, one: Rest, placed: dict[str, Floats]) -> None:
        """Bring the hips before the foot in front, or behind the other; feet are drawn up."""
        leg, before = Size.of(self.body).leg, toward(self._front(one.start) + np.pi / 2)
        apart = abs(float((self._feet["r"] - self._feet["l"]) @ before)) / 2
        away = leg * one.pose.ahead + np.copysign(apart, one.pose.ahead)
        self._shift((self._feet["r"] + self._feet["l"]) / 2 + away * before, one.forth)
        turned = self._front(one.stop)
        back = np.array([-one.pose.ahead, 0.0])
        for side, joint in self._joints(turned).items():
            ahead, right = leg * placed.get(side, back)
            to = joint + ahead * toward(turned + np.pi / 2) + right * toward(turned)
            self._feet[side] = to
            self.drawn.append(Move(*one.draws, PLACE, -1, side, to=to))
        self._until = one.stop
        if one.returns:
            self._shift((self._feet["r"] + self._feet["l"]) / 2, one.back)

    def _shift(self, there: Floats, window: tuple[float, float]) -> None:
        some = slice(*np.searchsorted(self.times, window).tolist())
        whole = there - self._now
        add(self.shift, some, whole * part(self.times[some], window)[:, None], whole)
        self._now = there

    def _move(self, one: Move) -> None:
        """Step or jump."""
        leg, turned = Size.of(self.body).leg, self._front(one.stop)
        some, share = one.within(self.times)
        if one.direction != PLACE:
            way = toward(np.radians(45.0 * one.direction) + turned)
            way *= leg * (STRIDE if one.flies else self._stride(one, way, turned))
            add(self.steps, some, way * share[:, None], way)
            self._now = self._now + way
        joints = self._joints(turned)
        for side in SIDES:
            if one.flies or side in one.feet:
                self._feet[side] = joints[side]
            elif one.start < self._until + BRIEF:
                self._draw(side, one, joints[side], turned)
        if one.flies:
            self.high[some] += DRAWN / 2 * (one.stop - one.start) ** 2 * share * (1 - share)
        self._until = -np.inf

    def _draw(self, side: str, one: Move, joint: Floats, turned: float) -> None:
        """Draw the foot along that carries a body which rises from a rest as it steps."""
        toe = Size.of(self.body).toe[0] * toward(turned + np.pi / 2)
        way, most = self._feet[side] + toe - joint, self._room(one.level)
        far = float(np.hypot(*way))
        if far > most:
            self._feet[side] = joint + most / far * way - toe
            begin = max(one.start, self._until)
            self.drawn.append(Move(begin, one.stop, PLACE, -1, side, to=self._feet[side]))

    def _room(self, level: int) -> float:
        """Return how far a toe is over the ground, mm, that comes near to the floor."""
        size = Size.of(self.body)
        reach = size.leg + float(np.linalg.norm(size.toe))
        high = size.leg * (REACHES + HEIGHT.get(level, 0.0) - HANGS) - size.toe[1]
        return float(np.sqrt(max(reach**2 - high**2, 0)))

    def _stride(self, one: Move, way: Floats, turned: float) -> float:
        """Return how far a step goes: so far that the other foot keeps its toe near the floor."""
        side, size = SIDES[1 - SIDES.index(one.feet)], Size.of(self.body)
        toe = self._feet[side] + size.toe[0] * toward(turned + np.pi / 2)
        away = toe - self._joints(turned)[side]
        along = float(away @ way)
        room = along**2 - float(away @ away) + self._room(one.level) ** 2
        return float(np.clip((along + np.sqrt(max(room, 0))) / size.leg, SHORT, STRIDE))
