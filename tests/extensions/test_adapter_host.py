"""An adapter of an extension in its process: keys, and every way in which it can be broken."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from talaia.extensions.installed import installed_extensions
from talaia.gateway.accepted_changes import AcceptedChanges
from talaia.gateway.change_policy import forbidden_changes
from talaia.gateway.errors import SettingsError
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.wire.frames import CommandPhase

from .adapter_bench import Bench, adapting
from .broken_packages import write_package

if TYPE_CHECKING:
    from pathlib import Path

ADAPTER = """
import asyncio, os, sys, time
from talaia.extend.adapter import *
class Keys(ExtensionKeys, frozen=True, kw_only=True):
    word: str = "x"
class Command(ExtensionKeys, frozen=True, kw_only=True):
    target: str
    angle: float = 0.0
class A:
    def __init__(self, keys, host):
        self.host = host
        {begin}
    async def run(self):
        self.host.connected()
        {run}
        await asyncio.Event().wait()
    async def execute(self, request):
        {execute}
extension = AdapterExtension(api=1, summary="t", connection=Keys, source=Keys, make=A,
                             command=Command)
"""
SITE = """
talaia: 1
site: lab
name: Lab
connections:
  one: {kind: extension, extension: thing, keys: {word: hello}}
devices:
  box:
    name: Box
    signals:
      speed: {name: Speed, unit: m/s, scale: 0.5, source: {keys: {word: v}}}
      door: {name: Door, type: state, states: [closed, open], source: {}}
      said: {name: Said, type: text, source: {}}
    commands:
      go:
        name: Go
        kind: extension
        target: place
        arguments: {angle: {type: number, field: angle}}
"""


@pytest.fixture
def written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def write(run: str = "pass", execute: str = "return ''", begin: str = "pass") -> None:
        code = ADAPTER.format(run=run, execute=execute, begin=begin)
        write_package(tmp_path, "thing", "talaia.adapters", "thing", code)

    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    installed_extensions.cache_clear()
    yield write
    installed_extensions.cache_clear()


async def test_values_are_scaled_words_are_states_and_wrong_ones_are_named_once(
    written, tmp_path: Path
) -> None:
    written(
        run="h = self.host; h.publish('box/speed', 3); h.publish('box/door', 'open');"
        " h.publish('box/said', 'hi'); h.publish('box/door', 'ajar'); h.publish('box/door', 7);"
        " h.publish('box/speed', float('nan'), 5); h.report('note', 'well');"
        " h.device_reachable('box', reachable=False, why='asleep'); print('not a word of ours')"
    )
    async with adapting(SITE, tmp_path) as bench:
        await bench.until(lambda: len(bench.values) == 3 and bench.away)
        assert bench.values == {"box/speed": 1.5, "box/door": 1.0, "box/said": "hi"}
        assert bench.away == {"box": "asleep"}
        kinds = [kind for kind, _ in bench.events]
        assert sorted(kinds) == ["note", "unreadable", "unreadable"]
        assert bench.lost == []


async def test_commands_end_as_the_extension_says_or_are_unknown(written, tmp_path: Path) -> None:
    written(
        execute="k = request.keys.angle\n"
        "        if k == 1: raise CommandRefused('not now')\n"
        "        if k == 2: raise ExecutionFailed('stuck')\n"
        "        if k == 3: raise KeyError('oh')\n"
        "        if k == 4: import msgspec; msgspec.convert('x', int)\n"
        "        if k == 5: os._exit(1)\n"
        "        return f'{request.device} {request.command} {request.keys.target} {k:g}'"
    )
    async with adapting(SITE, tmp_path) as bench:
        await bench.until(lambda: bench.ups)
        ends = [await bench.do("box", "go", angle=each) for each in (0.5, 1, 2, 3, 4, 5)]
    assert [each.phase for each in ends] == [
        CommandPhase.SUCCEEDED, CommandPhase.REFUSED, CommandPhase.FAILED,
        CommandPhase.UNKNOWN, CommandPhase.UNKNOWN, CommandPhase.UNKNOWN,
    ]  # fmt: skip
    assert [each.message for each in ends[:3]] == ["box go place 0.5", "not now", "stuck"]
    assert "KeyError" in ends[3].message
    # The extension's own mistake, when the command may have been begun.
    assert "ValidationError" in ends[4].message
    assert "look at the device" in ends[5].message


@pytest.mark.parametrize(
    ("how", "why"),
    [
        ({"run": "1 / 0"}, "the extension 'thing' failed: ZeroDivisionError"),
        ({"run": "return"}, "the extension 'thing' failed: its run ended by itself"),
        ({"run": "raise ConnectionLost('no cable')"}, "no cable"),
        ({"run": "os._exit(3)"}, "its process ended without a word"),
        ({"begin": "raise RuntimeError('no')"}, "the extension 'thing' failed: RuntimeError: no"),
        ({"run": "self.host.publish('box/none', 1)"}, "'box/none is no signal of this adapter'"),
    ],
)
async def test_an_adapter_that_breaks_is_named_and_begun_again(
    how: dict[str, str], why: str, written, tmp_path: Path
) -> None:
    written(**how)
    async with adapting(SITE, tmp_path) as bench:
        await bench.until(lambda: len(bench.lost) >= 2)
        assert why in bench.lost[0]
        assert bench.lost[0] == bench.lost[1]
    if "failed" in why:
        assert [each.name for each in installed_extensions().list_broken()] == ["thing"]


async def test_an_adapter_that_blocks_is_ended_with_the_gateway_and_holds_nothing_up(
    written, tmp_path: Path
) -> None:
    written(run="self.host.publish('box/speed', 1); await asyncio.sleep(0.01); time.sleep(3600)")
    turns = 0
    async with adapting(SITE, tmp_path) as bench:
        await bench.until(lambda: bench.values)
        for _ in range(100):
            await asyncio.sleep(0)
            turns += 1
    assert turns == 100


def test_an_extension_that_is_not_installed_is_refused_and_named(tmp_path: Path) -> None:
    installed_extensions.cache_clear()
    with pytest.raises(SettingsError, match=r"needs the extension 'thing', .*installed adapters:"):
        Bench(SITE, tmp_path)


async def test_keys_that_do_not_fit_are_told_with_their_place(written, tmp_path: Path) -> None:
    written()
    wrong = SITE.replace("word: v", "wort: v").replace("word: hello", "word: 5")
    assert check_site(load_site(wrong)) == []
    where = [
        each.where
        for each in check_site(load_site(wrong), installed_extensions().description_rules())
    ]
    assert where == [
        "$.connections.one.keys.word", "$.devices.box.signals.speed.source.keys.wort",
    ]  # fmt: skip
    async with adapting(wrong, tmp_path) as bench:
        await bench.until(lambda: bench.lost)
        assert "$.connections.one.keys.word: expected str, got int" in bench.lost[0]
        assert "did you mean 'word'?" in bench.lost[0]


def test_commands_of_an_extension_are_checked_by_its_keys(written) -> None:
    written()
    wrong = SITE.replace("field: angle", "field: angel").replace("target: place", "target: ''")
    found = check_site(load_site(wrong), installed_extensions().description_rules())
    assert [each.where for each in found] == ["$.devices.box.commands.go.fixed.angel"]
    no_kind = SITE.replace("kind: extension\n        target", "target")
    (found,) = check_site(load_site(no_kind))
    assert found.remedy == "write one of: extension"


def test_a_hub_without_the_extension_keeps_every_key() -> None:
    site = load_site(SITE)
    assert check_site(site) == []
    assert load_site(dump_site(site)) == site
    assert site.devices["box"].signals["speed"].source.keys == {"word": "v"}


@pytest.mark.parametrize(
    ("before", "after"),
    [("word: hello", "word: other"), ("word: v", "word: w"), ("target: place", "target: x")],
)
def test_what_an_extension_is_asked_for_is_not_changed_from_the_hub(
    before: str, after: str
) -> None:
    changed = load_site(SITE.replace(before, after))
    assert forbidden_changes(load_site(SITE), changed, AcceptedChanges.ALL)
