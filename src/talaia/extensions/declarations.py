"""What an extension declares of itself; each entry point names one of these objects.

`talaia.extend` gives these names to extensions, and they may count on them: what is added is
optional, and what is taken away or means something else raises `API_VERSION`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from talaia.errors import TalaiaError
from talaia.model.base import Shape

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from pathlib import Path

    from talaia.extensions.adapter_host import AdapterHost, ExtensionAdapter

__all__ = [
    "API_VERSION",
    "AdapterExtension",
    "Declared",
    "DetectorExtension",
    "ExtensionKeys",
    "ImportProblem",
    "ImportRequest",
    "ImportedSample",
    "ImporterExtension",
    "NotDelivered",
    "NotifierExtension",
    "NotifierMessage",
]

# Of what `talaia.extend` offers. An extension names the version that it was written for.
API_VERSION = 1


class ExtensionKeys(Shape, frozen=True, kw_only=True):
    """The keys that an extension takes: a subclass with a field for each.

    A field is a ``str``, ``int``, ``float`` or ``bool``, a ``Literal`` of them, or one of these
    with limits (``typing.Annotated`` and ``msgspec.Meta``); one without a default must be given.
    What only fits together is checked in ``__post_init__``, which raises ``ValueError``. The
    lines below ``Attributes:`` in the docstring are shown to people.
    """


@dataclass(frozen=True, kw_only=True)
class Declared:
    """What every extension says.

    Attributes:
        api: the `API_VERSION` that it was written for, as a number (not the name).
        summary: what it is, in a few words.

    """

    # The group of its entry points; each kind has its own.
    group: ClassVar[str] = ""

    api: int
    summary: str


@dataclass(frozen=True, kw_only=True)
class AdapterExtension(Declared):
    """A protocol that a gateway speaks; its name is the connection's ``extension``.

    Attributes:
        connection: the keys of a connection.
        source: the keys of a signal.
        make: given a connection's keys and an `AdapterHost`, makes what speaks the protocol.
        command: the keys of a command: ``target``, and what ``fixed`` and the arguments' fields
            name; none if there are no commands.

    """

    group: ClassVar[str] = "talaia.adapters"

    connection: type[ExtensionKeys]
    source: type[ExtensionKeys]
    # `Any`: each extension takes a subclass of `ExtensionKeys` of its own.
    make: Callable[[Any, AdapterHost], ExtensionAdapter]
    command: type[ExtensionKeys] | None = None


@dataclass(frozen=True, kw_only=True)
class DetectorExtension(Declared):
    """A detector of anomalies at the hub; its name is the ``extension`` of an ``anomalies`` entry.

    Attributes:
        make: a subclass of `Detector`; its own fields are made of ``keys``, name by name.
        keys: the keys that a description may give.
        bar: a score from here on is an anomaly, unless the description says another.
        quiet: it reports nothing before it has seen so many samples.
        learning: and only what is clear before it has seen so many.
        learns: a person can teach it what is usual (`Detector.forgive`).

    """

    group: ClassVar[str] = "talaia.detectors"

    make: type[Any]
    keys: type[ExtensionKeys] = ExtensionKeys
    bar: float = 0.5
    quiet: int = 0
    learning: int = 0
    learns: bool = True


class NotifierMessage(NamedTuple):
    """A message about alarms.

    Attributes:
        key: names it; the same when it is sent again.
        title: one line.
        body: some lines.
        severity: ``info``, ``warning`` or ``critical``: of the worst in it.
        sites: short names of the sites that it is about.
        page: the path of the hub's page that shows it.

    """

    key: str
    title: str
    body: str
    severity: str
    sites: tuple[str, ...]
    page: str


class NotDelivered(TalaiaError):
    """A message has certainly not arrived.

    Any other error means that it may have arrived, so that it is not sent again.
    """

    def __init__(self, problem: str, *, again: bool = True) -> None:
        """Say why; ``again`` where another try may do."""
        super().__init__(problem)
        # A wrong address stays wrong; a server that is away may be back.
        self.again = again


@dataclass(frozen=True, kw_only=True)
class NotifierExtension(Declared):
    """A kind of server that messages about alarms go to.

    Attributes:
        keys: what an admin fills in; kept sealed, and never shown again.
        send: sends a message, in a process of its own that reaches only the addresses that the
            hub's administrator allows; within 60 s. Raises `NotDelivered`.
        secret: keys that are typed like a password.

    """

    group: ClassVar[str] = "talaia.notifiers"

    keys: type[ExtensionKeys]
    send: Callable[[Any, NotifierMessage], None]
    secret: frozenset[str] = field(default_factory=frozenset)


class ImportProblem(TalaiaError):
    """A file cannot be read further; nothing of it is imported.

    Attributes:
        place: where in the file: ``line 12``.
        problem: what is wrong there.
        remedy: what a person can do; empty where nothing is known.

    """

    def __init__(self, place: str, problem: str, remedy: str = "") -> None:
        """Keep them apart."""
        super().__init__(place, problem, remedy)
        self.place, self.problem, self.remedy = place, problem, remedy


class ImportedSample(NamedTuple):
    """One reading of a file.

    Attributes:
        address: of the channel: ``base/speed``, ``base/pose.x``.
        time_us: µs since the epoch, UTC.
        value: a number in the signal's unit, the number of a state or its word, or a text.

    """

    address: str
    time_us: int
    value: float | str


@dataclass(frozen=True, kw_only=True)
class ImportRequest:
    """A file to be read.

    Attributes:
        path: the file.
        channels: addresses of the site's channels; what names another one is refused.
        names: what the person wrote as ``--column NAME=ADDRESS``.
        note: says to the person who imports what else is worth a look.
        skip: says that something in the file is not read: its name there, and why.

    """

    path: Path
    channels: tuple[str, ...]
    names: Mapping[str, str]
    note: Callable[[str], None]
    skip: Callable[[str, str], None]


@dataclass(frozen=True, kw_only=True)
class ImporterExtension(Declared):
    """A format of files that ``talaia import`` reads.

    Attributes:
        title: the format, as people call it.
        recognizes: given a path and the first 4096 bytes, tells whether it is of this format.
        read: gives the samples in the order of the file. Raises `ImportProblem`.

    """

    group: ClassVar[str] = "talaia.importers"

    title: str
    recognizes: Callable[[Path, bytes], bool]
    read: Callable[[ImportRequest], Iterator[ImportedSample]]
