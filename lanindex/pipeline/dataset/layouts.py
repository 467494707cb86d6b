"""How clips lie in a data set's folder: arrays by split, or as HumanML3D has them."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINTS, KINDS, kind_of
from lanindex.errors import UsageError
from lanindex.formats.npy import features
from lanindex.formats.npy.orders import SMPL
from lanindex.model import Score, Span, Symbol
from lanindex.notation.excerpt import excerpt
from lanindex.pipeline.dataset.splits import SPLITS
from lanindex.pipeline.dataset.texts import tagged

Floats = NDArray[np.float64]

FILES = tuple[tuple[str, bytes], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """One clip, as the layouts get it."""

    name: str
    split: str
    places: Floats
    rate: Fraction
    score: Score
    span: Span
    texts: Sequence[str]
    kind: str


class Layout(Protocol):
    """How clips are written."""

    rate: Fraction | None
    """Frames a second that clips must have; None: any."""

    said: tuple[str, ...]
    """What its card tells of it, a line each."""

    def names(self, name: str, split: str) -> tuple[str, ...]:
        """Return the files of a clip."""

    def lacking(self, clip: Clip) -> str:
        """Say why a clip cannot be written; empty: it can."""

    def files(self, clip: Clip) -> FILES:
        """Return the files of a clip, with what is in them."""

    def last(self) -> Iterator[tuple[str, bytes]]:
        """Yield what belongs to all clips, when all of them are written."""


@dataclass
class Arrays:
    """A file of numpy arrays a clip, in a folder a split; LanIndex reads them, too."""

    rate: Fraction | None = None
    said: tuple[str, ...] = (
        "`SPLIT/NAME.npz`, for `numpy.load`, none of it pickled:",
        "",
        "| array | |",
        "|---|---|",
        "| `joints` | (T, 20, 3) float32: places in metres, y up, right-handed; NaN: unknown |",
        "| `joint_names` | (20) of the joints |",
        "| `fps`, `unit`, `up` | frames a second, `m`, `y` |",
        "| `symbol_part`, `symbol_direction`, `symbol_level`, `symbol_amount` | (S) words; empty: none |",  # noqa: E501
        "| `symbol_frames` | (S, 2) int32: from, up to and not including; frames of the clip |",
        "| `texts` | what the clip is in words: its label, what was asked for, what was seen |",
        "| `label` | what it was found as; else the capture's label |",
    )

    def names(self, name: str, split: str) -> tuple[str, ...]:
        """Return the file of a clip."""
        return (f"{split}/{name}.npz",)

    def lacking(self, clip: Clip) -> str:
        """Refuse what has no place at all."""
        return "" if np.isfinite(clip.places).any() else "no joint of the body is known"

    def files(self, clip: Clip) -> FILES:
        """Return the arrays of a clip."""
        rows = [symbol for symbol in excerpt(clip.score, clip.span).symbols() if not symbol.passing]
        spans = np.array([(row.start, row.stop) for row in rows], np.float64).reshape(-1, 2)
        spans = np.rint(spans * float(clip.rate / clip.score.rate))
        arrays: dict[str, Any] = {
            "joints": clip.places.astype(np.float32),
            "joint_names": np.array(JOINTS),
            "fps": np.array(float(clip.rate)),
            "unit": np.array("m"),
            "up": np.array("y"),
            "symbol_part": _words(row.part for row in rows),
            "symbol_direction": _words(row.direction or "" for row in rows),
            "symbol_level": _words(row.level or "" for row in rows),
            "symbol_amount": _words(map(_amount, rows)),
            "symbol_frames": np.minimum(spans, len(clip.places)).astype(np.int32),
            "texts": _words(clip.texts),
            "label": np.array(clip.kind),
        }
        content = io.BytesIO()
        np.savez_compressed(content, allow_pickle=False, **arrays)
        return ((self.names(clip.name, clip.split)[0], content.getvalue()),)

    def last(self) -> Iterator[tuple[str, bytes]]:
        """Yield nothing more."""
        yield from ()


def _words(words: Any) -> NDArray[Any]:
    return np.array(list(words), dtype=np.str_)


def _amount(symbol: Symbol) -> str:
    amount = symbol.amount
    return "" if amount is None else KINDS[kind_of(symbol.part)].amount(amount)


_SPINE = {"spine1": 0.24, "spine2": 0.5, "spine3": 0.6}
"""How far each lies on the way from the pelvis over the chest to the neck."""

_COLLAR = {"spine3": 0.37, "neck": 0.26, "shoulder": 0.37}
"""What a collar is made of, as in the body at rest."""

_SAME = {
    **{"pelvis": "Pelvis", "neck": "Neck", "head": "Head"},
    **{
        f"{side}_{theirs}": side[0].upper() + ours
        for side in ("left", "right")
        for theirs, ours in (
            *(("hip", "Hip"), ("knee", "Knee"), ("ankle", "Ankle"), ("foot", "Toe")),
            *(("shoulder", "Shoulder"), ("elbow", "Elbow"), ("wrist", "Wrist")),
        )
    },
}

_NEEDED = [place for place, joint in enumerate(JOINTS) if joint in {*_SAME.values(), "Chest"}]


@dataclass
class HumanML3D:
    """The folders of HumanML3D: places, features, texts and lists of names."""

    rate: Fraction | None = Fraction(20)
    said: tuple[str, ...] = (
        "The folders of HumanML3D (Guo et al. 2022), 20 frames a second, metres, y up:",
        "",
        "| file | |",
        "|---|---|",
        "| `new_joints/NAME.npy` | (T, 22, 3) float32 places, above the origin and facing z at first |",  # noqa: E501
        "| `new_joint_vecs/NAME.npy` | (T, 263) float32 features of the same frames |",
        "| `texts/NAME.txt` | `caption#word/TAG word/TAG#0.0#0.0`, a line each; tags are those of words that LanIndex uses itself, others `X` |",  # noqa: E501
        "| `all.txt`, `train.txt`, `val.txt`, `test.txt` | names |",
        "| `Mean.npy`, `Std.npy` | (263) of the training clips; deviations are means over a group of features |",  # noqa: E501
        "",
        "Unlike there, bodies keep their own proportions (the published clips are brought to one",
        "skeleton), and the heading is told by hips and shoulders together. Spine and collars are",
        "laid between pelvis, chest, neck and shoulders: the captures have no such joints.",
    )
    names_by_split: dict[str, list[str]] = field(
        default_factory=lambda: {split: [] for split in SPLITS}
    )
    _sums: Floats = field(default_factory=lambda: np.zeros((2, 263)))
    _frames: Counter[str] = field(default_factory=Counter)

    def names(self, name: str, split: str) -> tuple[str, ...]:
        """Return the files of a clip."""
        return f"new_joints/{name}.npy", f"new_joint_vecs/{name}.npy", f"texts/{name}.txt"

    def lacking(self, clip: Clip) -> str:
        """Refuse what has fewer than three frames, or joints that are not known all the time."""
        if len(clip.places) < 3:
            return "fewer than 3 frames"
        gone = ~np.isfinite(clip.places[:, _NEEDED]).all(axis=(0, 2))
        named = ", ".join(JOINTS[_NEEDED[place]] for place in np.flatnonzero(gone))
        return f"not known all the time: {named}" if named else ""

    def files(self, clip: Clip) -> FILES:
        """Return places, features and texts of a clip."""
        places = features.grounded(joints22(clip.places))
        values = features.features(places)
        if clip.split == "train":
            exact = values.astype(np.float64)
            self._sums += exact.sum(axis=0), (exact * exact).sum(axis=0)
            self._frames["train"] += len(exact)
        self.names_by_split[clip.split].append(clip.name)
        captions = [text.replace("#", " ") for text in clip.texts or (clip.kind or "a movement",)]
        lines = "".join(f"{text}#{tagged(text)}#0.0#0.0\n" for text in captions)
        contents = _npy(places[:-1].astype(np.float32)), _npy(values), lines.encode()
        return tuple(zip(self.names(clip.name, clip.split), contents, strict=True))

    def last(self) -> Iterator[tuple[str, bytes]]:
        """Yield the lists of names, mean and deviation."""
        for split, names in self.names_by_split.items():
            yield f"{split}.txt", "".join(f"{name}\n" for name in names).encode()
        every = sorted(name for names in self.names_by_split.values() for name in names)
        yield "all.txt", "".join(f"{name}\n" for name in every).encode()
        if count := self._frames["train"]:
            mean = self._sums[0] / count
            spread = np.sqrt(np.maximum(self._sums[1] / count - mean * mean, 0))
            for first, last in ((0, 1), (1, 3), (3, 4), (4, 67), (67, 193), (193, 259), (259, 263)):
                spread[first:last] = spread[first:last].mean()
            yield "Mean.npy", _npy(mean.astype(np.float32))
            yield "Std.npy", _npy(spread.astype(np.float32))


def joints22(places: Floats) -> Floats:
    """Return the joints of HumanML3D, (T, 22, 3), of those of the body, (T, 20, 3)."""
    by_name = {name: places[:, JOINTS.index(joint)] for name, joint in _SAME.items()}
    pelvis, chest, neck = by_name["pelvis"], places[:, JOINTS.index("Chest")], by_name["neck"]
    lower, upper = (np.linalg.norm(end, axis=1)[:, None] for end in (chest - pelvis, neck - chest))
    for name, share in _SPINE.items():
        gone = share * (lower + upper)
        below = pelvis + (chest - pelvis) * (gone / np.maximum(lower, 1e-9))
        above = chest + (neck - chest) * ((gone - lower) / np.maximum(upper, 1e-9))
        by_name[name] = np.where(gone <= lower, below, above)
    for side in ("left", "right"):
        ends = ("spine3", "neck", f"{side}_shoulder")
        by_name[f"{side}_collar"] = np.asarray(
            sum(by_name[end] * part for end, part in zip(ends, _COLLAR.values(), strict=True))
        )
    return np.stack([by_name[name] for name in SMPL[:22]], axis=1)


def _npy(values: NDArray[Any]) -> bytes:
    content = io.BytesIO()
    np.save(content, values, allow_pickle=False)
    return content.getvalue()


LAYOUTS = {"npz": Arrays, "humanml3d": HumanML3D}
"""Every layout, by what it is called."""


def layout_of(name: str) -> Layout:
    """Return a layout, with nothing written yet."""
    if name not in LAYOUTS:
        raise UsageError(f'"{name}"', place="--layout", wanted=" or ".join(LAYOUTS))
    made: Layout = LAYOUTS[name]()
    return made
