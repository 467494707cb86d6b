"""The page's scripts: their types, and what they must not do."""

import json
import re
import subprocess
from pathlib import Path

import pytest

FORBIDDEN = {
    "writes markup": r"\b(?:inner|outer)HTML\b|\binsertAdjacentHTML\b"
    r"|\bdocument\.write|\bcreateContextualFragment\b",
    "runs text": r"\beval\s*\(|\bnew\s+Function\b|set(?:Timeout|Interval)\(\s*[\"'`]",
    "has a handler or style in an attribute": r"setAttribute\(\s*[\"'`](?:style|on\w+)|\.cssText\b",
    "fetches from elsewhere": r"[\"'`(](?:https?:|wss?:)?//(?!www\.w3\.org/)",
}
IMPORTED = re.compile(r"(?:\bfrom\s+|\bimport\s*\(?\s*)[\"'`]([^\"'`]+)")


def scripts(static: Path) -> list[Path]:
    return sorted(set(static.rglob("*.js")) - {static / "vendor" / "three.js"})


def faults(text: str, folder: Path, static: Path) -> list[str]:
    """Return what a script in a folder does that it must not."""
    code = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    code = re.sub(r"(?m)(?<![:\"'`(])//.*$", "", code)
    found = [name for name, pattern in FORBIDDEN.items() if re.search(pattern, code)]
    for name in IMPORTED.findall(code):
        path = (folder / name).resolve()
        if not (name.startswith(".") and path.is_relative_to(static) and path.is_file()):
            found.append(f"imports {name}")
    return found


def test_scripts_do_nothing_that_is_forbidden(static: Path) -> None:
    found = {str(path): faults(path.read_text(), path.parent, static) for path in scripts(static)}
    assert {name: own for name, own in found.items() if own} == {}


@pytest.mark.parametrize(
    "code",
    [
        "node.innerHTML = text",
        "eval(text)",
        "new Function('return 1')",
        "document.write('x')",
        "node.setAttribute('style', 'color: red')",
        "node.setAttribute(\"onclick\", 'go()')",
        "fetch('https://example.org/x')",
        "fetch('//example.org/x')",
        "import { a } from 'three'",
        "import { a } from '../server.js'",
        "import './none.js'",
        "await import('https://example.org/x.js')",
    ],
)
def test_what_is_forbidden_is_found(code: str, static: Path) -> None:
    assert faults(code, static, static)


def test_types_hold(static: Path, node_modules: Path, tmp_path: Path) -> None:
    config = json.loads(Path(__file__).with_name("jsconfig.json").read_text())
    config["compilerOptions"]["paths"] = {
        "three": [str(node_modules / "@types" / "three" / "index.d.ts")]
    }
    config["include"] = [str(static / "**" / "*.js")]
    config["exclude"] = [str(static / "vendor")]
    (tmp_path / "jsconfig.json").write_text(json.dumps(config))
    done = subprocess.run(
        [node_modules / ".bin" / "tsc", "-p", tmp_path / "jsconfig.json"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
