"""The hub put together: an ordered table of features."""

from __future__ import annotations

from typing import TYPE_CHECKING

from talaia.hub.assembly import AssembledHub
from talaia.hub.features.alarms import AlarmsFeature
from talaia.hub.features.anomalies import AnomaliesFeature
from talaia.hub.features.archive import ArchiveFeature
from talaia.hub.features.audit import AuditFeature
from talaia.hub.features.boards import BoardsFeature
from talaia.hub.features.connections.client_features import build_client_features
from talaia.hub.features.connections.client_protocols import ClientProtocolsFeature
from talaia.hub.features.connections.page_service import ConnectionsFeature
from talaia.hub.features.connections.taps import TapsFeature
from talaia.hub.features.descriptions import DescriptionsFeature
from talaia.hub.features.detection import DetectionFeature
from talaia.hub.features.extensions import ExtensionsFeature
from talaia.hub.features.gateway_links import GatewayLinksFeature
from talaia.hub.features.gateways import GatewaysFeature
from talaia.hub.features.history import HistoryFeature
from talaia.hub.features.media import MediaFeature
from talaia.hub.features.nights.alert_notices import AlertNoticesFeature
from talaia.hub.features.nights.observing import ObservingFeature
from talaia.hub.features.notifications import NotificationsFeature
from talaia.hub.features.pages import PagesFeature
from talaia.hub.features.people import PeopleFeature
from talaia.hub.features.recordings import RecordingsFeature
from talaia.hub.features.records.files import FilesFeature
from talaia.hub.features.records.hubs import HubsFeature
from talaia.hub.features.records.imports import ImportsFeature
from talaia.hub.features.records.maps import MapsFeature
from talaia.hub.features.records.missions import MissionsFeature
from talaia.hub.features.records.notes import NotesFeature
from talaia.hub.features.records.releases import ReleasesFeature
from talaia.hub.features.records.robot_log import RobotLogFeature
from talaia.hub.features.records.storage import StorageFeature
from talaia.hub.features.records.support import SupportFeature
from talaia.hub.features.robot_events import RobotEventsFeature
from talaia.hub.features.sightings import SightingsFeature

if TYPE_CHECKING:
    from talaia.clock import Clock
    from talaia.hub.ports import ClusterSeat, History
    from talaia.hub.settings import Settings

__all__ = ["Hub", "build_hub"]


class Hub(AssembledHub):
    """The hub of the product."""

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        history: History | None = None,
        *,
        seat: ClusterSeat | None = None,
    ) -> None:
        """Build every feature from those before it; nothing is opened yet."""
        super().__init__(settings, clock, seat=seat)
        # First: features close in the reverse order, so the log is there until the end.
        core, self.audit = self.core, AuditFeature(self.core)
        log = self.audit.log
        # Before people: a gateway's socket is admitted by the key that the registry knows.
        self.gateways = GatewaysFeature(core, audit=log)
        registry, links = self.gateways.registry, self.gateways.links
        self.people = PeopleFeature(core, audit=log, registry=registry)
        admission, seats = self.people.admission, self.people.seats
        self.history = HistoryFeature(core, store=history, registry=registry)
        store = self.history.store
        self.taps = TapsFeature(core, admission=admission, seats=seats, audit=log)
        # Before whatever finds something: detectors, cameras and gateways all speak to the engine.
        self.alarms = AlarmsFeature(core, people=self.people.accounts, history=store, audit=log)
        alarms = self.alarms.engine
        self.notifications = NotificationsFeature(
            core, alarms=alarms, outbox=self.alarms.outbox, audit=log
        )
        self.robot_events = RobotEventsFeature(core, alarms=alarms, audit=log)
        reporting, flood_guard = self.robot_events.reporting, self.robot_events.flood_guard
        self.media = MediaFeature(
            core, people=self.people, links=links, flood_guard=flood_guard, audit=log
        )
        self.anomalies = AnomaliesFeature(
            core, history=store, reporting=reporting, alarms=alarms, audit=log
        )
        self.sightings = SightingsFeature(core, alarms=alarms)
        self.detection = DetectionFeature(
            core,
            media=self.media.streams,
            history=store,
            sightings=self.sightings.journal,
            reporting=reporting,
            alarms=alarms,
            anomalies=self.anomalies.detectors,
        )
        self._add_gateway_links()
        self._add_connections()
        self._serve_guarded()

    def _add_gateway_links(self) -> None:
        """Build what gateways bring, and the links over which they do."""
        core, log, registry = self.core, self.audit.log, self.gateways.registry
        admission, links = self.people.admission, self.gateways.links
        reporting, flood_guard = self.robot_events.reporting, self.robot_events.flood_guard
        store, alarms = self.history.store, self.alarms.engine
        self.files = FilesFeature(core)
        self.archive = ArchiveFeature(core, store=self.files.store, audit=log)
        self.releases = ReleasesFeature(core, reporting=reporting, audit=log)
        self.recordings = RecordingsFeature(
            core,
            store=self.files.store,
            admission=admission,
            links=links,
            flood_guard=flood_guard,
            uploads=self.archive.uploads,
            assets=self.taps.assets,
            releases=self.releases.rollouts.folder,
            audit=log,
        )
        self.observing = ObservingFeature(
            core, deliver=self.notifications.wake_up, archive=self.archive.frames, audit=log
        )
        self.descriptions = DescriptionsFeature(
            core,
            followers=(*core.followers, alarms, self.sightings.journal, self.detection.cameras),
            reporting=reporting,
            media=self.media.streams,
            history=store,
            registry=registry,
            audit=log,
        )
        self.robot_log = RobotLogFeature(core)
        # After all that a gateway's messages are led to.
        self.gateway_links = GatewayLinksFeature(
            core,
            admission=admission,
            gateways=self.gateways,
            describing=self.descriptions.describing,
            reporting=reporting,
            flood_guard=flood_guard,
            samples=self.detection.samples,
            sightings=self.sightings.journal,
            media=self.media.streams,
            assets=self.taps.assets,
            nights=self.observing.link,
            robot_log=self.robot_log.intake,
            history=store,
        )

    def _serve_guarded(self) -> None:
        """Serve what was built, behind what guards every request."""
        # The limits go last: they count by the person that one of the others finds.
        people, protocols = self.people, self.client_protocols
        guards = (people.access.guard_request, protocols.admission.guard_request)
        self.serve_features(
            (*guards, people.limits.check_request),
            picture_origins=lambda: self.maps.sources.origins,
        )

    def _add_connections(self) -> None:
        """Build what serves pages and clients of other tools, from all that was built before."""
        core, log = self.core, self.audit.log
        # A person is told by the same ways when somebody tries codes for their account.
        self.people.proving.on_notice = self.notifications.wake_up
        self.imports = ImportsFeature(
            core,
            registry=self.gateways.registry,
            history=self.history.store,
            alarms=self.alarms.engine,
            audit=log,
        )
        self.alert_notices = AlertNoticesFeature(core, observing=self.observing, audit=log)
        self.extensions = ExtensionsFeature(core)
        self.storage = StorageFeature(core, history=self.history.store, files=self.files.store)
        self.support = SupportFeature(core, audit=log)
        self.hubs = HubsFeature(core, files=self.files.store)
        self.boards = BoardsFeature(core, audit=log)
        self.maps = MapsFeature(core, audit=log)
        self.notes = NotesFeature(core, audit=log)
        self.connections = ConnectionsFeature(
            core,
            seats=self.people.seats,
            reporting=self.robot_events.reporting,
            sightings=self.sightings,
            nights=self.observing.board,
            audit=log,
        )
        service = self.connections.service
        self.missions = MissionsFeature(
            core,
            accounts=self.people.mission_accounts,
            pages=service,
            reporting=self.robot_events.reporting,
            deliver=self.notifications.wake_up,
            audit=log,
        )
        # Before each of the protocols, which it lets clients in for.
        self.client_protocols = ClientProtocolsFeature(
            core, people=self.people, service=service, audit=log
        )
        self.clients = build_client_features(
            core,
            clients=self.client_protocols,
            media=self.media,
            alarms=self.alarms,
            history=self.history.store,
            files=self.files.store,
            assets=self.taps.assets,
            access=self.people.access,
            audit=log,
        )
        # Last: its route takes every path, so any route added after it would never be asked.
        self.pages = PagesFeature(
            core,
            admission=self.people.admission,
            service=service,
            sightings=self.sightings,
            audit=log,
        )

    @property
    def judging(self) -> bool:
        """Whether alarms are being judged: without that, a hub that answers is not well."""
        return self.alarms.engine.judging

    @property
    def setup_token(self) -> str | None:
        """What opens the set-up page, while there is nobody yet."""
        return self.people.setup_token

    def cached_bytes(self) -> int:
        """Give the memory of what was read of the history and may be asked for again (bytes)."""
        return self.history.store.cached_bytes


def build_hub(
    settings: Settings,
    clock: Clock,
    history: History | None = None,
    *,
    seat: ClusterSeat | None = None,
) -> Hub:
    """Put a hub together; ``history`` takes the place of the one in the settings' database.

    ``seat`` is its place among several hubs on that database; none: it is alone.

    Raises:
        StoreError: the database's URL cannot be used.

    """
    return Hub(settings, clock, history, seat=seat)
