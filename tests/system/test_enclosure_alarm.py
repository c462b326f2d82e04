"""A roof that does not close in the rain: people get mail, from the gateway and from the hub.

All of it is real: the simulated observatory, the gateway, the hub and a mail server.
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import pytest
from msgspec.structs import replace
from ports import free_port
from shared_trust import usual_trust

from talaia.hub import accounts
from talaia.hub.settings import Settings
from talaia.model.alarms.alarm import Alarm, AlarmKind, Escalation, Severity
from talaia.model.interlocks.enclosure import ClosingOrder
from talaia.model.yaml_text.load import dump_site, load_site

from .conftest import need_ros2
from .mail_server import Mailbox, mail_server
from .observatory import EXAMPLE, Observatory
from .stack import PASSWORD, Process, until

pytestmark = pytest.mark.robot
SITE = "observatory"
NOTICES = """\
after = 1
repeat = 600
[[mail]]
server = "127.0.0.1"
port = {port}
security = "none"
sender = "roof@example.org"
to = ["guard@example.org"]
"""


@pytest.fixture
async def mailbox() -> AsyncIterator[Mailbox]:
    async with mail_server() as mailbox:
        yield mailbox


def described() -> str:
    """Give the example with short times, and two people who are told of its roof in turn."""
    site = load_site(EXAMPLE.read_text())
    roof = replace(
        site.enclosures["dome"],
        order=ClosingOrder.PARALLEL, retries=1, move_within=2.0, alarm_every=6.0,
    )  # fmt: skip
    rules = {
        name: replace(rule, dwell=1.0, when=tuple(replace(each, dwell=None) for each in rule.when))
        for name, rule in site.interlocks.items()
    }
    alarm = Alarm(
        name="Roof NOT CLOSED", kind=AlarmKind.ENCLOSURE, severity=Severity.CRITICAL, repeat=10.0,
        escalate=(Escalation(who="anna"), Escalation(who="ben", after=3.0)),
    )  # fmt: skip
    return dump_site(
        replace(site, interlocks=rules, enclosures={"dome": roof}, alarms={"roof": alarm})
    )


async def sign_in(address: str, name: str) -> httpx.AsyncClient:
    client = httpx.AsyncClient(
        base_url=address, headers={"Origin": address}, timeout=60, verify=usual_trust()
    )
    (await client.post("/api/login", json={"name": name, "password": PASSWORD})).raise_for_status()
    return client


async def want_mail(address: str, port: int) -> httpx.AsyncClient:
    """Have both told by mail; give the session of the first."""
    admin, anna, ben = [await sign_in(address, who) for who in ("admin", "anna", "ben")]
    way = {
        "name": "Mail", "kind": "mail", "host": "127.0.0.1", "port": port, "security": "none",
        "sender": "talaia@example.org",
    }  # fmt: skip
    made = await admin.post("/api/ways", json=way)
    assert made.status_code == 201, made.text
    for client, who in ((anna, "anna"), (ben, "ben")):
        rule = {"site": SITE, "way": made.json()["id"], "target": f"{who}@example.org"}
        added = await client.post("/api/me/rules", json={**rule, "group_s": 0, "over": True})
        assert added.status_code == 201, added.text
    await admin.aclose()
    await ben.aclose()
    return anna


async def test_a_roof_that_does_not_close_reaches_people_with_and_without_the_hub(
    tmp_path: Path, mailbox: Mailbox
) -> None:
    need_ros2()
    port = free_port()
    address = f"http://localhost:{port}"
    (tmp_path / "notices.toml").write_text(NOTICES.format(port=mailbox.port))
    settings = Settings(
        data=tmp_path / "hub", host="127.0.0.1", port=port, plain=True, password_cost=4
    )
    for name, role in (("admin", "admin"), ("anna", "operator"), ("ben", "operator")):
        await accounts.create_user(settings, name, PASSWORD, role)
    key = await accounts.create_gateway(settings, SITE)
    site = Observatory(tmp_path, described())
    (tmp_path / "key").write_text(key)
    words = ["-m", "talaia", "hub", "--data", str(tmp_path / "hub"), "--plain"]
    words += ["--host", "127.0.0.1", "--port", str(port), "--notify-network", "127.0.0.0/8"]
    try:
        # What they want to be told stands before the alarm: it counts from its first moment.
        hub = Process(words, tmp_path / "hub.log", {})
        site.parts.append(hub)
        await hub.says("ready")
        anna = await want_mail(address, mailbox.port)
        hub.end()
        await site.parts[0].says("ready")
        assert "the dome is opened" in site.client("dome_servcli", "client", "open")
        gateway = site.start_gateway(
            "--hub", f"ws://127.0.0.1:{port}", "--notices", str(tmp_path / "notices.toml")
        )
        await site.cause_fault("dome stuck")
        await site.cause_fault("weather rain")
        # There is no hub: the gateway itself tells people.
        await until(lambda: mailbox.to("guard"), what="the gateway's own notice")
        assert site.note("NOT CLOSED")
        hub = Process(words, tmp_path / "hub.log", {})
        site.parts.append(hub)
        await hub.says("ready")
        await gateway.says("linked to")
        # The first person is told, and, as nobody acknowledges it, the second.
        await until(lambda: mailbox.to("anna"), what="a mail to the first person")
        assert "Roof NOT CLOSED (critical)" in mailbox.to("anna")[0]
        await until(lambda: mailbox.to("ben"), what="a mail to the second person")
        assert next(mail.to for mail in mailbox.mails if mail.to != "guard") == "anna"
        acted = await anna.post(f"/api/sites/{SITE}/alarms/roof/act", json={"act": "acknowledge"})
        assert acted.status_code == 204, acted.text
        # It still stands, for longer than the next repeat would have taken: nobody is told.
        before, times = len(mailbox.mails), len(site.note("NOT CLOSED"))
        await until(lambda: len(site.note("NOT CLOSED")) >= times + 3, what="it goes on")
        # One that was on its way may still have come.
        assert len(mailbox.mails) <= before + 1, mailbox.mails
        await site.cause_fault("dome ok")
        await until(lambda: site.note("alarm_over"), what="the roof is closed")
        await until(lambda: any("over" in each for each in mailbox.to("anna")), what="its end")
        # While the hub was there the gateway was silent.
        assert len(mailbox.to("guard")) == 1
        await anna.aclose()
    finally:
        site.close()
