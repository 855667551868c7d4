"""What the command line says and returns where it cannot do what is asked."""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner

from enfilade.cli import COMMANDS, cli, main

HOTEL = Path(__file__).parents[1] / "graphs" / "hotel.graph.json"


@dataclass(frozen=True)
class Done:
    """How a command ended."""

    status: int
    out: str
    err: str


Enfilade = Callable[..., Done]


@pytest.fixture
def enfilade(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Enfilade:
    """Run the command line in an empty folder, in this process."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("ENFILADE_STORE", raising=False)

    def run(*arguments: str) -> Done:
        monkeypatch.setattr(sys, "argv", ["enfilade", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        captured = capsys.readouterr()
        return Done(int(ended.value.code or 0), captured.out, captured.err)

    return run


@pytest.fixture
def with_hotel(enfilade: Enfilade) -> Enfilade:
    """The same, with a store that holds the hotel."""
    assert enfilade("import", str(HOTEL)).status == 0
    return enfilade


def assert_one_sentence(done: Done, *, status: int, about: str) -> None:
    assert done.status == status, done.err
    assert about in done.err
    assert "Traceback" not in done.err
    assert done.out == ""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command: str) -> None:
    result = CliRunner().invoke(cli, [command, "--help"])
    assert result.exit_code == 0, result.output
    assert "Usage:" in result.output


def test_help_lists_every_command_in_a_line() -> None:
    lines = CliRunner().invoke(cli, ["--help"]).output.split("Commands:\n")[1].splitlines()
    assert [line.split()[0] for line in lines] == list(COMMANDS)
    assert not any(line.endswith("...") for line in lines)


def test_missing_scan_file(enfilade: Enfilade) -> None:
    assert_one_sentence(enfilade("ingest", "nowhere.e57"), status=1, about="nowhere.e57")


def test_folder_without_scans(enfilade: Enfilade, tmp_path: Path) -> None:
    (tmp_path / "scans").mkdir()
    assert_one_sentence(enfilade("ingest", "scans"), status=1, about="scans")


def test_a_failed_ingest_leaves_the_store_as_it_was(with_hotel: Enfilade, tmp_path: Path) -> None:
    before = with_hotel("buildings", "--format", "json").out
    (tmp_path / "hotel.e57").write_bytes(b"ASTM-E57" + bytes(100))
    assert_one_sentence(with_hotel("ingest", "hotel.e57"), status=1, about="hotel.e57")
    assert with_hotel("buildings", "--format", "json").out == before


def test_unknown_building(with_hotel: Enfilade) -> None:
    assert_one_sentence(with_hotel("show", "motel"), status=1, about="motel")


def test_unknown_command(enfilade: Enfilade) -> None:
    assert_one_sentence(enfilade("qery", "MATCH"), status=2, about="qery")


def test_missing_store_is_not_made(enfilade: Enfilade, tmp_path: Path) -> None:
    assert_one_sentence(enfilade("buildings"), status=1, about="enfilade.db")
    assert not (tmp_path / "enfilade.db").exists()


@pytest.mark.parametrize(
    ("question", "about"),
    [
        ("MATCH (a:Rom) RETURN a", "Room"),
        ("MATCH (a:Room)-[:DOR]-(b:Room) RETURN a", "DOOR"),
        ("MATCH (a:Room {area: 20..10}) RETURN a", "20..10"),
        ("MATCH (a:Room) WHERE a.hight > 2 RETURN a", "height"),
        ("MATCH (a:Room) WHERE a.area > $least RETURN a", "least"),
        ("MATCH (a:Room", "line 1"),
    ],
)
def test_bad_question_shows_place_and_suggestion(with_hotel: Enfilade, question: str, about: str) -> None:
    assert_one_sentence(with_hotel("query", question), status=2, about=about)


def test_missing_mesh(with_hotel: Enfilade) -> None:
    done = with_hotel("query", "MATCH (o:Object LIKE 'nowhere.obj') RETURN o")
    assert_one_sentence(done, status=1, about="nowhere.obj")


def test_cypher_needs_neo4j(with_hotel: Enfilade) -> None:
    assert_one_sentence(with_hotel("cypher", "MATCH (n) RETURN n"), status=1, about="query")


def test_a_password_does_not_belong_into_an_address(enfilade: Enfilade) -> None:
    done = enfilade("--store", "neo4j://neo4j:secret@127.0.0.1:1", "buildings")
    assert_one_sentence(done, status=1, about="ENFILADE_PASSWORD")
    assert "secret" not in done.err


def test_answers_can_be_piped(with_hotel: Enfilade) -> None:
    done = with_hotel("query", "MATCH (a:Room {area: 12..14}) RETURN a, a.name", "--nl")
    assert done.status == 0, done.err
    assert done.out.splitlines()[0] == '{"a": "hotel/r1", "a.name": "Office A"}'


def test_question_from_a_file_with_parameters(with_hotel: Enfilade, tmp_path: Path) -> None:
    (tmp_path / "large.cypher").write_text("MATCH (a:Room) WHERE a.area > $least RETURN a.name", encoding="utf-8")
    done = with_hotel("query", "-f", "large.cypher", "--param", "least=20", "--format", "csv")
    assert done.out.splitlines() == ["a.name", "Lobby", "Suite"]


def test_explain_goes_to_standard_error(with_hotel: Enfilade) -> None:
    done = with_hotel("query", "MATCH (a:Room {area: 30}) RETURN a", "--format", "csv", "--explain")
    assert done.out.splitlines() == ["a", "hotel/r0"]
    assert "SELECT" in done.err


def test_a_file_that_cannot_be_written(with_hotel: Enfilade, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for form in ("json", "csv", "parquet", "table"):
        done = with_hotel("query", "MATCH (a:Room) RETURN a", "--format", form, "-o", "file/answer")
        assert_one_sentence(done, status=1, about="file/answer cannot be written")
    assert_one_sentence(with_hotel("export", "hotel", "-o", "file/folder"), status=1, about="file/folder")


def test_lists_and_missing_values_in_csv_are_those_of_json(with_hotel: Enfilade) -> None:
    question = "MATCH (a:Room {name: 'Office A'}) RETURN a.name, a.function, [1, 'x'] AS list, a.area > 1 AS large"
    done = with_hotel("query", question, "--format", "csv")
    assert done.out.splitlines() == ["a.name,a.function,list,large", 'Office A,,"[1, ""x""]",true']


def test_infinity_is_no_json_number(with_hotel: Enfilade) -> None:
    done = with_hotel("query", "MATCH (a:Room) RETURN a.area / 0 AS q, -a.area / 0 AS r LIMIT 1", "--nl")
    assert done.out == '{"q": "Infinity", "r": "-Infinity"}\n'


def test_parquet_that_cannot_hold_the_values(with_hotel: Enfilade) -> None:
    question = "MATCH (a:Room) RETURN [1, 'x'] AS list"
    done = with_hotel("query", question, "--format", "parquet", "-o", "answer.parquet")
    assert_one_sentence(done, status=1, about="--format json")


def test_rows_beyond_the_limit_are_left_out_and_it_is_said(with_hotel: Enfilade) -> None:
    done = with_hotel("query", "MATCH (a:Room) RETURN a ORDER BY a.area", "--rows", "2", "--nl")
    assert done.out == '{"a": "hotel/r3"}\n{"a": "hotel/r6"}\n'
    assert done.err == "Note: these are the first 2 of 7 rows; raise --rows for more.\n"


def test_unmet_conditions_stand_on_lines_of_their_own(with_hotel: Enfilade) -> None:
    question = "MATCH (a:Room {area: 29..30, name: 'Loft'}) WHERE a.height > 4 RETURN a LIMIT 1 RELAX 3"
    lines = [line.strip("│ \n") for line in with_hotel("query", question).out.splitlines()]
    assert [line.split("│")[-1].strip() for line in lines[3:5]] == ["(a:Room {name: 'Loft'})", "a.height > 4"]


def test_parquet_keeps_kinds_where_values_are_missing(with_hotel: Enfilade, tmp_path: Path) -> None:
    question = "MATCH (b:Building) OPTIONAL MATCH (o:Object {parts: 2}) RETURN b, o.parts AS n, b.scan_count AS m"
    assert with_hotel("query", question, "--format", "parquet", "-o", "a.parquet").status == 0
    near = "MATCH (a:Room {area: 30}) RETURN a LIMIT 1 RELAX 1"
    assert with_hotel("query", near, "--format", "parquet", "-o", "b.parquet").status == 0

    first, second = (pq.read_table(tmp_path / name) for name in ("a.parquet", "b.parquet"))

    assert first.to_pylist() == [{"b": "hotel", "n": 2, "m": None}]
    assert str(first.schema.field("n").type) == "int64"
    assert str(second.schema.field("unmet").type) == "list<element: string>"


@pytest.mark.parametrize("arguments", [("--nl", "--format", "csv"), ("--param", "x=" + "[" * 100_000)])
def test_options_that_make_no_sense(with_hotel: Enfilade, arguments: tuple[str, ...]) -> None:
    assert_one_sentence(with_hotel("query", "MATCH (a:Room) RETURN a", *arguments), status=2, about=arguments[0])


def test_a_question_file_may_begin_with_a_byte_order_mark(with_hotel: Enfilade, tmp_path: Path) -> None:
    (tmp_path / "large.cypher").write_text("\ufeffMATCH (a:Room {area: 30}) RETURN a", encoding="utf-8")
    assert with_hotel("query", "-f", "large.cypher", "--nl").out == '{"a": "hotel/r0"}\n'


def test_a_question_file_that_is_no_text(with_hotel: Enfilade, tmp_path: Path) -> None:
    (tmp_path / "large.cypher").write_bytes(b"MATCH \xff")
    assert_one_sentence(with_hotel("query", "-f", "large.cypher"), status=1, about="byte 6")


def test_an_import_that_stops_says_what_is_in(enfilade: Enfilade, tmp_path: Path) -> None:
    (tmp_path / "bad.json").write_text("{}", encoding="utf-8")
    done = enfilade("import", str(HOTEL), "bad.json")
    assert_one_sentence(done, status=1, about="bad.json")
    assert "Imported 1 building, then stopped." in done.err
    assert '"hotel"' in enfilade("buildings", "--format", "json").out


def test_an_import_of_no_building(enfilade: Enfilade, tmp_path: Path) -> None:
    (tmp_path / "empty.jsonl").touch()
    assert_one_sentence(enfilade("import", "empty.jsonl"), status=1, about="empty.jsonl holds no building")


def test_a_building_that_is_kept_after_all(with_hotel: Enfilade, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO("n\n"))
    done = with_hotel("remove", "hotel")
    assert done.status == 1
    assert "Nothing was removed." in done.err
    assert with_hotel("show", "hotel").status == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize("arguments", [("buildings",), ("query", "MATCH (a:Room) RETURN a", "--nl")])
def test_output_that_cannot_be_written(with_hotel: Enfilade, arguments: tuple[str, ...]) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run([sys.executable, "-m", "enfilade", *arguments], stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 1
    assert done.stderr.decode() == "Error: No space left on device.\n"


def test_listing_buildings_loads_nothing_heavy(with_hotel: Enfilade) -> None:
    code = "import enfilade.cli.buildings, sys; print({'numba', 'pandas', 'neo4j', 'open3d'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


@pytest.mark.parametrize("name", ["hotel.json", "hotel.jsonl", "hotel.jsonl.gz", "hotel.json.gz", "folder"])
def test_what_is_exported_can_be_imported(with_hotel: Enfilade, name: str) -> None:
    assert with_hotel("export", "hotel", "-o", name).status == 0
    done = with_hotel("--store", "sqlite:again.db", "import", name)
    assert done.status == 0, done.err
    first = with_hotel("query", "MATCH (a:Room) RETURN a, a.area, a.outline", "--nl")
    again = with_hotel("--store", "sqlite:again.db", "query", "MATCH (a:Room) RETURN a, a.area, a.outline", "--nl")
    assert first.out == again.out != ""


def test_an_empty_text_is_no_node(with_hotel: Enfilade) -> None:
    assert_one_sentence(with_hotel("measure", ""), status=1, about="1 to 200 characters")
    assert_one_sentence(with_hotel("measure", "hotel/r0", ""), status=1, about="1 to 200 characters")


@pytest.mark.parametrize(
    ("arguments", "status", "about"),
    [
        (("--storey", "0"), 2, "name a file or a folder with --plan"),
        (("--plan", "plans"), 1, "The building 'hotel' has no room with an outline or a centre to draw"),
        (("--plan", "plan.bmp"), 1, "a picture is a file that ends in"),
        (("--plan", "plan.png", "--storey", "attic"), 1, "There is no storey 'attic'"),
    ],
)
def test_plans_that_cannot_be_drawn(
    with_hotel: Enfilade, arguments: tuple[str, ...], status: int, about: str, tmp_path: Path
) -> None:
    done = with_hotel("show", "hotel", *arguments)
    assert done.status == status
    assert about in done.err
    assert not list(tmp_path.glob("plan*"))
