"""What a library hands on: clips of its captures, and data sets of them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex.library import store

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lanindex.model import Hit
    from lanindex.search.hits import Hits


class Exporting(store.Store):
    """A library whose hits can be written as files."""

    words: str | os.PathLike[str] | None

    def export(
        self,
        hits: Iterable[Hit],
        folder: str | os.PathLike[str],
        *,
        pad: str = "0",
        format: str = "native",
        origin: bool = False,
        preview: str | None = None,
        force: bool = False,
    ) -> list[dict[str, Any]]:
        """Write hits as clips, in the format they came in or another.

        Parameters
        ----------
        hits : Hits, or any Hit in an iterable
            What to cut.
        folder : path-like
            Where to.
        pad : str
            Time before and after each: ``0.5s``, ``10f``.
        format : str
            ``native``, or what they shall be written in anew: `lanindex.pipeline.clipping.FORMATS`.
        origin : bool
            Let clips begin above the floor's origin, facing forward; they are written anew then.
        preview : str, optional
            ``webp``, ``gif`` or ``mp4``: write a film of each clip beside it, too.
        force : bool
            Replace files that are there.

        Returns
        -------
        list of dict
            The manifest, a clip each.

        Raises
        ------
        ExportError
            Where a hit comes from another library, a source has changed or is gone, or a file
            is there already; then nothing is written.

        Examples
        --------
        >>> import lanindex
        >>> with lanindex.open_library("dance.db") as library:
        ...     hits = library.search("torso forward high -> hold 1s+")
        ...     for clip in library.export(hits, "clips", pad="0.5s"):
        ...         print(clip["clip"], clip["clip_start_frame"], clip["clip_end_frame"])
        greetings_467-617.bvh 467 617
        """
        from lanindex.pipeline.export import export
        from lanindex.pipeline.requests import from_hits

        wanted = from_hits(hits, getattr(hits, "pattern", ""))
        how: dict[str, Any] = {"pad": pad, "format": format, "origin": origin}
        return export(self, wanted, Path(folder), preview=preview, force=force, **how)

    def dataset(
        self,
        found: Hits | Mapping[str, Hits] | None,
        folder: str | os.PathLike[str],
        *,
        layout: str = "npz",
        fps: float | str | None = None,
        pad: str = "0",
        split: str = "80/10/10",
        split_by: str | None = None,
        seed: int = 0,
        force: bool = False,
    ) -> dict[str, Any]:
        """Write hits as a data set to train on: joints, symbols and words, in splits, with a card.

        Parameters
        ----------
        found : Hits, or Mapping of str to Hits, or None
            What is in it; by label, where clips shall not have their captures'; None: all captures,
            each as a whole.
        folder : path-like
            Where to.
        layout : str
            ``npz``, or ``humanml3d``.
        fps : number, optional
            Frames a second; else those of the captures.
        pad : str
            Time before and after each hit: ``0.5s``, ``10f``.
        split : str
            Per cent for training, validation and testing.
        split_by : str, optional
            The column that tells what must stay in one split; else performers, where a column of
            that name or a like one tells them, and captures.
        seed : int
            Another one gives other splits.
        force : bool
            Replace a data set that is there.

        Returns
        -------
        dict
            The card: counts by split, label and licence, how it was found, what was left out.

        Raises
        ------
        ExportError
            Where the folder holds things, or a source has changed or is gone; then nothing is
            written.

        Examples
        --------
        >>> import lanindex
        >>> import numpy as np
        >>> with lanindex.open_library("dance.db") as library:
        ...     bows = library.search("torso forward high -> hold 1s+")
        ...     card = library.dataset({"bow": bows}, "bows", fps=20)
        >>> card["clips"], card["by_label"]["bow"]["captures"], card["split_by"]
        (1, 1, 'capture')
        >>> clip = np.load("bows/train/greetings_482-602.npz")
        >>> clip["joints"].shape, float(clip["fps"]), str(clip["texts"][0])
        ((80, 20, 3), 20.0, 'bow')
        """
        from lanindex.pipeline import dataset
        from lanindex.pipeline.dataset.texts import of_pattern
        from lanindex.pipeline.words import named

        if found is None:
            wanted = [dataset.of_captures(self.captures())]
        else:
            wanted = [
                dataset.of_hits(
                    hits, label, of_pattern(hits.pattern, named(hits.pattern, self.words))
                )
                for label, hits in (found.items() if isinstance(found, Mapping) else [("", found)])
            ]
        rate = None if fps is None else Fraction(fps).limit_denominator(10**6)
        wishes = dataset.Wishes(layout, rate, pad, split, split_by, seed, force)
        return dict(dataset.write(self, wanted, Path(folder), wishes).card)
