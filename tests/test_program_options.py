"""Options from words, variables and a file: which of them counts, and where each comes from."""

from __future__ import annotations

import argparse
import json
import logging
from pathlib import Path

import pytest

from talaia.log_setup import set_up_log
from talaia.program_options import OptionRefused, OptionSource, parse_options, settings_text


def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser("thing")
    made.add_argument("site", type=Path)
    made.add_argument("--port", type=int, default=8443)
    made.add_argument("--key-file", type=Path, required=True)
    made.add_argument("--plain", action="store_true")
    made.add_argument("--proxy", action="append", default=[])
    return made


def read(words: str, file: Path | None = None, **variables: str) -> dict[str, tuple[object, str]]:
    """Give value and source of each option."""
    named = [] if file is None else ["--settings", str(file)]
    environment = {f"THING_{name}": value for name, value in variables.items()}
    _, sources = parse_options(parser(), [*words.split(), *named], "THING_", environment)
    return {each.name: (each.value, each.source) for each in sources}


def test_words_win_over_variables_and_those_over_the_file(tmp_path: Path) -> None:
    file = tmp_path / "thing.yaml"
    file.write_text("port: 1\nkey-file: from-file\nplain: true\nproxy: [a, b]\n")
    told = read("s.yaml --port 3", file, PORT="2", KEY_FILE="from-variable")
    assert told == {
        "port": (3, "--port"),
        "key-file": (Path("from-variable"), "THING_KEY_FILE"),
        "plain": (True, str(file)),
        "proxy": (["a", "b"], str(file)),
    }


def test_a_list_is_replaced_and_never_mixed(tmp_path: Path) -> None:
    file = tmp_path / "thing.yaml"
    file.write_text("proxy: [a, b]\n")
    assert read("s --key-file k --proxy z", file)["proxy"] == (["z"], "--proxy")
    assert read("s --key-file k", file, PROXY="x, y")["proxy"] == (["x", "y"], "THING_PROXY")


def test_the_file_may_be_named_by_a_variable(tmp_path: Path) -> None:
    file = tmp_path / "thing.yaml"
    file.write_text("port: 7\n")
    assert read("s --key-file k", SETTINGS=str(file))["port"] == (7, str(file))


def test_what_is_required_may_come_from_anywhere_and_is_asked_for_if_it_does_not(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert read("s", KEY_FILE="k")["key-file"] == (Path("k"), "THING_KEY_FILE")
    with pytest.raises(SystemExit):
        read("s")
    assert "--key-file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("prot: 1", "unknown option 'prot'; did you mean 'port'?"),
        ("- port", "expected lines like 'port: 8443'"),
        ("port: [", "is no YAML"),
        ("plain: maybe", "expected true or false, found 'maybe'"),
        ("help: true", "unknown option 'help'"),
    ],
)
def test_a_mistake_in_the_file_is_told_with_the_file(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "thing.yaml"
    file.write_text(text)
    with pytest.raises(OptionRefused) as refused:
        read("s --key-file k", file)
    assert said in str(refused.value)
    assert str(file) in str(refused.value)


def test_a_value_that_is_refused_is_told_with_where_it_comes_from(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "thing.yaml"
    file.write_text("port: many\n")
    for words, given, said in (
        ("s --key-file k", None, "error: THING_PORT: invalid int value: 'many'"),
        ("s --key-file k", file, f"error: {file}: port: invalid int value: 'many'"),
        ("s --key-file k --port many", None, "error: argument --port: invalid int value: 'many'"),
    ):
        variables = {"PORT": "many"} if said.startswith("error: THING") else {}
        with pytest.raises(SystemExit):
            read(words, given, **variables)
        assert said in capsys.readouterr().err


def test_a_variable_that_is_no_option_is_told_and_refuses_nothing(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert read("s --key-file k", PROT="7")["port"] == (8443, "default")
    assert "THING_PROT is no option; did you mean THING_PORT?" in capsys.readouterr().err


def test_a_file_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(OptionRefused, match="cannot be read"):
        read("s --key-file k", tmp_path / "missing.yaml")


def test_settings_are_printed_as_the_file_has_them() -> None:
    _, sources = parse_options(parser(), ["s", "--key-file", "k", "--plain"], "THING_", {})
    assert settings_text(sources).splitlines() == [
        "port: 8443   # default (THING_PORT)",
        "key-file: k  # --key-file (THING_KEY_FILE)",
        "plain: true  # --plain (THING_PLAIN)",
        "proxy: []    # default (THING_PROXY)",
    ]


def test_passwords_in_addresses_are_not_printed() -> None:
    shown = settings_text(
        [
            OptionSource("database", "T_DATABASE", "postgresql://hub:s3cret@db:5432/t", "default"),
            OptionSource("cluster", "T_CLUSTER", ["nats://a:p%40ss@one", "nats://two"], "default"),
        ]
    )
    assert "postgresql://hub:***@db:5432/t" in shown
    assert "[nats://a:***@one, nats://two]" in shown


def test_a_log_of_everything_has_nothing_that_libraries_say_to_their_own_developers(
    capsys: pytest.CaptureFixture[str],
) -> None:
    root, ours = logging.getLogger(), logging.getLogger("talaia")
    before, levels = list(root.handlers), (root.level, ours.level)
    root.handlers.clear()
    try:
        set_up_log("debug", "text")
        logging.getLogger("talaia.part").debug("a turn")
        # A library of databases says each value here, also those that are nobody's to read.
        logging.getLogger("aiosqlite").debug("a value")
        logging.getLogger("aiosqlite").info("a sentence")
    finally:
        root.handlers[:] = before
        root.setLevel(levels[0])
        ours.setLevel(levels[1])
    said = capsys.readouterr().err
    assert "a turn" in said
    assert "a sentence" in said
    assert "a value" not in said


def test_a_log_of_json_has_an_object_in_each_line_and_no_secret(
    capsys: pytest.CaptureFixture[str],
) -> None:
    root = logging.getLogger()
    before, level = list(root.handlers), root.level
    root.handlers.clear()
    try:
        set_up_log("warning", "json", lambda text: text.replace("secret", "***"))
        logging.getLogger("talaia.part").info("not said")
        try:
            int("secret")
        except ValueError:
            logging.getLogger("talaia.part").exception("it holds a %s", "secret")
    finally:
        root.handlers[:] = before
        root.setLevel(level)
    (line,) = capsys.readouterr().err.splitlines()
    row = json.loads(line)
    assert (row["level"], row["logger"]) == ("error", "talaia.part")
    assert row["message"] == "it holds a ***"
    assert row["traceback"].endswith("with base 10: '***'")
    assert row["time"].endswith("Z")
