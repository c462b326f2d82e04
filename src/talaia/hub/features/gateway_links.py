"""The links of gateways: samples and states come in, commands go out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.api.sockets.gateway_sockets import GatewaySocket
from talaia.hub.features.feature import Feature
from talaia.hub.live.gateways.doubles.gateway_places import GatewayPlaces
from talaia.hub.live.gateways.join_queue import JoinQueue
from talaia.hub.live.gateways.link_service import LinkService

if TYPE_CHECKING:
    from talaia.hub.api.sockets.socket_admission import SocketAdmission
    from talaia.hub.features.feature import Core
    from talaia.hub.features.gateways import GatewaysFeature
    from talaia.hub.live.assets.robot_assets import RobotAssets
    from talaia.hub.live.detection.sightings import SightingJournal
    from talaia.hub.live.gateways.description_intake import DescriptionIntake
    from talaia.hub.live.gateways.flood_guard import FloodGuard
    from talaia.hub.live.gateways.live_samples import LiveSamples
    from talaia.hub.live.gateways.robot_events import RobotEvents
    from talaia.hub.live.observing.night_link import NightLink
    from talaia.hub.live.pictures.picture_fanout import PictureFanout
    from talaia.hub.live.robot_log_intake import RobotLogIntake
    from talaia.hub.ports import History

__all__ = ["GatewayLinksFeature"]


class GatewayLinksFeature(Feature):
    """Serves the link of each gateway; its pictures and files have sockets of their own."""

    name = "gateway_links"

    def __init__(
        self,
        core: Core,
        *,
        admission: SocketAdmission,
        gateways: GatewaysFeature,
        describing: DescriptionIntake,
        reporting: RobotEvents,
        flood_guard: FloodGuard,
        samples: LiveSamples,
        sightings: SightingJournal,
        media: PictureFanout,
        assets: RobotAssets,
        nights: NightLink,
        robot_log: RobotLogIntake,
        history: History,
    ) -> None:
        """Lead what a gateway says to the parts that it is for."""
        links = LinkService(
            sites=core.sites,
            describing=describing,
            reporting=reporting,
            samples=samples,
            sightings=sightings,
            media=media,
            taps=core.taps,
            assets=assets,
            watched=core.fanout.watched,
            nights=nights,
            robot_log=robot_log,
            history=history,
            attendance=gateways.registry.attendance,
            links=gateways.links,
            # Turns for the hello; those for the key are `PeopleFeature`'s.
            admission=JoinQueue(),
            flood_guard=flood_guard,
            places=GatewayPlaces(
                sites=core.sites,
                reporting=reporting,
                resumes=core.resumes,
                clock=core.clock,
                beat_s=core.settings.beat_s,
            ),
            settings=core.settings,
            clock=core.clock,
        )
        socket = GatewaySocket(
            "/gateway/link", admission=admission, flood_guard=flood_guard, server=links
        )
        self.sockets = [socket.router()]
