"""A few trials of each campaign, so that they go on working."""

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
CAMPAIGNS = {"kills": 4, "damage": 20, "disks": 4, "clocks": 2, "inputs": 1}


def test_all_are_tried() -> None:
    others = {"common", Path(__file__).stem}
    assert {path.stem for path in HERE.glob("*.py")} - others == {*CAMPAIGNS}


@pytest.mark.slow
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_a_few_trials(name: str) -> None:
    command = [sys.executable, HERE / f"{name}.py", "--count", str(CAMPAIGNS[name])]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{name}: {CAMPAIGNS[name]} trials, 0 failed" in done.stdout.splitlines()[-1]
    assert done.stderr == ""
