"""A window without a screen, and the means to wait for it and to answer its questions."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from patience import PATIENCE_S

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")


@pytest.fixture(scope="session")
def qt() -> Any:
    """The one Qt application; skips, or fails where nothing may be missing, without Qt."""
    try:
        from talaia.configurator.qt.app import make_application
    except ImportError as error:
        if os.environ.get("TALAIA_REQUIRE_ALL"):
            pytest.fail(f"Qt cannot be loaded: {error}")
        pytest.skip(f"Qt cannot be loaded: {error}")
    return make_application()


@pytest.fixture
def opened_pages() -> list[str]:
    """The addresses that the window had opened in a browser."""
    return []


@pytest.fixture
def make_window(qt: Any, opened_pages: list[str], tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """Makes a window, shown; what it started is ended with the test."""
    from talaia.configurator.qt.window import ConfiguratorWindow, Means

    made = []

    def make(*talaia: str) -> Any:
        means = Means(
            talaia or (sys.executable, "-m", "talaia"),
            "UTC",
            opened_pages.append,
            str(tmp_path / "data"),
        )
        window = ConfiguratorWindow(means)
        window.resize(1024, 700)
        window.show()
        window.activateWindow()
        made.append(window)
        settle(qt)
        return window

    yield make
    for window in made:
        window.finder.cancel()
        window.generate.stop_and_wait()
        window.hide()
        window.deleteLater()
    from PySide6.QtCore import QEvent

    qt.sendPostedEvents(None, QEvent.Type.DeferredDelete)


@pytest.fixture
def window(make_window: Callable[..., Any]) -> Any:
    return make_window()


def settle(qt: Any) -> None:
    """Let Qt do what is due now; layouts take several turns."""
    for _ in range(6):
        qt.sendPostedEvents()
        qt.processEvents()


def wait(
    qt: Any, condition: Callable[[], object], within: float = PATIENCE_S, what: str = ""
) -> None:
    """Let Qt run until a condition holds."""
    from PySide6.QtCore import QEventLoop

    end = time.monotonic() + within
    while not condition():
        assert time.monotonic() < end, f"not within {within:g} s: {what or condition}"
        qt.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, 50)


def answer(qt: Any, do: Callable[[Any], object]) -> None:
    """Do something with the next dialog that stands in the way, once it is shown."""
    from PySide6.QtCore import QTimer

    timer = QTimer(qt)

    def look() -> None:
        dialog = qt.activeModalWidget()
        if dialog is not None and dialog.isVisible():
            timer.stop()
            do(dialog)

    timer.timeout.connect(look)
    timer.start(10)


def choose(text: str) -> Callable[[Any], None]:
    """Press the button of that name in a question."""

    def press(dialog: Any) -> None:
        buttons = {each.text().replace("&", ""): each for each in dialog.buttons()}
        buttons[text].click()

    return press


def type_file(path: Path) -> Callable[[Any], None]:
    """Name a file in a file dialog."""

    def name(dialog: Any) -> None:
        from PySide6.QtWidgets import QLineEdit

        dialog.findChild(QLineEdit, "fileNameEdit").setText(str(path))
        dialog.accept()

    return name
