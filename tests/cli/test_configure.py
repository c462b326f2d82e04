"""``talaia configure`` where its window cannot be shown: what to install, or what is missing."""

from __future__ import annotations

import sys

import pytest

from talaia.cli.main import main


def test_without_qt_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [each for each in sys.modules if each.startswith("talaia.configurator.qt")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "PySide6", None)
    monkeypatch.setitem(sys.modules, "PySide6.QtCore", None)
    assert main(["configure"]) == 2
    assert "pip install 'talaia[configurator]'" in capsys.readouterr().err


def test_a_file_that_is_not_there_is_told_before_any_window(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["configure", "nowhere.yaml"]) == 2
    assert "nowhere.yaml: there is no such file" in capsys.readouterr().err
