"""A robot's own log at the hub: taken from its gateway once, and read by who may see the site."""

from __future__ import annotations

import time

from talaia.wire.frames import LogLine, RobotLogAck, RobotLogBatch

AT = "/api/sites/agv/log"


async def test_lines_are_kept_once_made_harmless_and_paged(hub, gateway) -> None:
    now_us = time.time_ns() // 1000
    lines = [
        LogLine(
            time_us=now_us - 2000, level=30, node="lidar", text="\x1b[31mred\x1b[0m \x00\u202e<b>"
        ),
        LogLine(time_us=now_us - 1000, level=40, node="pump", text="dry", file="/p.cpp", line=3),
        # Of a clock that is a day ahead.
        LogLine(time_us=now_us + 86_400_000_000, level=50, node="pump", text="late\nsecond"),
    ]
    for _ in range(2):
        await gateway.say(RobotLogBatch(boot="run", first=0, lines=lines))
        assert (await gateway.hear(RobotLogAck)).below == 3
    operator, guest = await hub.client("operator"), await hub.client("guest")
    answer = (await operator.get(AT)).json()
    assert [one["text"] for one in answer["lines"]] == [
        "late\nsecond",
        "dry",
        "red \\x00\\u202e<b>",
    ]
    assert answer["next"] is None
    assert answer["lines"][0]["time_us"] < now_us + 3_600_000_000
    page = (await operator.get(AT, params={"limit": 2})).json()
    rest = (await operator.get(AT, params={"limit": 2, "before": page["next"]})).json()
    assert [one["level"] for one in [*page["lines"], *rest["lines"]]] == [50, 40, 30]
    some = (await operator.get(AT, params={"level": 40, "text": "DRY", "node": "pump"})).json()
    assert [(one["file"], one["line"]) for one in some["lines"]] == [("/p.cpp", 3)]
    assert (await operator.get(AT + "/nodes")).json() == {"nodes": ["lidar", "pump"]}
    assert (await operator.get(AT, params={"before": "x"})).status_code == 422
    assert (await guest.get(AT)).status_code in (403, 404)
