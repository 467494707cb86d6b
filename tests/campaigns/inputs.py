"""Damage files of all formats: each is read, or refused with a sentence, soon and in little room.

A trial is a hundred damaged files. A traceback, a reader that takes more than 20 s or more than a
gigabyte for one file, and a process that dies are failures. The file is then kept in the working
directory.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
from collections import Counter
from fractions import Fraction
from hashlib import sha256
from pathlib import Path
from random import Random

import common
from made_amc import made as made_amc
from made_fbx import binary, fbx
from made_fbx import waving as waving_of_fbx
from made_gltf import Made, body, waving
from made_mvnx import mvnx
from made_mvnx import subject as subject_of_mvnx
from mutations import mutated

from lanindex import formats, notation
from lanindex.errors import LanindexError
from lanindex.formats import bvh
from lanindex.model import Span
from lanindex.notation import lnd
from lanindex.perform import perform
from lanindex.pipeline import convert
from lanindex.pipeline.ingest import read_labels

FILES = 100
LONGEST = 20  # seconds of the processor
LARGEST = 1 << 30  # bytes
SMALL = 60_000  # bytes of a real capture that is tried
LABELS = b'file,label,who\na.bvh,walk,Ada\n"b, c.bvh",bow,\n'
KEPT = Path.cwd()

SOURCES: dict[str, list[bytes]] = {}
"""Whole files, by the name under which they are read."""

ASF, AMC = made_amc()


def prepare() -> None:
    """Write a short movement in all formats, and add small real captures."""
    for text in common.texts(3):
        score = lnd.read(text.encode())
        motion = formats.read("x.bvh", data=bvh.write(perform(score, rate=Fraction(10))))
        motion = convert.stretch(motion, Span(0, 12))
        for form in ("bvh", "c3d", "trc", "csv", "npz", "glb"):
            add(f"x.{form}", convert.file_content(motion, form)[0])
        for form in notation.WRITTEN:
            add(f"x.{form}", notation.write(score, form))
    scene = Made()
    waving(scene, body(scene))
    add("x.gltf", scene.gltf())
    add("x.mvnx", mvnx(subject_of_mvnx(4)))
    add("x.amc", AMC)
    for people, form in (("",), {}), (("Ada:", "Ida:"), {"unit": 2.54}), (("",), {"bone": "Null"}):
        text = fbx({"wave": waving_of_fbx(people[0])}, people, **form)
        for content in (text, binary(text)):
            add("x.fbx", content)
    add("labels.csv", LABELS)
    folder = os.environ.get("LANINDEX_CAPTURES")
    for path in sorted(Path(folder).rglob("*.*")) if folder else ():
        name = f"x{path.suffix.lower()}"
        if name in SOURCES and path.stat().st_size <= SMALL:
            add(name, path.read_bytes())


def add(name: str, content: bytes) -> None:
    SOURCES.setdefault(name, []).append(content)


def read(name: str, data: bytes) -> str:
    """Read a file, and return what came of it."""
    try:
        if name == "labels.csv":
            Path(name).write_bytes(data)
            read_labels(name)
        elif notation.notation_of(name):
            notation.read(name, data)
        else:
            found = formats.read(name, data=data)
            if cut := formats.cutter(formats.File(name, data)):
                cut(Span(0, len(found)))
    except LanindexError as error:
        said = str(error)
    else:
        return "read"
    assert said.startswith(("x.", "labels.csv")), said
    return "refused"


def too_long(*_: object) -> None:
    raise TimeoutError(f"more than {LONGEST} s")


def trial(choice: Random, folder: Path) -> dict[str, int]:
    """Read a hundred damaged files."""
    became = Counter[str]()
    signal.alarm(0)  # a trial is as long as its files take
    signal.signal(signal.SIGPROF, too_long)
    for _ in range(FILES):
        name = choice.choice(list(SOURCES))
        source = choice.choice(SOURCES[name])
        words = choice.choice(SOURCES[name])[:2000].split()[:50]
        data = mutated(source, choice, words)
        asf = mutated(ASF, choice) if name == "x.amc" and choice.random() < 0.4 else ASF
        Path("x.asf").write_bytes(asf)
        before, begun = most_memory(), spent()
        signal.setitimer(signal.ITIMER_PROF, LONGEST)
        try:
            became[read(name, data)] += 1
            assert most_memory() < max(before, LARGEST), f"{most_memory() >> 20} MB"
            assert spent() - begun < LONGEST, f"{spent() - begun:.0f} s"
        except BaseException as error:
            kept = KEPT / f"{sha256(data).hexdigest()[:12]}-{name}"
            kept.write_bytes(data)
            raise AssertionError(f"{kept}: {error!r}") from error
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        became["slow"] += spent() - begun > 2
    return became


OURS = resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN
"""This process, and those that have read a file of FBX for it."""


def most_memory() -> int:
    """Return the most memory that a process has held, in bytes."""
    return max(resource.getrusage(one).ru_maxrss for one in OURS) << 10


def spent() -> float:
    """Return the seconds that all have had a processor."""
    return sum(it.ru_utime + it.ru_stime for it in map(resource.getrusage, OURS))


def main() -> int:
    options = common.arguments(__doc__.split("\n")[0], 10_000).parse_args()
    prepare()
    return common.run(trial, options)


if __name__ == "__main__":
    sys.exit(main())
