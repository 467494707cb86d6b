"""Let the disk be full, read-only or out of names: a sentence, nothing half, and on it goes.

A verb that writes runs on a small disk that has too little room, mostly, or none; that may only be
read; that takes no more files; or where files may be no longer than so. It ends with 2 and a
sentence, or has done what it does where there is room. What it left is as before, or whole. Then
there is room, and the same command ends well.
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import chdir, contextmanager, suppress
from functools import partial
from pathlib import Path
from random import Random

import common
import kills
from common import called, errors_of
from kills import LIBRARY, Scene, Verb
from page_client import asking

from lanindex.errors import LanindexError
from lanindex.pipeline.library import Library
from lanindex.web import uploads

DISK = 64 << 20
FILM = "in/film.bvh"

Tree = dict[str, bytes]
"""What is in files, by path."""

OWN = ("--db", LIBRARY)
JOBS: dict[str, tuple[str | int | float, ...]] = {
    "export": ("export", "arm any", "-o", "clips", *OWN),
    "export again": ("export", "arm any", "-o", "clips", "--force", *OWN),
    "other clips": ("export", "arm any", "-o", "clips", "--format", "c3d", "--in", "*.bvh", *OWN),
    "data set": ("export", "--dataset", "data", "--fps", 10, *OWN),
    "words": ("export", "arm any", "--dataset", "data", "--layout", "humanml3d", *OWN),
    "sheet": ("search", "arm any", "--preview", "hits.html", *OWN),
    "hit": ("search", "arm any", "--preview", "hits.png", "--limit", 1, *OWN),
    "webp": ("play", FILM, "-o", "film.webp", "--to", 0.2, "--size", "120x120"),
    "gif": ("play", FILM, "-o", "film.gif", "--to", 0.2, "--size", "120x120"),
    "mp4": ("play", FILM, "-o", "film.mp4", "--to", 0.2, "--size", "120x120"),
    "svg": ("score", FILM, "-o", "score.svg"),
    "pdf": ("score", FILM, "-o", "score.pdf"),
    "png": ("score", FILM, "-o", "score.png"),
    "c3d": ("convert", FILM, "film.c3d"),
    "glb": ("convert", FILM, "film.glb"),
    "npz": ("convert", FILM, "film.npz"),
    "eaf": ("convert", FILM, "film.eaf"),
    "csv": ("show", "--all", "-o", "all.csv", *OWN),
    "parquet": ("show", "--all", "-o", "all.parquet", *OWN),
    "plot": ("stats", "--by", "label", "--plot", "plot.svg", *OWN),
    "animate": ("animate", "in/score.lnd", "-o", "score.bvh"),
}
"""Verbs that write files; the library they read lies on the same disk."""


def upload(scene: Scene) -> Verb:
    """Send a capture as a browser does, and have it ingested."""
    scene.fill()
    number = next(it for it in scene.spare if kills.FILES[it][0] == ".bvh")
    after = str(scene.folder / "some-captures" / "sent.bvh")
    new = kills.SHA256[number], kills.DIGESTS["default"], "", ()

    def work(lines: int) -> int:
        with Library.open(LIBRARY) as library, asking(library) as ask:
            answer = ask.put("/api/uploads/sent.bvh", content=kills.FILES[number][1])
            told = answer.json()
            if answer.status_code == 200:
                begun = ask.post("/api/ingests", json={"files": {"sent.bvh": told["name"]}})
                told = begun.json()
                while told.get("state", "running") == "running" and not told.get("error"):
                    told = ask.get(f"/api/ingests/{begun.json()['job']}").json()
        failed = [it["error"] for it in told.get("outcomes", ()) if it["error"]]
        if told.get("error") or failed:
            raise LanindexError(*failed or [told["error"]["found"]])
        return 0

    return Verb(work, [[scene.held], [scene.held | {after: new}]])


VERBS = (
    *[upload] * 2,
    *(kills.first_ingest, kills.later_ingest, kills.move, kills.write_anew, kills.label),
    *(kills.remove, kills.search, kills.join, kills.segments, kills.mend, kills.upgrade),
)


def mounted(*options: str) -> bool:
    command = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", *options]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def remount(folder: Path, option: str) -> None:
    subprocess.run(["mount", "-o", f"remount,{option}", folder], check=True)


def free(folder: Path) -> int:
    held = os.statvfs(folder)
    return held.f_bavail * held.f_frsize


@contextmanager
def without_room(folder: Path, kind: str, room: int) -> Iterator[None]:
    """Leave so many bytes on a disk, or a few files, or let it be read only."""
    if kind == "full":
        with open(folder / "filler", "wb", buffering=0) as file, suppress(OSError):
            while (more := free(folder) - room) > 0:
                file.write(bytes(min(more, 1 << 20)))
    elif kind == "read-only":
        remount(folder, "ro")
    elif kind == "names":
        held = os.statvfs(folder)
        remount(folder, f"nr_inodes={held.f_files - held.f_ffree + room % 3}")
    try:
        yield
    finally:
        if kind == "read-only":
            remount(folder, "rw")
        elif kind == "names":
            remount(folder, "nr_inodes=100000")
        elif kind == "full":
            (folder / "filler").unlink()


def tree() -> Tree:
    """Return all files here but the library's."""
    return {
        str(path): path.read_bytes()
        for path in sorted(Path().rglob("*"))
        if path.is_file() and not path.parts[0].startswith((LIBRARY, "other"))
    }


def trial(choice: Random, folder: Path) -> dict[str, int]:
    """Do something on a disk that is too small."""
    disk = folder / "disk"
    disk.mkdir()
    kinds = ["quota"]
    if mounted("none", str(disk)):
        kinds += ["full", "full", "full", "read-only", "names"]
    common.SAID[0] = folder
    os.chdir(disk)
    try:
        return _on_disk(choice, disk, choice.choice(kinds))
    finally:
        os.chdir(folder)
        if len(kinds) > 1:
            subprocess.run(["umount", "--lazy", disk], check=True)


def _on_disk(choice: Random, disk: Path, kind: str) -> dict[str, int]:
    name, verb = a_verb(choice, disk)
    temporary = str(choice.choice((disk, disk.parent)))

    def work(longest: int = resource.RLIM_INFINITY) -> int:
        tempfile.tempdir = temporary
        resource.setrlimit(resource.RLIMIT_FSIZE, (longest, resource.RLIM_INFINITY))
        with open(os.devnull, "w") as lines:
            return verb.work(lines=lines.fileno())

    before, wrong_before, held = tree(), kills.look()[1], free(disk)
    shutil.copytree(disk, kept := disk.with_name("kept"))
    assert common.forked(work) in verb.ends, (name, errors_of())  # to know what comes of it
    after, taken = tree(), held - free(disk)
    longest = max(map(len, (*after.values(), Path(LIBRARY).read_bytes())))
    for path in disk.iterdir():
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    shutil.copytree(kept, disk, dirs_exist_ok=True)
    shutil.rmtree(kept)

    share = choice.choice((0, choice.random(), 2 * choice.random()))
    with without_room(disk, kind, round(share * taken)):
        limits = (max(round(share * longest), 1 << 13),) if kind == "quota" else ()
        code = common.forked(partial(work, *limits))
    said, left, (state, wrong) = errors_of(), tree(), kills.look()
    about = name, kind, share, code, said, {*left} ^ {*before}
    assert state in verb.states, about
    assert {*wrong} <= {*wrong_before}, about
    if code == 2:
        (line,) = (it for it in said.splitlines() if it.startswith("lanindex: "))
        assert any(word in line for word in SAYS), about
        assert left == before, about
        assert name != "search", about  # which goes without what it could have kept
    else:
        assert code in verb.ends, about
        assert same(left, after), about
        assert state == verb.states[-1], about
    if code == 2 or name not in JOBS:  # which refuse to write over what they have written
        assert common.forked(work) in verb.ends, (name, errors_of())
    assert same(tree(), after), about
    assert kills.look()[0] == verb.states[-1], about
    return {kind: 1, "done": code != 2, "refused": code == 2}


SAYS = ("full", "space", "too large", "ead-only", "written", "opened")


def a_verb(choice: Random, disk: Path) -> tuple[str, Verb]:
    """Return a verb with its name, in a folder that is prepared for it."""
    if choice.random() < 0.5:
        make = choice.choice(VERBS)
        return make.__name__, make(Scene(choice, disk))
    name = choice.choice(list(JOBS))
    shutil.copytree(READY, disk, dirs_exist_ok=True)
    if "--force" in JOBS[name]:
        assert called(*JOBS["export"]) == 0
        for path in Path("clips").iterdir():
            path.write_bytes(b"x")
    return name, Verb(lambda lines: called(*JOBS[name]), [[kills.content(LIBRARY)]])


def same(one: Tree, other: Tree) -> bool:
    """Return whether files are the same, but for those that say when they were made."""
    timed = (".eaf", ".pdf", ".webp", ".mp4", ".parquet", ".svg", ".gif")
    return one.keys() == other.keys() and all(
        content == other[path] or path.endswith(timed) for path, content in one.items()
    )


READY = Path()
"""A folder with a library and what is in it."""


def main() -> int:
    """Prepare a folder, and run the trials on copies of it."""
    global READY
    uploads.SPARE = 0
    options = common.arguments(__doc__.split("\n")[0], 1000).parse_args()
    with tempfile.TemporaryDirectory() as name, tempfile.TemporaryDirectory() as other:
        with chdir(name):
            kills.prepare(Path(name))
        READY = Path(other)
        with chdir(other):
            Path("in").mkdir()
            Path("in/score.lnd").write_bytes(kills.FILES[0][1])
            Path(FILM).write_bytes(kills.FILES[-1][1])
            assert called("ingest", "in", "--db", LIBRARY) == 0
            for words in JOBS.values():  # which imports what they need
                assert called(*words, *["--force"] * ("--force" not in words)) == 0, errors_of()
            for path in Path().iterdir():
                if path.name not in ("in", LIBRARY):
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
        return common.run(trial, options)


if __name__ == "__main__":
    sys.exit(main())
