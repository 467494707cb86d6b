"""BVH (BioVision Hierarchy): read, cut byte for byte, write."""

from lanindex.formats.bvh.layout import cutter
from lanindex.formats.bvh.read import read
from lanindex.formats.bvh.write import write

__all__ = ["cutter", "read", "write"]
