"""The clips that are most like one: whole or, where they are much longer, their best stretch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lanindex.search.example.align import compared
from lanindex.search.example.candidates import promises
from lanindex.search.example.moves import Clips, LazyClips, Watch, pieces, unwatched
from lanindex.search.example.stretches import reach_of, stretches

LONGER = 4.0
"""From how many times the length of the example on a clip is looked through by stretches, too."""

MOST = 4096
"""Clips that are aligned at the most."""

_BLOCK = 256
"""Clips that are aligned at a time."""

_ROWS = 1 << 18
"""Rows of clips that are laid out at a time."""

_LONG = 16
"""Rows a part of an example from which on these are fewer."""


class Near(NamedTuple):
    """A clip that is like the example, or a stretch of it.

    Attributes
    ----------
    clip : int
        Which.
    begin, end : int
        Frames of its source, half-open.
    likeness : float
        0 to 1.
    """

    clip: int
    begin: int
    end: int
    likeness: float


class Found(NamedTuple):
    """What is like an example.

    Attributes
    ----------
    near : list of Near
        The best first.
    aligned : int
        How many clips were aligned.
    sure : bool
        Whether no whole clip that was not aligned could be among them.
    """

    near: list[Near]
    aligned: int
    sure: bool


def nearest(
    query: Clips,
    seconds: float,
    clips: Clips | LazyClips,
    frames: Sequence[int],
    rates: Sequence[float],
    limit: int,
    *,
    most: int = MOST,
    watch: Watch = unwatched,
) -> Found:
    """Return the clips that are most like one.

    Parameters
    ----------
    query : Clips
        The one, with the same parts as `clips`.
    seconds : float
        How long it lasts.
    clips : Clips
        To choose from.
    frames, rates : sequence
        Of each clip: its length in frames, and frames a second.
    limit : int
        How many are wanted.
    most : int
        How many are aligned at the most.
    watch : callable, optional
        Is told how far it is; it may raise.
    """
    # of a long example fewer clips at a time, so that whoever waits is told as often
    work = clips.counts * max(1, len(query.moves.rows) // (_LONG * len(query.parts)))
    whole, stretch = np.zeros((2, len(clips)), np.float32)
    for some in pieces(work, _ROWS):
        watch("captures", some.start, len(clips))
        own = clips.taken(np.arange(some.start, some.stop))
        whole[some], stretch[some], _ = promises(query, own)
    lasting = np.array(frames, np.int64)
    lengths = seconds * np.array(rates, np.float64)
    longer = lasting >= LONGER * lengths
    hope = np.where(longer, np.maximum(whole, stretch), whole)
    order = np.argsort(-hope, kind="stable")
    near: list[Near] = []
    done, worst = 0, 0.0
    while done < min(most, len(order)) and hope[order[done]] > worst:
        watch("candidates", done, min(most, len(order)))
        block = order[done : min(done + _BLOCK, most)]
        block = block[next(pieces(work[block], _ROWS))]
        own = clips.taken(block)
        alike = compared(query, own, own.whole()).tolist()
        whole_ones = zip(block.tolist(), lasting[block].tolist(), alike, strict=True)
        near = _best(
            [*near, *(Near(clip, 0, last, value) for clip, last, value in whole_ones)], limit
        )
        worst = near[-1].likeness if len(near) == limit else 0.0
        chosen = np.flatnonzero(longer[block] & (stretch[block] > worst))
        if len(chosen):
            reach = reach_of(query, own, promises(query, own))
            found = stretches(query, own, reach, chosen, lasting[block], lengths[block], worst)
            near += [Near(int(block[one.clip]), *one[1:]) for one in found]
            near = _best(near, limit)
            worst = near[-1].likeness if len(near) == limit else 0.0
        done += len(block)
    return Found(near, done, done >= len(order) or bool(hope[order[done]] <= worst))


def _best(near: list[Near], limit: int) -> list[Near]:
    """Return the best, each clip once."""
    kept: dict[int, Near] = {}
    for one in sorted(near, key=_rank):
        kept.setdefault(one.clip, one)
    return [one for one in kept.values() if one.likeness > 0][:limit]


def _rank(near: Near) -> tuple[float, int, int]:
    return -near.likeness, near.begin - near.end, near.clip
