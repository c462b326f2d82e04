"""Mosquitto on a free port of loopback, and ears for what is published there."""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import contextlib
import getpass
import json
import os
import shutil
import time

import aiomqtt
import pytest
from patience import PATIENCE_S
from ports import free_port


def mosquitto_program(name: str = "mosquitto") -> str:
    """Find a program of Mosquitto, or skip."""
    program = shutil.which(name) or shutil.which(name, path="/usr/sbin:/usr/bin")
    if program is None:
        said = f"{name} is missing (apt install mosquitto mosquitto-clients)"
        if os.environ.get("TALAIA_REQUIRE_ALL") == "1":
            pytest.fail(f"{said}, and TALAIA_REQUIRE_ALL=1")
        pytest.skip(said)
    return program


class Broker:
    """A broker that may be killed and begun anew at its port; it keeps nothing over that.

    Args:
        folder: holds its files.
        certificates: it speaks TLS by them.
        accounts: passwords by user; without them everybody is let in.
        rules: lines of its access list.
        keeps: what is retained outlives it.

    """

    def __init__(self, folder, *, certificates=None, accounts=None, rules=(), keeps=False) -> None:
        self.port = free_port()
        self._accounts = accounts or {}
        self._conf = folder / "mosquitto.conf"
        self._passwords = folder / "passwords"
        lines = [f"listener {self.port} 127.0.0.1"]
        lines += [f"allow_anonymous {'false' if self._accounts else 'true'}"]
        lines += [f"persistence {'true' if keeps else 'false'}"]
        lines += [f"persistence_location {folder}/"] if keeps else []
        if self._accounts:
            lines += [f"password_file {self._passwords}"]
        if rules:
            (folder / "acl").write_text("\n".join(rules) + "\n")
            (folder / "acl").chmod(0o600)
            lines += [f"acl_file {folder / 'acl'}"]
        lines += ["set_tcp_nodelay true"]
        # As root it would become somebody who may not read the test's folder.
        lines += [f"user {getpass.getuser()}"]
        if certificates:
            lines += [f"certfile {certificates.cert}", f"keyfile {certificates.key}"]
        self._conf.write_text("\n".join(lines) + "\n")
        self._process = None

    async def __aenter__(self) -> Broker:
        await self.start()
        return self

    async def __aexit__(self, *_exc: object) -> None:
        await self.kill()

    async def start(self) -> None:
        quiet = asyncio.subprocess.DEVNULL
        for at, (user, password) in enumerate(self._accounts.items()):
            words = ["-c"] if not at else []
            said = [*words, "-b", str(self._passwords), user, password]
            made = await asyncio.create_subprocess_exec(
                mosquitto_program("mosquitto_passwd"), *said
            )
            assert await made.wait() == 0
        program = mosquitto_program()
        self._process = await asyncio.create_subprocess_exec(
            program, "-c", str(self._conf), stdout=quiet, stderr=quiet
        )
        async with asyncio.timeout(PATIENCE_S):
            while True:
                try:
                    _, writer = await asyncio.open_connection("127.0.0.1", self.port)
                except OSError:
                    assert self._process.returncode is None, "mosquitto does not start"
                    await asyncio.sleep(0.05)
                    continue
                writer.close()
                return

    async def kill(self) -> None:
        """End it without farewell; what it was to keep may be lost."""
        await self._end(lambda process: process.kill())

    async def end(self) -> None:
        """End it as its machine does that is shut down."""
        await self._end(lambda process: process.terminate())

    async def _end(self, how) -> None:
        if self._process is not None:
            how(self._process)
            await self._process.wait()
            self._process = None

    def client(self, **options) -> aiomqtt.Client:
        return aiomqtt.Client(
            "127.0.0.1", self.port, protocol=aiomqtt.ProtocolVersion.V5, **options
        )

    @contextlib.asynccontextmanager
    async def ear(self):
        """Hear all that is published, and what is kept."""
        async with self.client() as client:
            await client.subscribe("#", qos=1)
            ear = Ear(client)
            reading = asyncio.create_task(ear.read())
            try:
                # Behind all that is kept.
                await client.publish("sync", b"", qos=1)
                await ear.until(lambda: "sync" in ear.holds)
                yield ear
            finally:
                reading.cancel()
                await asyncio.gather(reading, return_exceptions=True)


class Ear:
    """What a consumer hears: every message, and what each topic holds by now."""

    def __init__(self, client) -> None:
        self.client = client
        self.heard = []
        self.holds = {}
        self._news = asyncio.Condition()

    async def read(self) -> None:
        async for message in self.client.messages:
            async with self._news:
                topic = str(message.topic)
                self.heard.append((topic, message.payload, message.properties))
                self.holds[topic] = message.payload
                self._news.notify_all()

    async def until(self, where) -> None:
        """Wait until something is true of what was heard."""
        async with asyncio.timeout(PATIENCE_S), self._news:
            await self._news.wait_for(where)

    def topics(self) -> set[str]:
        """Name the topics that hold something."""
        return {topic for topic, payload in self.holds.items() if payload}

    def value(self, topic) -> dict:
        """Read what a topic holds; empty: nothing."""
        return json.loads(self.holds.get(topic) or "{}")

    async def answer(self, topic, phase):
        """Wait for an answer; it and those before it are taken out."""

        def found():
            return [
                at
                for at, (name, payload, _) in enumerate(self.heard)
                if name == topic and payload and json.loads(payload)["phase"] == phase
            ]

        await self.until(found)
        _, payload, properties = self.heard[found()[0]]
        del self.heard[: found()[0] + 1]
        return json.loads(payload), getattr(properties, "CorrelationData", None)


def asked_now(**more) -> str:
    return json.dumps({"time": time.time(), **more})
