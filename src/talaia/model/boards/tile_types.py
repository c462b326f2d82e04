"""The types of tiles that the pages have, for who writes a board by hand.

A hub takes any type in a board: it may be one of newer pages. `talaia check` and the page's editor
say what these pages would show as unknown.
"""

from __future__ import annotations

from typing import Final

__all__ = ["TILE_TYPES"]

# As in web/src/tiles/board/board-catalog.ts; a test compares them.
TILE_TYPES: Final = (
    "alarms",
    "camera",
    "cameras",
    "chart",
    "command",
    "device",
    "diagnostics",
    "dome",
    "drive",
    "extension",
    "gauge",
    "graph",
    "lifecycle",
    "log",
    "logbook",
    "parameters",
    "picture",
    "plan",
    "scene",
    "sky",
    "table",
    "text",
    "timeline",
    "topic",
    "trail",
    "value",
    "weather",
    "xy",
)
