from pathlib import Path

import pytest

from lanindex.errors import LanindexError
from lanindex.pipeline.labels import read_labels


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


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the columns are none"),
        ("name,label\na,b\n", 'l.csv:1: the columns are name, label, wanted a column "file"'),
        ("file,label\na,b,c\n", "l.csv:2: 3 cells, wanted 2 as in line 1"),
        ("file,label\na,b\na,c\n", "l.csv:3"),
        ("\nfile,style,label,Style\n", 'l.csv:2: columns 2 and 4 are both called "style"'),
        ("file,File\n", 'l.csv:1: columns 1 and 2 are both called "file"'),
        ("file,,label,\na,,b\n\nc,,d,x\n", 'l.csv:4: column 4 has no name and holds "x"'),
        ("label,file\na\n", "l.csv:2: no file"),
        ('file,label\n"a,b\n', "wanted CSV"),
    ],
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
