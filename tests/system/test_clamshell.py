"""A clamshell through the real chain: ROS servers, a gateway, and no hub.

What a shell truly does is known from its encoder, which no fault of these tests touches.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from talaia.model.yaml_text.load import dump_site, load_site

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway"))
from observatory_site import as_ros1

from .conftest import need_ros1, need_ros2
from .observatory import EXAMPLE, Observatory
from .stack import until

pytestmark = pytest.mark.robot
CLAMSHELL = EXAMPLE.parents[1] / "clamshell" / "site.yaml"


@pytest.fixture(params=["ROS 2"])
def site(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Observatory]:
    # The locks of the start, and the minute between two alarms, are not waited for here.
    quick = re.sub(r"dwell: \d+", "dwell: 1", CLAMSHELL.read_text())
    ros1 = request.param == "ROS 1"
    if ros1:
        need_ros1()
        quick = dump_site(as_ros1(load_site(quick)))
    else:
        need_ros2()
    running = Observatory(tmp_path, quick, ros1=ros1, roof="clamshell")
    try:
        yield running
    finally:
        running.close()


class Began(NamedTuple):
    """From when on the simulator's ledger (monotonic, ns) and the gateway's log (lines) count."""

    ledger_ns: int
    lines: int


async def opened(site: Observatory) -> Began:
    """The gateway watches, and someone on site has opened.

    A gateway that found its robot late has closed what it does not know; so it is opened after.
    """
    await site.parts[0].says("ready")
    gateway = site.start_gateway()
    for rule in ("rain", "weather", "daylight"):
        await gateway.says(f"interlock_released  {rule}")
    await until(
        lambda: "the dome is opened" in site.client("dome_servcli", "client", "open"), what="opened"
    )
    return Began(site.ledger()[-1]["t"], len(site.note("")))


def told(site: Observatory, words: str, began: Began) -> list[str]:
    """What the gateway has said since, with these words in it."""
    return [line for line in site.note("")[began.lines :] if words in line]


async def until_told(site: Observatory, words: str, began: Began) -> None:
    await until(lambda: told(site, words, began), 120, words)


def ends(site: Observatory, device: str, what: str, began: Began) -> list[dict[str, Any]]:
    return [each for each in site.asked(device, what, began.ledger_ns) if each["phase"] != "asked"]


@pytest.mark.parametrize("site", ["ROS 2", "ROS 1"], indirect=True)
async def test_in_rain_both_shells_close_and_no_telescope_is_waited_for(site: Observatory) -> None:
    began = await opened(site)
    assert "not parked" in site.client("telescope_servcli", "client", "unpark")
    await site.cause_fault("telescope stuck")
    await site.cause_fault("weather rain")
    await until_told(site, "enclosure_closed", began)
    closed = ends(site, "dome", "close", began)[0]
    assert (closed["phase"], closed["said"]) == ("done", "the dome is closed")
    rained = site.asked("weather", "rain", began.ledger_ns)[0]["t"]
    assert (closed["t"] - rained) / 1e9 < 30
    await site.cause_fault("telescope ok")
    await until(lambda: ends(site, "telescope", "park", began), what="the telescope is asked, too")


async def test_one_shell_that_is_stuck_is_asked_again_and_told_as_not_closed(
    site: Observatory,
) -> None:
    began = await opened(site)
    await site.cause_fault("dome west stuck")
    await site.cause_fault("weather rain")
    await until_told(site, "NOT CLOSED after 3 tries", began)
    tries = ends(site, "dome", "close", began)
    assert len(tries) >= 3
    assert "stuck: west; no end switch was reached" in {each["said"] for each in tries}
    assert told(site, "enclosure_closed", began) == []
    await site.cause_fault("dome ok")
    await until_told(site, "alarm_over", began)
    assert ends(site, "dome", "close", began)[-1]["said"] == "the dome is closed"


async def test_an_end_switch_that_lies_is_a_disagreement_and_the_roof_is_asked_to_close_still(
    site: Observatory,
) -> None:
    began = await opened(site)
    await site.cause_fault("dome west lying closed")
    await site.cause_fault("weather rain")
    await until_told(site, "enclosure_disagrees", began)
    said = told(site, "enclosure_disagrees", began)[0]
    assert "West end switch: yes, West shell: 100 %" in said
    await until_told(site, "NOT CLOSED", began)
    # Its controller is content each time; the shell's encoder is not outvoted by its switches.
    tries = ends(site, "dome", "close", began)
    assert len(tries) >= 3
    assert {each["said"] for each in tries} <= {"the dome is closed", "another command came"}
    assert told(site, "enclosure_closed", began) == []
    await site.cause_fault("dome ok")
    await until_told(site, "enclosure_agrees", began)
    await until_told(site, "enclosure_closed", began)
