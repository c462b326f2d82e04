"""The HTTP adapter with another's server (Python's own), that misbehaves in many ways."""

from __future__ import annotations

import asyncio
import http.server
import json
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, ClassVar

import pytest
from certificates import Certificates, speak_tls
from fake_hub import fake_hub
from gateway_bench import addresses_of, running
from patience import PATIENCE_S

from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.gateway.adapters.http.fetching import (
    MAX_ANSWER,
    FetchFailed,
    HttpQuestion,
    HttpServer,
)
from talaia.gateway.change_policy import forbidden_changes
from talaia.model.yaml_text.load import load_site
from talaia.wire.frames import DeviceState, Event

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

SITE = """
talaia: 1
site: test
name: Test
connections:
  station:
    {kind: http, url: "http://127.0.0.1:PORT/api", poll: 0.1, timeout: 5, here: true,
     token_file: secret}
devices:
  roof:
    name: Roof
    signals:
      wind: {name: Wind, unit: m/s, source: {get: "/weather?units=si", path: wind.speed}}
      word: {name: Word, type: text, source: {get: /word}}
  other:
    name: Other
    signals:
      odd: {name: Odd, source: {get: /absent, path: a}}
"""


class Station(http.server.BaseHTTPRequestHandler):
    """Answers what a test has put there: a body, or a status and a body."""

    bodies: ClassVar[dict[str, bytes]] = {}
    asked: ClassVar[list[tuple[str, str]]] = []
    begun: ClassVar[threading.Event] = threading.Event()
    # Never set: who waits for it is held until the server ends.
    ended: ClassVar[threading.Event] = threading.Event()

    def do_GET(self) -> None:
        self.asked.append((self.path, self.headers.get("Authorization", "")))
        body = self.bodies.get(self.path)
        if self.path == "/elsewhere":
            self.send_response(302)
            self.send_header("Location", "http://169.254.169.254/")
            self.end_headers()
        elif self.path == "/slow":
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"1")
            self.wfile.flush()
            self.begun.set()
            self.ended.wait()
        elif self.path == "/short":
            self.send_response(200)
            self.send_header("Content-Length", "100")
            self.end_headers()
            self.wfile.write(b"21")
        elif body is None:
            self.send_error(404)
        else:
            self.send_response(200)
            self.end_headers()
            self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def station() -> Iterator[int]:
    """A server's port."""
    with serving_station() as (port, _):
        yield port


@contextmanager
def serving_station() -> Iterator[tuple[int, http.server.ThreadingHTTPServer]]:
    Station.bodies, Station.asked, Station.ended = {}, [], threading.Event()
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Station) as server:
        server.daemon_threads = True
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server.server_address[1], server
        Station.ended.set()
        server.shutdown()
        thread.join()


async def test_answers_become_signals_and_what_fails_is_told(station: int, tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("a token\n")
    text = SITE.replace("PORT", str(station)).replace(": secret", f": {tmp_path / 'secret'}")
    Station.bodies["/api/weather?units=si"] = json.dumps({"wind": {"speed": 5.25}}).encode()
    Station.bodies["/api/word"] = b"sunny"
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", text):
        await hub.until(lambda: hub.values("roof/wind") and hub.values("roof/word"), "values")
        assert (hub.values("roof/wind")[0], hub.values("roof/word")[0]) == (5.25, "sunny")
        assert ("/api/weather?units=si", "Bearer a token") in Station.asked
        away = await hub.next(DeviceState, lambda state: state.device == "other")
        assert not away.reached
        assert "status 404" in away.why
        # One of two good addresses is enough; what cannot be read is told once.
        Station.bodies["/api/weather?units=si"] = b"<html>Please log in</html>"
        said = await hub.next(Event, lambda event: event.kind == "unreadable")
        assert "roof/wind: /weather?units=si: field '$.wind.speed': it is not JSON" in said.message
        del Station.bodies["/api/word"]
        lost = await hub.next(DeviceState, lambda state: state.device == "roof")
        assert not lost.reached
        Station.bodies["/api/word"] = b"rainy"
        await hub.next(DeviceState, lambda state: state.device == "roof" and state.reached)
        await hub.until(lambda: hub.values("roof/word")[-1] == "rainy", "the word after it")


async def test_server_with_tls_is_read_and_one_of_another_authority_is_told_and_not(
    tmp_path: Path,
) -> None:
    certificates = Certificates(tmp_path)
    (tmp_path / "secret").write_text("a token\n")
    with serving_station() as (port, server):
        speak_tls(server, certificates)
        Station.bodies["/api/word"] = b"over TLS"
        text = SITE.replace("http://", "https://").replace("PORT", str(port))
        text = text.replace(": secret", f": {tmp_path / 'secret'}")
        trusting = text.replace("here: true,", f"here: true, ca: {certificates.ca},")
        async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", trusting):
            await hub.until(lambda: hub.values("roof/word"), "a value")
            assert hub.values("roof/word")[0] == "over TLS"
        # What the first asked last may still come; the second has another token.
        (tmp_path / "other").write_text("another token\n")
        text = text.replace(str(tmp_path / "secret"), str(tmp_path / "other"))
        async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "more", text):
            lost = await hub.next(DeviceState, lambda state: state.device == "roof")
            assert not lost.reached
            assert "certificate verify failed" in lost.why
        # Nor was it told the token.
        assert {token for _, token in Station.asked} == {"Bearer a token"}


@pytest.mark.parametrize(
    ("get", "said"),
    [
        ("/elsewhere", "it sends us elsewhere (302), which is not followed"),
        ("/short", "its answer ends before its stated length"),
        ("/absent", "it answers with the status 404"),
        ("/huge", f"its answer is longer than {MAX_ANSWER // 1024} KiB"),
    ],
)
def test_answer_that_cannot_be_used_is_refused(station: int, get: str, said: str) -> None:
    Station.bodies["/huge"] = b"1" * (MAX_ANSWER + 1)
    server = HttpServer(f"http://127.0.0.1:{station}", {}, None, 60.0, here=True)
    with pytest.raises(FetchFailed) as raised:
        HttpQuestion(server, get).fetch_answer()
    assert said in str(raised.value)


async def test_server_that_sends_byte_by_byte_is_cut_off_in_time(station: int) -> None:
    server = HttpServer(f"http://127.0.0.1:{station}", {}, None, 60.0, here=True)
    question = HttpQuestion(server, "/slow")
    asking = asyncio.get_running_loop().run_in_executor(None, question.fetch_answer)
    assert await asyncio.to_thread(Station.begun.wait, PATIENCE_S)
    question.cut_off()
    with pytest.raises(FetchFailed, match="not answered whole within 60 s"):
        await asking


def test_name_of_this_computer_is_not_asked_unless_that_is_meant(station: int) -> None:
    server = HttpServer(f"http://localhost:{station}", {}, None, 60.0, here=False)
    with pytest.raises(FetchFailed, match=r"localhost is not asked: it is .*this computer itself"):
        HttpQuestion(server, "/word").fetch_answer()
    assert Station.asked == []


def test_hub_changes_neither_what_is_asked_nor_which_server() -> None:
    before = load_site(SITE)
    for old, new in (("/word", "/relay?turn=on"), ("127.0.0.1", "10.0.0.1")):
        after = load_site(SITE.replace(old, new))
        assert forbidden_changes(before, after, AcceptedChanges.ALL)
    other_path = load_site(SITE.replace("wind.speed", "wind.gust"))
    assert not forbidden_changes(before, other_path, AcceptedChanges.READINGS)
