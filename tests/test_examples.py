"""The examples in docstrings are real: each is run beside the corpus and a library of it."""

import ast
import doctest
import importlib
import inspect
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import REPOSITORY

import lanindex
from lanindex.pipeline.jobs import IngestJob, SearchJob
from lanindex.search.explain.advice import Advice
from lanindex.search.explain.why import Trace
from lanindex.search.hits import Counts, Hits

PACKAGE = REPOSITORY / "lanindex"
RESULTS = (Hits, Counts, Advice, Trace, SearchJob, IngestJob)
"""Classes that nobody imports but everybody gets."""


def modules_with_examples() -> list[str]:
    paths = sorted(path for path in PACKAGE.rglob("*.py") if ">>> " in path.read_text())
    names = (path.relative_to(REPOSITORY).with_suffix("") for path in paths)
    return [".".join(name.parts).removesuffix(".__init__") for name in names]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Make a library of the corpus' captures, its paths as a person would type them."""
    folder = tmp_path_factory.mktemp("examples")
    (folder / "corpus").symlink_to(REPOSITORY / "corpus")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        with lanindex.open_library("dance.db", create=True) as made:
            made.ingest(sorted(Path("corpus").glob("*.bvh")), labels="corpus/labels.csv")
    return folder / "dance.db"


@pytest.fixture
def place(library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "corpus").symlink_to(REPOSITORY / "corpus")
    shutil.copy(library, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("place")
@pytest.mark.parametrize("module", modules_with_examples())
def test_examples_do_what_they_show(module: str) -> None:
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    said: list[str] = []
    for example in doctest.DocTestFinder(exclude_empty=True).find(importlib.import_module(module)):
        example.globs = {"__name__": "__main__"}  # an example imports what it needs
        runner.run(example, out=said.append)
    assert runner.tries > 0
    assert runner.failures == 0, "".join(said)


def examples_of(thing: object) -> str:
    if inspect.ismodule(thing):  # one that is its main function, too
        thing = thing.__call__
    found = doctest.DocTestParser().get_examples(inspect.getdoc(thing) or "")
    return "".join(example.source for example in found)


def public() -> list[tuple[str, object, str]]:
    """Return name, object and the examples of its class, of all that users call."""
    things = [(name, getattr(lanindex, name)) for name in lanindex.__all__]
    things += [(kind.__name__, kind) for kind in RESULTS]
    found = [
        (name, thing, examples_of(getattr(thing, "__self__", None)))
        for name, thing in things
        if callable(thing)
    ]
    for name, kind in ((name, thing) for name, thing in things if inspect.isclass(thing)):
        for method, member in inspect.getmembers(kind, callable):
            ours = (getattr(member, "__module__", None) or "").startswith("lanindex.")
            if ours and not method.startswith("_") and member not in dict(things).values():
                found.append((f"{name}.{method}", member, examples_of(kind)))
    return found


@pytest.mark.parametrize("name", [name for name, _, _ in public()])
def test_whatever_users_call_has_an_example(name: str) -> None:
    thing, around = next((thing, around) for other, thing, around in public() if other == name)
    called = re.search(rf"\.{name.split('.')[-1]}\(", around)
    assert examples_of(thing) or called, f"{name} has no example"


@pytest.mark.slow
def test_names_in_docstrings_are_names_of_something() -> None:
    trees = {path: ast.parse(path.read_text()) for path in PACKAGE.rglob("*.py")}
    names = {path.stem for path in trees} | {path.parent.name for path in trees}
    said: dict[str, str] = {}
    for path, tree in trees.items():
        for node in ast.walk(tree):
            found = (getattr(node, field, None) for field in ("name", "id", "attr", "arg"))
            names |= {name for name in found if isinstance(name, str)}
            if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module):
                text = ast.get_docstring(node) or ""
                said |= dict.fromkeys(re.findall(r"(?<!`)`([A-Za-z_.]+)`(?!`)", text), str(path))
    files = {path.name for path in PACKAGE.rglob("*") if path.suffix in (".toml", ".md")}
    unknown = {name for name in said if name.split(".")[-1] not in names} - files
    assert {name: said[name] for name in unknown} == {}
