"""Clips hold the lines of their frames, byte for byte."""

import pytest
from bvh_bodies import hierarchy

from lanindex import formats
from lanindex.formats import file as files
from lanindex.model import Span


def head(frames: int) -> str:
    return f"{hierarchy({'Pelvis': 'Hips'})}MOTION\nFrames: {frames}\nFrame Time: 0.1\n"


def lines(count: int, end: str = "\n") -> list[str]:
    return [f"0 {number} 0 0 0 0{end}" for number in range(count)]


@pytest.mark.parametrize("piece", [1, 30, 1 << 20])
@pytest.mark.parametrize("between", ["", "\n", "   \n\n"])
@pytest.mark.parametrize("span", [(0, 9), (0, 1), (8, 9), (2, 7)])
def test_a_clip_is_its_lines(tmp_path, monkeypatch, piece, between, span):
    monkeypatch.setattr(files, "PIECE", piece)
    monkeypatch.setattr(files, "WHOLE", 0)
    frames = lines(9)
    data = (head(9) + between + between.join(frames) + between).encode()
    (tmp_path / "x.bvh").write_bytes(data)
    wanted = head(span[1] - span[0]) + "".join(frames[slice(*span)])
    for file in (formats.File("x.bvh", data), formats.opened(tmp_path / "x.bvh")):
        assert formats.cutter(file)(Span(*span)).decode() == wanted


def test_a_last_line_without_an_end_stays_so():
    data = (head(3) + "".join(lines(3, "\r\n"))).encode().removesuffix(b"\r\n")
    clip = formats.cutter(formats.File("x.bvh", data))(Span(1, 3))
    assert clip == (head(2) + "".join(lines(3, "\r\n")[1:])).encode().removesuffix(b"\r\n")
