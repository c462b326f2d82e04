"""A gateway that cannot start says why."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from talaia.gateway.program import main

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize(
    ("site", "hub", "said"),
    [
        ("talaia: 1\nsite: s\nname: S\ndevices: {d: {nam: D}}", "wss://h:1", "$.devices.d.nam"),
        ("talaia: 1\nsite: s\nname: S\ndevices: {}", "wss://h:1", "$.devices"),
        ("talaia: 1\nsite: s\nname: S\ndevices: {d: {name: D}}", "ws://h:1", "plain text"),
    ],
)
def test_what_cannot_start_says_why_and_ends_with_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], site: str, hub: str, said: str
) -> None:
    (tmp_path / "site.yaml").write_text(site)
    (tmp_path / "key").write_text("k\n")
    key = str(tmp_path / "key")
    assert main([str(tmp_path / "site.yaml"), "--hub", hub, "--key-file", key]) == 2
    error = capsys.readouterr().err
    assert error.startswith("talaia gateway: ")
    assert said in error
