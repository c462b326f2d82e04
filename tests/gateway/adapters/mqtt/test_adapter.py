"""The MQTT adapter with a real broker (Mosquitto), and its own clients as devices."""

from __future__ import annotations

import asyncio
import gc
import ssl
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import TYPE_CHECKING, Any

import aiomqtt
import pytest
from certificates import Certificates
from fake_hub import FakeHub, fake_hub
from gateway_bench import addresses_of, running
from mosquitto_broker import Broker, mosquitto_program

from talaia.wire.frames import DeviceState, Event, InterlockState

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

SITE = """
talaia: 1
site: test
name: Test
connections:
  broker: {kind: mqtt, url: "mqtt://127.0.0.1:PORT", user: gateway, password_file: secret}
devices:
  roof:
    name: Roof
    signals:
      wind:
        {name: Wind, unit: m/s, scale: 0.1, source: {topic: roof/weather, path: wind.speed}}
      gust: {name: Gust, unit: m/s, source: {topic: roof/weather, path: "$.wind.gusts[1]"}}
      rain: {name: Rain, type: state, states: [dry, wet], source: {topic: roof/rain}}
      said: {name: Said, type: text, max_age: 0, source: {topic: roof/said}}
      twice: {name: T, unit: m/s, source: {expression: "{roof/wind} * 2"}}
interlocks:
  wet:
    name: Rain
    when: [{signal: roof/rain, is: [wet], max_age: 60}]
    refuse: ["roof/*"]
"""
SECRET, WRONG = "a secret", "quite another"


class Devices(Broker):
    """A broker with a password for the gateway, and devices of another make that publish there."""

    def __init__(self, folder: Path, **more: Any) -> None:  # noqa: D107
        super().__init__(folder, accounts={"gateway": SECRET}, keeps=True, **more)

    async def publish(self, topic: str, said: str, *more: str) -> None:
        words = ["-h", "127.0.0.1", "-p", str(self.port), "-u", "gateway", "-P", SECRET]
        sent = await asyncio.create_subprocess_exec(
            mosquitto_program("mosquitto_pub"), *words, "-q", "1", "-t", topic, "-m", said, *more
        )
        assert await sent.wait() == 0

    def client(self, **more: Any) -> AbstractAsyncContextManager[Any]:
        return aiomqtt.Client("127.0.0.1", self.port, username="gateway", password=SECRET, **more)


@pytest.fixture
async def broker(tmp_path: Path) -> AsyncIterator[Devices]:
    one = Devices(tmp_path)
    await one.start()
    yield one
    await one.end()


@asynccontextmanager
async def reading(
    broker: Devices, tmp_path: Path, text: str = SITE, secret: str = SECRET
) -> AsyncIterator[FakeHub]:
    (tmp_path / "secret").write_text(secret + "\n")
    text = text.replace("PORT", str(broker.port)).replace(": secret", f": {tmp_path / 'secret'}")
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", text):
        await hub.until(lambda: hub.hellos, "a hello")
        yield hub


async def test_topics_become_signals_and_a_broker_that_vanishes_is_told(
    broker: Devices, tmp_path: Path
) -> None:
    await broker.publish("roof/said", "kept by the broker", "-r")
    await broker.publish("roof/rain", "dry", "-r")
    async with reading(broker, tmp_path) as hub:
        await hub.until(lambda: hub.values("roof/said"), "what the broker kept")
        await hub.until(lambda: hub.values("roof/rain"), "a state that it kept")
        weather = '{"wind": {"speed": 52, "gusts": [1, "7.5"]}}'
        await broker.publish("roof/weather", weather)
        await hub.until(lambda: hub.values("roof/twice"), "what is worked out of it")
        assert hub.values("roof/wind") == [5.2]
        assert hub.values("roof/gust") == [7.5]
        assert hub.values("roof/twice") == [10.4]
        # Nobody knows when "dry" was said: no interlock has gone by it in all this time.
        assert all(state.unknown for state in hub.of(InterlockState))
        await broker.publish("roof/rain", "dry")
        await hub.next(InterlockState, lambda state: not state.unknown)
        # Of a message that is half broken the other half is read, and the rest told once.
        await broker.publish("roof/weather", '{"wind": {"speed": 10, "gusts": []}}')
        await broker.publish("roof/weather", "<html>")
        await hub.until(lambda: len(hub.values("roof/wind")) == 2, "the half that is right")
        said = await hub.next(Event, lambda event: event.kind == "unreadable")
        assert "roof/gust: roof/weather: field '$.wind.gusts[1]': is not in" in said.message

        await broker.end()
        lost = await hub.next(DeviceState, lambda state: state.device == "roof")
        assert not lost.reached
        assert "MQTT broker" in lost.why
        await broker.start()
        await hub.next(DeviceState, lambda state: state.device == "roof" and state.reached)
        await broker.publish("roof/said", "again")
        await hub.until(lambda: hub.values("roof/said")[-1] == "again", "a message after it")
        assert hub.values("roof/said") == ["kept by the broker", "again"]


async def test_wrong_password_is_told_and_never_shown(broker: Devices, tmp_path: Path) -> None:
    async with reading(broker, tmp_path, secret=WRONG) as hub:
        lost = await hub.next(DeviceState, lambda state: state.device == "roof")
        assert "takes us" in lost.why
        assert WRONG not in lost.why


# paho leaves a socket whose handshake failed to the garbage collector.
@pytest.mark.filterwarnings("ignore:.*SSLSocket:pytest.PytestUnraisableExceptionWarning")
async def test_broker_with_tls_is_read_and_one_of_another_authority_is_told_and_not(
    tmp_path: Path,
) -> None:
    certificates = Certificates(tmp_path)
    async with Devices(tmp_path, certificates=certificates) as broker:
        tls = ssl.create_default_context(cafile=str(certificates.ca))
        trusting = SITE.replace("mqtt://", "mqtts://").replace(
            "user: gateway,", f"user: gateway, ca: {certificates.ca},"
        )
        async with reading(broker, tmp_path, trusting) as hub:
            async with broker.client(tls_context=tls) as device:
                await device.publish("roof/said", "over TLS", retain=True)
            await hub.until(lambda: hub.values("roof/said") == ["over TLS"], "a value")
        more = tmp_path / "more"
        more.mkdir()
        async with reading(broker, more, SITE.replace("mqtt://", "mqtts://")) as hub:
            lost = await hub.next(DeviceState, lambda state: state.device == "roof")
            assert not lost.reached
            assert "certificate verify failed" in lost.why
            assert not hub.values("roof/said")
    gc.collect()


async def test_a_thousand_topics_are_all_heard(broker: Devices, tmp_path: Path) -> None:
    many = 1000
    lines = "".join(
        f"      s{n}: {{name: S, source: {{topic: plant/{n}/state, path: value}}}}\n"
        for n in range(many)
    )
    head = SITE.split("interlocks:")[0]
    async with reading(broker, tmp_path, head + lines) as hub:
        async with broker.client() as device:
            # Kept, so that it does not matter who is first.
            for n in range(many):
                await device.publish(f"plant/{n}/state", f'{{"value": {n}}}', retain=True)

        def heard() -> set[str]:
            return {name for rows in hub.samples.values() for name, _, _ in rows.values()}

        await hub.until(lambda: len(heard()) == many, "all of them")
        assert hub.values(f"roof/s{many - 1}") == [many - 1]
