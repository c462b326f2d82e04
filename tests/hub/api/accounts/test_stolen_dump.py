"""Whoever has a dump of the database has nothing in it that signs in."""

from __future__ import annotations

import sqlite3

from ...conftest import PASSWORD
from .test_own_account import with_factor
from .test_people import may, token_of


async def test_nothing_in_a_dump_opens_a_session_a_script_a_screen_or_a_gateways_link(hub) -> None:
    admin, operator = await hub.client("admin"), await hub.client("operator")
    gateway = await hub.proven_gateway()
    place = (await gateway.hello()).resume.split(".")[2]
    totp, recovery = await with_factor(operator)
    script = await token_of(admin, may("view"))
    made = [
        (await admin.post(path, json=asked)).json()
        for path, asked in (
            ("/api/displays", {"name": "Hall", "sites": ["agv"]}),
            ("/api/audit/hubs", {"name": "Other", "keep_days": 30}),
            ("/api/gateways/codes", {"site": "agv"}),
        )
    ]
    secrets = {
        "password": [PASSWORD],
        "sessions": [client.cookies["talaia"] for client in (admin, operator)],
        "factor": [totp.secret, *recovery],
        "token": [script["token"]],
        "display and other hub": [each["token"] for each in made[:2]],
        "enrolment": [made[2]["code"], made[2]["code"].replace("-", "")],
        "gateway": [hub.keys["agv"], place],
    }
    await hub.hub.audit.log.wait_written()
    with sqlite3.connect(hub.hub.core.settings.data / "talaia.db") as database:
        dump = "\n".join(database.iterdump())
    database.close()
    # It is the whole of it, and what is kept of each thing is in it.
    assert "Hall" in dump
    assert "script" in dump
    for what, words in secrets.items():
        for word in words:
            assert len(word) >= 10, what
            assert word not in dump, what
            # As bytes it would be written in hexadecimal digits.
            assert word.encode().hex() not in dump.lower(), what
