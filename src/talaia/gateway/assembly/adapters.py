"""The adapters: one for each connection of the site, joined into one robot."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from talaia.gateway.adapters.catalog import adapter_of
from talaia.gateway.adapters.connection_scope import connection_names, scopes_of
from talaia.gateway.adapters.connectivity import DeviceReachability
from talaia.gateway.adapters.multi_adapter import ConnectionStatus, MultiAdapter
from talaia.gateway.assembly.gateway_part import GatewayPart
from talaia.gateway.ports import AdapterContext
from talaia.gateway.taps.service import ConnectionTaps
from talaia.gateway.uplink.output_router import OutputRouter

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from talaia.gateway.adapters.connection_scope import ConnectionScope
    from talaia.gateway.assembly.description import DescriptionPart
    from talaia.gateway.assembly.foundation import FoundationPart
    from talaia.gateway.assembly.recording import RecordingPart
    from talaia.gateway.assembly.robot_log import RobotLogPart
    from talaia.gateway.assembly.samples import SamplesPart
    from talaia.gateway.assembly.taps import TapsPart
    from talaia.gateway.assembly.video import VideoPart
    from talaia.gateway.ports import Adapter

__all__ = ["AdaptersPart"]


class AdaptersPart(GatewayPart):
    """The robot's side, and what is said to it.

    Attributes:
        answers: what the commands of process connections printed, by the signal's address.
        reachability: which devices answer now.
        by_connection: each connection's adapter, by its name.
        adapter: all of them as one.
        output: what is decided here goes out by it: to the robot, the hub and the record.
        recording: what records of what they say.
        taps: raw topics of them that somebody looks at.
        robot_log: lines of the robot's log that they hear.

    """

    def __init__(
        self,
        *,
        base: FoundationPart,
        description: DescriptionPart,
        samples: SamplesPart,
        recording: RecordingPart,
        video: VideoPart,
        taps: TapsPart,
        robot_log: RobotLogPart,
    ) -> None:
        """Make an adapter for each connection; none runs yet.

        Raises:
            SettingsError: the description names a connection that cannot be used here.

        """
        self._base, self._description = base, description
        self.recording, self.taps, self.robot_log = recording, taps, robot_log
        # Filled by process adapters, read by the door for founding clients.
        self.answers: dict[str, str] = {}
        # Only for the start: `ConnectionExchange` gives both the names of another description.
        of = connection_names(description.site)
        self.reachability = DeviceReachability(of, base.clock, base.lanes.send)
        self._context = AdapterContext(
            clock=base.clock,
            samples=samples.sink,
            pictures=video.pictures,
            events=base.events,
            folder=base.settings.folder,
            domain=base.settings.domain,
            answers=self.answers,
            raw=recording.recorder,
            frames=video.frame_taker,
            files=video.whole_files,
            site=description.site.name,
            kept_log=robot_log.reporter,
            budget=video.budget,
        )
        scopes = scopes_of(description.site, description.numbering)
        # Each with its status: `ConnectionExchange` exchanges both together.
        self.by_connection = {scope.name: self.make_adapter(scope) for scope in scopes}
        self.adapter = MultiAdapter(
            of=of,
            # A copy: this one is replaced whole when another description counts.
            adapters=dict(self.by_connection),
            reach=self.reachability,
            events=base.events,
        )
        taps.service.attach_adapter(self.adapter)
        # What is worked out is unknown as soon as what it is worked out from is.
        samples.sink.attach_reachability(self.reachability.still_counts)
        self.adapter.subscribe_losses(lost=samples.sink.forget_devices, back=lambda _devices: None)
        # Made of the joined adapter, so that what is decided goes to whichever serves the device
        # now.
        self.output = OutputRouter(
            adapter=self.adapter,
            lanes=base.lanes,
            clock=base.clock,
            recorders=recording.recorders,
        )

    def make_adapter(self, scope: ConnectionScope) -> tuple[Adapter, ConnectionStatus]:
        """Make the adapter of one connection, and where it says how its side stands.

        Raises:
            SettingsError: the connection cannot be used here.

        """
        status = ConnectionStatus(scope.name, self._base.loop, self.reachability)
        # Bound to the connection's name: what is found is kept by it.
        status.on_found = partial(self._description.restart.found, scope.name)
        context = self._context._replace(taps=ConnectionTaps(self.taps.service, scope.name))
        return adapter_of(scope, context, status), status

    def tasks(self) -> Mapping[str, Callable[[], Awaitable[None]]]:
        """Read the robot."""
        return {"robot": self.adapter.run}
