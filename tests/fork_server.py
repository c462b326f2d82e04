"""Start Python programs as forks of a process that has imported their modules already.

To import a hub takes more than a second of a core, a gateway about one, and tests start hundreds of
them. What a program does from its ``main`` on is the same; that it also starts as a process of its
own from nothing is seen by the tests of ``talaia demo``, ``talaia up`` and many others.

A run of many groups has one such process for all, of which each group forks its own; see
`start_ancestor`.

Only on Linux, and not while line coverage is measured: there each program is started anew, and
with ``TALAIA_TEST_FORKS=0`` in the environment.
"""

from __future__ import annotations

import ast
import atexit
import contextlib
import ctypes
import gc
import importlib
import json
import os
import re
import runpy
import select
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import IO, Any, NamedTuple

from talaia.cli.child_processes import _follow_parent
from talaia.errors import TalaiaError
from talaia.ros_installation import ros_environment, use_ros

CODE = struct.Struct("i")
# What a program of ROS 2 imports at the latest when it joins the others, and a gateway with it.
ROS2 = ("ros_wheels_bootstrapper", "rclpy", "rclpy.executors", "rclpy.node", "rclpy.action",
        "std_msgs.msg", "geometry_msgs.msg", "sensor_msgs.msg", "nav_msgs.msg",
        "std_srvs.srv", "rcl_interfaces.srv", "rosidl_generator_py")  # fmt: skip
# What a command imports only when it is needed, which it always is.
LATER = {
    "gateway": (*ROS2, "talaia.gateway.run", "talaia.gateway.adapters.ros2.adapter"),
    "hub": ("talaia.hub.run", "pydantic.v1", "aiosqlite", "alembic.command", "alembic.context",
            "email_validator"),
    "sim": (*ROS2, "talaia.sim.vehicle.node", "talaia.sim.vehicle.world",
            "talaia.sim.observatory.ros2_shell"),
}  # fmt: skip
MAX_REQUEST = 1 << 17
# Where a process listens from which servers are forked.
ANCESTOR = "TALAIA_TEST_FORKS_FROM"
# Of linux/prctl.h; see prctl(2). Longer names are cut off.
PR_SET_NAME = 15


def is_used() -> bool:
    """Tell whether programs are forked in this run."""
    # With this each new program measures itself; a fork would not.
    measured = any(name.startswith("COVERAGE_PROCESS") for name in os.environ)
    wanted = os.environ.get("TALAIA_TEST_FORKS") != "0"
    return sys.platform == "linux" and wanted and not measured


class ForkedProcess:
    """A program that runs: what tests use of `subprocess.Popen`.

    Attributes:
        args: the words that would have started it, as of `subprocess.Popen`.
        pid: of the process.
        returncode: None while it runs; negative for a signal.
        stdin: a pipe to the program, without a buffer.

    """

    def __init__(self, args: list[str], pid: int, ended: int, stdin: IO[bytes]) -> None:
        """Take what the server has started; ``ended`` is where its exit code comes."""
        self.args = args
        self.pid = pid
        self.returncode: int | None = None
        self.stdin: IO[bytes] | None = stdin
        self._ended = ended
        # A test may ask in one thread while another waits.
        self._lock = threading.Lock()

    def poll(self) -> int | None:
        """Give the exit code if it has ended."""
        return self._look(0.0)

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end and give the exit code.

        Raises:
            subprocess.TimeoutExpired: not within ``timeout`` seconds.

        """
        ends = None if timeout is None else time.monotonic() + timeout
        while self._look(None if ends is None else max(0.0, ends - time.monotonic())) is None:
            if ends is not None and time.monotonic() >= ends:
                raise subprocess.TimeoutExpired(self.args, timeout or 0.0)
        assert self.returncode is not None
        return self.returncode

    def _look(self, within: float | None) -> int | None:
        with self._lock:
            if self.returncode is None and select.select([self._ended], [], [], within)[0]:
                code = os.read(self._ended, CODE.size)
                # Without a word the server has ended, and this one with it.
                self.returncode = CODE.unpack(code)[0] if code else -signal.SIGTERM
                os.close(self._ended)
            return self.returncode

    def send_signal(self, number: int) -> None:
        """Send a signal, if it still runs."""
        if self.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)

    def terminate(self) -> None:
        """Ask it to end."""
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        """End it."""
        self.send_signal(signal.SIGKILL)


class ForkServer:
    """The process that has imported everything; see `fork_program`."""

    def __init__(self) -> None:
        """Start it, with nothing imported yet."""
        # Of this process: one that was forked from it has a server of its own.
        self.owner = os.getpid()
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        if path := os.environ.get(ANCESTOR):
            self._channel = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            self._channel.connect(path)
            (self._pid,) = CODE.unpack(self._channel.recv(CODE.size))
            return
        self._channel, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, __file__, str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                start_new_session=True,
            )
        self._pid = self._process.pid

    def fork(
        self,
        words: list[str],
        environment: dict[str, str],
        output: IO[bytes],
        errors: IO[bytes] | None = None,
    ) -> ForkedProcess:
        """Run ``python WORDS``; see `fork_program`."""
        request = {"words": words, "environment": environment, "folder": str(Path.cwd())}
        theirs, stdin = os.pipe()
        ended, told = os.pipe()
        try:
            with self._lock:
                data = json.dumps(request).encode()
                files = [theirs, output.fileno(), (errors or output).fileno(), told]
                socket.send_fds(self._channel, [data], files)
                answer = self._channel.recv(CODE.size)
        finally:
            os.close(theirs)
            os.close(told)
        assert answer, "the fork server has ended; its own words stand in the output of the tests"
        (pid,) = CODE.unpack(answer)
        pipe = os.fdopen(stdin, "wb", buffering=0)
        return ForkedProcess([sys.executable, *words], pid, ended, pipe)

    def cpu_time(self) -> float:
        """Give the CPU time of the server and of the programs that have ended (s)."""
        try:
            text = Path(f"/proc/{self._pid}/stat").read_text()
        except FileNotFoundError:
            return 0.0
        # proc_pid_stat(5): utime, stime, cutime and cstime, which are fields 14 to 17.
        ticks = text.rpartition(")")[2].split()[11:15]
        return sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK")

    def close(self) -> None:
        """End it, and all that it started; only where it was begun."""
        if os.getpid() == self.owner and self._channel.fileno() >= 0:
            # The ancestor may have ended before, and this server with it.
            with contextlib.suppress(OSError):
                self._channel.shutdown(socket.SHUT_WR)
                self._channel.recv(CODE.size)
            self._channel.close()
            if self._process is not None:
                self._process.wait()


_servers: list[ForkServer] = []


def fork_program(
    words: list[str],
    environment: dict[str, str],
    output: IO[bytes],
    errors: IO[bytes] | None = None,
) -> ForkedProcess:
    """Run ``python WORDS`` with the modules that it needs imported already.

    It ends with this process, however that ends.

    Args:
        words: as behind ``python``: ``-m``, a module and its arguments, or a script and its own.
        environment: all of it.
        output: an open file for its standard output.
        errors: one for its standard error, if not the same.

    """
    if not _servers or _servers[-1].owner != os.getpid():
        server = ForkServer()
        atexit.register(server.close)
        _servers.append(server)
    return _servers[-1].fork(words, environment, output, errors)


def open_program(words: list[str]) -> tuple[ForkedProcess | subprocess.Popen[bytes], IO[bytes]]:
    """Run ``python WORDS`` in this process's environment; give it and what it prints."""
    output, theirs = os.pipe()
    with os.fdopen(theirs, "wb") as out, os.fdopen(os.dup(2), "wb") as errors:
        if is_used():
            process = fork_program(words, dict(os.environ), out, errors)
            return process, os.fdopen(output, "rb")
        pipe = subprocess.PIPE
        started = subprocess.Popen([sys.executable, *words], stdin=pipe, stdout=out, stderr=errors)
        return started, os.fdopen(output, "rb")


def cpu_time() -> float:
    """Give the CPU time of what was forked for this process and has ended (s)."""
    return sum(server.cpu_time() for server in _servers if server.owner == os.getpid())


def start_ancestor(path: Path) -> subprocess.Popen[bytes]:
    """Start the process that servers are forked from; they find it by `ANCESTOR`.

    To import everything takes three seconds of a core: so once, and not for each group of tests.

    Args:
        path: of the socket at which it listens; short, see unix(7).

    """
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as listening:
        listening.bind(str(path))
        # Who comes before everything is imported waits.
        listening.listen(64)
        return subprocess.Popen(
            [sys.executable, __file__, "--listen", str(listening.fileno())],
            stdin=subprocess.DEVNULL,
            pass_fds=[listening.fileno()],
            start_new_session=True,
        )


# ── in the server's process ──


def fork_servers(listening: socket.socket) -> socket.socket:
    """Fork a server for each that connects; returns in each of them, with its channel."""
    # However the run ends.
    _follow_parent()
    for command in LATER:
        import_for(["-m", "talaia", command])
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    ancestor = os.getpid()
    while True:
        channel, _ = listening.accept()
        with channel:
            if fork_with_tracing() == 0:
                os.setsid()
                end_with(ancestor)
                listening.close()
                # For whom: nothing else says it to those who look at processes.
                asking = channel.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, CODE.size)
                name_process(f"for {CODE.unpack(asking)[0]}")
                channel.send(CODE.pack(os.getpid()))
                return channel.dup()


class Order(NamedTuple):
    """What a fork is to run."""

    words: list[str]
    environment: dict[str, str]
    folder: str


def serve(channel: socket.socket) -> Order:
    """Fork whenever that is asked for; returns in each fork, with what it is to run."""
    server = os.getpid()
    children: dict[int, int] = {}
    wakes, wake = socket.socketpair()
    wake.setblocking(False)  # noqa: FBT003 - the signature is the library's
    signal.set_wakeup_fd(wake.fileno(), warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    while True:
        ready, _, _ = select.select([channel, wakes], [], [])
        if wakes in ready:
            wakes.recv(4096)
        report_ended(children)
        if channel not in ready:
            continue
        data, fds, _, _ = socket.recv_fds(channel, MAX_REQUEST, 4)
        if not data:
            # Its end is the end of all that it forked; see `_follow_parent`.
            os._exit(0)
        order = Order(**json.loads(data))
        *files, told = fds
        import_for(order.words)
        if (pid := fork_with_tracing()) == 0:
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            become_program(server, files)
            for fd in (*children.values(), *fds):
                os.close(fd)
            for each in (channel, wakes, wake):
                each.close()
            return order
        children[pid] = told
        channel.send(CODE.pack(pid))
        for fd in files:
            os.close(fd)


def fork_with_tracing() -> int:
    """Fork as `os.fork` does.

    ROS 2 brings LTTng, which has two threads from its import on: a fork has none of them, and at
    its end they would be waited for. LTTng's own functions for forks start them anew
    (lttng-ust(3), "Using LTTng-UST with daemons"; up to 2.12 by these names).
    """
    loaded = re.search(r"/\S+/liblttng-ust-[0-9a-f]+\.so\S*", Path("/proc/self/maps").read_text())
    if loaded is None:
        return os.fork()
    library = ctypes.CDLL(loaded[0])
    # A sigset_t of this C library, in which the signals of before are kept.
    signals = ctypes.create_string_buffer(128)
    library.ust_before_fork(signals)
    pid = os.fork()
    if pid:
        library.ust_after_fork_parent(signals)
    else:
        library.ust_after_fork_child(signals)
    return pid


def report_ended(children: dict[int, int]) -> None:
    """Say of each fork that has ended how it did."""
    while children:
        pid, status = os.waitpid(-1, os.WNOHANG)
        if not pid:
            return
        told = children.pop(pid)
        # Who asked may be gone.
        with contextlib.suppress(BrokenPipeError):
            os.write(told, CODE.pack(os.waitstatus_to_exitcode(status)))
        os.close(told)


def end_with(parent: int) -> None:
    """End when ``parent`` does, from which this process was forked."""
    _follow_parent()
    # It may have ended before that was said.
    if os.getppid() != parent:
        os._exit(1)


def import_for(words: list[str]) -> None:
    """Import what a program imports at its start."""
    names: list[str] = []
    if words[0].endswith(".py"):
        # Also what its functions import: a starter that changes something first does that.
        for node in ast.walk(ast.parse(Path(words[0]).read_text())):
            if isinstance(node, ast.Import):
                names += [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.append(node.module)
    if words[:2] == ["-m", "talaia"] or "talaia.cli.main" in names:
        from talaia.cli.main import COMMANDS

        command = words[2] if words[0] == "-m" else words[1]
        names += [COMMANDS[command].module, *LATER.get(command, ())]
    gc.disable()
    for name in names:
        # What cannot be imported is for the program itself to find out.
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    gc.freeze()
    gc.enable()


def become_program(server: int, files: list[int]) -> None:
    """Leave the server's terminal and session; ``files`` become the first three."""
    os.setsid()
    end_with(server)
    for number, mine in enumerate(files):
        os.dup2(mine, number)


def name_process(name: str) -> None:
    """Say what `ps` and the like call this process."""
    ctypes.CDLL(None).prctl(PR_SET_NAME, name.encode())


def run_program(order: Order) -> None:
    """Do what Python does with the words behind its name."""
    # What `ps` and the like call it: a module and its command, or a script.
    module = order.words[0] == "-m"
    name_process(" ".join(order.words[1:3]) if module else Path(order.words[0]).name)
    os.environ.clear()
    os.environ.update(order.environment)
    # Chosen by the environment of before, where a module has asked for it.
    tempfile.tempdir = None
    # As this process has it: else the program would start itself anew.
    os.environ.update(ros_environment())
    os.chdir(order.folder)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(write_through=True)  # type: ignore[union-attr]
    # With these it starts itself anew, where ROS 2 is found to need another environment.
    sys.orig_argv = [sys.executable, *order.words]
    first, *more = order.words
    here: Any = os.getcwd()
    if first == "-m":
        sys.argv = more
        sys.path[0] = here
        runpy.run_module(more[0], run_name="__main__", alter_sys=True)
    elif first == "-c":
        raise SystemExit("a text that is a program is started anew")
    else:
        sys.argv = order.words
        sys.path[0] = str(Path(first).resolve().parent)
        runpy.run_path(first, run_name="__main__")


if __name__ == "__main__":
    # Now, while nothing is asked for yet: it may start this process anew.
    with contextlib.suppress(ImportError, TalaiaError):
        use_ros(ordered=True)
    place = socket.socket(fileno=int(sys.argv[-1]))
    run_program(serve(fork_servers(place) if sys.argv[1] == "--listen" else place))
