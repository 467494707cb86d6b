"""MVNX, what the inertial suits of Xsens write: read, cut byte for byte."""

from lanindex.formats.mvnx.cut import cutter, subjects
from lanindex.formats.mvnx.read import read

__all__ = ["cutter", "read", "subjects"]
