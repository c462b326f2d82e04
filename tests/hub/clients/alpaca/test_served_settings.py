"""The file that says where the hub answers Alpaca's clients."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from talaia.hub.clients.alpaca.served_settings import read_alpaca_serving
from talaia.hub.errors import CannotStart

if TYPE_CHECKING:
    from pathlib import Path

GOOD = "address: 192.0.2.7\nsite: roof\ntoken_file: token\ncommands: [dome/*]\n"


def test_a_file_names_address_site_token_and_commands(tmp_path: Path) -> None:
    (tmp_path / "alpaca.yaml").write_text(GOOD)
    read = read_alpaca_serving(tmp_path / "alpaca.yaml")
    assert (read.address, read.port, read.site) == ("192.0.2.7", 11_111, "roof")
    assert read.token_file == str(tmp_path / "token")
    assert read.has_command("dome/open")
    assert not read.has_command("telescope/park")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (GOOD.replace("192.0.2.7", "0.0.0.0"), "no single address"),  # noqa: S104 - refused
        (GOOD.replace("192.0.2.7", "'::'"), "no single address"),
        (GOOD.replace("192.0.2.7", "roof.local"), "expected an IP address"),
        (GOOD.replace("site: roof\n", ""), "site"),
        (GOOD + "password: x\n", "password"),
        ("[", "while parsing"),
    ],
)
def test_a_file_that_says_no_address_is_refused(tmp_path: Path, text: str, why: str) -> None:
    (tmp_path / "alpaca.yaml").write_text(text)
    with pytest.raises(CannotStart, match=why):
        read_alpaca_serving(tmp_path / "alpaca.yaml")


def test_without_commands_there_are_reads_only(tmp_path: Path) -> None:
    (tmp_path / "alpaca.yaml").write_text(GOOD.replace("commands: [dome/*]\n", ""))
    assert not read_alpaca_serving(tmp_path / "alpaca.yaml").has_command("dome/close")
