"""NumPy arrays, alone (``.npy``) or several (``.npz``): joints, or how the joints of SMPL turn."""

from lanindex.formats.npy.cut import cutter
from lanindex.formats.npy.read import read
from lanindex.formats.npy.write import write

__all__ = ["cutter", "read", "write"]
