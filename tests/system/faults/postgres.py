"""A PostgreSQL server of its own, which a test may kill."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import psutil
from ports import free_port

from talaia.hub import accounts
from talaia.hub.settings import Settings

from ..stack import PASSWORD, PEOPLE, SITE
from .world import World

PROGRAMS = sorted(Path("/usr/lib/postgresql").glob("*/bin"))


class Server:
    """One server in one folder; it runs as ``postgres`` where we are root, as it must."""

    def __init__(self, folder: Path, port: int) -> None:
        """Make the cluster and start it.

        Raises:
            PermissionError: there is no PostgreSQL on this machine.

        """
        if not PROGRAMS:
            raise PermissionError("PostgreSQL's server programs")
        self._bin, self._folder, self.port = PROGRAMS[-1], folder, port
        if os.geteuid() == 0:
            shutil.chown(folder, "postgres", "postgres")
        self._user = "postgres" if os.geteuid() == 0 else None
        words = ["-D", str(folder / "data"), "-U", "postgres", "-A", "trust", "--no-sync"]
        self._run([str(self._bin / "initdb"), *words])
        self.start()
        self._run([str(self._bin / "createdb"), "-h", "127.0.0.1", "-p", str(port), "-U",
                   "postgres", "talaia"])  # fmt: skip

    def _run(self, words: list[str]) -> None:
        subprocess.run(words, check=True, capture_output=True, user=self._user, cwd=self._folder)

    def start(self) -> None:
        """Start, or start again after a kill, and wait until it answers."""
        words = [str(self._bin / "postgres"), "-D", str(self._folder / "data"), "-p",
                 str(self.port), "-k", str(self._folder), "-h", "127.0.0.1"]  # fmt: skip
        with (self._folder / "log").open("ab") as log:
            self.popen = subprocess.Popen(
                words, stdout=log, stderr=log, user=self._user, cwd=self._folder,
                start_new_session=True,
            )  # fmt: skip
        ready = [
            str(self._bin / "pg_isready"),
            "-q",
            "-U",
            "postgres",
            "-h",
            "127.0.0.1",
            "-p",
            str(self.port),
        ]
        deadline = time.monotonic() + 30
        while subprocess.run(ready, check=False, capture_output=True).returncode:
            assert time.monotonic() < deadline, (self._folder / "log").read_text()[-2000:]
            time.sleep(0.05)

    def kill(self) -> None:
        """Kill -9 the server and all of its children."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.popen.pid, signal.SIGKILL)
        self.popen.wait(10)
        (self._folder / "data" / "postmaster.pid").unlink(missing_ok=True)

    @contextlib.contextmanager
    def frozen(self) -> Iterator[None]:
        """Let the server and all of its children stand still meanwhile."""
        # Each child of PostgreSQL's has a process group of its own.
        ours = [self.popen.pid, *self._children()]
        try:
            for each in ours:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(each, signal.SIGSTOP)
            yield
        finally:
            for each in ours:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(each, signal.SIGCONT)

    def _children(self) -> list[int]:
        return [each.pid for each in psutil.Process(self.popen.pid).children(recursive=True)]


@contextlib.asynccontextmanager
async def postgres(world: World) -> AsyncIterator[Server]:
    """Let the world's hub use a server of its own, with the world's people and its key."""
    # Not in the hub's folder, which is nobody else's to enter.
    folder = Path(tempfile.mkdtemp(prefix="talaia-postgres-"))
    server = Server(folder, free_port())
    url = f"postgresql+asyncpg://postgres@127.0.0.1:{server.port}/talaia"
    settings = Settings(
        data=world.folder, host="127.0.0.1", port=world.port, plain=True, password_cost=4,
        database_url=url,
    )  # fmt: skip
    key, cookie = (world.folder / "key").read_text(), world._cookie
    world.hub.end()
    world.gateway.end()
    try:
        for name, role in PEOPLE.items():
            await accounts.create_user(settings, name, PASSWORD, role)
        (world.folder / "key").write_text(await accounts.create_gateway(settings, SITE))
        world.database_url, world._cookie = url, ""
        world.start_hub()
        await world.hub.says("ready")
        yield server
    finally:
        world.hub.end()
        world.gateway.end()
        (world.folder / "key").write_text(key)
        world.database_url, world._cookie = "", cookie
        server.kill()
        shutil.rmtree(folder, ignore_errors=True)
