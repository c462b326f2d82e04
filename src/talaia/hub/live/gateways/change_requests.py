"""Changes of a description that people ask for: handed to the gateway, which decides."""

from __future__ import annotations

import asyncio
import secrets
from typing import TYPE_CHECKING

from talaia.wire.frames import ChangePhase, ChangeRequest, ChangeState
from talaia.wire.sealing import compress_text, digest_of, seal_of

if TYPE_CHECKING:
    from talaia.hub.live.sites import LiveSite
    from talaia.hub.store.sites.site_registry import SiteRegistry

__all__ = ["ChangeRequestClient"]

# Zeros for ten seconds, a slow disk and a slow network; after that nobody knows.
ANSWER_S = 25.0


class ChangeRequestClient:
    """Asks gateways, and gives each answer to whoever asked."""

    def __init__(self, registry: SiteRegistry) -> None:
        """Seal with what ``registry`` keeps of the gateways' keys."""
        self._registry = registry
        # Site and answer of each change that somebody waits for, by its id.
        self._asked: dict[str, tuple[str, asyncio.Future[ChangeState]]] = {}
        # How each came about, in a few words; kept with the version that comes of it.
        self._notes: dict[str, str] = {}

    async def request_change(
        self, live: LiveSite, text: str, who: str, note: str = ""
    ) -> ChangeState:
        """Ask a site's gateway to go by ``text``; give how it ended.

        Without an answer in time, or when the link is lost, the answer is *waiting*: look which
        description the gateway goes by.

        Args:
            live: the site, which has a link.
            text: the description.
            who: asks for it.
            note: in a few words, how it came about; kept with the version.

        """
        link, key_hash = live.link, await self._registry.key_hash(live.gateway.id)
        name = secrets.token_hex(8)
        if link is None or key_hash is None:
            return ChangeState(
                id=name, phase=ChangePhase.REFUSED, message="the gateway is not connected now"
            )
        # Which text the change was made from.
        base = digest_of(live.gateway.source)
        data = await asyncio.to_thread(compress_text, text)
        seal = seal_of(key_hash, change_id=name, who=who, base=base, text=text)
        answer: asyncio.Future[ChangeState] = asyncio.get_running_loop().create_future()
        self._asked[name] = (live.name, answer)
        self._notes[name] = note
        try:
            link.send(ChangeRequest(id=name, source=data, base=base, who=who, seal=seal))
            async with asyncio.timeout(ANSWER_S):
                return await answer
        except TimeoutError:
            message = "the gateway has not answered; look which description it goes by"
            return ChangeState(id=name, phase=ChangePhase.WAITING, message=message)
        finally:
            del self._asked[name]
            self._notes.pop(name, None)

    def note_of(self, change_id: str) -> str:
        """Give what was noted of a change that is being waited for."""
        return self._notes.get(change_id, "")

    def receive_state(self, live: LiveSite, state: ChangeState) -> None:
        """Take what a gateway says of a change, or of its own file."""
        if not state.id:
            live.gateway.problem = state if state.phase is ChangePhase.REFUSED else None
            return
        # An id answers for its own site only: no gateway ends the change of another's.
        site, answer = self._asked.get(state.id, ("", None))
        final = state.phase is not ChangePhase.WAITING
        if answer is not None and site == live.name and final and not answer.done():
            answer.set_result(state)

    def link_lost(self, live: LiveSite) -> None:
        """Tell those who wait that there is no answer."""
        message = "the connection was lost; look which description the gateway goes by"
        for name, (site, answer) in self._asked.items():
            if site == live.name and not answer.done():
                # Not refused: the gateway may go by it all the same.
                answer.set_result(ChangeState(id=name, phase=ChangePhase.WAITING, message=message))
