"""The joints of any file → the body of 20 joints: names, shape, unit, up axis, calibration.

`understand` is the one function that a format calls; names and exporters are data in `names.toml`.
"""

from lanindex.body.understand import Stated, Understanding, body_of, sampled, understand

__all__ = ["Stated", "Understanding", "body_of", "sampled", "understand"]
