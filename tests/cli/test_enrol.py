"""``talaia enrol``: a key file for a gateway, made beside the hub."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from talaia.cli.enrol import main
from talaia.gateway.errors import SettingsError
from talaia.gateway.key_file import read_key_file

if TYPE_CHECKING:
    from pathlib import Path


def enrol(folder: Path, hub: str, *more: str) -> int:
    return main(
        ["agv", "--data", str(folder), "--to", str(folder / "agv.key"), "--hub", hub, *more]
    )


def test_an_address_in_plain_text_is_taken_with_the_option_that_its_error_names(
    tmp_path: Path,
) -> None:
    with pytest.raises(SettingsError, match="--allow-plain on loopback"):
        enrol(tmp_path, "ws://127.0.0.1:8080")
    assert enrol(tmp_path, "ws://127.0.0.1:8080", "--allow-plain") == 0
    kept = read_key_file(tmp_path / "agv.key")
    # There is no certificate to know such a hub by.
    assert (kept.hub, kept.fingerprint) == ("ws://127.0.0.1:8080", "")


def test_plain_text_to_another_machine_is_refused_whatever_is_asked(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="for loopback only"):
        enrol(tmp_path, "ws://192.0.2.1:8080", "--allow-plain")
    assert not (tmp_path / "agv.key").exists()
