"""A roof that is moved and read by plain commands, and keeps a ledger of what it was asked.

    python command_roof.py FOLDER status|open|close

It moves while nobody looks: where it stands follows from the last order and the time since.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

# From closed to open (s).
TRAVEL_S = 1.0


def position(folder: Path) -> float:
    """Give how far the roof is open now (0 to 1)."""
    file = folder / "roof.json"
    if not file.exists():
        return 0.0
    order = json.loads(file.read_text())
    way = (time.monotonic_ns() - order["t"]) / 1e9 / TRAVEL_S
    start, end = order["start"], order["end"]
    return max(end, start - way) if end < start else min(end, start + way)


def main(place: str, asked: str) -> None:
    """Do what is asked, and print how it stands as the founding clients do."""
    folder = Path(place)
    now = position(folder)
    if asked != "status":
        if (folder / "roof stuck").exists():
            sys.exit("the motor does not turn")
        order = {"t": time.monotonic_ns(), "start": now, "end": float(asked == "open")}
        with (folder / "ledger.jsonl").open("a") as ledger:
            ledger.write(json.dumps({**order, "asked": asked}) + "\n")
        beside = folder / "roof.new"
        beside.write_text(json.dumps(order))
        beside.replace(folder / "roof.json")
    sys.stdout.write({0.0: "closed", 1.0: "opened"}.get(now, "moving") + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
