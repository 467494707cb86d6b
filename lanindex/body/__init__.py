"""The joints of any file → the body of 20 joints: names, shape, unit, up axis, calibration.

`map_body` is the one function that a format calls; names and exporters are data in `names.toml`.
"""

from lanindex.body.mapping import BodyMapping, Declared, body_of, map_body, sampled

__all__ = ["BodyMapping", "Declared", "body_of", "map_body", "sampled"]
