"""Speed of reading beside other readers, file by file: ``python tests/benchmarks/reading.py``.

Of each format: what takes a file to the places of its points or joints, ours and others', and, for
comparison, what takes it to a motion with a body. Runs take turns; printed are megabytes a second
of processor time, the medians, and how many times as fast ours is, the median of the rounds. A
reader that is not installed, or refuses a file, has no figure. The captures are those of
LANINDEX_CAPTURES.
"""

import io
import statistics
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from places import CAPTURES

from lanindex import formats
from lanindex.formats import amc, text_rows, trc
from lanindex.formats.c3d import names_of, places, scan
from lanindex.formats.file import holding
from lanindex.formats.gltf import chosen
from lanindex.formats.mvnx import walk
from lanindex.formats.point_tables import layout_of
from lanindex.model import Reading

ROUNDS = 7

Reader = Callable[[Path], Any]


def c3d_points(path: Path) -> None:
    file = formats.opened(path)
    layout = scan(file)
    names_of(layout)
    places(file.content, layout)


def c3d_by_ezc3d(path: Path) -> None:
    import ezc3d

    ezc3d.c3d(str(path))


def c3d_by_c3d(path: Path) -> None:
    import c3d

    with path.open("rb") as file:
        for _ in c3d.Reader(file).read_frames():
            pass


def amc_numbers(path: Path) -> None:
    file = formats.opened(path)
    skeleton, _ = amc.skeleton_of(file, Reading())
    floats = amc.Numbers(amc.parse(skeleton).bones)
    layout = amc.scan(file.content, file.name)
    for start in range(0, len(layout.starts), 1024):
        stops, ends = layout.stops[start : start + 1024], layout.ends[start : start + 1024]
        data, first = holding(file.content, int(stops[0]), int(ends[-1]))
        floats.read(data, stops - first, ends - first, str)


def amc_by_a_loop(path: Path) -> None:
    """Read the numbers of each bone line by line, as a plain loop does."""
    frames: list[dict[str, list[float]]] = []
    for line in path.read_text().splitlines():
        words = line.split()
        if not words or line[0] in "#:":
            continue
        if len(words) == 1:
            frames.append({})
        else:
            frames[-1][words[0]] = [float(word) for word in words[1:]]


def mvnx_numbers(path: Path) -> None:
    walk(formats.opened(path), True)


def mvnx_by_etree(path: Path) -> None:
    for frame in ElementTree.parse(path).iter("{http://www.xsens.com/mvn/mvnx}frame"):
        for name in ("position", "orientation"):
            list(map(float, frame.findtext(f"{{*}}{name}", "").split()))


def trc_numbers(path: Path) -> None:
    file = formats.opened(path)
    text_rows.read(file, trc.scan(file).table)


def table_numbers(path: Path) -> None:
    file = formats.opened(path)
    text_rows.read(file, layout_of(file).table)


def by_loadtxt(path: Path) -> None:
    """Read the rows alone, which have no blanks, behind a header of as many lines as it has."""
    file = formats.opened(path)
    rows = (trc.scan if path.suffix == ".trc" else layout_of)(file).table.lines
    text = file.content[int(rows[0, 0]) :]
    separator = max(b"\t,", key=text[:1000].count)
    np.loadtxt(io.BytesIO(text.replace(b",\n", b"\n")), delimiter=chr(separator))


def gltf_places(path: Path) -> None:
    found, _ = chosen(formats.opened(path), None)
    found.placed(np.arange(found.clock.count))


def gltf_by_pygltflib(path: Path) -> None:
    """Read the numbers of the animations, which is as far as it goes."""
    import pygltflib

    held = pygltflib.GLTF2().load(str(path))
    for number in {
        it for one in held.animations for s in one.samplers for it in (s.input, s.output)
    }:
        accessor = held.accessors[number]
        view = held.bufferViews[accessor.bufferView]
        buffer = held.buffers[view.buffer]
        data = held.get_data_from_buffer_uri(buffer.uri) if buffer.uri else held.binary_blob()
        first = (view.byteOffset or 0) + (accessor.byteOffset or 0)
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor.type]
        np.frombuffer(data, "<f4", accessor.count * width, first)


# format: files, ours to places or numbers, the others'
TABLE: dict[str, tuple[str, Reader, dict[str, Reader]]] = {
    "amc": ("amc/cmu/*.amc", amc_numbers, {"loop": amc_by_a_loop}),
    "trc": ("trc/*.trc", trc_numbers, {"loadtxt": by_loadtxt}),
    "csv": ("csv/**/*.csv", table_numbers, {"loadtxt": by_loadtxt}),
    "mvnx": ("mvnx/*.mvnx", mvnx_numbers, {"etree": mvnx_by_etree}),
    "gltf": ("gltf/*", gltf_places, {"pygltflib": gltf_by_pygltflib}),
    "c3d": ("c3d/*.c3d", c3d_points, {"ezc3d": c3d_by_ezc3d, "c3d": c3d_by_c3d}),
}


def taken(reader: Reader, path: Path) -> float | None:
    """Return seconds; None where a reader refuses a file."""
    start = time.process_time()
    try:
        reader(path)
    except Exception:
        return None
    return time.process_time() - start


def line(path: Path, ours: Reader, others: dict[str, Reader]) -> str:
    readers = {"points": ours, "motion": formats.read, **others}
    rounds = [{who: taken(it, path) for who, it in readers.items()} for _ in range(ROUNDS + 1)][1:]
    size = path.stat().st_size / 1e6
    text = f"{path.name[:30]:30} {size:5.1f}"
    for who in readers:
        times = [it[who] for it in rounds]
        if None in times:
            text += f"{'-':>9}" + " " * 7 * (who in others)
            continue
        text += f"{size / statistics.median(times):9.1f}"
        if who in others:
            text += f" {statistics.median(it[who] / it['points'] for it in rounds):5.1f}x"
    return text


def main() -> None:
    warnings.simplefilter("ignore")
    for form, (files, ours, others) in TABLE.items():
        heads = "".join(f"{who:>9} {'ours':>6}" for who in others)
        print(f"{form + ', MB/s':30}    MB   points   motion{heads}")
        for path in sorted(CAPTURES.glob(files)):
            print(line(path, ours, others))


if __name__ == "__main__":
    main()
