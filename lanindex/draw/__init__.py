"""A score as a picture: a staff of Labanotation, time upwards.

`draw` turns a `Score` into a `Picture`; `lanindex.draw.svg` writes it as SVG, PNG or PDF, and
`lanindex.draw.text` shows a score in a terminal. Nothing here knows a format or a library.
"""

from lanindex.draw.picture import Picture as Picture
from lanindex.draw.staff import draw as draw
