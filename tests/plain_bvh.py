"""A BVH reader as plain as can be, to check files that were written."""

import numpy as np
from scipy.spatial.transform import Rotation


def positions(text: str) -> tuple[list[str], np.ndarray, float]:
    """Return names, (T, J, 3) positions in units of the file, and the frame time."""
    hierarchy, motion = text.split("MOTION\n")
    names: list[str] = []
    parents: list[int] = []
    offsets: list[list[float]] = []
    channels: list[list[str]] = []
    stack: list[int] = []
    for words in map(str.split, hierarchy.splitlines()):
        match words:
            case ["ROOT" | "JOINT", name]:
                names.append(name)
            case ["End", "Site"]:
                names.append(names[stack[-1]] + " End")
            case ["{"]:
                parents.append(stack[-1] if stack else -1)
                stack.append(len(names) - 1)
                channels.append([])
            case ["}"]:
                stack.pop()
            case ["OFFSET", *numbers]:
                offsets.append([float(number) for number in numbers])
            case ["CHANNELS", _, *kinds]:
                channels[-1] = kinds
    count, time, *lines = motion.splitlines()
    frames = [[float(word) for word in line.split()] for line in lines]
    assert len(frames) == int(count.removeprefix("Frames: "))
    points = np.zeros((len(frames), len(names), 3))
    for frame, numbers in enumerate(frames):
        turns: list[Rotation] = []
        values = iter(numbers)
        for joint, parent in enumerate(parents):
            place = list(offsets[joint])
            turn = Rotation.identity()
            for kind in channels[joint]:
                axis, value = kind[0].lower(), next(values)
                if kind.endswith("position"):
                    place["xyz".index(axis)] = value
                else:
                    turn = turn * Rotation.from_euler(axis, value, degrees=True)
            above = turns[parent] if parent >= 0 else Rotation.identity()
            turns.append(above * turn)
            start = points[frame, parent] if parent >= 0 else 0
            points[frame, joint] = start + above.apply(place)
        assert not list(values)
    return names, points, float(time.removeprefix("Frame Time: "))
