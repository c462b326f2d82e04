"""Database servers of a bench's own: two of a kind, each with its folder, ended with the bench."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import psutil
import sqlalchemy as sa
from stack import free_port

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["KINDS", "DatabaseServer", "started_servers"]

_PATIENCE_S = 60.0


class DatabaseServer(NamedTuple):
    """One that runs.

    Attributes:
        url: of an empty database on it, as a user would write it.
        pid: of its first process.

    """

    url: str
    pid: int

    def cpu_s(self) -> float:
        """Give the processor time of all its processes so far (s)."""
        first = psutil.Process(self.pid)
        times = [one.cpu_times() for one in (first, *first.children(recursive=True))]
        # Those of before that have ended are in their parent's account.
        ended = first.cpu_times().children_user + first.cpu_times().children_system
        return sum(one.user + one.system for one in times) + ended


def _start_mariadb(folder: Path, port: int) -> list[str]:
    install = shutil.which("mariadb-install-db") or "mariadb-install-db"
    me = f"--user={os.environ.get('USER', 'root')}" if os.geteuid() else "--user=root"
    subprocess.run(
        [install, "--no-defaults", f"--datadir={folder}/data", me, "--skip-test-db",
         "--auth-root-authentication-method=normal"],
        check=True, capture_output=True,
    )  # fmt: skip
    program = shutil.which("mariadbd", path="/usr/sbin:/usr/bin") or "mariadbd"
    return [
        program, "--no-defaults", f"--datadir={folder}/data", me, f"--port={port}",
        f"--socket={folder}/s", "--bind-address=127.0.0.1", f"--pid-file={folder}/pid",
    ]  # fmt: skip


def _start_postgresql(folder: Path, port: int) -> list[str]:
    programs = sorted(Path("/usr/lib/postgresql").glob("*/bin"))[-1]
    # It refuses to run as root.
    other = [] if os.geteuid() else ["setpriv", "--reuid=postgres", "--regid=postgres",
                                     "--clear-groups"]  # fmt: skip
    if other:
        shutil.chown(folder, "postgres", "postgres")
    subprocess.run(
        [*other, programs / "initdb", "-D", folder / "data", "-U", "postgres", "-A", "trust"],
        check=True, capture_output=True, cwd="/",
    )  # fmt: skip
    return [
        *other, str(programs / "postgres"), "-D", f"{folder}/data", "-p", str(port),
        "-k", str(folder), "-c", "listen_addresses=127.0.0.1",
    ]  # fmt: skip


KINDS = {
    "PostgreSQL": ("postgresql+pg8000://postgres@127.0.0.1:{}/postgres", _start_postgresql),
    "MariaDB": ("mysql+pymysql://root@127.0.0.1:{}/mysql", _start_mariadb),
}
_DRIVERS = {"PostgreSQL": "postgresql", "MariaDB": "mariadb"}


@contextlib.contextmanager
def started_servers(kind: str, folder: Path, count: int) -> Iterator[list[DatabaseServer]]:
    """Run so many servers of a kind, as they come, on ports of loopback."""
    admin, prepare = KINDS[kind]
    with contextlib.ExitStack() as stack:
        servers = []
        for at in range(count):
            own, port = folder / f"{_DRIVERS[kind]}{at}", free_port()
            own.mkdir()
            words = prepare(own, port)
            log = stack.enter_context((folder / f"{_DRIVERS[kind]}{at}.log").open("wb"))
            process = subprocess.Popen(words, stdout=log, stderr=log, cwd="/")
            stack.callback(_end_process, process)
            _make_database(admin.format(port), process)
            url = sa.make_url(admin.format(port)).set(
                drivername=_DRIVERS[kind], database="talaia", query={"sslmode": "disable"}
            )
            servers.append(DatabaseServer(url.render_as_string(hide_password=False), process.pid))
        yield servers


def _make_database(url: str, process: subprocess.Popen[bytes]) -> None:
    engine = sa.create_engine(url, isolation_level="AUTOCOMMIT")
    ends = time.monotonic() + _PATIENCE_S
    while True:
        try:
            with engine.connect() as connection:
                connection.exec_driver_sql("CREATE DATABASE talaia")
            break
        except (sa.exc.SQLAlchemyError, OSError):
            if process.poll() is not None or time.monotonic() > ends:
                raise
            time.sleep(0.2)
    engine.dispose()


def _end_process(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(_PATIENCE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
