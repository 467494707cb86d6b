"""Static checks, imports and start-up."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

SLOW_TO_IMPORT = {"numpy", "sqlalchemy", "alembic", "rapidfuzz", "numba", "scipy", "rich", "fsspec"}


def modules(repository: Path) -> list[Path]:
    return sorted((repository / "lanindex").rglob("*.py"))


def tool(name: str) -> str:
    return str(Path(sys.executable).parent / name)


@pytest.mark.parametrize(
    "command",
    [
        ["ruff", "format", "--check", "--no-cache", "."],
        ["ruff", "check", "--no-cache", "."],
        pytest.param(["mypy"], marks=pytest.mark.slow),  # a minute in a fresh tree
        ["lint-imports", "--no-cache"],
    ],
    ids=lambda command: " ".join(command[:2]),
)
def test_checks_are_clean(command: list[str], repository: Path) -> None:
    done = subprocess.run(
        [tool(command[0]), *command[1:]],
        cwd=repository,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_nothing_below_the_app_prints(repository: Path) -> None:
    printing = [
        str(path)
        for path in modules(repository)
        if "app" not in path.relative_to(repository / "lanindex").parts[:1]
        and any(
            isinstance(node, ast.Call) and getattr(node.func, "id", "") == "print"
            for node in ast.walk(ast.parse(path.read_text()))
        )
    ]
    assert printing == []


def loaded(*words: str) -> set[str]:
    code = (
        f"import sys; sys.argv = ['lanindex', *{words!r}]\n"
        "from lanindex.app.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print('LOADED', *sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    line = next(line for line in done.stdout.splitlines() if line.startswith("LOADED"))
    return set(line.split()[1:])


def test_help_starts_fast() -> None:
    assert loaded("--help") & SLOW_TO_IMPORT == set()


def test_a_search_loads_what_it_needs_alone(repository: Path, tmp_path: Path) -> None:
    library = str(tmp_path / "l.db")
    score = str(repository / "corpus" / "semaphore.lnd")
    assert "fsspec" not in loaded("ingest", score, "--db", library)
    needless = {
        "sqlalchemy",
        "alembic",
        "rapidfuzz",
        "numba",
        "scipy",
        "rich",
        "numpy.ma",
        "fsspec",
    }
    for words in (("-n", "5"), ("--count",), ("--json", "--in", "*.lnd")):
        held = loaded("search", "r_arm high", "--db", library, *words)
        assert "numpy" in held
        assert held & needless == set()


def test_import_starts_fast() -> None:
    code = "import lanindex, sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) & SLOW_TO_IMPORT == set()


def test_every_benchmark_can_be_imported(repository: Path) -> None:
    code = (
        "import runpy, sys\n"
        "from pathlib import Path\n"
        "here = Path(sys.argv[1])\n"
        "sys.path.insert(0, str(here))\n"
        "for path in sorted(here.glob('*.py')):\n"
        "    if path.name != 'blender.py':  # which Blender runs\n"
        "        runpy.run_path(str(path), run_name='imported')\n"
    )
    benchmarks = repository / "tests" / "benchmarks"
    done = subprocess.run(
        [sys.executable, "-c", code, benchmarks], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_encode_is_a_function_whatever_is_imported_first() -> None:
    code = (
        "import importlib, types, lanindex\n"
        "for name in ('lanindex.encoding', 'lanindex.encoding.profile', 'lanindex.pipeline'):\n"
        "    importlib.import_module(name)\n"
        "print(*(type(one) is types.FunctionType for one in (lanindex.encode, lanindex.trace)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "True"]
