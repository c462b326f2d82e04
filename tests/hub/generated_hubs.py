"""What `talaia generate --hubs 3` writes, really started: only ports, folders and addresses differ.

NATS, HAProxy and the hubs are this machine's own programs; each is called with the words that the
compose file has for its container.
"""

# ruff: noqa: D107
from __future__ import annotations

import asyncio
import re
import ssl
from contextlib import AsyncExitStack
from pathlib import Path

import httpx
import websockets
import yaml
from async_program import start_program
from patience import PATIENCE_S, until_answered
from ports import free_port
from server_programs import server_or_skip

from talaia.cli.main import main
from talaia.wire.browser import FROM_BROWSER, TO_BROWSER

from .conftest import Peer
from .several_hubs import ADA

# From here the balancer dials, so that whoever asks a hub by itself is not taken for one.
BALANCER = "127.0.0.2"


def any_certificate() -> ssl.SSLContext:
    """Trust whoever answers, as a person does who compares the fingerprint."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    return context


class GeneratedHubs:
    """Hubs, NATS and HAProxy of a generated folder."""

    def __init__(self, folder: Path, description: Path, url: str, history_url: str) -> None:
        self.folder = folder / "deployment"
        words = ["generate", str(description), "--to", str(self.folder), "--hubs", "3"]
        words += ["--history-servers", "1"]
        assert main([*words, "--allow-host", "hub.example"]) == 0
        compose = yaml.safe_load((self.folder / "compose.yaml").read_text())
        self.services = compose["services"]
        self.names = [name for name in self.services if name.startswith("hub-")]
        # The volume that all hubs have.
        self.data = folder / "hub-data"
        self.ports = {name: free_port() for name in (*self.names, "nats", "haproxy")}
        self.port = self.ports["haproxy"]
        self.origin = f"https://127.0.0.1:{self.port}"
        self.programs = {}
        self.said = {name: [] for name in self.names}
        self.cookie = ""
        self._reading = []
        self._stack = AsyncExitStack()
        self._rewrite("secrets/database_url", ("", url))
        history = self.folder / "secrets/history_servers.yaml"
        history.write_text(re.sub(r'"postgresql://[^"]*"', f'"{history_url}"', history.read_text()))
        self._rewrite("secrets/cluster_url", ("@nats:4222", f"@localhost:{self.ports['nats']}"))

    async def __aenter__(self) -> GeneratedHubs:
        await self.start_servers()
        await self.start_hub(self.names[0])
        await self.until_says(self.names[0], "talaia hub leads")
        await asyncio.gather(*map(self.start_hub, self.names[1:]))
        await asyncio.gather(*map(self.until_ready, self.names))
        await until_answered(lambda: self.is_ready(self.port))
        return self

    async def __aexit__(self, *_exc: object) -> None:
        await self._stack.aclose()
        for program in self.programs.values():
            if program.returncode is None:
                program.terminate()
        await asyncio.gather(*(program.wait() for program in self.programs.values()))
        await asyncio.gather(*self._reading)

    async def start_servers(self) -> None:
        """Start NATS and HAProxy."""
        nats = ("0.0.0.0:4222", f"127.0.0.1:{self.ports['nats']}")
        state = ("127.0.0.1:8222", f"127.0.0.1:{free_port()}")
        self._rewrite("secrets/nats.conf", nats, state, ("/run/secrets", f"{self.folder}/secrets"))
        words = self._own_words("nats", self.services["nats"]["command"])
        await self._start_other("nats", server_or_skip("nats-server"), *words)
        dialled = [(f"hub-{at}:8443", f"127.0.0.1:{self.ports[f'hub-{at}']}") for at in (1, 2, 3)]
        self._rewrite(
            "haproxy.cfg",
            ("bind :8443", f"bind 127.0.0.1:{self.port}"),
            ("127.0.0.1:8404", f"127.0.0.1:{free_port()}"),
            ("default-server check", f"default-server source {BALANCER} check"),
            *dialled,
        )
        config = str(self.folder / "haproxy.cfg")
        await self._start_other("haproxy", server_or_skip("haproxy"), "-db", "-f", config)

    async def start_hub(self, name: str) -> None:
        """Start a hub as the compose file has it."""
        words = self._own_words(name, self.services[name]["command"])
        # Docker's networks; none of them is loopback.
        words += ["--proxy-protocol", BALANCER]
        environment = self.services[name]["environment"]
        program = await start_program(
            *("-m", "talaia", *words),
            **{key: self._own_text(name, value) for key, value in environment.items()},
        )
        self.programs[name], self.said[name] = program, []
        self._reading.append(asyncio.create_task(self._read(name, program)))
        await self.until_says(name, "talaia hub is ready")

    async def end_hub(self, name: str, number: int) -> int:
        """End a hub by a signal; give its exit code."""
        self.programs[name].send_signal(number)
        return await asyncio.wait_for(self.programs[name].wait(), PATIENCE_S)

    async def until_says(self, name: str, words: str) -> str:
        """Wait for a line that a hub prints, or has printed."""

        async def has_said() -> bool:
            return any(words in line for line in self.said[name])

        await until_answered(has_said)
        return next(line for line in self.said[name] if words in line)

    async def until_ready(self, name: str) -> None:
        """Wait until HAProxy would send somebody to a hub."""
        await until_answered(lambda: self.is_ready(self.ports[name]))

    async def is_ready(self, port: int) -> bool:
        try:
            async with self.client(port) as client:
                return (await client.get("/api/ready")).status_code == 200
        except httpx.TransportError:
            return False

    def client(self, port: int = 0) -> httpx.AsyncClient:
        """Make a client of HAProxy, or of whoever listens at a port."""
        origin = f"https://127.0.0.1:{port or self.port}"
        return httpx.AsyncClient(
            base_url=origin,
            headers={"Origin": origin, "Cookie": self.cookie},
            timeout=PATIENCE_S,
            verify=any_certificate(),
        )

    async def set_up(self) -> None:
        """Make the first person, through HAProxy."""
        line = await self.until_says(self.names[0], "/setup#")
        token = re.search(r"/setup#(\S+)", line)[1]
        async with self.client() as client:
            answer = await client.post("/api/setup", json={**ADA, "token": token})
            assert answer.status_code == 200, answer.text
            self.cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())

    async def enrol(self, monkeypatch) -> Path:
        """Make the gateway's key as the service of that name does; give its file."""
        key = self.folder / "link" / "gateway.key"
        key.parent.mkdir()
        command = self.services["enrol"]["command"]
        words = [word.replace("/link", str(key.parent)) for word in command]
        words = [word.replace(":8443", f":{self.port}") for word in words]
        words[words.index("/data")] = str(self.data)
        monkeypatch.setenv("TALAIA_DATABASE_URL_FILE", str(self.folder / "secrets/database_url"))
        assert await asyncio.to_thread(main, words) == 0
        return key

    async def page(self) -> Peer:
        """Open a page's socket through HAProxy."""
        connection = await websockets.connect(
            f"wss://127.0.0.1:{self.port}/ws",
            additional_headers={"Origin": self.origin, "Cookie": self.cookie},
            compression=None,
            proxy=None,
            open_timeout=PATIENCE_S,
            ping_interval=None,
            ssl=any_certificate(),
        )
        peer = Peer(connection, FROM_BROWSER, TO_BROWSER)
        self._stack.push_async_callback(peer.close)
        return peer

    async def get(self, path: str, **asked) -> httpx.Response:
        """Ask through HAProxy as the person; while no hub leads, again."""
        answers = []

        async def has_answered() -> bool:
            try:
                async with self.client() as client:
                    answers.append(await client.get(path, params=asked))
            except httpx.TransportError:
                return False
            return answers[-1].status_code != 503

        await until_answered(has_answered)
        return answers[-1]

    def _own_words(self, name: str, words: list[str]) -> list[str]:
        return [self._own_text(name, word) for word in words]

    def _own_text(self, name: str, text: str) -> str:
        """Give the text of a container as it is on this machine."""
        alone = {"/data": str(self.data), "8443": str(self.ports[name])}
        alone["0.0.0.0"] = "127.0.0.1"  # noqa: S104 - replaced, not bound
        return alone.get(text, text.replace("/run/secrets", f"{self.folder}/secrets"))

    def _rewrite(self, name: str, *changes: tuple[str, str]) -> None:
        path = self.folder / name
        text = path.read_text()
        for before, after in changes:
            assert before in text, f"{name} has no {before}"
            text = text.replace(before, after) if before else after
        path.write_text(text)

    async def _start_other(self, name: str, *words: str) -> None:
        quiet = asyncio.subprocess.DEVNULL
        self.programs[name] = await asyncio.create_subprocess_exec(
            *words, stdout=quiet, stderr=quiet
        )

    async def _read(self, name: str, program) -> None:
        while line := (await program.stdout.readline()).decode():
            self.said[name].append(line)
