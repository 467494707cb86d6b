"""How clips lie in a data set's folder: arrays by split, or as HumanML3D has them."""

import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINTS, KINDS, kind_of
from lanindex.data import shipped
from lanindex.errors import UsageError
from lanindex.formats import smpl
from lanindex.model import Score, Span, Symbol
from lanindex.notation.excerpt import excerpt

Floats = NDArray[np.float64]

SPLITS = ("train", "val", "test")


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """One clip, as the layouts get it; `places` are (T, 20, 3) in metres."""

    name: str
    split: str
    places: Floats
    rate: Fraction
    score: Score
    span: Span
    texts: Sequence[str]
    label: str


class Arrays:
    """A file of numpy arrays a clip, in a folder a split; LanIndex reads them, too."""

    rate: Fraction | None = None
    """Frames a second that clips must have; None: any."""

    shared: tuple[str, ...] = ()
    """Names of files that belong to all clips."""

    def names(self, name: str, split: str) -> tuple[str, ...]:
        """Return the file of a clip."""
        return (f"{split}/{name}.npz",)

    def lacking(self, clip: Clip) -> str:
        """Return why a clip cannot be written: it has no place at all."""
        return "" if np.isfinite(clip.places).any() else "no joint of the body is known"

    def contents(self, clip: Clip) -> Iterator[bytes]:
        """Yield the arrays of a clip."""
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
            "label": np.array(clip.label),
        }
        content = io.BytesIO()
        np.savez_compressed(content, allow_pickle=False, **arrays)
        yield content.getvalue()

    def shared_contents(self) -> Iterator[bytes]:
        """Yield nothing: no file belongs to all clips."""
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

_SAME: dict[str, str] = shipped("pipeline/layouts.toml")["joints"]

_NEEDED = [place for place, joint in enumerate(JOINTS) if joint in {*_SAME.values(), "Chest"}]


class HumanML3D:
    """The folders of HumanML3D: places, features, texts and lists of names."""

    rate: Fraction | None = Fraction(20)
    shared = (*(f"{split}.txt" for split in SPLITS), "all.txt", "Mean.npy", "Std.npy")

    def __init__(self) -> None:
        self._names: dict[str, list[str]] = {split: [] for split in SPLITS}
        self._sums: Floats = np.zeros((2, 263))  # of the features of training, and of their squares
        self._frames = 0

    def names(self, name: str, split: str) -> tuple[str, ...]:
        """Return the files of a clip."""
        return f"new_joints/{name}.npy", f"new_joint_vecs/{name}.npy", f"texts/{name}.txt"

    def lacking(self, clip: Clip) -> str:
        """Return why a clip cannot be written: too short, or joints that are not always known."""
        if len(clip.places) < 3:
            return "fewer than 3 frames"
        gone = ~np.isfinite(clip.places[:, _NEEDED]).all(axis=(0, 2))
        named = ", ".join(JOINTS[_NEEDED[place]] for place in np.flatnonzero(gone))
        return f"not known all the time: {named}" if named else ""

    def contents(self, clip: Clip) -> Iterator[bytes]:
        """Yield places, features and texts of a clip."""
        places = smpl.grounded(joints22(clip.places))
        values = smpl.features(places)
        if clip.split == "train":
            exact = values.astype(np.float64)
            self._sums += exact.sum(axis=0), (exact * exact).sum(axis=0)
            self._frames += len(exact)
        self._names[clip.split].append(clip.name)
        yield _npy(places[:-1].astype(np.float32))
        yield _npy(values)
        captions = [text.replace("#", " ") for text in clip.texts or (clip.label or "a movement",)]
        yield "".join(f"{text}#{tagged(text)}#0.0#0.0\n" for text in captions).encode()

    def shared_contents(self) -> Iterator[bytes]:
        """Yield the lists of names, and mean and deviation if there is a training clip."""
        every = sorted(name for names in self._names.values() for name in names)
        for names in (*self._names.values(), every):
            yield "".join(f"{name}\n" for name in names).encode()
        if self._frames:
            mean = self._sums[0] / self._frames
            spread = np.sqrt(np.maximum(self._sums[1] / self._frames - mean * mean, 0))
            for first, last in ((0, 1), (1, 3), (3, 4), (4, 67), (67, 193), (193, 259), (259, 263)):
                spread[first:last] = spread[first:last].mean()
            yield _npy(mean.astype(np.float32))
            yield _npy(spread.astype(np.float32))


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
    return np.stack([by_name[name] for name in smpl.SMPL[:22]], axis=1)


def _npy(values: NDArray[Any]) -> bytes:
    content = io.BytesIO()
    np.save(content, values, allow_pickle=False)
    return content.getvalue()


def tagged(text: str) -> str:
    """Return a text's words with their parts of speech, as HumanML3D has them.

    Those are known of words that LanIndex itself uses; others are ``X``.
    """
    tags = shipped("pipeline/layouts.toml")["tags"].items()
    words = re.findall(r"[^\W\d_]+", text.lower())
    tag_of = {word: tag for tag, known in tags for word in known.split()}
    return " ".join(f"{word}/{tag_of.get(word, 'X')}" for word in words)


LAYOUTS: dict[str, type[Arrays] | type[HumanML3D]] = {"npz": Arrays, "humanml3d": HumanML3D}
"""Every layout, by what it is called."""


def layout_of(name: str) -> Arrays | HumanML3D:
    """Return a layout, with nothing written yet."""
    if name not in LAYOUTS:
        raise UsageError(f'"{name}"', place="--layout", wanted=" or ".join(LAYOUTS))
    return LAYOUTS[name]()
