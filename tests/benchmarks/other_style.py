"""Read scores that another program draws: ``other_style.py [PAGES]``.

The drawings are those of LabanotationSuite, by the package `labanotation`. The staff gets a line at
its top, and what is below it is cut off: names that are not ours, and the starting position.
"""

import sys

import cv2
import numpy as np
from numpy.typing import NDArray

from lanindex.reader.score import read_signs

PARTS = {
    **{"right elbow": "r_upper_arm", "right wrist": "r_forearm"},
    **{"left elbow": "l_upper_arm", "left wrist": "l_forearm", "head": "head"},
}
WAYS = {
    **{"place": "place", "right": "right", "left": "left", "forward": "forward"},
    **{"backward": "back", "right forward": "r_forward", "left forward": "l_forward"},
    **{"right backward": "r_back", "left backward": "l_back"},
}
LEVELS = {"low": "low", "middle": "mid", "high": "high"}
WIDTH, HEIGHT, EDGE = 480, 1400, 40  # pixels
KEYS = 12  # times at which directions are told

Signs = set[tuple[str, str | None, str | None, float, float]]


def drawn(seed: int) -> tuple[NDArray[np.uint8], Signs]:
    """Return a random score as that program draws it, (H, W) grey, and its signs."""
    from labanotation.visualization.laban_to_image import ConvertLabanScriptToView

    rng, now = np.random.default_rng(seed), 1
    where = dict.fromkeys(PARTS, ("place", "low"))
    lines, signs, before = list[str](), Signs(), 0.0
    for key in range(KEYS):
        lines.append(f"Start Time:{now}")
        for name, part in PARTS.items():
            if key and rng.random() < 0.6:
                new = str(rng.choice(list(WAYS))), str(rng.choice(list(LEVELS)))
                if new != where[name]:  # else nothing is drawn
                    where[name] = new
                    signs.add((part, WAYS[new[0]], LEVELS[new[1]], before, float(now // 1000)))
            lines.append(":".join((name, *where[name])))
        before = float(now // 1000)
        now += 1000 * int(rng.choice([1, 1, 2]))
    view = ConvertLabanScriptToView(WIDTH, HEIGHT, "\n".join(lines))
    image = cv2.cvtColor(view.img, cv2.COLOR_BGR2GRAY)
    image[HEIGHT + 5 :] = 255
    image = np.pad(image, EDGE, constant_values=255)
    left, right = (EDGE + WIDTH // 11 * column for column in (3, 7))
    cv2.line(image, (left, EDGE), (right, EDGE), 0, 2)
    return np.asarray(image, np.uint8), signs


def main(pages: str = "40") -> None:
    signs = right = false = unknown = 0
    for seed in range(int(pages)):
        image, there = drawn(seed)
        page = read_signs(image)
        found = {(it.part, it.direction, it.level, it.start, it.end) for it in page.records}
        signs += len(there)
        right += len(there & found)
        false += len(found - there)
        unknown += len(page.unknown)
    print(f"{signs} signs: {right / signs:.3f} right, {false / signs:.3f} false", end="; ")
    print(f"{unknown} pieces of ink are not known")


if __name__ == "__main__":
    main(*sys.argv[1:])
