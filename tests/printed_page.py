"""A small page of Labanotation for tests: two bars, one sign of which nobody knows."""

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from lanindex.draw import draw, svg
from lanindex.notation import lnd
from lanindex.reader.score import read_signs

LND = b"""\
#speed=60
#rhythm 4/4
#unit_per_line 4
#unit_total 2
#unit0
direction r_arm place low 0 0
direction l_arm place low 0 0
#unit1
direction r_arm right mid 0 2
direction r_arm forward high 2 4
direction l_arm left high 0 4
#unit2
direction l_arm forward mid 0 2
"""


@cache
def clean() -> NDArray[np.uint8]:
    """Return the page as it was drawn, (H, W) grey."""
    picture = draw(lnd.read(LND, place="own"), bars=2)
    drawn = svg.image(svg.write(picture, scale=2, ink=svg.INK))
    found = cv2.imdecode(np.frombuffer(drawn, np.uint8), cv2.IMREAD_GRAYSCALE)
    return np.asarray(found)


@cache
def scribbled() -> NDArray[np.uint8]:
    """Return the page with a scribble where the left arm goes forward, at the count of 4."""
    page = clean().copy()
    (sign,) = (it for it in read_signs(page).records if (it.part, it.start) == ("l_arm", 4))
    left, top, right, bottom = sign.box
    page[top + 2 : bottom - 2, left:right] = 255
    rows = range(top + 8, bottom - 8, 12)
    corners = [(right - 5 if at % 2 else left + 5, y) for at, y in enumerate(rows)]
    cv2.polylines(page, [np.array(corners)], False, 0, 3, cv2.LINE_AA)
    return page
