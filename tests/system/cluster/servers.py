"""What several hubs stand on, as processes: NATS in threes, lines that may be cut, HAProxy, S3."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

import httpx
from hub.object_stores import BUCKET, SIGNED
from ports import free_port
from server_programs import find_server

from talaia.cli.child_processes import _follow_parent
from talaia.deploy.several_hubs import write_balancer_config

# HAProxy dials hubs from here, so that whoever asks a hub by itself is not taken for it.
BALANCER = "127.0.0.2"
_START_S = 30.0


def find_program(name: str) -> str:
    """Find a server's program.

    Raises:
        PermissionError: it is not installed.

    """
    program = find_server(name)
    if program is None:
        raise PermissionError(f"{name} (apt install {name})")
    return program


def wait_for_port(port: int) -> None:
    """Wait until somebody listens there."""
    ends = time.monotonic() + _START_S
    while True:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        assert time.monotonic() < ends, f"nobody listens at {port}"
        time.sleep(0.02)


class Program:
    """A server that may be killed, frozen and begun anew."""

    def __init__(self, words: list[str], port: int, **environment: str) -> None:
        """Start it with ``words``, and wait until it listens at ``port``."""
        self._words, self.port, self._environment = words, port, environment
        self.start()

    def start(self) -> None:
        """Start it, or start it again."""
        self._process = subprocess.Popen(
            self._words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, **self._environment}, preexec_fn=_follow_parent,
        )  # fmt: skip
        wait_for_port(self.port)

    def kill(self) -> None:
        """End it without farewell."""
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait(10)

    def freeze(self) -> None:
        """Let it stand still: what goes through it goes nowhere, and nobody is told."""
        self._process.send_signal(signal.SIGSTOP)

    def wake(self) -> None:
        """Let it go on, with all that has come meanwhile."""
        self._process.send_signal(signal.SIGCONT)


class NatsNodes:
    """Three servers of NATS that are one."""

    def __init__(self) -> None:
        """Start them."""
        program = find_program("nats-server")
        ports = [(free_port(), free_port(), free_port()) for _ in range(3)]
        routes = ",".join(f"nats://127.0.0.1:{route}" for _, route, _ in ports)
        self.nodes = [
            # They do not name each other to hubs, which would go past the lines otherwise.
            Program(
                [program, "-a", "127.0.0.1", "-p", str(port), "--cluster_name", "talaia",
                 "--cluster", f"nats://127.0.0.1:{route}", "--routes", routes,
                 "--no_advertise=true", "-m", str(state)],
                port,
            )
            for port, route, state in ports
        ]  # fmt: skip
        self._states = [state for _, _, state in ports]

    def node_of(self, hub: str) -> Program:
        """Give the server by which a hub sends what is urgent."""
        for node, state in zip(self.nodes, self._states, strict=True):
            told = httpx.get(f"http://127.0.0.1:{state}/connz", trust_env=False).json()
            if any(one.get("name") == f"{hub} urgent" for one in told["connections"]):
                return node
        raise AssertionError(f"{hub} is at no server of NATS")

    def close(self) -> None:
        """End them."""
        for node in self.nodes:
            node.kill()


class Line:
    """The way from one hub to a server, which may be cut: dark and silent, or with a reset."""

    def __init__(self, folder: Path, targets: list[int]) -> None:
        """Lead to each port of ``targets`` from one of `ports`."""
        self.ports = [free_port() for _ in targets]
        ways = zip(self.ports, targets, strict=True)
        text = (
            "defaults\n  mode tcp\n  timeout connect 2s\n  timeout client 1h\n  timeout server 1h\n"
        )
        text += "".join(
            f"listen to-{target}\n  bind 127.0.0.1:{port}\n  server it 127.0.0.1:{target}\n"
            for port, target in ways
        )
        file = folder / f"line-{self.ports[0]}.cfg"
        file.write_text(text)
        words = [find_program("haproxy"), "-q", "-db", "-f", str(file)]
        self._program = Program(words, self.ports[0])

    @contextlib.contextmanager
    def dark(self) -> Iterator[None]:
        """Let nothing through meanwhile; it is kept, as TCP would, and comes late."""
        self._program.freeze()
        try:
            yield
        finally:
            self._program.wake()

    def close(self) -> None:
        """End it."""
        self._program.kill()


class Balancer:
    """HAProxy before the hubs, from the file that `talaia generate` writes."""

    def __init__(self, folder: Path, port: int, hubs: Mapping[str, int]) -> None:
        """Listen at ``port`` for the hubs, which have ports of their own."""
        text = write_balancer_config(list(hubs))
        changes = {
            "bind :8443": f"bind 127.0.0.1:{port}",
            "bind 127.0.0.1:8404": f"bind 127.0.0.1:{free_port()}",
            # Here the hubs speak without TLS, which is another test's.
            "check check-ssl verify none": f"source {BALANCER} check",
            " resolvers containers init-addr last,libc,none": "",
            **{f"{name}:8443": f"127.0.0.1:{at}" for name, at in hubs.items()},
        }
        for before, after in changes.items():
            assert before in text, f"HAProxy's file has no {before}"
            text = text.replace(before, after)
        file = folder / "haproxy.cfg"
        file.write_text(text)
        self._program = Program([find_program("haproxy"), "-q", "-db", "-f", str(file)], port)

    def close(self) -> None:
        """End it."""
        self._program.kill()


class Store:
    """Moto's S3, with an empty bucket."""

    def __init__(self) -> None:
        """Start it."""
        self.port = free_port()
        words = [sys.executable, "-W", "ignore", "-m", "moto.server", "-H", "127.0.0.1"]
        self._program = Program([*words, "-p", str(self.port)], self.port)
        with httpx.Client(trust_env=False, headers={"Authorization": SIGNED}) as client:
            client.put(f"http://127.0.0.1:{self.port}/{BUCKET}", timeout=60).raise_for_status()

    def close(self) -> None:
        """End it; it forgets everything."""
        self._program.kill()
