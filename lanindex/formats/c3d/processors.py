"""How three kinds of processors write numbers: Intel, DEC and MIPS.

Source: *The C3D File Format, User Guide*, Motion Lab Systems (c3d.org), "Processor types"; *VAX
Architecture Reference Manual* (1987), F_floating.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Processor:
    """How one kind of processor writes numbers."""

    name: str  # as people call it
    order: str  # ``<``, the low byte first, or ``>``
    # whether its floats are those of the VAX: halves exchanged, exponents greater by two
    dec: bool = False

    def ints(self, data: Any, count: int = -1, offset: int = 0) -> NDArray[np.int16]:
        """Return integers of 16 bits, a view."""
        return np.frombuffer(data, self.order + "i2", count, offset)

    def floats(self, data: Any, count: int = -1, offset: int = 0) -> NDArray[np.float32]:
        """Return floats of 32 bits, a view unless they are DEC's."""
        if not self.dec:
            return np.frombuffer(data, self.order + "f4", count, offset)
        return from_dec(np.frombuffer(data, "<u4", count, offset))

    def written(self, values: Any, kind: int) -> bytes:
        """Return numbers as bytes, of a parameter's kind: 1 and 2, integers; 4, floats."""
        if kind == 4 and self.dec:
            return to_dec(np.asarray(values, np.float32)).tobytes()
        code = {1: "u1", 2: "i2", 4: "f4"}[kind]
        array = np.asarray(values)
        if kind == 2:
            array = array.astype(np.int64).astype(np.uint16).view(np.int16)
        return array.astype(self.order + code).tobytes()


PROCESSORS: Mapping[int, Processor] = {
    84: Processor("Intel", "<"),
    85: Processor("DEC", "<", dec=True),
    86: Processor("MIPS", ">"),
}
"""By the fourth byte of the parameters."""


def from_dec(words: NDArray[np.uint32]) -> NDArray[np.float32]:
    """Return VAX F floats, the halves of each exchanged, as numbers.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.formats.c3d.processors import from_dec
    >>> from_dec(np.array([0x00004348], np.uint32))  # POINT:RATE of a file of 50 Hz
    array([50.], dtype=float32)
    """
    values = ((words >> np.uint32(16)) | (words << np.uint32(16))).view(np.float32)
    with np.errstate(invalid="ignore"):  # of damaged files
        values *= np.float32(0.25)
    return values


def to_dec(values: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Return numbers as VAX F floats."""
    words = (np.ascontiguousarray(values, np.float32) * np.float32(4)).view(np.uint32)
    exchanged: NDArray[np.uint32] = (words >> np.uint32(16)) | (words << np.uint32(16))
    return exchanged.astype("<u4")
