"""Cameras of one Foxglove client: its subscriptions as views, pictures as its messages."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.hub.clients.foxglove.schemas import encode_picture
from talaia.wire.foxglove.codec import encode_message_data

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from talaia.hub.clients.client_cameras import ClientCameras
    from talaia.hub.clients.foxglove.offer import CameraChannel
    from talaia.wire.browser import CameraPicture

__all__ = ["CameraChannels"]

_NO_FILM = "the gateway of this camera makes no H.264; take {topic} for its pictures"


class CameraChannels:
    """What one client looks at; call `end_views` at the end."""

    def __init__(
        self,
        cameras: ClientCameras,
        *,
        subscription_of: Callable[[str], int | None],
        send: Callable[[bytes], Awaitable[None]],
        warn: Callable[[str], Awaitable[None]],
    ) -> None:
        """Look at nothing yet.

        Args:
            cameras: where pictures come from.
            subscription_of: the client's number of a topic, while it has one.
            send: returns when the client's line has taken it.
            warn: shows a warning in the client.

        """
        self._cameras = cameras
        self._subscription_of = subscription_of
        self._send = send
        self._warn = warn
        # By topic; kept here, for a new offer may not have it any more.
        self._viewed: dict[str, CameraChannel] = {}
        # Films that come as single pictures, of which the client was told.
        self._without_film: set[str] = set()

    def subscribe_topic(self, topic: str, camera: CameraChannel) -> None:
        """Begin to look."""
        self._viewed[topic] = camera
        deliver = partial(self._deliver_picture, topic, camera)
        self._cameras.subscribe_stream(camera.stream, deliver, self._warn, film=camera.film)

    def unsubscribe_topic(self, topic: str) -> None:
        """Look no more; nothing happens where it is no camera that is looked at."""
        camera = self._viewed.pop(topic, None)
        if camera is not None:
            self._without_film.discard(topic)
            self._cameras.unsubscribe_stream(camera.stream, film=camera.film)

    def end_views(self) -> None:
        """Look at nothing any more."""
        self._cameras.end_views()

    async def _deliver_picture(
        self, topic: str, camera: CameraChannel, picture: CameraPicture
    ) -> None:
        subscription = self._subscription_of(topic)
        if subscription is None:
            return
        # Of gateways that make no film, single pictures come in its place.
        if picture.format != ("h264" if camera.film else "jpeg"):
            if topic not in self._without_film:
                self._without_film.add(topic)
                await self._warn(_NO_FILM.format(topic=topic.removesuffix("/video")))
            return
        # Single pictures and films are of one optical frame.
        frame = topic.removesuffix("/video") if camera.film else topic
        data = encode_picture(
            picture.data, camera=frame, time_us=picture.time_us, form=picture.format
        )
        await self._send(encode_message_data(subscription, picture.time_us * 1000, data))
