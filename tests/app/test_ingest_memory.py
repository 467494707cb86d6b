"""``lanindex ingest --jobs`` starts fewer processes where memory is short, and says so."""

from pathlib import Path

import pytest
from bvh_bodies import person
from typer.testing import CliRunner

from lanindex.app.cli import app
from lanindex.pipeline import prepare


@pytest.mark.parametrize(("free", "said"), [(0, True), (1 << 50, False)])
def test_fewer_processes_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, free: int, said: bool
) -> None:
    monkeypatch.setattr(prepare, "available", lambda: free)
    (tmp_path / "walk.bvh").write_bytes(person())
    words = ["ingest", str(tmp_path), "--jobs", "2", "-v", "--db", str(tmp_path / "l.db")]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    told = "1 of 2 processes: the largest files leave no room for more"
    assert (told in done.output) is said
