"""A few trials of each campaign, so that they go on working."""

import subprocess
import sys
from pathlib import Path

import pytest
from postgres_server import folder_of_commands

HERE = Path(__file__).parent
CAMPAIGNS = {
    **{"kills": 3, "damage": 10, "disks": 2, "clocks": 1, "inputs": 1, "servers": 1},
    "cluster": 2,
}


def test_all_are_tried() -> None:
    others = {"common", "schemas", Path(__file__).stem}
    assert {path.stem for path in HERE.glob("*.py")} - others == {*CAMPAIGNS}


@pytest.mark.slow
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_a_few_trials(name: str) -> None:
    if name == "servers" and folder_of_commands() is None:
        pytest.skip("no PostgreSQL server is installed")
    if name == "cluster":
        pytest.importorskip("distributed")
    command = [sys.executable, HERE / f"{name}.py", "--count", str(CAMPAIGNS[name])]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{name}: {CAMPAIGNS[name]} trials, 0 failed" in done.stdout.splitlines()[-1]
    assert done.stderr == ""
