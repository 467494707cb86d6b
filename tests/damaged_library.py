"""Changes behind a library's back: of a cell, a bit of the file, a row."""

import sqlite3
from contextlib import closing

from lanindex.library.schema import tables, version

TABLES = {table.name: table for table in (*tables.sorted_tables, version)}

VALUES = (None, b"\xff", b"", "z", "", "[[0,", "3", 0, 1, -1, 0.5, 1 << 40, "\udcff", "{}", "[]")


def change_a_cell(path, choice):
    table = TABLES[choice.choice(list(TABLES))]
    with closing(sqlite3.connect(path)) as connection, connection:
        row = one_row(connection, table, choice)
        column = choice.choice(table.c.keys())
        before = row[table.c.keys().index(column)]
        more = [before + 7] * 5 if isinstance(before, int) else []
        value = choice.choice([*VALUES, *more])
        if isinstance(value, str):  # as bytes that need not be UTF-8
            value = value.encode("utf-8", "surrogateescape")
            text = f"UPDATE {table.name} SET {column} = CAST(? AS TEXT)"
        else:
            text = f"UPDATE {table.name} SET {column} = ?"
        key, own = where(table, row)
        connection.execute(f"{text} WHERE {key}", (value, *own))


def turn_a_bit(path, choice):
    content = bytearray(path.read_bytes())
    content[choice.randrange(len(content))] ^= 1 << choice.randrange(8)
    path.write_bytes(content)


def take_out_a_row(path, choice):
    table = TABLES[choice.choice(list(TABLES))]
    with closing(sqlite3.connect(path)) as connection, connection:
        key, own = where(table, one_row(connection, table, choice))
        connection.execute(f"DELETE FROM {table.name} WHERE {key}", own)


def put_a_row_in_twice(path, choice):
    table = TABLES[choice.choice(list(TABLES))]
    with closing(sqlite3.connect(path)) as connection, connection:
        row = list(one_row(connection, table, choice))
        names = table.c.keys()
        for column in {"location", choice.choice(names), choice.choice(names)}.intersection(names):
            place = names.index(column)
            row[place] = row[place] + 7 if isinstance(row[place], int) else f"{row[place]}2"
        marks = ", ".join("?" * len(row))
        connection.execute(f"INSERT INTO {table.name} VALUES ({marks})", row)


def one_row(connection, table, choice):
    names = ", ".join(table.c.keys())
    return choice.choice(connection.execute(f"SELECT {names} FROM {table.name}").fetchall())


def where(table, row):
    keys = [column.name for column in table.primary_key.columns]
    return (
        " AND ".join(f"{name} = ?" for name in keys),
        [row[table.c.keys().index(name)] for name in keys],
    )
