import unicodedata
from pathlib import Path

import pytest

from lanindex.errors import LanindexError, UsageError
from lanindex.pipeline.ingest import read_labels, unfitting
from lanindex.pipeline.library import open_library


def test_columns_beside_the_label(tmp_path: Path) -> None:
    table = tmp_path / "labels.csv"
    text = 'File,Label,dataset,,\na.bvh,"walk, slow",d1,,\n/x/b.bvh,run,\nc.bvh,,d2\n\n'
    table.write_text(text, "utf-8-sig")
    assert read_labels(table) == {
        str(tmp_path / "a.bvh"): ("walk, slow", {"dataset": "d1"}),
        "/x/b.bvh": ("run", {}),
        str(tmp_path / "c.bvh"): (None, {"dataset": "d2"}),
    }


def test_no_column_of_labels(tmp_path: Path) -> None:
    (tmp_path / "l.csv").write_text("file,style\na.bvh,slow\n")
    assert read_labels(tmp_path / "l.csv") == {str(tmp_path / "a.bvh"): (None, {"style": "slow"})}


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be"])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_tables_as_spreadsheets_save_them(
    tmp_path: Path, delimiter: str, encoding: str, newline: str
) -> None:
    rows = [
        ["label", '"File"', "a,b,c,d;e;f;g".replace(delimiter, ".")],
        ["räv", "a.bvh", "1"],
    ]
    text = newline.join(delimiter.join(row) for row in rows)
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    (tmp_path / "l.csv").write_bytes((mark + text).encode(encoding))
    ((key, (label, others)),) = read_labels(tmp_path / "l.csv").items()
    assert (key, label) == (str(tmp_path / "a.bvh"), "räv")
    assert list(others.values()) == ["1"]


def test_a_table_of_files_alone(tmp_path: Path) -> None:
    (tmp_path / "l.csv").write_text("file\na.bvh\n")
    assert read_labels(tmp_path / "l.csv") == {str(tmp_path / "a.bvh"): (None, {})}


def test_letters_of_two_characters_are_those_of_one(tmp_path: Path) -> None:
    names = [unicodedata.normalize(form, "é/tänze.bvh") for form in ("NFC", "NFD")]
    tables = []
    for name in names:
        (tmp_path / "l.csv").write_text(f"file,label\n{name},x\n")
        tables.append(read_labels(tmp_path / "l.csv"))
    assert names[0] != names[1]
    assert tables[0] == tables[1]
    assert all(unfitting(tables[0], [tmp_path / name]) == "" for name in names)


def test_a_file_is_looked_for_beside_the_table_then_in_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, tables = tmp_path / "here", tmp_path / "tables"
    for folder, names in ((here, ("a", "b")), (tables, ("b", "c"))):
        folder.mkdir()
        for name in names:
            (folder / f"{name}.bvh").write_text("")
    (tables / "l.csv").write_text("file,label\na.bvh,1\nb.bvh,2\nc.bvh,3\nd.bvh,4\n")
    monkeypatch.chdir(here)
    labels = read_labels(tables / "l.csv")
    assert {key: label for key, (label, _) in labels.items()} == {
        str(here / "a.bvh"): "1",
        str(tables / "b.bvh"): "2",
        str(tables / "c.bvh"): "3",
        str(tables / "d.bvh"): "4",
    }


def test_a_table_of_no_file_is_refused_before_anything_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.bvh").write_text("")
    (tmp_path / "l.csv").write_text("file,label\nb.bvh,walk\n")
    with open_library(tmp_path / "l.db", create=True) as library:
        with pytest.raises(UsageError, match=r"l\.csv: no row names a file that is read"):
            library.ingest(tmp_path / "a.bvh", labels=tmp_path / "l.csv")
        assert library.captures() == []


def test_what_fits_no_file_is_told() -> None:
    def fits(*names: str) -> str:
        return unfitting({f"/in/{name}": ("x", {}) for name in names}, files)

    files = ["/in/walk_01.bvh", "/out/run.bvh", "/in/other/run.bvh"]
    assert fits() == fits("walk_01.bvh") == ""
    assert fits("walk_01.bvh", "jump.bvh") == "1 of 2 rows name no file that is read"
    said = "no row names a file that is read; the first names /in/"
    assert fits("walk_1.bvh", "x").startswith(f"{said}walk_1.bvh; is it /in/walk_01.bvh? (a rel")
    assert fits("other/a/run.bvh").startswith(f"{said}other/a/run.bvh; is it /in/other/run.bvh?")
    assert fits("zzz").startswith(f"{said}zzz (a relative path counts from")
    assert unfitting({"/in/a": ("x", {})}, []).startswith(f"{said}a (a relative")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the columns are none"),
        ("name,label\na,b\n", 'l.csv:1: the columns are name, label, wanted a column "file"'),
        ("file,label\na,b,c\n", "l.csv:2: 3 cells, wanted 2 as in line 1"),
        ("file,label\na,b\na,c\n", "l.csv:3"),
        ("\nfile,style,label,Style\n", 'l.csv:2: columns 2 and 4 are both called "style"'),
        (
            "file,a=b\nx,1\n",
            'l.csv:1: column 2 is called "a=b", wanted a name without "="',
        ),
        ("file,File\n", 'l.csv:1: columns 1 and 2 are both called "file"'),
        ("file,,label,\na,,b\n\nc,,d,x\n", 'l.csv:4: column 4 has no name and holds "x"'),
        ("label,file\na\n", "l.csv:2: no file"),
        ('file,label\n"a,b\n', "wanted CSV"),
        ("name;label\na;b\n", 'l.csv:1: the columns are name, label, wanted a column "file"'),
        ("x" * 5000, f"l.csv:1: the columns are {'x' * 199}…, wanted"),
        ("file," + "x" * 5000 + "," + "x" * 5000, f'both called "{"x" * 59}…"'),
        ("file,\na," + "x" * 5000, f'l.csv:2: column 2 has no name and holds "{"x" * 59}…"'),
    ],
    ids=lambda text: text[:40],
)
def test_errors_name_the_line(tmp_path: Path, text: str, message: str) -> None:
    table = tmp_path / "l.csv"
    table.write_text(text)
    with pytest.raises(LanindexError) as error:
        read_labels(table)
    assert message in str(error.value)


def test_no_text(tmp_path: Path) -> None:
    (tmp_path / "l.csv").write_bytes(b"file\xff\n")
    with pytest.raises(LanindexError, match="byte 4 is no UTF-8"):
        read_labels(tmp_path / "l.csv")
    (tmp_path / "l.csv").write_bytes(b"\xff\xfef\0i")
    with pytest.raises(LanindexError, match="byte 4 is no UTF-16"):
        read_labels(tmp_path / "l.csv")
