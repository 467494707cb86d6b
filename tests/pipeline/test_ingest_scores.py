"""Scores in other notations are ingested as LND is."""

from pathlib import Path

import pytest

import lanindex
from lanindex.errors import ExportError
from lanindex.notation import NOTATIONS, WRITTEN, write
from lanindex.pipeline.ingest import discover
from lanindex.pipeline.library import open_library

WHOLE = [name for name in WRITTEN if not NOTATIONS[name].parts]
"""Notations that have room for all parts."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with one score in every notation that is written."""
    score = lanindex.read_lnd("corpus/jumping_jacks.lnd")
    for name in WHOLE:
        (tmp_path / f"{name}{NOTATIONS[name].suffix}").write_bytes(write(score, name))
    return tmp_path


def test_all_are_found_alike(folder: Path, tmp_path: Path) -> None:
    paths = [str(folder / f"{name}{NOTATIONS[name].suffix}") for name in WHOLE]
    (folder / "bad.eaf").write_text("<a/>")
    with open_library(tmp_path / "l.db", create=True) as library:
        *good, bad = library.ingest(*paths, folder / "bad.eaf")
        assert [(it.status, it.symbols, it.seconds) for it in good] == [
            ("added", good[0].symbols, 12.0)
        ] * len(paths)
        assert (bad.status, bad.error) == (
            "failed",
            f"{folder}/bad.eaf: XML of <a>, wanted <ANNOTATION_DOCUMENT>",
        )
        assert [it.status for it in library.ingest(*paths)] == ["unchanged"] * len(paths)
        hits = library.search("r_arm right high")
        found = {it.capture.format: 0 for it in hits}
        for hit in hits:
            found[hit.capture.format] += 1
        assert found == dict.fromkeys(WHOLE, found["lnd"])
        own = [hit for hit in hits if hit.capture.format == "eaf"][:1]
        (row,) = library.export(own, tmp_path / "out")
        assert Path(row["clip"]).suffix == ".lnd"
        with pytest.raises(ExportError, match="came as eaf, wanted a bvh source"):
            library.export(own, tmp_path / "bvh", format="bvh")


def test_folders_are_searched_for_scores_of_movement_only(folder: Path) -> None:
    (folder / "wave.laban").write_text("<a/>")
    others: list[str] = []
    assert [Path(it).name for it in discover([folder], others)] == ["lnd.lnd", "wave.laban"]
    assert sorted(Path(it).name for it in others) == sorted(
        f"{name}{NOTATIONS[name].suffix}" for name in WHOLE if not NOTATIONS[name].ingested
    )
