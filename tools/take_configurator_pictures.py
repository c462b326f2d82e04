"""Take the configurator's pictures for the docs, without a screen.

.venv/bin/python tools/take_configurator_pictures.py [FOLDER]
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

os.environ["QT_QPA_PLATFORM"] = "offscreen"

from talaia.configurator.description_paths import with_value
from talaia.configurator.qt.app import make_application
from talaia.configurator.qt.palette import DARK, LIGHT
from talaia.configurator.qt.window import ConfiguratorWindow, Means

if TYPE_CHECKING:
    from PySide6.QtWidgets import QApplication

    from talaia.configurator.qt.palette import Colours
    from talaia.model.site import Site

ROOT = Path(__file__).resolve().parent.parent
SIZE = (1024, 700)
SPEED = ("devices", "base", "signals", "speed")


def main(folder: Path) -> int:
    """Write each picture; 0 when all are written."""
    qt = make_application()
    folder.mkdir(parents=True, exist_ok=True)
    window = ConfiguratorWindow(Means((sys.executable, "-m", "talaia"), "UTC", lambda _: None))
    window.resize(*SIZE)
    window.show()
    take(qt, window, LIGHT, folder / "configure-services-light.png", 0)
    window.open_file(ROOT / "examples/agv/site.yaml")
    window.show_page(1)
    window.sensors.select(SPEED)
    take(qt, window, DARK, folder / "configure-sensors-dark.png", 1)
    window.devices.select(SPEED)
    window.editor.apply("break", broken)
    window.devices.select(SPEED, ("minimum",))
    take(qt, window, DARK, folder / "configure-problems-dark.png", 3)
    return 0


def broken(site: Site) -> Site:
    """Give a description with a least value above the greatest."""
    return with_value(site, (*SPEED, "minimum"), 0.5)


def take(
    qt: QApplication, window: ConfiguratorWindow, colours: Colours, file: Path, page: int
) -> None:
    """Paint the window in these colours and write what it looks like."""
    window.steps.setCurrentRow(page)
    window.paint(colours)
    for _ in range(8):
        qt.sendPostedEvents()
        qt.processEvents()
    if not window.grab().toImage().save(str(file)):
        raise SystemExit(f"{file} cannot be written")


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "pictures"))
