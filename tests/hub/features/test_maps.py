"""Maps of the hub: files by ranges, tile servers by an admin's word, and where each site is."""

from __future__ import annotations

import dataclasses
import http.server
import json
import threading

import pytest

from talaia.clock import SystemClock
from talaia.hub.api.maps.google_sessions import GoogleSessions, SessionRefused

from ..conftest import DESCRIPTION

NOW = 1_700_000_000_000_000
TILES = "https://tiles.example.org/{z}/{x}/{y}.png"
MAPPED = DESCRIPTION + (
    "\ngroup: North\ntags: [indoor]\nmap:\n"
    "  origin: {latitude: 41.387, longitude: 2.168}\n"
    "  zones:\n"
    "    yard:\n"
    "      name: Yard\n"
    "      kind: fence\n"
    "      geometry: {type: LineString, coordinates: [[2.168, 41.387], [2.169, 41.387]]}\n"
)


@pytest.fixture
def settings(settings, tmp_path):
    folder = tmp_path / "maps"
    folder.mkdir()
    (folder / "yard.pmtiles").write_bytes(bytes(range(256)))
    (folder / "secret.txt").write_text("not a map")
    return dataclasses.replace(settings, maps=folder)


async def test_a_file_of_the_folder_is_given_by_ranges_and_nothing_else_of_it(hub) -> None:
    guest = await hub.client("guest")
    offer = (await guest.get("/api/maps")).json()
    assert offer == {
        "files": [{"name": "yard", "url": "/api/maps/files/yard.pmtiles"}],
        "sources": [],
    }
    part = await guest.get(offer["files"][0]["url"], headers={"Range": "bytes=10-13"})
    assert (part.status_code, part.content) == (206, bytes([10, 11, 12, 13]))
    for name in ("secret.txt", "..%2Fmaps%2Fyard.pmtiles", "none.pmtiles"):
        assert (await guest.get(f"/api/maps/files/{name}")).status_code == 404
    assert (await (await hub.client()).get("/api/maps")).status_code == 401


async def test_pages_may_ask_exactly_the_hosts_that_an_admin_allowed(hub) -> None:
    admin, operator = await hub.client("admin"), await hub.client("operator")

    async def pictures() -> str:
        policy = (await admin.get("/home")).headers["content-security-policy"]
        return next(part for part in policy.split("; ") if part.startswith("img-src"))

    alone = "img-src 'self' blob: data:"
    assert await pictures() == alone
    asked = {"name": "Streets", "address": TILES, "attribution": "© Makers"}
    assert (await operator.post("/api/maps/sources", json=asked)).status_code == 403
    made = (await admin.post("/api/maps/sources", json=asked)).json()["id"]
    assert await pictures() == f"{alone} https://tiles.example.org"
    source = (await operator.get("/api/maps")).json()["sources"][0]
    assert (source["host"], source["tiles"]) == ("tiles.example.org", TILES)
    assert (await operator.delete(f"/api/maps/sources/{made}")).status_code == 403
    assert (await admin.delete(f"/api/maps/sources/{made}")).status_code == 204
    assert await pictures() == alone
    kinds = [row["kind"] for row in (await admin.get("/api/audit")).json()["rows"]]
    assert {"map source allowed", "map source removed"} <= set(kinds)


@pytest.mark.parametrize(
    "asked",
    [
        {"address": "http://tiles.example.org/{z}/{x}/{y}.png"},
        {"address": "https://tiles.example.org/{z}/{x}.png"},
        {"address": "https://tiles.example.org;script-src *{z}/{x}/{y}"},
        {"address": "https://me:secret@tiles.example.org/{z}/{x}/{y}"},
        {"address": "https://*/{z}/{x}/{y}"},
        {"address": "javascript:alert(1)//{z}{x}{y}"},
        {"address": TILES, "key": "a key"},
        {"kind": "google"},
        {"kind": "google", "key": "k", "address": TILES},
    ],
)
async def test_an_address_that_could_open_more_than_pictures_is_refused(hub, asked) -> None:
    admin = await hub.client("admin")
    answer = await admin.post("/api/maps/sources", json={"name": "Bad", **asked})
    assert answer.status_code == 422
    assert (await admin.get("/api/maps")).json()["sources"] == []


async def test_a_key_is_sealed_and_no_list_tells_it(hub) -> None:
    admin = await hub.client("admin")
    asked = {"name": "Google", "kind": "google", "key": "a-secret-key"}
    made = (await admin.post("/api/maps/sources", json=asked)).json()["id"]
    assert "a-secret-key" not in (await admin.get("/api/maps")).text
    assert await hub.hub.maps.sources.find_key(int(made)) == "a-secret-key"
    assert hub.hub.maps.sources.origins == ("https://tile.googleapis.com",)


class FakeGoogle(http.server.BaseHTTPRequestHandler):
    """Answers as the documentation of the Map Tiles API says it does."""

    asked: list[str] = []  # noqa: RUF012 - of one test

    def do_POST(self) -> None:
        type(self).asked.append(self.path)
        good = self.path.endswith("key=good")
        body = (
            {"session": "a token", "expiry": "4000000000", "tileWidth": 256}
            if good
            else {"error": {"code": 403, "message": "The key is not for this."}}
        )
        self.send_response(200 if good else 403)
        self.end_headers()
        self.wfile.write(json.dumps(body).encode())

    def log_message(self, *_: object) -> None: ...


async def test_a_session_of_a_key_is_made_once_and_a_refusal_says_why() -> None:
    FakeGoogle.asked.clear()
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), FakeGoogle) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        origin = f"http://127.0.0.1:{server.server_port}"
        sessions = GoogleSessions(SystemClock(), origin)
        first = await sessions.open_session("good")
        assert first.tiles == f"{origin}/v1/2dtiles/{{z}}/{{x}}/{{y}}?session=a%20token&key=good"
        assert await sessions.open_session("good") == first
        assert FakeGoogle.asked == ["/v1/createSession?key=good"]
        with pytest.raises(SessionRefused, match=r"403.*not for this"):
            await sessions.open_session("bad")
        server.shutdown()
        thread.join()
    with pytest.raises(SessionRefused, match="does not answer"):
        await GoogleSessions(SystemClock(), origin).open_session("good")


async def test_a_site_says_at_a_glance_how_it_is_and_where_its_robot_is(hub, history) -> None:
    gateway = await hub.gateway()
    await gateway.hello(MAPPED)
    operator, guest = await hub.client("operator"), await hub.client("guest")
    before = (await operator.get("/api/sites")).json()[0]
    assert (before["group"], before["tags"]) == ("North", ["indoor"])
    # Nothing is known of the robot: the place is the site's.
    assert (before["moving"], before["latitude"], before["battery"]) == (False, 41.387, None)
    rows = [("base/pose.x", NOW, 100.0), ("base/pose.y", NOW, 0.0), ("base/pose.yaw", NOW, 0.0)]
    await gateway.samples(*rows)
    await history.appended.wait()
    after = (await operator.get("/api/sites")).json()
    assert after[0]["moving"]
    assert after[0]["latitude"] == pytest.approx(41.387, abs=1e-6)
    # 100 m to the east at this latitude.
    assert (after[0]["longitude"] - 2.168) * 83_640 == pytest.approx(100, abs=0.2)
    assert after[0]["heading"] == pytest.approx(90)
    detail = (await operator.get("/api/sites/agv")).json()
    assert detail["map"]["zones"][0]["lines"][0]["longitudes"] == [2.168, 2.169]
    # A guest sees what is public, and not where the site is.
    for row in (await guest.get("/api/sites")).json():
        assert row["latitude"] is None
    seen = await guest.get("/api/sites/agv")
    assert seen.status_code == 404 or seen.json()["map"] is None
