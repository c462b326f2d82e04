"""Which event loop hub and gateway run on."""

from __future__ import annotations

import subprocess
import sys

from talaia.process_tuning.event_loop import new_event_loop


def test_the_faster_loop_is_taken_where_it_is_installed() -> None:
    loop = new_event_loop()
    loop.close()
    assert type(loop).__module__ == "uvloop"


def test_without_it_pythons_own_loop_does_the_same() -> None:
    code = (
        "import sys, asyncio; sys.modules['uvloop'] = None\n"
        "from talaia.process_tuning.event_loop import new_event_loop\n"
        "with asyncio.Runner(loop_factory=new_event_loop) as runner:\n"
        "    print(runner.run(asyncio.sleep(0, type(runner.get_loop()).__module__)))\n"
    )
    words = (sys.executable, "-c", code)
    said = subprocess.run(words, check=True, capture_output=True, text=True).stdout
    assert said == "asyncio.unix_events\n"
