"""Socket.IO clients for tests: three of others, of both generations, and raw requests."""

from __future__ import annotations

import asyncio
import base64
import json
import shutil
import sys
from pathlib import Path

import httpx
import socketio
from patience import PATIENCE_S
from shared_trust import usual_trust

from ..heard_events import HeardEvents
from ..tokens import open_protocol, token_of

HERE = Path(__file__).parent
MODULES = HERE.parents[3] / "web" / "package.json"


class _Heard(HeardEvents):
    """Events with their namespaces; used as a context."""

    async def __aenter__(self):
        return self


class PythonClient(_Heard):
    """PyPI's python-socketio."""

    async def connect(self, hub, query, namespaces, *, transports="default"):
        self._client = client = socketio.AsyncClient(reconnection=False, request_timeout=PATIENCE_S)
        asked = "&".join(f"{name}={value}" for name, value in query.items())
        for namespace in namespaces:
            self._register(namespace)
        options = {} if transports == "default" else {"transports": transports.split(",")}
        await client.connect(
            f"http://127.0.0.1:{hub.port}?{asked}",
            namespaces=namespaces,
            wait_timeout=PATIENCE_S,
            **options,
        )
        return self

    def _register(self, namespace) -> None:
        async def heard(event, *args) -> None:
            data = args[0] if args else None
            if isinstance(data, bytes):
                data = {"bytes": base64.b64encode(data).decode()}
            await self.note(event, namespace, data)

        self._client.on("*", heard, namespace=namespace)

        async def ended(reason) -> None:
            await self.note("disconnect", namespace, reason)

        self._client.on("disconnect", ended, namespace=namespace)

    async def say(self, namespace, event, *args) -> None:
        data = args[0] if len(args) == 1 else args or None
        await self._client.emit(event, data, namespace=namespace)

    async def ask(self, namespace, event, *args):
        data = args[0] if len(args) == 1 else args or None
        return await self._client.call(event, data, namespace=namespace, timeout=PATIENCE_S)

    async def transport(self) -> str:
        return self._client.transport()

    async def __aexit__(self, *_):
        await self._client.disconnect()


class _ProcessClient(_Heard):
    """One in a process of its own."""

    async def _start(self, *command: str):
        self._process = await asyncio.create_subprocess_exec(
            *command,
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            limit=2**24,
        )
        self._reading = asyncio.create_task(self._read())

    async def say(self, *command) -> None:
        self._process.stdin.write(json.dumps(command).encode() + b"\n")
        await self._process.stdin.drain()

    async def ask(self, *command):
        await self.say(*command, "answer")
        return await self.hear("answered")

    async def transport(self) -> str:
        await self.say("transport", "")
        return await self.hear("transport")

    async def __aexit__(self, *_):
        if self._process.returncode is None:
            await self.say("close", "")
            try:
                async with asyncio.timeout(10):
                    await self._process.wait()
            except TimeoutError:
                self._process.kill()
                await self._process.wait()
        await self._reading

    async def _read(self) -> None:
        async for line in self._process.stdout:
            await self.note(*json.loads(line))
        await self.note("gone", "", None)


class FoundingClient(_ProcessClient):
    """PyPI's socketIO-client 0.7.2, of the old generation."""

    async def connect(self, hub, query, namespaces, *, transports="default"):
        await self._start(
            sys.executable,
            "-W",
            "ignore",
            str(HERE / "founding_client.py"),
            f"http://127.0.0.1:{hub.port}",
            json.dumps(query),
            transports.replace("polling", "xhr-polling"),
            *namespaces,
        )
        await self.hear("ready")
        return self


class NodeClient(_ProcessClient):
    """npm's socket.io-client of today."""

    module = "socket.io-client"

    async def connect(self, hub, query, namespaces, *, transports="default"):
        asked = "&".join(f"{name}={value}" for name, value in query.items())
        await self._start(
            shutil.which("node"),
            str(HERE / "node_client.mjs"),
            str(MODULES),
            self.module,
            f"http://127.0.0.1:{hub.port}/?{asked}",
            transports,
            *namespaces,
        )
        for _ in namespaces:
            await self.hear("connect")
        return self


class OldNodeClient(NodeClient):
    """npm's socket.io-client 2, of the old generation."""

    module = "socket.io-client-2"


CLIENTS = [FoundingClient, OldNodeClient, PythonClient, NodeClient]


async def client_of(world, name, kind, *namespaces, transports="default", **wishes):
    """Connect as somebody, with a token of theirs."""
    await open_protocol(world.hub, "socketio")
    token = await token_of(world.hub, name)
    query = {"token": token, "site": "agv", **wishes}
    return await kind().connect(world.hub, query, list(namespaces), transports=transports)


class RawClient:
    """Polled requests that may say anything; revision 4 unless asked."""

    def __init__(self, hub, **query) -> None:
        """Ask ``hub``, with ``query`` in each address."""
        self._client = httpx.AsyncClient(
            base_url=f"http://127.0.0.1:{hub.port}",
            timeout=PATIENCE_S,
            trust_env=False,
            verify=usual_trust(),
        )
        self.query = {"EIO": "4", "transport": "polling", "site": "agv", **query}

    async def get(self, *, headers=None, **query) -> httpx.Response:
        return await self._client.get(
            "/socket.io/", params={**self.query, **query}, headers=headers or {}
        )

    async def post(self, body, **query) -> httpx.Response:
        return await self._client.post("/socket.io/", params={**self.query, **query}, content=body)

    async def connect(self):
        answer = await self.get()
        assert answer.status_code == 200, answer.text
        self.query["sid"] = json.loads(answer.text[1:])["sid"]
        return self

    async def __aenter__(self):
        return self

    async def __aexit__(self, *_):
        await self._client.aclose()
