"""Questions to one ONVIF camera, signed, each on a line and a thread of its own.

All of them go to the host and port that the description names, whatever addresses the camera tells
of its services: of those only the path is used. So nobody else is ever sent a signature.
"""

from __future__ import annotations

import secrets
import time
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from talaia import __version__
from talaia.gateway.adapters.credentials import read_authorities, read_secret
from talaia.gateway.adapters.http.fetching import (
    FetchFailed,
    HttpPost,
    HttpQuestion,
    HttpServer,
    StatusRefused,
)
from talaia.gateway.adapters.onvif.answers import parse_clock, parse_paths
from talaia.gateway.adapters.onvif.http_digest import authorization_of, best_challenge
from talaia.gateway.adapters.onvif.soap import (
    CameraFault,
    Signature,
    content_type_of,
    envelope_of,
    fault_in,
    parse_answer,
)
from talaia.gateway.adapters.onvif.xml_nodes import UnreadableXml, XmlNode

if TYPE_CHECKING:
    from pathlib import Path

    from talaia.gateway.adapters.onvif.http_digest import DigestChallenge
    from talaia.model.connection import OnvifConnection

__all__ = ["OnvifServer"]

# A Move, its Stop, the poll and a command, each of which may be asked twice at once.
_THREADS = 8
_LONGEST = 1024 * 1024


class OnvifServer:
    """Asks one camera. On the event loop; `close` when nothing is to be asked any more."""

    def __init__(self, settings: OnvifConnection, folder: Path) -> None:
        """Take where it answers and who signs in; nothing is asked yet.

        Raises:
            SettingsError: the password or the authorities cannot be read.

        """
        parts = urlsplit(settings.url)
        self.where = parts.netloc
        self._user = settings.user
        self._password = read_secret("password", folder, file=settings.password_file)
        secure = parts.scheme == "https"
        self._server = HttpServer(
            f"{parts.scheme}://{parts.netloc}",
            {"User-Agent": f"talaia/{__version__}", "Accept": "application/soap+xml"},
            read_authorities(folder, settings.ca) if secure else None,
            settings.timeout,
            settings.here,
        )
        # By service, on this host and port.
        self._paths = {"device": parts.path or "/onvif/device_service"}
        # How far the camera's clock is before ours (s): signatures are dated by its own.
        self._offset_s = 0.0
        # How it wants to be signed in at, once it has said so; and how often that was answered.
        self._challenge: DigestChallenge | None = None
        self._answered = 0
        self._threads = ThreadPoolExecutor(_THREADS, "talaia-onvif")

    def close(self) -> None:
        """Ask nothing any more; what is under way is not waited for."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def begin(self) -> None:
        """Learn the camera's clock and where its services are.

        Raises:
            FetchFailed: it does not answer.
            CameraFault: it does not let us in.
            UnreadableXml: its answer is none of ONVIF's.

        """
        await self._read_clock()
        try:
            inside = "<device:IncludeCapability>false</device:IncludeCapability>"
            answer = await self.ask("device", "GetServices", inside)
        except (CameraFault, StatusRefused):
            # Older cameras know only this.
            inside = "<device:Category>All</device:Category>"
            answer = await self.ask("device", "GetCapabilities", inside)
        self._paths |= parse_paths(answer)

    def has_service(self, service: str) -> bool:
        """Tell whether the camera has a service: ``device``, ``media``, ``ptz``."""
        return service in self._paths

    async def ask(self, service: str, action: str, inside: str = "") -> XmlNode:
        """Ask a service something; give what it answers.

        Args:
            service: ``device``, ``media`` or ``ptz``.
            action: ONVIF's name of it.
            inside: what it takes, written with the prefixes of `NAMESPACES`.

        Raises:
            ServerNotReached: nothing was sent.
            FetchFailed: there is no answer: nobody knows what became of it.
            CameraFault: it refuses.
            UnreadableXml: its answer is none of ONVIF's.

        """
        if service not in self._paths:
            raise CameraFault("ActionNotSupported", f"it has no service for {service}")
        body = f"<{service}:{action}>{inside}</{service}:{action}>"
        try:
            return await self._ask_signed(service, action, body)
        except CameraFault as fault:
            # Nothing was done, so it may be asked once more. A camera whose clock was set since
            # takes no signature that is dated by the old one.
            if not fault.unauthorized or not self._password or self._challenge is not None:
                raise
        await self._read_clock()
        return await self._ask_signed(service, action, body)

    async def _ask_signed(self, service: str, action: str, body: str) -> XmlNode:
        path = self._paths[service]
        for attempt in (1, 2):
            try:
                data = await self._post(path, content_type_of(service, action), body)
            except StatusRefused as refused:
                challenge = best_challenge(refused.challenges)
                if refused.status == 401 and challenge and self._password and attempt == 1:
                    # Another one each time that it has grown old.
                    self._challenge, self._answered = challenge, 0
                    continue
                raise _refusal_of(refused) from refused
            return parse_answer(data, action)
        raise AssertionError  # The second attempt has returned or raised.

    async def _post(self, path: str, content_type: str, body: str) -> bytes:
        headers = dict(self._server.headers)
        signature = None
        if self._challenge is not None:
            self._answered += 1
            headers["Authorization"] = authorization_of(
                self._challenge,
                self._user,
                self._password,
                path=path,
                count=self._answered,
                cnonce=secrets.token_hex(8),
            )
        elif self._password:
            at = time.time() + self._offset_s
            signature = Signature(self._user, self._password, secrets.token_bytes(16), at)
        server = self._server._replace(headers=headers)
        post = HttpPost(content_type, envelope_of(body, signature))
        question = HttpQuestion(server, path, post=post, longest=_LONGEST)
        return await question.fetch_in_time(self._threads)

    async def _read_clock(self) -> None:
        """Learn how far the camera's clock is from ours; it tells that to everybody."""
        action = "GetSystemDateAndTime"
        post = HttpPost(content_type_of("device", action), envelope_of(f"<device:{action}/>"))
        question = HttpQuestion(self._server, self._paths["device"], post=post)
        try:
            data = await question.fetch_in_time(self._threads)
            told = parse_clock(parse_answer(data, action))
        except (StatusRefused, CameraFault):
            # Some tell it to nobody: then its clock is taken for right.
            told = None
        self._offset_s = 0.0 if told is None else told - time.time()


def _refusal_of(refused: StatusRefused) -> CameraFault | FetchFailed:
    """Give what a status other than 200 means: faults come with 400 and 500."""
    try:
        fault = fault_in(refused.body)
    except UnreadableXml:
        fault = None
    if fault is not None and refused.status not in (401, 403):
        return fault
    if refused.status in (401, 403):
        said = "it wants another user or password"
        if any(one.strip().lower().startswith("basic") for one in refused.challenges):
            said = "it asks for the password in plain, and does not get it"
        return CameraFault("", said, unauthorized=True)
    return refused
