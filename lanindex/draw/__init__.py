"""A score as a picture: a staff of Labanotation, time upwards.

Nothing here knows a file or a table: `draw` makes a `Picture` of a `Score`, `lanindex.draw.svg`
writes it, `lanindex.draw.svg` makes an image of that.
"""

from __future__ import annotations

from lanindex.draw.picture import Picture as Picture
from lanindex.draw.score import draw as draw

__all__ = ["Picture", "draw"]
