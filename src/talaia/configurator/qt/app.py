"""Starts Qt, with the window of the configurator."""

from __future__ import annotations

import signal
import sys
from typing import TYPE_CHECKING

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from talaia.configurator.qt.window import ConfiguratorWindow

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.configurator.qt.window import Means

__all__ = ["make_application", "run_window"]

_LOOK_MS = 300


def make_application() -> QApplication:
    """Give the one Qt application, with the style that the colours are made for."""
    # Qt allows one application in a process; a test may have made it.
    there = QApplication.instance()
    made = there if isinstance(there, QApplication) else QApplication(sys.argv[:1])
    made.setApplicationName("talaia")
    made.setApplicationDisplayName("Talaia")
    # Wayland finds the window's icon by it.
    made.setDesktopFileName("talaia")
    # The same on every system; a native style takes only part of the style sheet.
    made.setStyle("Fusion")
    return made


def run_window(means: Means, file: Path | None) -> int:
    """Show the window until it is closed; gives the exit code."""
    qt = make_application()
    # Kept in a variable: Qt does not hold a window that Python lets go of.
    window = ConfiguratorWindow(means)
    # Where it cannot be opened the window says why, and is shown all the same.
    if file is not None:
        window.open_file(file)
    window.show()
    signal.signal(signal.SIGINT, lambda *_: window.close())
    # Qt's loop is C: Python sees Ctrl-C only when it has a turn.
    turn = QTimer(interval=_LOOK_MS)
    turn.timeout.connect(lambda: None)
    turn.start()
    return qt.exec()
