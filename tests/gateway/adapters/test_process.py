"""Plain commands as a robot's side: real processes, no shell."""

from __future__ import annotations

import ast
import asyncio
import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import psutil
import pytest
from fake_hub import fake_hub
from gateway_bench import addresses_of, running
from hypothesis import given, strategies as st
from patience import PATIENCE_S

from talaia.gateway.adapters.process import fill_arguments, number_in, run_words
from talaia.model.checks.site_checks import check_site
from talaia.model.connection import ProcessSource
from talaia.model.discovery.command_file import site_of
from talaia.model.site import (
    Argument,
    ArgumentType,
    Command,
    CommandKind,
    Signal,
    SignalType,
)
from talaia.model.yaml_text.load import dump_site
from talaia.wire.frames import CommandPhase, CommandRequest, CommandState, DeviceState

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from fake_hub import FakeHub

CLASSIC = Path(__file__).parents[2] / "wire" / "recorded" / "observatory_commands.json"


def command(**fields: ArgumentType) -> Command:
    arguments = {
        name: Argument(type=kind, field=name, default="" if name == "parameters" else None)
        for name, kind in fields.items()
    }
    places = " ".join(f"{{{name}}}" for name in fields)
    return Command(
        name="C", kind=CommandKind.PROCESS, target=f"prog client {places}", arguments=arguments
    )


@given(st.text(min_size=1).filter(lambda t: not t.startswith("-") and "\0" not in t))
def test_whatever_a_person_writes_is_one_argument_as_it_is(text: str) -> None:
    one = command(parameters=ArgumentType.TEXT)
    assert fill_arguments(one.target, one, {"parameters": text}) == ["prog", "client", text]


def test_numbers_are_written_for_every_program_and_options_are_refused() -> None:
    one = command(ra=ArgumentType.NUMBER, parameters=ArgumentType.TEXT)
    assert fill_arguments(one.target, one, {"ra": 1e-5, "parameters": ""}) == [
        "prog",
        "client",
        "0.00001",
    ]
    assert fill_arguments(one.target, one, {"ra": -5.0, "parameters": "-5:30"}) == [
        "prog", "client", "-5", "-5:30",
    ]  # fmt: skip
    said = fill_arguments(one.target, one, {"ra": 1.0, "parameters": "--log=/etc/passwd"})
    assert isinstance(said, str)
    assert "begins with a dash" in said


def test_a_value_is_read_by_pattern_by_state_or_as_it_is() -> None:
    words = {"opened": "the dome is opened", "closed": "the dome is closed"}
    state = Signal(
        name="S",
        type=SignalType.STATE,
        states=tuple(words),
        source=ProcessSource(run="x", messages=words),
    )
    assert number_in(state, " closed\n") == 1.0
    assert number_in(state, " Invalid dome action\n") is None
    text = Signal(name="T", type=SignalType.TEXT, source=ProcessSource(run="x", messages=words))
    assert number_in(text, " closed\n") == "the dome is closed"
    number = Signal(name="N", source=ProcessSource(run="x", pattern=r"Alt:(-?[\d.]+)"))
    assert number_in(number, " Alt:10.000000 Az:20.0\n") == 10.0
    assert number_in(number, "nothing") is None


async def test_a_command_that_hangs_is_ended_with_all_it_has_started(tmp_path: Path) -> None:
    started = tmp_path / "pid"
    script = f"sleep 600 & echo $! > {shlex.quote(str(started))}; sleep 600"
    answer = await run_words(["sh", "-c", script], 1.0)
    assert (answer.code, answer.text) == (-1, "")
    assert "did not end within 1 s" in answer.problem
    child = int(started.read_text())
    async with asyncio.timeout(PATIENCE_S):
        while _alive(child):  # noqa: ASYNC110 - another process's child tells nobody
            await asyncio.sleep(0.01)


async def test_a_command_that_is_cancelled_leaves_nothing_behind_at_whatever_moment(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    known = {each.pid for each in psutil.Process().children()}
    start = asyncio.create_subprocess_exec
    cancelled = asyncio.Event()

    async def slowly(*words: str, **how: Any) -> asyncio.subprocess.Process:
        process = await start(*words, **how)
        # A busy machine: it runs, and nobody has been told yet.
        await cancelled.wait()
        return process

    monkeypatch.setattr(asyncio, "create_subprocess_exec", slowly)
    for steps in range(12):
        cancelled.clear()
        task = asyncio.ensure_future(run_words(["sleep", "600"], 600))
        for _ in range(steps):
            await asyncio.sleep(0)
        # Twice: who cancels, and who ends the gateway meanwhile.
        task.cancel()
        await asyncio.sleep(0)
        task.cancel()
        cancelled.set()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert {each.pid for each in psutil.Process().children()} <= known


def _alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


async def test_an_answer_without_end_is_cut(tmp_path: Path) -> None:
    answer = await run_words(["sh", "-c", "yes | head -c 3000000"], 20)
    assert (answer.code, len(answer.text)) == (0, 64 * 1024)


# A dome in a file: the founding clients' words, without any ROS.
DOME = """\
import pathlib, sys, time
state = pathlib.Path({folder!r}, "state")
log = pathlib.Path({folder!r}, "log")
words = sys.argv[1:]
with log.open("a") as file:
    file.write(repr(words) + chr(10))
action = words[2]
if pathlib.Path({folder!r}, "hang").exists():
    time.sleep(600)
if action == "status":
    print("", state.read_text())
elif action in ("open", "close"):
    state.write_text("opened" if action == "open" else "closed")
    print(" the dome is", state.read_text())
elif action == "getcoord":
    print(" Alt:10.000000 Az:20.500000")
elif action == "goto":
    print(" slewing")
else:
    print(" Invalid dome action")
    sys.exit(0 if action == "test" else 1)
"""


class Bench:
    """A gateway on the contract's command file, with clients that are a small script."""

    def __init__(self, folder: Path, hub: FakeHub) -> None:  # noqa: D107
        self.folder, self.hub = folder, hub
        self.count = 0

    def asked(self) -> list[list[str]]:
        log = self.folder / "log"
        return (
            [ast.literal_eval(line) for line in log.read_text().splitlines()]
            if log.exists()
            else []
        )

    async def ask(self, device: str, what: str, **args: float | str) -> CommandState:
        self.count += 1
        ask = CommandRequest(
            id=f"c{self.count}", device=device, command=what, args=args, ttl_ms=5000, who="Ada"
        )
        await self.hub.send(ask)
        return await self.hub.next(
            CommandState,
            lambda each: (
                each.id == ask.id
                and each.phase not in (CommandPhase.ACCEPTED, CommandPhase.RUNNING)
            ),
        )


@pytest.fixture
async def bench(tmp_path: Path) -> AsyncIterator[Bench]:
    (tmp_path / "state").write_text("closed")
    (tmp_path / "dome.py").write_text(DOME.format(folder=str(tmp_path)))
    text = CLASSIC.read_text().replace("ros2 run", f"{sys.executable} -S {tmp_path / 'dome.py'}")
    site = site_of(text, "observatory")
    assert check_site(site) == []
    connection = msgspec.structs.replace(site.connections["commands"], timeout=2.0)
    quick = dump_site(msgspec.structs.replace(site, connections={"commands": connection}))
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", quick):
        await hub.until(lambda: hub.hellos, "a hello")
        yield Bench(tmp_path, hub)


async def test_the_command_file_opens_and_closes_and_its_answers_are_read(bench: Bench) -> None:
    hub = bench.hub
    await hub.until(lambda: 1.0 in hub.values("dome/status"), "closed")
    opened = await bench.ask("dome", "open")
    assert (opened.phase, opened.message) == ("succeeded", "the dome is opened")
    await hub.until(lambda: hub.values("dome/status")[-1] == 0.0, "opened")
    assert (await bench.ask("dome", "close")).phase == "succeeded"
    await hub.until(lambda: hub.values("dome/status")[-1] == 1.0, "closed again")
    await hub.until(lambda: hub.values("telescope/azimuth"), "the telescope")
    assert hub.values("telescope/azimuth")[0] == 20.5
    assert hub.values("dome/rt")[0] == "Invalid dome action"


async def test_bad_input_is_refused_in_words_and_no_command_is_run(bench: Bench) -> None:
    for device, what, args, said in (
        ("roof", "open", {}, "roof/open is not a command of this site"),
        ("dome", "explode", {}, "dome/explode is not a command of this site"),
        ("telescope", "goto", {"ra": 25.0, "dec": 0.0}, "ra: 25.0 is above 24.0"),
        ("telescope", "goto", {"ra": 1.0}, "the argument 'dec' is missing"),
        ("dome", "open", {"parameters": "--help"}, "begins with a dash"),
    ):
        state = await bench.ask(device, what, **args)
        assert state.phase == "refused"
        assert said in state.message
    assert not [
        words for words in bench.asked() if words[2] not in ("status", "test", "getcoord", "info")
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"devices": {"dome": {', "line 1, column 23: is not JSON"),
        ('{"devices": {"dome": {"comands": {}}}}', "$.devices.dome.comands: unknown key"),
        (
            '{"devices": {"dome": {"commands": {"open": ["rm", "-rf"]}}}}',
            "$.devices.dome.commands.open: expected a text",
        ),
    ],
)
def test_a_malformed_command_file_is_told_with_its_place_and_no_gateway_starts(
    text: str, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "commands.json"
    path.write_text(text)
    (tmp_path / "key").write_text("k" * 40)
    done = subprocess.run(
        [
            sys.executable, "-m", "talaia", "gateway", str(path), "--hub", "wss://127.0.0.1:1",
            "--key-file", str(tmp_path / "key"), "--data", str(tmp_path / "data"),
        ],
        capture_output=True, text=True, timeout=PATIENCE_S, check=False,
    )  # fmt: skip
    assert done.returncode != 0
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "data").exists()


async def test_a_shells_words_are_one_inert_argument(bench: Bench) -> None:
    precious = bench.folder / "precious"
    precious.write_text("x")
    evil = f"; rm -rf {precious} `id` $(id) && id | id"
    assert (await bench.ask("dome", "open", parameters=evil)).phase == "succeeded"
    assert precious.read_text() == "x"
    assert ["dome_servcli", "client", "open", evil] in bench.asked()


async def test_clients_that_hang_are_ended_and_the_device_is_unknown_then_back(
    bench: Bench,
) -> None:
    hub = bench.hub
    await hub.until(lambda: hub.values("dome/status"), "a first answer")
    (bench.folder / "hang").touch()
    lost = await hub.next(DeviceState, lambda each: each.device == "dome" and not each.reached)
    assert "did not end within 2 s" in lost.why
    # Every line is asked for again, never twice at once.
    running_now = clients_of(bench.folder)
    assert len(running_now) <= 4
    (bench.folder / "hang").unlink()
    await hub.next(DeviceState, lambda each: each.device == "dome" and each.reached)


def clients_of(folder: Path) -> list[Path]:
    wanted = str(folder / "dome.py").encode()
    return [each for each in Path("/proc").glob("[0-9]*/cmdline") if wanted in _bytes_of(each)]


def _bytes_of(path: Path) -> bytes:
    try:
        return path.read_bytes() if path.parent.name != str(os.getpid()) else b""
    except OSError:
        return b""


async def test_a_program_that_is_not_there_is_told_by_name(tmp_path: Path) -> None:
    text = CLASSIC.read_text().replace("ros2 run", "no_such_launcher run")
    site = dump_site(site_of(text, "observatory"))
    async with fake_hub(addresses_of) as hub, running(hub.url, tmp_path / "data", site):
        await hub.until(lambda: hub.hellos, "a hello")
        one = Bench(tmp_path, hub)
        state = await one.ask("dome", "open")
        assert state.phase == "refused"
