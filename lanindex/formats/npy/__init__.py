"""NumPy arrays, alone (``.npy``) or several (``.npz``): joints, or how the joints of SMPL turn."""

from lanindex.formats.npy.read import cutter, read, write

__all__ = ["cutter", "read", "write"]
