"""An INDI driver whose stamps stand still once a file is there; its values go on arriving.

old_station.py FILE is written as a program of its own by the test, for indiserver takes no words.
"""

from __future__ import annotations

import sys
import threading
import time
from datetime import UTC, datetime
from pathlib import Path

NAME = 'device="Station"'
CONNECTION = (
    f'<defSwitchVector {NAME} name="CONNECTION" label="C" group="Main" state="Ok" perm="rw"'
    ' rule="OneOfMany" timeout="60"><defSwitch name="CONNECT" label="C">On</defSwitch>'
    '<defSwitch name="DISCONNECT" label="D">Off</defSwitch></defSwitchVector>'
)


def vector(kind: str, wind: float, stamp: str) -> str:
    more = ' label="W" group="Main" perm="ro" timeout="60"' if kind == "def" else ""
    limits = ' label="W" format="%.1f" min="0" max="100" step="0"' if kind == "def" else ""
    one = "defNumber" if kind == "def" else "oneNumber"
    return (
        f'<{kind}NumberVector {NAME} name="WEATHER_PARAMETERS" state="Ok"'
        f' timestamp="{stamp}"{more}>'
        f'<{one} name="WEATHER_WIND_SPEED"{limits}>{wind}</{one}></{kind}NumberVector>'
    )


def say(xml: str) -> None:
    sys.stdout.write(f"{xml}\n")
    sys.stdout.flush()


def run(stands: Path) -> None:
    asked = threading.Event()

    def listen() -> None:
        for line in sys.stdin:
            if "getProperties" in line:
                say(CONNECTION + vector("def", 10.0, stamp))
                asked.set()

    stamp, wind = "", 10.0
    threading.Thread(target=listen, daemon=True).start()
    while True:
        if not stands.exists():
            stamp = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S.%f")[:-3]
        if asked.is_set():
            wind = 11.0 if wind == 10.0 else 10.0
            say(vector("set", wind, stamp))
        time.sleep(0.2)
