"""Which gateway opens a socket: it proves its key by a challenge; older ones say the key."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.access import deny_socket
from talaia.hub.api.problems import STORE_DOWN, problem_response
from talaia.hub.auth.gateway_challenges import GatewayChallenges
from talaia.hub.errors import HubBusy, StoreDown
from talaia.hub.policy import SOCKETS, AccessNeed
from talaia.hub.store.sites.site_registry import GatewayKey
from talaia.wire.gateway_proof import (
    SCHEME,
    challenge_words,
    is_key_of,
    next_nonce_words,
    read_proof,
)

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from talaia.clock import Clock
    from talaia.hub.auth.resume_tokens import ResumeTokens
    from talaia.hub.live.gateways.join_queue import JoinQueue
    from talaia.hub.ports import Shard
    from talaia.hub.store.sites.site_registry import SiteRegistry

__all__ = ["GatewayAdmission"]

_ELSEWHERE = "another hub has this site; come again"
# Until whoever leads gateways to their hub may know better (s).
_ELSEWHERE_S = 1


class GatewayAdmission:
    """Lets gateways in, or sends them away before the upgrade."""

    def __init__(
        self,
        *,
        registry: SiteRegistry,
        resumes: ResumeTokens,
        turns: JoinQueue,
        shard: Shard,
        clock: Clock,
    ) -> None:
        """Know keys by ``registry``; ``turns`` at it, for gateways that all dial at once.

        A gateway of a site that is not of ``shard`` is sent away, to come again.
        """
        self._registry = registry
        self._shard = shard
        self._resumes = resumes
        self._turns = turns
        self._challenges = GatewayChallenges(clock)

    async def admit_gateway(self, socket: WebSocket) -> GatewayKey | None:
        """Tell which gateway opens a socket; None when it was sent away before the upgrade."""
        path = socket.scope["path"]
        scheme = socket.headers.get("authorization", "").partition(" ")[0]
        found = None
        try:
            if SOCKETS.get(path, AccessNeed.NEVER) is AccessNeed.GATEWAY:
                found = await self._find_key(socket, path)
                if not self._shard.is_whole and not await self._is_own(socket, found):
                    code, after_s = "elsewhere", _ELSEWHERE_S
                    await deny_socket(
                        socket, status=503, code=code, message=_ELSEWHERE, retry_s=after_s
                    )
                    return None
        except HubBusy as error:
            # No fault of the key: a 401 would say that it is void.
            after_s = round(self._turns.after_s)
            await deny_socket(socket, status=503, code="busy", message=str(error), retry_s=after_s)
            return None
        except StoreDown:
            await deny_socket(socket, status=503, code="store", message=STORE_DOWN, retry_s=2)
            return None
        if found is None:
            said = "this key is not known, or was revoked"
            answer = problem_response(401, "unauthorized", said)
            # Whoever asks for a number is told one, known or not.
            if scheme.lower() == SCHEME.lower():
                nonce = self._challenges.make_nonce()
                answer.headers["WWW-Authenticate"] = challenge_words(nonce)
            await socket.send_denial_response(answer)
        return found

    async def accept_socket(self, socket: WebSocket, key: GatewayKey) -> None:
        """Let a gateway in; one that proves its key is told a number for its next connection."""
        words = next_nonce_words(self._challenges.make_nonce()) if key.challenged else ""
        headers = [(b"authentication-info", words.encode())] if words else []
        await socket.accept(headers=headers)

    async def _is_own(self, socket: WebSocket, found: GatewayKey | None) -> bool:
        # Before anything is told of its key; one that only asks for a number says its site, too.
        proof = read_proof(socket.headers.get("authorization", ""))
        said = "" if proof is None else proof.site
        site = said if found is None else found.site
        return not site or await self._shard.look_up(site)

    async def _find_key(self, socket: WebSocket, path: str) -> GatewayKey | None:
        header = socket.headers.get("authorization", "")
        kind, _, key = header.partition(" ")
        if kind.lower() == "bearer" and key:
            # Only the look-up is in the turn, not the life of the link; all at once share a query.
            async with self._turns.wait_turn():
                return await self._registry.gateway_of(key.strip())
        said = read_proof(header)
        # Without our own open number nothing is looked up.
        if said is None or not said.nonce or not self._challenges.is_open(said.nonce):
            return None
        async with self._turns.wait_turn():
            keys = await self._registry.keys_of_site(said.site)
        for number, key_hash in keys:
            # Again: another socket may have answered the same number meanwhile.
            if is_key_of(said, key_hash, path) and self._challenges.is_open(said.nonce):
                self._challenges.use_nonce(said.nonce)
                resumed = self._resumes.read_token(number, said, path)
                return GatewayKey(number, said.site, challenged=True, resumed=resumed)
        return None
