"""The best of a search by example in the order in which their bodies move alike."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from lanindex import formats
from lanindex.errors import LanindexError, UsageError, shown
from lanindex.library.encoding import Encoding
from lanindex.library.store import Store
from lanindex.model import Reading, Span
from lanindex.notation import notation_of
from lanindex.pipeline.example import Alike
from lanindex.pipeline.patience import Patience, silent
from lanindex.pipeline.prepare import as_ingested
from lanindex.search.example.warping import normalised, warped
from lanindex.search.hits import Hits

MOST = 100
"""Hits of which files are read."""


def reranked(library: Store, found: Alike, patience: Patience | None = None) -> Alike:
    """Return what is like an example, the best hundred by how far their joints lie from its own.

    Parameters
    ----------
    library : Store
        Where the hits are from.
    found : Alike
        The likest first.
    patience : Patience, optional
        How long it may take, and who is told how far it is.

    Returns
    -------
    Alike
        Those whose file is at hand by dynamic time warping of joint positions; behind them, as
        they came, those whose file is not, and the rest. What could not be used is `told`.

    Raises
    ------
    UsageError
        Where the example itself has no joints, or its file is not at hand.
    """
    one, hits = found.example, found.hits
    known = library.known()
    digest = one.capture.sha256 if one.capture else ""
    location = one.capture.location if one.capture else one.path
    try:
        own = _joints(location, digest, known, one.span)
    except LanindexError as error:
        place = f"--like {shown(one.named)} --rerank"
        raise UsageError(f"no joint positions: {error}", place=place) from error
    told: list[str] = []
    apart: list[float] = []
    watch, best = patience or Patience(silent, None), hits[:MOST]
    for done, hit in enumerate(best):
        watch("files", done, len(best))
        try:
            joints = _joints(hit.capture.location, hit.capture.sha256, known, hit.span)
            apart.append(warped(own, joints))
            if apart[-1] == inf:
                told.append(f"{hit.path}: no joint is known in all frames of both")
        except LanindexError as error:
            told.append(str(error))
            apart.append(inf)
    order = sorted(range(len(apart)), key=apart.__getitem__)
    moved = [*(hits[index] for index in order), *hits[MOST:]]
    return replace(found, hits=Hits(moved, hits.pattern), told=tuple(told))


def _joints(
    location: str, digest: str, known: dict[str, tuple[str, Encoding]], span: Span
) -> NDArray[np.float32]:
    """Return the joints of a stretch of a file, as every body would do it."""
    if notation_of(location):
        raise UsageError("a score has no joints", place=location, wanted="a capture")
    file = formats.opened(location)
    _, encoding = known.get(location, ("", Encoding()))
    if digest and not as_ingested(file, digest, encoding):
        raise UsageError("has changed since it was ingested", place=location)
    told = Reading(**encoding.options)
    motion = formats.read_file(file, told, formats.Wanted(body_only=True))
    body = motion.skeleton.body
    joints = np.asarray(motion.positions[max(span.start, motion.first) : span.stop])[:, body]
    joints[:, body < 0] = np.nan
    return normalised(joints, float(motion.rate))
