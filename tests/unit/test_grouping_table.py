"""The grouping table: names or indices, and a sentence with the line for what is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from enfilade.errors import InputError
from enfilade.ingest.grouping_table import read_grouping

NAMES = ("Scan 001", "Scan 002", "Büro, links")


def table(folder: Path, text: str) -> Path:
    path = folder / "rooms.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_scans_are_named_by_name_or_index(tmp_path: Path) -> None:
    given = read_grouping(table(tmp_path, 'scan,room\nScan 001,a\n1, b \n\n"Büro, links",a\n'), NAMES)
    assert given == {0: "a", 1: "b", 2: "a"}


def test_indices_are_those_of_the_files_and_not_of_the_names(tmp_path: Path) -> None:
    assert read_grouping(table(tmp_path, "scan,room\n1,a\n2,b\n"), NAMES, [2, 0, 1]) == {2: "a", 0: "b"}


def test_a_byte_order_mark_is_no_part_of_the_header(tmp_path: Path) -> None:
    assert read_grouping(table(tmp_path, "\ufeffscan,room\n0,a\n"), NAMES) == {0: "a"}


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("", "line 1: the header must be 'scan,room'"),
        ("room,scan\n0,a\n", "line 1: the header must be 'scan,room'"),
        ("scan,room\nScan 001,a\nScan 9,b\n", "line 3: there is no scan 'Scan 9'; the scans are 'Scan 001'"),
        ("scan,room\n3,a\n", "line 2: there is no scan '3'"),
        ("scan,room\n0\n", "line 2: 1 columns where 2 are needed"),
        ("scan,room\n0, \n", "line 2: the room of scan '0' is empty"),
        ("scan,room\n0,a\nScan 001,b\n", "line 3: scan 'Scan 001' is already in room 'a'"),
    ],
)
def test_a_wrong_line_is_named_with_its_cause(tmp_path: Path, text: str, fault: str) -> None:
    path = table(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_grouping(path, NAMES)
    assert str(caught.value).startswith(str(path))
    assert fault in str(caught.value)


def test_a_name_that_two_scans_have_must_be_an_index(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="2 scans are called 'hall'"):
        read_grouping(table(tmp_path, "scan,room\nhall,a\n"), ("hall", "hall"))


def test_a_missing_or_binary_table_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_grouping(tmp_path / "absent.csv", NAMES)
    (tmp_path / "binary.csv").write_bytes(b"scan,room\n\xff\xfe\x00,1\n")
    with pytest.raises(InputError, match="cannot be read"):
        read_grouping(tmp_path / "binary.csv", NAMES)
