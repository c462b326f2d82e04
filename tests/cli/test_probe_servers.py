"""``talaia probe`` and ``init`` at a real broker and a real server, with and without TLS."""

from __future__ import annotations

import asyncio
import gc
import http.server
import json
import ssl
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

import msgspec
import pytest
from certificates import Certificates, speak_tls
from mosquitto_broker import Broker
from tests.gateway.adapters.onvif.onvif_camera import serving_camera

from talaia.cli.main import main
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

SAID = {
    "roof/weather": {"wind": {"speed_mps": 5.5, "gusts": [1, "7.5"]}, "odd key": 3, "none": None},
    "roof/rain": "dry",
    "stat/plug/POWER": "ON",
    "shed/temperature": 21.5,
    "homeassistant/sensor/a/config": {"unique_id": "a"},
}


@contextmanager
def answering(body: object, certificates: Certificates | None = None) -> Iterator[int]:
    """Answer each GET with a body, until the block ends; give the port."""

    class Server(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            data = body if isinstance(body, bytes) else json.dumps(body).encode()
            self.send_response(200)
            self.send_header("Content-Length", str(len(data)))
            self.end_headers()
            self.wfile.write(data)

        def log_message(self, *_: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Server)
    if certificates is not None:
        speak_tls(server, certificates)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield server.server_port
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


# paho leaves a socket whose handshake failed to the garbage collector.
@pytest.mark.filterwarnings("ignore:.*SSLSocket:pytest.PytestUnraisableExceptionWarning")
async def test_topics_of_a_broker_over_tls_become_a_description_that_is_sound(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    certificates = Certificates(tmp_path)
    broker = Broker(tmp_path, certificates=certificates, accounts={"probe": "a secret"})
    async with broker:
        (tmp_path / "secret").write_text("a secret\n")
        tls = ssl.create_default_context(cafile=str(certificates.ca))
        said = {"username": "probe", "password": "a secret", "tls_context": tls}
        async with broker.client(**said) as client:
            for topic, value in SAID.items():
                payload = value if isinstance(value, str) else json.dumps(value)
                await client.publish(topic, payload, qos=1, retain=True)
            await client.publish("roof/picture", b"\xff\xd8\xff", qos=1, retain=True)
        url = f"mqtts://127.0.0.1:{broker.port}"
        login = ["--mqtt", url, "--user", "probe", "--password-file", "secret"]
        words = ["init", *login, "--ca", "ca.pem", "--seconds", "1", "--site", "farm"]
        assert await asyncio.to_thread(main, words) == 0
        # Of an authority that this machine does not know, nothing is told to it.
        assert await asyncio.to_thread(main, ["probe", *login, "--seconds", "1"]) == 2
        assert "certificate verify failed" in capsys.readouterr().err
    gc.collect()
    text = (tmp_path / "site.yaml").read_text()
    site = load_site(text)
    assert not check_site(site)
    read = {
        (signal.source.topic, signal.source.path): signal
        for device in site.devices.values()
        for signal in device.signals.values()
    }
    assert set(read) == {
        ("roof/weather", "wind.speed_mps"),
        ("roof/weather", "wind.gusts[0]"),
        ("roof/weather", "wind.gusts[1]"),
        ("roof/weather", "$['odd key']"),
        ("roof/rain", ""),
        ("stat/plug/POWER", ""),
        ("shed/temperature", ""),
    }
    assert read["roof/weather", "wind.speed_mps"].unit == "m/s"
    assert read["stat/plug/POWER", ""].states == ("OFF", "ON")
    # Kept by the broker, and heard once: it holds until it is said anew.
    assert read["roof/rain", ""].max_age == 0
    assert "Home Assistant" in text
    assert "roof/picture: its message is neither JSON nor text" in text
    assert "a secret" not in text


async def test_broker_that_lets_nobody_listen_to_all_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    async with Broker(tmp_path, accounts={"probe": "a secret"}) as broker:
        words = ["probe", "--mqtt", f"127.0.0.1:{broker.port}", "--seconds", "0.5"]
        assert await asyncio.to_thread(main, words) == 2
        assert "no MQTT broker takes us" in capsys.readouterr().err


def test_fields_of_an_address_over_tls_become_a_description_that_is_sound(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    certificates = Certificates(tmp_path)
    body = {"meters": [{"voltage": "230.1"}], "on": True, "model name": "X1"}
    with answering(body, certificates) as port:
        url = f"https://127.0.0.1:{port}/api/status?units=si"
        assert main(["init", "--http", url, "--ca", "ca.pem", "--site", "farm"]) == 0
        assert main(["probe", "--http", url]) == 2
        assert "certificate verify failed" in capsys.readouterr().err
    site = load_site((tmp_path / "site.yaml").read_text())
    assert not check_site(site)
    (device,) = site.devices.values()
    sources = [(one.source.get, one.source.path, one.type.value) for one in device.signals.values()]
    get = "/api/status?units=si"
    assert sources == [
        (get, "meters[0].voltage", "number"),
        (get, "on", "state"),
        (get, "$['model name']", "text"),
    ]


def test_what_a_probe_wrote_down_is_read_on_another_machine(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with answering({"power": 1}) as port:
        assert main(["probe", "--json", "--http", f"http://127.0.0.1:{port}/a"]) == 0
    written = capsys.readouterr().out
    assert msgspec.json.decode(written)["protocol"] == "http"
    (tmp_path / "found.json").write_text(written)
    words = ["--found", str(tmp_path / "found.json"), "-o", str(tmp_path / "site.yaml")]
    assert main(["init", *words]) == 0


ODD = {
    "a page": ([b"<html>" + b"x" * 500], "a page and no JSON"),
    "no text": ([b"\xff\xfe"], "UTF-8"),
}


@pytest.mark.parametrize("case", ODD)
def test_answer_that_is_no_json_says_so(case: str, capsys: pytest.CaptureFixture[str]) -> None:
    (body,), why = ODD[case]
    with answering(body) as port:
        main(["probe", "--http", f"http://127.0.0.1:{port}/"])
    told = capsys.readouterr()
    assert why in told.out + told.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--mqtt", "http://broker"], "expected mqtts://broker.local"),
        (["--mqtt", "mqtt://broker/home"], "without a path"),
        (["--mqtt", "mqtt://me:word@broker"], "--password-file"),
        (["--http", "station.local"], "expected http://192.168.1.30/api/status"),
        (["--http", "http://[::1"], "expected http://192.168.1.30/api/status"),
        (["--user", "me"], "are for --mqtt, --http and --onvif"),
    ],
)
def test_address_that_is_none_is_told_before_anything_is_asked(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["probe", *words]) == 2
    assert said in capsys.readouterr().err


def test_a_camera_that_is_named_is_listed_and_described_with_its_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "secret").write_text("s3cret\n")
    with serving_camera() as (port, camera):
        camera.user = "operator:s3cret"
        named = ["--onvif", f"127.0.0.1:{port}", "--user", "operator", "--password-file", "secret"]
        assert main(["probe", *named, "--fields"]) == 0
        said = capsys.readouterr().out
        assert f"http://127.0.0.1:{port}/onvif/device_service" in said
        assert "rtsp://127.0.0.1/main" in said
        assert main(["init", *named, "--no-questions", "-o", "site.yaml"]) == 0
    text = (tmp_path / "site.yaml").read_text()
    site = load_site(text)
    assert not check_site(site)
    (connection,) = site.connections.values()
    assert (connection.user, connection.password_file) == ("operator", "secret")
    assert "s3cret" not in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--user", "me"], "name the camera that is signed in at"),
        (["--token-file", "x"], "is for --http and --rosbridge"),
    ],
)
def test_a_search_for_cameras_takes_no_credentials(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["probe", "--onvif", *words]) != 0
    assert said in capsys.readouterr().err
