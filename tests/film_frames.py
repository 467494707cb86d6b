"""Decodes films with PyAV and Pillow."""

from dataclasses import dataclass
from io import BytesIO

import av
import numpy as np
from PIL import Image


@dataclass
class Seen:
    """What a player finds in a film."""

    frames: list[np.ndarray]
    seconds: float
    size: tuple[int, int]


def seen(content: bytes, form: str) -> Seen:
    """Play a film: its frames as (H, W, 3) RGB."""
    if form == "mp4":
        with av.open(BytesIO(content)) as container:
            frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
            stream = container.streams.video[0]
            lasts = float(stream.duration * stream.time_base)
            return Seen(frames, lasts, (stream.width, stream.height))
    frames, lasts = [], 0.0
    with Image.open(BytesIO(content)) as film:
        assert film.format.lower() == form
        assert film.info.get("loop") == 0
        for number in range(film.n_frames):
            film.seek(number)
            frames.append(np.asarray(film.convert("RGB")))
            lasts += film.info["duration"] / 1000
        return Seen(frames, lasts, film.size)
