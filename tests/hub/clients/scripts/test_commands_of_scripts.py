"""`talaia watch`, `get`, `call` and `record` at a real hub, as people and scripts use them."""

from __future__ import annotations

import asyncio
import contextlib
import io
import json
import os
import signal
import sys
from pathlib import Path

import pytest
import pytest_asyncio
from patience import PATIENCE_S

from talaia.cli.main import main
from talaia.wire import frames
from talaia.wire.frames import CommandPhase

from ...everyone.world import NOW
from ..tokens import token_of

HOW_TO = Path(__file__).parents[4] / "docs" / "how-to" / "python-client.md"

pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest_asyncio.fixture(loop_scope="module")
async def run(shared_world, monkeypatch, capsys):
    """Run a command as the operator; give its exit code and what it printed."""
    monkeypatch.setenv("TALAIA_HUB", shared_world.hub.origin)
    monkeypatch.setenv("TALAIA_TOKEN", await token_of(shared_world.hub, "operator"))

    async def run_command(*words):
        code = await asyncio.to_thread(main, list(words))
        return (code, *capsys.readouterr())

    return run_command


async def test_watch_prints_what_is_known_for_people_and_for_programs(shared_world, run) -> None:
    await shared_world.gateways["agv"].samples(
        ("base/open", NOW + 1, 0.5), ("base/words", NOW + 1, "two\nlines")
    )
    code, out, _ = await run("watch", "--once", "agv/base/open", "agv/base/words")
    assert code == 0
    lines = out.splitlines()
    assert len(lines) == 2
    assert "agv/base/open  0.5" in lines[0]
    assert "two�lines" in lines[1]
    _, out, _ = await run("watch", "--once", "--json", "agv/base/open")
    found = json.loads(out)
    assert (found["address"], found["value"]) == ("agv/base/open", 0.5)


async def test_get_prints_a_table_or_saves_a_file(shared_world, run, tmp_path) -> None:
    gateway = shared_world.gateways["agv"]
    begin = gateway.sequence
    await gateway.samples(*(("camera/shut", NOW + at, at / 4) for at in range(3)))
    await gateway.hear(frames.Ack, lambda ack: ack.below == begin + 3)
    words = (
        "get",
        "agv/camera/shut",
        "--since",
        "2023-11-14T22:13Z",
        "--until",
        "2023-11-14T22:14Z",
    )
    code, out, _ = await run(*words)
    assert code == 0
    assert [line.split()[-1] for line in out.splitlines()] == ["camera/shut", "0", "0.25", "0.5"]
    _, out, _ = await run(*words, "--json")
    assert [json.loads(line)["camera/shut"] for line in out.splitlines()] == [0.0, 0.25, 0.5]
    target = tmp_path / "a.csv"
    code, out, _ = await run(*words, "-o", str(target))
    assert code == 0
    assert out == f"{target}: {target.stat().st_size} bytes\n"
    code, _, err = await run(*words, "-o", str(tmp_path / "a.xlsx"))
    assert (code, "expected .csv, .parquet or .arrow" in err) == (2, True)


@pytest.mark.parametrize(
    ("phase", "expected"),
    [(CommandPhase.SUCCEEDED, 0), (CommandPhase.FAILED, 1), (CommandPhase.UNKNOWN, 3)],
)
async def test_calls_exit_code_says_what_became_of_the_command(
    shared_world, run, phase, expected
) -> None:
    gateway = shared_world.gateways["agv"]
    running = asyncio.create_task(run("call", "agv/base.turn", "--json"))
    asked = await gateway.hear(frames.CommandRequest)
    await gateway.say(
        frames.CommandState(
            id=asked.id, device="base", command="turn", phase=phase, message="so it is"
        )
    )
    code, out, _ = await running
    assert code == expected
    assert json.loads(out)["message"] == "so it is"


async def test_wrong_words_end_with_a_sentence_and_the_exit_code_2(run) -> None:
    for words, said in (
        (("call", "agv/base/trun"), "did you mean agv/base/turn"),
        (("call", "agv/base/turn", "fast"), "expected NAME=VALUE"),
        (("watch", "agv/base/nothing", "--once"), "no signal"),
        (("record", "start", "mars"), "no such site"),
        (("record", "fetch", "agv", "none", "--wait", "0.1"), "not whole after 0.1 s"),
    ):
        code, _, err = await run(*words)
        assert (code, said in err) == (2, True), err
    assert (await run("record", "list", "agv"))[0] == 0


async def test_example_of_the_how_to_runs_as_it_stands(shared_world, run) -> None:
    example = HOW_TO.read_text().partition("```python\n")[2].partition("```")[0]
    gateway = shared_world.gateways["agv"]
    await gateway.samples(("base/open", NOW + 500, 0.25))
    with contextlib.redirect_stdout(io.StringIO()) as out:
        running = asyncio.create_task(asyncio.to_thread(exec, example, {}))
        asked = await gateway.hear(frames.CommandRequest)
        succeeded = CommandPhase.SUCCEEDED
        await gateway.say(
            frames.CommandState(id=asked.id, device="base", command="turn", phase=succeeded)
        )
        await running
    assert "agv online" in out.getvalue()
    assert "agv/base/open 0.25" in out.getvalue()
    assert out.getvalue().splitlines()[-1].strip() == "succeeded"


async def test_ctrl_c_ends_a_watch_quietly_and_its_token_is_in_no_process_list(
    shared_world, tmp_path
) -> None:
    token = tmp_path / "token"
    token.write_text(await token_of(shared_world.hub, "operator"))
    token.chmod(0o600)
    watch = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "talaia", "watch", "agv/base/open", "--hub", shared_world.hub.origin,
        "--token-file", str(token), stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )  # fmt: skip
    reading = asyncio.create_task(watch.stdout.readline())
    at = 0
    while not reading.done():
        at += 1
        await shared_world.gateways["agv"].samples(("base/open", NOW + 1000 + at, 0.5))
        await asyncio.wait([reading], timeout=0.5)
    assert b"agv/base/open" in await reading
    words = Path(f"/proc/{watch.pid}/cmdline").read_bytes()  # noqa: ASYNC240
    assert token.read_bytes() not in words
    watch.send_signal(signal.SIGINT)
    async with asyncio.timeout(PATIENCE_S):
        _, err = await watch.communicate()
    assert (watch.returncode, err) == (130, b"")
