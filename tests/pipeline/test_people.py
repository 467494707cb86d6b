"""Several people in a file are read once and kept apart."""

import importlib.util
import shutil
import zipfile
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_c3d import STANDING, c3d, standing
from made_fbx import fbx
from made_fbx import waving as waving_fbx
from made_gltf import Made, body, waving
from made_mvnx import mvnx, subject

from lanindex import formats
from lanindex.encoding.profile import load
from lanindex.formats import c3d as c3d_format
from lanindex.formats import fbx as fbx_format
from lanindex.library.selection import Selection
from lanindex.model import Reading
from lanindex.pipeline.convert import score_of
from lanindex.pipeline.ingest import discover, ingest
from lanindex.pipeline.library import Library, open_library
from lanindex.pipeline.prepare import Outcome, Task, prepare

PROFILE = load("default")


def people(*names: str, frames: int = 60, more: Mapping[str, object] | None = None) -> bytes:
    """Return a C3D file of some who walk side by side and raise the right arm."""
    one, ways = standing(frames), np.linspace(0, np.pi, frames)
    for number, name in enumerate(STANDING):
        if name in ("RELB", "RWRA", "RWRB", "RFIN"):
            down = 1420 - one[:, number, 2]
            one[:, number, 1] -= down * np.sin(ways)
            one[:, number, 2] = 1420 - down * np.cos(ways)
    points = np.concatenate([np.add(one, (0, 900 * at, 0, 0)) for at in range(len(names))], 1)
    return c3d(points, [f"{name}:{marker}" for name in names for marker in STANDING], more=more)


@pytest.fixture
def library(tmp_path: Path):
    with open_library(tmp_path / "l.db", create=True) as opened:
        yield opened


@pytest.fixture
def trial(tmp_path: Path) -> Path:
    path = tmp_path / "in" / "trial.c3d"
    path.parent.mkdir()
    path.write_bytes(people("Ada", "Bob"))
    return path


@pytest.fixture
def done(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Count how often a file is opened, its people are told apart, its numbers are found."""
    counts: Counter[str] = Counter()
    for name, *modules in (("opened", formats), ("subjects", c3d_format), ("scan", c3d_format)):
        known = getattr(modules[0], name)

        def counted(what: Any, known: Any = known, name: str = name) -> Any:
            counts[name] += 1
            return known(what)

        for module in modules:
            monkeypatch.setattr(module, name, counted)
    return counts


def told(outcomes: list[Outcome]) -> dict[str, str]:
    return {Path(one.path).name: one.status for one in outcomes}


def test_a_file_is_opened_once_whoever_is_in_it(library: Library, trial: Path, done) -> None:
    assert told(library.ingest(trial)) == {"trial.c3d#Ada": "added", "trial.c3d#Bob": "added"}
    assert done == {"opened": 1, "subjects": 1, "scan": 1}
    done.clear()
    again = {"trial.c3d#Ada": "unchanged", "trial.c3d#Bob": "unchanged"}
    assert told(library.ingest(trial)) == again
    assert done == {"opened": 1}


def test_who_was_never_read_is_told_each_time(library: Library, trial: Path, monkeypatch) -> None:
    read = formats.read_file

    def refusing(file: formats.File, *more: Any) -> Any:
        return read(formats.File(file.name, b"") if file.subject == "Bob" else file, *more)

    with monkeypatch.context() as patch:
        patch.setattr(formats, "read_file", refusing)
        for status in ("added", "unchanged"):
            outcomes = told(library.ingest(trial))
            assert outcomes == {"trial.c3d#Ada": status, "trial.c3d#Bob": "failed"}
    assert told(library.ingest(trial)) == {"trial.c3d#Ada": "unchanged", "trial.c3d#Bob": "added"}


@pytest.mark.parametrize("jobs", [1, 2])
def test_who_was_removed_comes_back(library: Library, trial: Path, jobs: int) -> None:
    library.ingest(trial.parent, jobs=jobs)
    library.remove("trial.c3d#Ada")
    outcomes = library.ingest(trial.parent, jobs=jobs)
    assert told(outcomes) == {"trial.c3d#Ada": "added", "trial.c3d#Bob": "unchanged"}
    outcomes = library.ingest(trial.parent, jobs=jobs, force=True)
    assert told(outcomes) == {"trial.c3d#Ada": "added", "trial.c3d#Bob": "added"}


def test_another_content_has_others(library: Library, trial: Path) -> None:
    library.ingest(trial)
    trial.write_bytes(people("Ada", "Cid", "Dan"))
    names = {f"trial.c3d#{name}" for name in ("Ada", "Cid", "Dan")}
    assert told(library.ingest(trial)) == dict.fromkeys(names, "added")
    assert told(library.ingest(trial)) == dict.fromkeys(names, "unchanged")
    trial.write_bytes(people("Ada"))
    for status in ("added", "unchanged"):
        assert told(library.ingest(trial)) == {"trial.c3d": status}


def test_one_of_them_by_name(library: Library, trial: Path) -> None:
    named = f"{trial}#Bob"
    assert told(library.ingest(named)) == {"trial.c3d#Bob": "added"}
    assert told(library.ingest(named)) == {"trial.c3d#Bob": "unchanged"}
    library.ingest(trial)  # how many there are was not known
    assert set(told(library.ingest(trial, named)).values()) == {"unchanged"}
    alone = score_of(trial, Reading(), "default")
    assert alone.warnings[0] == "Ada is read; it holds also Bob"
    assert [one.path[-3:] for one in prepare(Task(str(trial), PROFILE))] == ["Ada", "Bob"]


def test_files_with_people_move(library: Library, trial: Path) -> None:
    before = {one.path: one.location for one in library.ingest(trial) and library.captures()}
    shutil.move(trial, trial.with_name("other.c3d"))
    looked = list(ingest(library.store, discover([trial.parent]), PROFILE, dry_run=True))
    outcomes = library.ingest(trial.parent)
    assert told(looked) == told(outcomes) == dict.fromkeys(
        ("other.c3d#Ada", "other.c3d#Bob"), "unchanged"
    )  # fmt: skip
    assert [one.moved for one in outcomes] == list(before.values())
    assert [one.path[-3:] for one in library.captures()] == ["Ada", "Bob"]
    shutil.move(trial.with_name("other.c3d"), trial)
    (one,) = library.ingest(f"{trial}#Bob")
    assert (one.status, one.moved[-13:]) == ("unchanged", "other.c3d#Bob")


def test_people_in_an_archive(library: Library, trial: Path) -> None:
    archive = trial.with_name("a.zip")
    with zipfile.ZipFile(archive, "w") as packed:
        packed.write(trial, "in/trial.c3d")
    for status in ("added", "unchanged"):
        outcomes = library.ingest(archive)
        assert [one.status for one in outcomes] == [status] * 2
        assert outcomes[0].path == f"{archive}!/in/trial.c3d#Ada"
    assert len(library.export(library.search("r_arm place high")[:1], trial.parent / "out")) > 0


def test_a_library_that_does_not_know_how_many_there_are(library: Library, trial: Path) -> None:
    library.ingest(*discover([trial]))
    assert set(told(library.ingest(trial)).values()) == {"added"}
    assert set(told(library.ingest(trial)).values()) == {"unchanged"}


ODD = {
    "a/b": "a_b", "a#b": "a_b 2", "..": "..", "../x!/y": ".._x!_y", " Ada\n ": "Ada",
    "[a]*": "[a]*",
    "Zoe\u0308": "Zoë", "é" * 120: "é" * 100, "-rf //": "-rf __", "a\\b": "a_b 10", "大": "大",
}  # fmt: skip
"""What people are called, and by what name they go."""


def odd_c3d() -> tuple[bytes, list[str]]:
    told = dict(list(ODD.items())[:9])
    before = [f"{number}:" for number in range(len(told))]
    more = {"SUBJECTS:NAMES": list(told), "SUBJECTS:LABEL_PREFIXES": before}
    return people(*(it[:-1] for it in before), more=more), list(told.values())


def odd_glb() -> tuple[bytes, list[str]]:
    made = Made()
    nodes = [body(made, skin=name) for name in ODD]
    waving(made, nodes[0], 40)
    (take,) = made.json["animations"]
    for one in nodes[1:]:
        for channel in list(take["channels"])[:2]:
            name = next(it for it, at in nodes[0].items() if at == channel["target"]["node"])
            target = {**channel["target"], "node": one[name]}
            take["channels"].append({**channel, "target": target})
    return made.glb(), list(ODD.values())


@pytest.mark.parametrize("suffix", ["c3d", "glb"])
def test_odd_names(library: Library, tmp_path: Path, suffix: str) -> None:
    content, names = odd_c3d() if suffix == "c3d" else odd_glb()
    path = tmp_path / "in" / f"odd#1.{suffix}"
    path.parent.mkdir()
    path.write_bytes(content)
    places = [f"{path}#{name}" for name in names]
    for status in ("added", "unchanged"):
        outcomes = library.ingest(path.parent)
        assert [(one.path, one.status) for one in outcomes] == [(it, status) for it in places]
    assert list(discover([path])) == [one.location for one in library.captures()] == places
    assert library.store.missing() == []
    hits = library.search("r_arm place high")
    assert [hit.path for hit in hits] == places
    assert [hit.path for hit in library.search("r_arm place high", Selection("*#.."))] == places[
        2:3
    ]
    library.export(hits, tmp_path / "out")
    clips = list((tmp_path / "out").glob(f"*.{suffix}"))
    assert sorted(len(formats.read(clip)) for clip in clips) == sorted(
        hit.span.stop - hit.span.start for hit in hits
    )
    for place in places:
        assert library.capture(place).path == place
    path.unlink()
    assert [one.path for one in library.store.missing()] == places


@pytest.mark.skipif(importlib.util.find_spec("ufbx") is None, reason="ufbx is not installed")
def test_one_child_process_for_a_file(library: Library, trial: Path, monkeypatch) -> None:
    keys = {**waving_fbx("A:"), **waving_fbx("B:")}
    (trial.parent / "two.fbx").write_bytes(fbx({"wave": keys}, people=("A:", "B:")))
    counts: Counter[str] = Counter()
    run = fbx_format.subprocess.run
    monkeypatch.setattr(
        fbx_format.subprocess,
        "run",
        lambda *what, **how: counts.update(["run"]) or run(*what, **how),
    )
    for status in ("added", "unchanged"):
        outcomes = library.ingest(trial.parent / "two.fbx")
        assert told(outcomes) == {"two.fbx#A": status, "two.fbx#B": status}
        assert counts == {"run": 1}


def test_of_an_mvnx_file(library: Library, trial: Path) -> None:
    (trial.parent / "two.mvnx").write_bytes(mvnx(subject(), subject(label="Ben")))
    for status in ("added", "unchanged"):
        outcomes = library.ingest(trial.parent / "two.mvnx")
        assert told(outcomes) == {"two.mvnx#Ada": status, "two.mvnx#Ben": status}
