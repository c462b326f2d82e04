"""A rollout of sites of several shards: each shard hands the release to its own gateways."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

import msgspec

from talaia.hub.sharding.held_answers import HeldAnswer, ask_shard, problem_answer
from talaia.hub.sharding.merged_bodies import join_rollouts, read_rollout
from talaia.hub.sharding.plan import MAIN

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from starlette.types import ASGIApp, Scope

__all__ = ["SplitRollouts"]

_LOG = logging.getLogger(__name__)
_DONE, _MADE = 204, 201
_AWAY = "one of the hubs that have these sites cannot be reached; nothing was handed out"
_NOT_STOPPED = "one of the hubs cannot be reached and may hand it out yet; stop it again"


class SplitRollouts:
    """Begins and stops rollouts at all shards."""

    def __init__(
        self, apps: Mapping[str, ASGIApp], shard_of: Callable[[str], Awaitable[str] | str]
    ) -> None:
        """Ask ``apps`` by shard; ``shard_of`` names a site's."""
        self._apps = apps
        self._shard_of = shard_of

    async def begin(self, scope: Scope, body: bytes) -> HeldAnswer:
        """Begin one: at all shards that have sites of it, or at none."""
        asked = _read_asked(body)
        if asked is None:
            # The main shard says what is wrong.
            return await ask_shard(self._apps[MAIN], scope, body)
        running = await self._find_running(scope)
        if running is not None:
            return running
        begun: list[tuple[str, HeldAnswer]] = []
        for shard, sites in (await self._split(asked["sites"])).items():
            own = msgspec.json.encode({**asked, "sites": sites})
            answer = await self._ask(shard, _with_length(scope, own), own)
            if answer.status != _MADE:
                await self._take_back([name for name, _ in begun], scope)
                return answer
            begun.append((shard, answer))
        first = begun[0][1]
        rollouts = [msgspec.json.decode(answer.body) for _, answer in begun]
        return first._replace(body=msgspec.json.encode(join_rollouts(rollouts)))

    async def stop(self, scope: Scope, body: bytes) -> HeldAnswer:
        """Stop what is under way, at all shards."""
        answers = [await self._ask(shard, scope, body) for shard in self._apps]
        main = answers[0]
        # A refusal of another kind than that nothing is under way is said as it is.
        unsaid = [one for one in answers if one.status not in {_DONE, 409}]
        if unsaid:
            is_away = unsaid[0] is not main and unsaid[0].status >= 500
            return problem_answer(503, "busy", _NOT_STOPPED, 1) if is_away else unsaid[0]
        return next((one for one in answers if one.status == _DONE), main)

    async def _find_running(self, scope: Scope) -> HeldAnswer | None:
        """Say no if a rollout is under way at a shard, also at one that has no site of this one."""
        about = {**scope, "method": "GET", "path": "/api/releases", "raw_path": b"/api/releases"}
        for shard in self._apps:
            answer = await self._ask(shard, _with_length(about, b""), b"")
            if answer.status != 200:
                return answer
            found = read_rollout(answer.body)
            if found is not None and found["runs"]:
                said = f"the rollout of {found['version']} is under way; stop it before another"
                return problem_answer(409, "refused", said)
        return None

    async def _split(self, sites: list[str]) -> dict[str, list[str]]:
        split: dict[str, list[str]] = {}
        for site in sites:
            found = self._shard_of(site)
            shard = found if isinstance(found, str) else await found
            split.setdefault(shard if shard in self._apps else MAIN, []).append(site)
        return split

    async def _take_back(self, shards: list[str], scope: Scope) -> None:
        path = "/api/rollouts/stop"
        stop = _with_length({**scope, "path": path, "raw_path": path.encode()}, b"")
        for shard in shards:
            answer = await self._ask(shard, stop, b"")
            if answer.status != _DONE:
                _LOG.warning("a rollout goes on at shard %s, though not at another", shard)

    async def _ask(self, shard: str, scope: Scope, body: bytes) -> HeldAnswer:
        try:
            return await ask_shard(self._apps[shard], scope, body)
        except OSError:
            if shard == MAIN:
                raise
            return problem_answer(503, "busy", _AWAY, 1)


def _read_asked(body: bytes) -> dict[str, Any] | None:
    """Read which sites are asked for; None: that cannot be read."""
    try:
        asked = msgspec.json.decode(body, type=dict[str, Any])
    except (msgspec.DecodeError, RecursionError, UnicodeError):
        return None
    sites = asked.get("sites")
    good = isinstance(sites, list) and sites and all(isinstance(site, str) for site in sites)
    return asked if good else None


def _with_length(scope: Scope, body: bytes) -> Scope:
    headers = [(name, said) for name, said in scope["headers"] if name != b"content-length"]
    return {**scope, "headers": [*headers, (b"content-length", str(len(body)).encode())]}
