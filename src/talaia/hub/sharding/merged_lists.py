"""Requests about all sites: each shard answers for its own, and one answer is made of them.

The main shard is asked first: whom it refuses gets its answer. Where another one cannot be reached,
the answer has what the others say, and names the shard in the header ``x-talaia-missing``.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.sharding.held_answers import (
    HeldAnswer,
    RequestTooLong,
    ask_shard,
    problem_answer,
    read_body,
    send_answer,
)
from talaia.hub.sharding.merged_bodies import (
    join_client_protocols,
    join_commands,
    join_devices,
    join_gateways,
    join_releases,
    join_sites,
    join_storage,
)
from talaia.hub.sharding.merged_metrics import join_metrics, join_past_series
from talaia.hub.sharding.plan import MAIN
from talaia.hub.sharding.split_rollouts import SplitRollouts

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping, Sequence

    from starlette.types import ASGIApp, Receive, Scope, Send

__all__ = ["MISSING", "MergedLists"]

_LOG = logging.getLogger(__name__)
# Names the shards that did not answer, with commas between.
MISSING = b"x-talaia-missing"
# A shard that has not answered by then is left out (s): lists that each page begins with, and what
# is looked for in a history.
_SOON_S, _LATER_S = 5.0, 60.0


class _Merge(NamedTuple):
    """How one request's answers are put together.

    Attributes:
        join: bodies by shard, those that answered, the main one first, to one body.
        is_long: to look for the answer may take a shard more than a moment.
        by_site: a shard refuses (403) those who may have nothing of its own sites, though they may
            have something of another's.

    """

    join: Callable[[Mapping[str, bytes]], bytes]
    is_long: bool = False
    by_site: bool = False


def _plainly(join: Callable[[Sequence[bytes]], bytes]) -> Callable[[Mapping[str, bytes]], bytes]:
    return lambda bodies: join(list(bodies.values()))


_MERGED: dict[tuple[str, str], _Merge] = {
    ("GET", "/api/sites"): _Merge(_plainly(join_sites)),
    ("GET", "/api/devices"): _Merge(_plainly(join_devices)),
    ("GET", "/api/commands"): _Merge(_plainly(join_commands)),
    ("GET", "/api/gateways"): _Merge(_plainly(join_gateways)),
    ("GET", "/api/client-protocols"): _Merge(_plainly(join_client_protocols)),
    ("GET", "/api/releases"): _Merge(_plainly(join_releases)),
    ("GET", "/api/storage"): _Merge(_plainly(join_storage), is_long=True),
    ("GET", "/api/storage/outlook"): _Merge(_plainly(join_storage), is_long=True),
    ("GET", "/metrics"): _Merge(lambda bodies: join_metrics(bodies, MAIN), by_site=True),
    ("POST", "/clients/prometheus/read"): _Merge(
        _plainly(join_past_series), is_long=True, by_site=True
    ),
}
# These are split by the sites that they name.
_BEGIN, _STOP = ("POST", "/api/rollouts"), ("POST", "/api/rollouts/stop")


class MergedLists:
    """Answers what is asked about all sites."""

    def __init__(
        self,
        apps: Mapping[str, ASGIApp],
        shard_of: Callable[[str], Awaitable[str] | str] = lambda _site: MAIN,
        *,
        soon_s: float = _SOON_S,
    ) -> None:
        """Ask ``apps``, by the names of their shards; ``main`` is the first of them.

        ``shard_of`` names the shard of a site, at once or later. A list goes without a shard that
        has not answered within ``soon_s``.
        """
        self._soon_s = soon_s
        self._apps = apps
        self._rollouts = SplitRollouts(apps, shard_of)

    @staticmethod
    def takes(method: str, path: str) -> bool:
        """Tell whether a request is one about all sites."""
        return (method, path) in _MERGED or (method, path) in {_BEGIN, _STOP}

    async def serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request that `takes` has named.

        Raises:
            Exception: the main shard cannot be reached, in its application's own words; nothing is
                answered then.

        """
        try:
            body = await read_body(receive)
        except RequestTooLong:
            await send_answer(send, problem_answer(413, "too_large", "this request is too long"))
            return
        route = scope["method"], scope["path"]
        if route == _BEGIN:
            answer = await self._rollouts.begin(scope, body)
        elif route == _STOP:
            answer = await self._rollouts.stop(scope, body)
        else:
            answer = await self._merge(_MERGED[route], scope, body)
        await send_answer(send, answer)

    async def _merge(self, merge: _Merge, scope: Scope, body: bytes) -> HeldAnswer:
        main = await ask_shard(self._apps[MAIN], scope, body)
        if main.status != 200 and not (merge.by_site and main.status == 403):
            return main
        others = [shard for shard in self._apps if shard != MAIN]
        asking = (self._ask_other(shard, scope, body, merge) for shard in others)
        answers = {MAIN: main, **dict(zip(others, await asyncio.gather(*asking), strict=True))}
        found = {
            shard: answer
            for shard, answer in answers.items()
            if answer is not None and answer.status == 200
        }
        if not found:
            return main
        joined = await asyncio.to_thread(
            merge.join, {shard: answer.body for shard, answer in found.items()}
        )
        missing = ",".join(shard for shard, answer in answers.items() if answer is None)
        headers = [*next(iter(found.values())).headers]
        if missing:
            headers.append((MISSING, missing.encode()))
        return HeldAnswer(200, headers, joined)

    async def _ask_other(
        self, shard: str, scope: Scope, body: bytes, merge: _Merge
    ) -> HeldAnswer | None:
        """Ask a shard that is not the main one; None: it is not to be reached."""
        try:
            async with asyncio.timeout(_LATER_S if merge.is_long else self._soon_s):
                answer = await ask_shard(self._apps[shard], scope, body)
        except OSError as error:
            _LOG.debug("shard %s: %r", shard, error)
            return None
        except Exception:  # noqa: BLE001 - a shard must not take the others' answers with it
            _LOG.exception("shard %s does not answer %s", shard, scope["path"])
            return None
        if answer.status == 200 or (merge.by_site and answer.status == 403):
            return answer
        _LOG.warning("shard %s answers %s with %d", shard, scope["path"], answer.status)
        return None
