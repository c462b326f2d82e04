"""An admin downloads a support bundle from the hub: it helps, and has no secret in it."""

from __future__ import annotations

import asyncio
import io
import zipfile
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest

# By where it stands; without a sign that would give it away.
SECRETS = {
    "key": "walrusone",
    "settings": "walrustwo",
    "description": "walrusthree",
    "environment": "walrusfour",
    "log": "walrusfive",
    "comment": "walrussix",
}
SITE = f"""\
# the key is {SECRETS["comment"]}
talaia: 1
site: agv
name: North dome
connections:
  run: {{kind: process, prefix: "domectl -k {SECRETS["description"]}"}}
devices:
  dome:
    name: Dome
    connection: run
    signals:
      wind: {{name: Wind, unit: m/s, source: {{run: wind, pattern: '([0-9.]+)'}}}}
"""


def texts_of(raw: bytes) -> dict[str, str]:
    with zipfile.ZipFile(io.BytesIO(raw)) as archive:
        return {name: archive.read(name).decode() for name in archive.namelist()}


async def test_an_admin_downloads_a_bundle_without_any_of_the_planted_secrets(
    hub, settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    (settings.data / "seal-other.key").write_text(SECRETS["key"])
    (settings.data / "hub.log").write_text(
        f"the hub listens\npassword={SECRETS['log']}\n"
        f"{SECRETS['key']} and {SECRETS['environment']}\n"
    )
    monkeypatch.setenv("TALAIA_MQTT_PASSWORD", SECRETS["environment"])
    gateway = await hub.gateway()
    await gateway.hello(SITE)
    admin = await hub.client("admin")
    answer = await admin.post("/api/support-bundle", json={})
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/zip"
    assert 'filename="talaia-support.zip"' in answer.headers["content-disposition"]
    texts = texts_of(answer.content)
    assert {"README.txt", "versions.txt", "doctor.txt", "database.txt", "site/agv.yaml"} <= set(
        texts
    )
    assert "rows of users" in texts["database.txt"]
    assert "the hub listens" in texts["logs/hub.log"]
    assert "North dome" in texts["site/agv.yaml"]
    for where, secret in SECRETS.items():
        assert not [name for name, text in texts.items() if secret in text], where
    rows = (await admin.get("/api/audit", params={"kind": "support bundle made"})).json()["rows"]
    assert len(rows) == 1


async def test_nobody_but_an_admin_gets_one(hub) -> None:
    for name in ("operator", "guest"):
        person = await hub.client(name)
        assert (await person.post("/api/support-bundle", json={})).status_code == 403


async def test_one_is_made_at_a_time(hub) -> None:
    admin = await hub.client("admin")
    answers = await asyncio.gather(*(admin.post("/api/support-bundle", json={}) for _ in range(3)))
    assert sorted(answer.status_code for answer in answers) == [200, 409, 409]
    busy = next(answer for answer in answers if answer.status_code == 409)
    assert busy.json()["code"] == "busy"
