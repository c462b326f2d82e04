"""Notices of transients through a whole hub: from a folder and by a token, to requests and back."""

from __future__ import annotations

import datetime as dt
import time
from pathlib import Path

import pytest

from talaia.hub.live.observing.alert_folder import REFUSED, TAKEN, AlertFolder

SITE = "observatory"
DESCRIPTION = (Path(__file__).parents[3] / "examples" / "observatory" / "site.yaml").read_text()
AT = f"/api/sites/{SITE}"
RULES = f"{AT}/proposals/BURSTS/alert-rules"
RULE = {
    "name": "bright bursts",
    "filter": {"sources": ["*SWIFT*"], "largest_error": 0.1, "least": {"Rate_Signif": 7}},
    "configurations": [{"exposure": 30.0, "count": 4}],
    "hours": 12.0,
    "priority": 15.0,
}


def notice(name: str, trigger: int, *, signif: float = 9.5, cites: str = "") -> bytes:
    """Write a VOEvent in the form of those of Swift's BAT, of a minute ago."""
    now = dt.datetime.now(dt.UTC) - dt.timedelta(minutes=1)
    return f"""<?xml version='1.0' encoding='UTF-8'?>
<voe:VOEvent ivorn='ivo://nasa.gsfc.gcn/SWIFT#{name}' role='observation' version='2.0'
 xmlns:voe='http://www.ivoa.net/xml/VOEvent/v2.0'>
 <What><Param name='TrigID' value='{trigger}'/><Param name='Rate_Signif' value='{signif}'/></What>
 <WhereWhen><ObsDataLocation><ObservationLocation><AstroCoordSystem id='UTC-FK5-GEO'/>
  <AstroCoords coord_system_id='UTC-FK5-GEO'>
   <Time unit='s'><TimeInstant><ISOTime>{now:%Y-%m-%dT%H:%M:%S}</ISOTime></TimeInstant></Time>
   <Position2D unit='deg'><Value2><C1>83.6</C1><C2>22.0</C2></Value2>
    <Error2Radius>0.05</Error2Radius></Position2D>
  </AstroCoords></ObservationLocation></ObsDataLocation></WhereWhen>
 <Citations>{cites}</Citations></voe:VOEvent>""".encode()


def retraction(name: str, trigger: int, of: str) -> bytes:
    cited = f"<EventIVORN cite='retraction'>ivo://nasa.gsfc.gcn/SWIFT#{of}</EventIVORN>"
    return notice(name, trigger, cites=cited)


@pytest.fixture
async def observatory(hub):
    """A hub with an observatory, and a proposal that the operator leads."""
    key = await hub.hub.gateways.registry.new_key(SITE)
    gateway = await hub.gateway(key=key)
    await gateway.hello(DESCRIPTION, site=SITE)
    admin = await hub.client("admin")
    asked = {"id": "BURSTS", "hours_allocated": 2.0, "urgencies": ["RAPID_RESPONSE"]}
    assert (await admin.post(f"{AT}/proposals", json=asked)).status_code == 201
    member = {"name": "operator", "role": "principal_investigator"}
    await admin.put(f"{AT}/proposals/BURSTS/members", json=member)
    return hub


async def states_of(client) -> dict[str, str]:
    rows = (await client.get(f"{AT}/requests")).json()["requests"]
    return {row["group_name"]: row["state"] for row in rows}


async def test_notices_become_requests_once_and_a_retraction_ends_them(
    observatory, tmp_path
) -> None:
    hub = observatory
    operator = await hub.client("operator")
    folder = AlertFolder(tmp_path, hub.hub.core.sites, hub.hub.alert_notices.intake)
    # Before there is a rule they are only known, for the preview.
    (tmp_path / "1.xml").write_bytes(notice("first", 1))
    (tmp_path / "2.xml").write_bytes(notice("faint", 2, signif=3.0))
    (tmp_path / "3.json").write_bytes(b"no notice")
    (tmp_path / "4.part").write_bytes(b"not yet")
    await folder.read_files()
    assert sorted(path.name for path in (tmp_path / TAKEN).iterdir()) == ["1.xml", "2.xml"]
    assert [path.name for path in (tmp_path / REFUSED).iterdir()] == ["3.json"]
    preview = await operator.post(f"{AT}/proposals/BURSTS/alert-preview", json=RULE)
    assert preview.json()["message"] == "of the last 2 notices 1 would have become requests"
    faint, first = preview.json()["notices"]
    assert (faint["passes"], faint["why"]) == (False, "Rate_Signif is 3, not at least 7")
    assert first["passes"]
    assert "place is known to 0.05°" in first["why"]
    assert await states_of(operator) == {}
    made = await operator.post(RULES, json=RULE)
    assert made.status_code == 201, made.text
    for name, words in (("5", notice("second", 5)), ("6", notice("second-again", 5))):
        (tmp_path / f"{name}.xml").write_bytes(words)
        await folder.read_files()
    assert await states_of(operator) == {"bright bursts: TrigID 5": "PENDING"}
    # The very same notice once more, and what takes the event back.
    (tmp_path / "7.xml").write_bytes(notice("second", 5))
    (tmp_path / "8.xml").write_bytes(retraction("back", 5, of="second"))
    await folder.read_files()
    assert await states_of(operator) == {"bright bursts: TrigID 5": "CANCELED"}
    (row,) = (await operator.get(f"{AT}/requests")).json()["requests"]
    log = (await operator.get(f"{AT}/requests/{row['id']}")).json()["log"]
    assert log[-1]["why"] == "its alert was retracted by ivo://nasa.gsfc.gcn/SWIFT#back"
    audited = await (await hub.client("admin")).get("/api/audit")
    kinds = {line["kind"] for line in audited.json()["rows"]}
    assert {"alert rule added", "request by alert", "alert retracted"} <= kinds


async def test_a_token_brings_notices_for_its_person_s_proposals_alone(observatory) -> None:
    hub = observatory
    operator, admin = await hub.client("operator"), await hub.client("admin")
    assert (await operator.post(RULES, json=RULE)).status_code == 201
    # By hand nobody does: a page that somebody was lured to could not either.
    by_hand = await operator.post(f"{AT}/alert-notices", json={"text": notice("mine", 7).decode()})
    assert by_hand.status_code == 403
    answers = {}
    for name, person in (("operator", operator), ("admin", admin)):
        permissions = [{"right": "request", "site": SITE, "device": "*"}]
        ends_us = time.time_ns() // 1000 + 3_600_000_000
        asked = {"name": "gcn", "ends_us": ends_us, "permissions": permissions}
        token = (await person.post("/api/me/tokens", json=asked)).json()["token"]
        program = await hub.client()
        program.headers["Authorization"] = f"Bearer {token}"
        answer = await program.post(
            f"{AT}/alert-notices", json={"text": notice("burst", 8).decode()}
        )
        assert answer.status_code == 200, answer.text
        answers[name] = (program, answer.json())
    # The admin is no member; what the operator brought was acted upon.
    assert answers["admin"][1]["outcomes"] == []
    program, said = answers["operator"]
    (outcome,) = said["outcomes"]
    assert (outcome["name"], outcome["group"] != "") == ("bright bursts", True)
    again = (
        await program.post(f"{AT}/alert-notices", json={"text": notice("burst", 8).decode()})
    ).json()
    assert (again["known"], again["outcomes"]) == (True, [])
    broken = await program.post(f"{AT}/alert-notices", json={"text": "<VOEvent/>"})
    assert broken.status_code == 422
    # What may not be asked by quota is not asked, and said.
    await admin.put(f"{AT}/proposals/BURSTS", json={"hours_allocated": 2.0})
    refused = (
        await program.post(f"{AT}/alert-notices", json={"text": notice("next", 9).decode()})
    ).json()
    assert "may not ask for RAPID_RESPONSE" in refused["outcomes"][0]["why"]
    # Who left the proposal asks for nothing more, by rules of before either.
    await admin.put(f"{AT}/proposals/BURSTS/members", json={"name": "operator"})
    gone = (
        await program.post(f"{AT}/alert-notices", json={"text": notice("last", 10).decode()})
    ).json()
    assert gone["outcomes"] == []
    assert (await operator.get(RULES)).status_code == 404
