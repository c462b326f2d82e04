"""What the hub expects of the parts it is given; long, because all of it stands in one place."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import (
        AsyncGenerator,
        AsyncIterator,
        Collection,
        Iterable,
        Iterator,
        Mapping,
        Sequence,
    )

    from sqlalchemy import ColumnElement
    from sqlalchemy.engine.interfaces import DBAPIConnection

    from talaia.hub.anomaly.episode_runner import EpisodeRunner
    from talaia.hub.cluster.peers import HubNotice
    from talaia.hub.history.queries.channels import StoredChannel
    from talaia.hub.history.queries.export_formats import ExportColumn, FileForm
    from talaia.hub.history.queries.outliers import Outliers
    from talaia.hub.history.queries.series import Series
    from talaia.hub.history.queries.statistics import Statistics
    from talaia.hub.history.sensors.sensor_views import StoredSensorKind
    from talaia.hub.history.storage import Storage
    from talaia.hub.sharding.plan import ShardPlan
    from talaia.hub.store.database import Database
    from talaia.model.site import Site
    from talaia.wire.columns import Columns

__all__ = [
    "AnomalyReport",
    "AnomalySink",
    "CauseSink",
    "ClusterSeat",
    "DescribedSite",
    "DescribedSites",
    "DetectorSink",
    "History",
    "Shard",
    "SharedCause",
    "SightingEvent",
    "SightingSink",
]


class History(Protocol):
    """Samples for good. Times are microseconds since the epoch (UTC)."""

    async def open(self) -> None:
        """Make ready; called once, after the tables are up to date."""
        ...

    async def close(self) -> None:
        """Let go of everything; what was appended is already safe."""
        ...

    async def describe_site(self, site: Site) -> None:
        """Make a place for every signal of a description; the rest of the history stays."""
        ...

    async def rename_channels(self, site: str, moves: Mapping[str, str]) -> None:
        """Let channels go on under other addresses, with all their history.

        Args:
            site: whose they are.
            moves: the new addresses by the former ones. Where the new one has a history of its
                own, both stay as they are.

        """
        ...

    async def append_samples(
        self, site: str, boot: str, first: int, *, addresses: Sequence[str], columns: Columns
    ) -> None:
        """Store samples for good; durable on return, and twice the same changes nothing.

        Args:
            site: whose they are.
            boot: the gateway's run.
            first: sequence number of the first; the others follow without a hole.
            addresses: what ``columns.channel`` indexes.
            columns: the samples, in any order of time; not to be changed afterwards.

        """
        ...

    async def record_gap(
        self,
        site: str,
        boot: str,
        first: int,
        last: int,
        *,
        from_us: int,
        to_us: int,
        reason: str,
    ) -> None:
        """Store that samples ``first`` to ``last`` are lost; durable on return.

        With ``last = first - 1`` it is a gap in time of which no sequence numbers are known.
        """
        ...

    async def stored_below(self, site: str, boot: str) -> int:
        """Give the first sequence number that is neither stored nor in a recorded gap."""
        ...

    def has_channel(self, site: str, address: str) -> bool:
        """Tell whether a channel has ever had a sample."""
        ...

    async def read_series(
        self,
        site: str,
        addresses: Sequence[str],
        from_us: int,
        to_us: int,
        *,
        width: int,
        steps: Collection[str] = (),
    ) -> list[Series]:
        """Read a window, both ends included, for a chart of ``width`` pixels.

        A series has at most ``2 * width`` points: all samples if they fit (``exact``), otherwise
        the least and the greatest of each pixel, in order of time and at their own times. Pixels
        are anchored to the epoch. Of texts, the first and the last of each pixel are kept; of
        ``steps`` (addresses of states), the last and one that differs from it. An unknown address
        gives an empty series.
        """
        ...

    async def last_readings(
        self, site: str, addresses: Sequence[str], to_us: int = 2**62
    ) -> dict[str, tuple[int, float, str]]:
        """Give the newest stored sample up to ``to_us`` of each address that has one.

        It is a time (µs), a value (NaN for a text), and a text.
        """
        ...

    async def read_statistics(
        self, site: str, addresses: Sequence[str], from_us: int, to_us: int
    ) -> list[Statistics]:
        """Sum up a window of each address."""
        ...

    def count_outliers(
        self, site: str, address: str, from_us: int, to_us: int, *, k: float
    ) -> AsyncGenerator[Outliers | None]:
        """Find how many samples of a window, both ends included, are far outside its quartiles.

        It gives None again and again, so that who asks may stop, and what was found at the end.
        One channel after the other is looked at, whoever asks: of many samples it takes seconds.
        """
        ...

    def kind_of(self, site: str, address: str) -> StoredSensorKind | None:
        """Give what a channel's signal is, or was when it was last described."""
        ...

    async def list_channels(self, site: str, without: Collection[str] = ()) -> list[StoredChannel]:
        """List every channel of a site that has history, those of former descriptions too.

        Those that are named in ``without`` are left out, and cost nothing.
        """
        ...

    async def measure_storage(self) -> Storage:
        """Tell how much room the history takes."""
        ...

    @property
    def cached_bytes(self) -> int:
        """Memory of what is kept only because it may be asked for again."""
        ...

    @property
    def trouble(self) -> str:
        """Why nothing can be stored at present; empty while all is well."""
        ...

    @property
    def most_bytes(self) -> int:
        """What it may take (bytes); 0 if there is no limit."""
        ...

    def kept_us(self, site: str, address: str) -> int:
        """Give how long a channel is kept (µs); 0 is for good."""
        ...

    def export_samples(
        self,
        site: str,
        columns: Sequence[ExportColumn],
        from_us: int,
        to_us: int,
        *,
        form: FileForm,
        width: int = 0,
    ) -> AsyncIterator[bytes]:
        """Give the bytes of a file with a window, both ends included, of some channels.

        With a ``width``, it holds what a chart of so many pixels shows, otherwise every sample.
        What is held at once does not grow with the window.
        """
        ...


class ClusterSeat(Protocol):
    """This hub's place among several on one database."""

    @property
    def shard(self) -> str:
        """The shard whose lead this seat is for."""
        ...

    @property
    def plan(self) -> ShardPlan:
        """Which shards there are besides the main one."""
        ...

    @property
    def connected(self) -> bool:
        """Whether the hubs can hear each other."""
        ...

    def check_connection(self, connection: DBAPIConnection, record: object) -> None:
        """Refuse a new connection to the database unless this hub leads."""
        ...

    async def claim_lead(self, database: Database, seal_hash: str) -> None:
        """Write down that this hub leads now; called once the tables are up to date.

        Raises:
            CannotStart: it does not fit the others.

        """
        ...

    def begin_anew(self) -> None:
        """Close this lead's hub, and open it again with the sites that its shard has by then.

        It happens soon; to ask again meanwhile changes nothing.
        """
        ...

    def own_notice(self) -> HubNotice:
        """Say how this hub stands."""
        ...

    def heard_hubs(self) -> Iterable[tuple[HubNotice, int]]:
        """Give how the others stand, and when each was heard last (monotonic ns)."""
        ...


class Shard(Protocol):
    """Which sites are this hub's own, where they are divided among several leads.

    Attributes:
        name: ``main``, or the name of the history server whose sites these are.
        is_main: it has the accounts, and does what is done once for all sites.
        is_whole: sites are not divided: there is only this shard.
        suffix: ends names of what each shard has for itself where others look, too: files in a
            data folder, connections at a broker; empty for the main one.

    """

    @property
    def name(self) -> str: ...  # noqa: D102 - above

    @property
    def is_main(self) -> bool: ...  # noqa: D102 - above

    @property
    def is_whole(self) -> bool: ...  # noqa: D102 - above

    @property
    def suffix(self) -> str: ...  # noqa: D102 - above

    async def open(self) -> None:
        """Read which sites are whose; called once, when the tables are up to date."""
        ...

    def has_site(self, site: str) -> bool:
        """Tell whether a site is of this shard, by what is known."""
        ...

    async def look_up(self, site: str) -> bool:
        """Tell whether a site is of this shard; asks the database about one that is new.

        Raises:
            StoreDown: the database does not answer.

        """
        ...

    async def refresh(self) -> None:
        """Read again which sites are whose, so that `has_site` knows those that have come since.

        Raises:
            StoreDown: the database does not answer.

        """
        ...

    def own_rows(self, site: ColumnElement[Any], /) -> tuple[ColumnElement[bool], ...]:
        """Say in SQL which rows are of own sites, by a column of the accounts' database.

        It holds at the moment of the query, whatever `has_site` knows; empty: all are.
        """
        ...


class DescribedSite(Protocol):
    """A site as it is described; nothing of how it stands."""

    @property
    def name(self) -> str:
        """Its short name."""
        ...

    @property
    def description(self) -> Site:
        """What its gateway said last."""
        ...


class DescribedSites(Protocol):
    """All sites that this hub's database knows, those of other shards among them."""

    def __iter__(self) -> Iterator[DescribedSite]:
        """Go through them in the order of their names."""
        ...

    def find_site(self, name: str) -> DescribedSite | None:
        """Find one by its short name."""
        ...


class AnomalyReport(NamedTuple):
    """An anomaly began, or ended.

    Attributes:
        site: its short name.
        channel: the signal's address, ``device/signal``.
        detector: a word of `DetectorKind`.
        began_us: when its first high score was (µs, UTC); with ``channel`` and ``detector`` it
            tells anomalies apart.
        ended_us: when its last high score was (µs, UTC); None while it is on.
        score: 0 to 1; the greatest so far.
        why: in words, with numbers and units.
        excess: how far beyond the bar the score is, of what is left up to 1.
        shares: of a group: what each of its signals (by address) has to do with it.

    """

    site: str
    channel: str
    detector: str
    began_us: int
    ended_us: int | None
    score: float
    why: str
    excess: float = 0.0
    shares: tuple[tuple[str, float], ...] = ()


class AnomalySink(Protocol):
    """Who wants to hear of anomalies."""

    def report_anomaly(self, news: AnomalyReport) -> None:
        """Take the news in order, on the event loop; must not wait and not raise."""
        ...


class SharedCause(NamedTuple):
    """What became unusual together in a part of a site, as it stands now.

    Attributes:
        site: its short name.
        part: its name; the first device of the part.
        began_us: when the first of it was told of (µs, UTC, by the hub); names it.
        score: the greatest of what goes on, 0 to 1.
        why: in words: the signals with their shares, and why.
        shares: address, share (0 to 1) and whether it is on, for each signal, the greatest first.
        over: nothing of it goes on.

    """

    site: str
    part: str
    began_us: int
    score: float
    why: str
    shares: tuple[tuple[str, float, bool], ...]
    over: bool


class CauseSink(Protocol):
    """Who wants to hear of what became unusual together: alarms."""

    def report_cause(self, news: SharedCause) -> None:
        """Take how an episode stands; must not wait and not raise."""
        ...


class DetectorSink(Protocol):
    """Who shows how detectors stand: pages."""

    def report_detector(self, site: str, watched: EpisodeRunner) -> None:
        """Take how a detector of a site stands now; must not wait and not raise."""
        ...


class SightingEvent(NamedTuple):
    """A detector sees something, sees more or less of it, or sees it no more.

    Attributes:
        site: its short name.
        camera: the stream's address, ``device/stream``.
        label: what is seen, by the detector's name for it.
        many: so many at once.
        confidence: of the surest, 0 to 1.
        began_us: when it was seen first (µs, UTC); with ``camera`` and ``label`` it tells
            sightings apart.
        ended_us: when it was seen last (µs, UTC); None while it is.

    """

    site: str
    camera: str
    label: str
    many: int
    confidence: float
    began_us: int
    ended_us: int | None


class SightingSink(Protocol):
    """Who wants to hear of sightings."""

    def report_sighting(self, news: SightingEvent) -> None:
        """Take the news in order, on the event loop; must not wait and not raise."""
        ...
