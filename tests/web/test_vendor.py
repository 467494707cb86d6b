"""three.js as it stands in the package."""

import gzip
import hashlib
import json
import re
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import pytest

from lanindex.data import shipped
from lanindex.draw.svg import BODY

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


def test_every_name_of_it_is_used(static: Path, vendor: Path) -> None:
    names = re.findall(r"\w+(?=,)", (vendor / "three.d.ts").read_text())
    scripts = "".join(path.read_text() for path in static.glob("*.js"))
    assert [name for name in names if f"three.{name}" not in scripts] == []


def test_colours_are_those_of_films(static: Path) -> None:
    table = (static / "look.js").read_text().split("export const COLORS = {")[1].split("}")[0]
    colors = dict(re.findall(r"(\w+): .*(#\w+)", table))
    films = {**BODY, **shipped("film/figure.toml")["colors"]}
    assert colors.keys() >= {"right", "left", "head", "lit", "floor", "way"}
    assert colors == {name: films[name] for name in colors}
