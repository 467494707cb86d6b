"""Tables of points as text: of joints, of Kinect, Vicon Nexus, Motive, Qualisys, or any other."""

from lanindex.formats.table.read import cutter, read, subjects, write

__all__ = ["cutter", "read", "subjects", "write"]
