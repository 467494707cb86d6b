"""C3D (Coordinate 3D): read, cut in its own numbers, write."""

from lanindex.formats.c3d.cut import cutter
from lanindex.formats.c3d.read import read, subjects
from lanindex.formats.c3d.write import write

__all__ = ["cutter", "read", "subjects", "write"]
