"""three.js as it stands in the package."""

import gzip
import hashlib
import json
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import pytest

HEAVIEST = 180_000  # bytes of three.js, compressed


@pytest.fixture(scope="module")
def vendor(static: Path) -> Path:
    return static / "vendor"


@pytest.fixture(scope="module")
def record(vendor: Path) -> dict[str, Any]:
    return tomllib.loads((vendor / "three.toml").read_text())


def test_it_is_what_its_record_says(vendor: Path, record: dict[str, Any]) -> None:
    bundle = (vendor / "three.js").read_bytes()
    assert hashlib.sha256(bundle).hexdigest() == record["sha256"]
    assert len(gzip.compress(bundle)) < HEAVIEST
    assert "three.js authors" in (vendor / record["licence"]).read_text()
    packages = json.loads(Path(__file__).with_name("package.json").read_text())["dependencies"]
    assert packages["three"] == packages["@types/three"] == record["version"]
    assert packages["esbuild"] == record["esbuild"]


def test_it_is_built_again_to_the_same_bytes(
    vendor: Path, record: dict[str, Any], node_modules: Path
) -> None:
    done = subprocess.run(
        [node_modules / ".bin" / "esbuild", "--loader=js", *record["options"]],
        input=(vendor / record["entry"]).read_bytes(),
        cwd=node_modules.parent,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr.decode()
    assert done.stdout == (vendor / "three.js").read_bytes()
