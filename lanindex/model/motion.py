"""A capture in memory: joints over time, where they come from, and the options of a reader."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from fractions import Fraction
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINTS
from lanindex.errors import EncodeError
from lanindex.model.symbol import frozen


@dataclass(frozen=True, slots=True)
class Reading:
    """Options of a reader: what the user states in place of what the file says."""

    unit: str | None = None  # Of the file: ``mm``, ``cm``, ``m``, ``inch``, ``inch/0.45``
    up: str | None = None  # Its vertical axis: ``y``, ``z``, ``x``, ``-y``, ``-z``, ``-x``
    rate: Fraction | float | str | None = None  # Frames a second
    # ``parent``: a joint's turn follows its parent's; ``child``: it precedes it
    compose: str | None = None
    # A file with the skeleton, where the capture's own has none and none lies beside it
    skeleton: str | None = None
    body: str | None = None  # A file that says which joints or markers play the body
    columns: str | None = None  # A file that says what the columns of a table are
    take: str | None = None  # Which of several takes in a file
    # How time is counted: ``auto``, by the movement's own beat, or a file of beats
    tempo: str | None = None

    def given(self) -> dict[str, str]:
        """Return the options that were given, as text."""
        values = ((one.name, getattr(self, one.name)) for one in fields(self))
        return {name: str(value) for name, value in values if value is not None}


def _frozen(what: str, array: NDArray[Any], *shape: int | str) -> NDArray[Any]:
    """Return an array that cannot be written to; of any other shape it is an error."""
    fitting = tuple(n if one == "T" else one for n, one in zip(array.shape, shape, strict=False))
    if array.shape != fitting or len(shape) != array.ndim:
        raise EncodeError(f"{what} shape {array.shape}", wanted=str(shape).replace("'", ""))
    return frozen(array)


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """The joints of a capture, as its file names them."""

    names: tuple[str, ...]  # (J) names, parents before children
    parents: NDArray[np.int16]  # (J,) int16, index of each joint's parent, -1 for a root
    offsets: NDArray[np.float32]  # (J, 3) float32, mm, y up: from the parent, at rest
    # (20,) int16, index of the joint that plays each of ``alphabet.JOINTS``, -1: absent
    body: NDArray[np.int16]

    def __post_init__(self) -> None:
        joints = len(self.names)
        for name, shape in (("parents", (joints,)), ("offsets", (joints, 3)), ("body", (20,))):
            object.__setattr__(self, name, _frozen(f"{name} has", getattr(self, name), *shape))

    def played(self) -> dict[str, str]:
        """Return the joints of the body model that are present, with the file's names."""
        players = zip(JOINTS, self.body, strict=True)
        return {joint: self.names[index] for joint, index in players if index >= 0}


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """The file of a motion, and how the reader took it."""

    path: str  # As given
    format: str  # ``bvh`` ...
    # Name of the unit, with ``(detected)`` where the file does not state it, ``(guessed)`` where no
    # unit gives the body a usual size
    unit: str
    scale: float  # Millimetres in one unit of the file
    up: str  # The file's vertical axis: ``y``, ``z``, ``-y``
    # Whether a joint's turn follows its parent's (``parent``) or precedes it (``child``), and how
    # that is known; empty where the format leaves no choice
    compose: str = ""
    # All joints of the file; a motion may hold only those of the body
    joints: tuple[str, ...] = ()
    # Name of the marker set, where joints were made of markers
    set: str = ""
    # By joint of the body, the markers that it was made of
    made: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Markers:
    """The markers of a capture, beside the joints that were made of them."""

    names: tuple[str, ...]  # (M) names in the file
    positions: NDArray[np.float32]  # (T, M, 3) float32, mm, y up, right-handed; NaN where unknown

    def __post_init__(self) -> None:
        positions = _frozen("markers have", self.positions, "T", len(self.names), 3)
        object.__setattr__(self, "positions", positions)

    def __getitem__(self, name: str) -> NDArray[np.float32]:
        """Return the places of one marker, (T, 3)."""
        if name not in self.names:
            raise KeyError(name)
        return self.positions[:, self.names.index(name)]


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A capture: positions of joints over time.

    Attributes
    ----------
    skeleton : Skeleton
        Names and hierarchy.
    rate : Fraction
        Frames a second.
    positions : ndarray
        (T, J, 3) float32, mm, y up, right-handed; NaN where unknown.
    source : Source
        The file.
    first : int
        The first frame that is movement: behind a calibration pose, if there is one, else 0.
    warnings : tuple of str
        What the reader found doubtful.
    rotations : ndarray or None
        (T, J, 4) float32, unit quaternions (w, x, y, z) from each joint's rest to the world, in
        the axes of `positions`; NaN where unknown. None where the source has none: a twist cannot
        be told from positions.
    markers : Markers or None
        Of a source that has them, where all of it was read.
    axes : mapping of str to ndarray
        By joint of the body, where the source tells how that is turned: (T, 2, 3) float32, where
        what at rest points to the body's right, and up, points now; unit vectors, NaN where
        unknown.

    Examples
    --------
    >>> import lanindex
    >>> motion = lanindex.read("corpus/compass.bvh")
    >>> len(motion), motion.rate, motion.seconds, motion.positions.shape
    (840, Fraction(30, 1), 28.0, (840, 28, 3))
    >>> motion.skeleton.played()["RWrist"]
    'RightHand'
    >>> motion.source.unit, motion.source.up
    ('cm (detected)', 'y')
    """

    skeleton: Skeleton
    rate: Fraction
    positions: NDArray[np.float32]
    source: Source
    first: int = 0
    warnings: tuple[str, ...] = ()
    rotations: NDArray[np.float32] | None = None
    markers: Markers | None = None
    axes: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        joints = len(self.skeleton.names)
        positions = _frozen("positions have", self.positions, "T", joints, 3)
        if self.rate <= 0:
            raise EncodeError(f"a rate of {self.rate} frames a second", wanted="more than 0")
        object.__setattr__(self, "rate", Fraction(self.rate))
        object.__setattr__(self, "positions", positions)
        if self.rotations is not None:
            rotations = _frozen("rotations have", self.rotations, len(self), joints, 4)
            object.__setattr__(self, "rotations", rotations)
        axes = {
            joint: _frozen(f"axes of {joint} have", one, len(self), 2, 3)
            for joint, one in self.axes.items()
        }
        object.__setattr__(self, "axes", axes)

    def __len__(self) -> int:
        return int(self.positions.shape[0])

    @property
    def seconds(self) -> float:
        """How long it lasts."""
        return float(len(self) / self.rate)

    def _repr_html_(self) -> str:
        """Return some poses, which a notebook shows."""
        return str(import_module("lanindex.film.notebook").of_motion(self))

    def __repr__(self) -> str:
        return (
            f"<Motion {self.source.path}: {len(self)} frames at {float(self.rate):g} Hz, "
            f"{self.seconds:.2f} s, {len(self.skeleton.names)} joints>"
        )
