"""The pictures of an ONVIF camera, read as those of any camera with RTSP."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.model.connection import OnvifSource, VideoConnection, VideoSource, source_as

if TYPE_CHECKING:
    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.adapters.video.adapter import VideoAdapter
    from talaia.gateway.ports import AdapterContext
    from talaia.model.connection import OnvifConnection

__all__ = ["pictures_of"]


def pictures_of(
    scope: ConnectionScope, settings: OnvifConnection, context: AdapterContext
) -> VideoAdapter | None:
    """Make what reads the camera's pictures, as those of any camera with RTSP."""
    if not any(device.streams for device in scope.devices.values()):
        return None
    # Here: a camera whose pictures nobody wants needs no codec.
    from talaia.gateway.adapters.video.adapter import VideoAdapter

    devices = {
        name: msgspec.structs.replace(
            device,
            signals={},
            streams={
                key: msgspec.structs.replace(
                    stream, source=VideoSource(url=source_as(stream.source, OnvifSource).url)
                )
                for key, stream in device.streams.items()
            },
        )
        for name, device in scope.devices.items()
    }
    video = VideoConnection(
        user=settings.user,
        password_file=settings.password_file,
        udp=settings.udp,
        here=settings.here,
    )
    return VideoAdapter(scope._replace(connection=video, devices=devices), context, _SilentStatus())


class _SilentStatus:
    """An `AdapterStatus` of which nobody hears: how a camera stands, its control says."""

    def up(self) -> None:
        """See `AdapterStatus.up`."""

    def device(self, device: str, *, there: bool, why: str = "", sure: bool = True) -> None:
        """See `AdapterStatus.device`."""

    def found(self, devices: object) -> None:
        """See `AdapterStatus.found`."""
