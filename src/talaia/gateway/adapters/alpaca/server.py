"""Questions to one Alpaca server over HTTP, each on a line and a thread of its own."""

from __future__ import annotations

import itertools
import random
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

from talaia import __version__
from talaia.gateway.adapters.alpaca.protocol import (
    AlpacaRefused,
    Configured,
    device_path,
    parse_configured,
    parse_value,
    property_path,
    put_form,
)
from talaia.gateway.adapters.http.fetching import HttpQuestion, HttpServer, StatusRefused

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.gateway.adapters.alpaca.protocol import Scalar
    from talaia.model.connection import AlpacaConnection

__all__ = ["AlpacaServer"]

# Of a picture: 61 million pixels of 4 bytes, and room.
_LONGEST_PICTURE = 300 * 1024 * 1024
_PICTURE_S = 120.0
_THREADS = 32


class AlpacaServer:
    """Asks one server. On the event loop; `close` when nothing is to be asked any more."""

    def __init__(self, settings: AlpacaConnection) -> None:
        """Take where it answers; nothing is asked yet."""
        host = f"[{settings.host}]" if ":" in settings.host else settings.host
        self.where = f"{host}:{settings.port}"
        headers = {"User-Agent": f"talaia/{__version__}", "Accept": "application/json"}
        url = f"http://{self.where}"
        self._server = HttpServer(url, headers, None, settings.timeout, settings.here)
        picture = {**headers, "Accept": "application/imagebytes"}
        self._pictures = HttpServer(url, picture, None, _PICTURE_S, settings.here)
        # Tells this client apart in a server's log; ASCOM asks for 1 to 65535.
        self._client = random.SystemRandom().randint(1, 65_535)
        self._transactions = itertools.count(1)
        self._threads = ThreadPoolExecutor(_THREADS, "talaia-alpaca")

    def close(self) -> None:
        """Ask nothing any more; what is under way is not waited for."""
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def ask_property(self, address: str) -> object:
        """Give a property's value.

        Raises:
            FetchFailed: there is no answer.
            AlpacaRefused: the answer is an error.

        """
        number = next(self._transactions)
        path = property_path(address, self._client, number)
        return parse_value(await self._ask_words(HttpQuestion(self._server, path)), number)

    async def put_method(self, address: str, fields: Mapping[str, Scalar], seconds: float) -> None:
        """Call a method, once.

        Args:
            address: ``dome/0/openshutter``.
            fields: its parameters.
            seconds: older drivers answer only when it is done (s).

        Raises:
            ServerNotReached: nothing was sent.
            FetchFailed: it was sent, and there is no answer: nobody knows what became of it.
            AlpacaRefused: the answer is an error.

        """
        number = next(self._transactions)
        form = put_form(fields, self._client, number)
        server = self._server._replace(timeout=seconds)
        question = HttpQuestion(server, device_path(address), form=form)
        parse_value(await self._ask_words(question), number)

    async def fetch_picture(self, camera: str) -> bytes:
        """Give a camera's newest picture as it comes: ImageBytes, or JSON of an older server.

        Raises:
            FetchFailed: there is no answer.
            AlpacaRefused: the answer is an error.

        """
        path = property_path(f"{camera}/imagearray", self._client, next(self._transactions))
        question = HttpQuestion(self._pictures, path, longest=_LONGEST_PICTURE)
        return await self._ask_words(question)

    async def list_devices(self) -> list[Configured] | None:
        """Give the devices that it has; none if it has no management API.

        Raises:
            FetchFailed: there is no answer.
            AlpacaRefused: the answer is no list of devices.

        """
        question = HttpQuestion(self._server, "/management/v1/configureddevices")
        try:
            return parse_configured(await question.fetch_in_time(self._threads))
        except StatusRefused as error:
            if error.status in (400, 404, 405):
                return None
            raise

    async def _ask_words(self, question: HttpQuestion) -> bytes:
        try:
            return await question.fetch_in_time(self._threads)
        except StatusRefused as error:
            # By the API's text 400 is a question that cannot be read: nothing is done then.
            refused = 400 <= error.status < 500
            words = f"status {error.status}: {error.words}"
            raise AlpacaRefused(0, words, refused=refused) from error
