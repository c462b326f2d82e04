"""A file that an importer of an extension reads, as a `Source`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from talaia.cli.errors import BadFile
from talaia.cli.importing.source import Findings, Piece
from talaia.extensions.declarations import ImporterExtension, ImportProblem, ImportRequest
from talaia.extensions.installed import installed_extensions
from talaia.gateway.adapters.topic_readers import SampleBuffer

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from talaia.extensions.declarations import ImportedSample
    from talaia.model.site import Site

__all__ = ["ExtensionImportSource", "importer_of"]

# Samples of a piece: bounded memory, and a word of progress now and then.
_AT_ONCE = 4096
# Bytes that an importer sees to know its format by.
_BEGIN = 4096


def importer_of(path: Path) -> str:
    """Name the installed importer that takes a file for its own; empty where none does."""
    if not path.is_file():
        return ""
    with path.open("rb") as file:
        begin = file.read(_BEGIN)
    # By name: two importers that take the same file are chosen between in the same way each time.
    for name, importer in sorted(installed_extensions().importers_by_name().items()):
        try:
            if importer.recognizes(path, begin):
                return name
        except Exception as error:  # noqa: BLE001 - whatever it raises, it is named
            said = f"it fails at {path.name}: {type(error).__name__}: {error}"
            installed_extensions().note_failure(ImporterExtension, name, said)
    return ""


class ExtensionImportSource:
    """A `Source`."""

    def __init__(self, path: Path, name: str, site: Site, named: Mapping[str, str]) -> None:
        """Read ``path`` with the importer of this name.

        Args:
            path: the file.
            name: of an installed importer.
            site: whose channels they are.
            named: what the person wrote as ``--column NAME=ADDRESS``.

        """
        # The extension's own object; its `read` runs in this process and may raise anything.
        self._importer = installed_extensions().importers_by_name()[name]
        self._name, self._path, self._named = name, path, named
        self.kind = self._importer.title
        # Filled while it is read, by the extension's `note` and `skip`.
        self.findings = Findings()
        # Numbers of the site's channels by address, as columns name them.
        self._channels = {channel.address: number for number, channel in enumerate(site.channels())}
        # Addresses of texts, which go into other columns than numbers.
        self._texts = frozenset(channel.address for channel in site.channels() if channel.text)
        # Words of a signal's states by address; a sample may name a state by its word.
        self._states = {
            channel.address: site.devices[channel.device].signals[channel.signal].states
            for channel in site.channels()
        }

    def read_pieces(self) -> Iterator[Piece]:
        """See `Source.pieces`."""
        request = ImportRequest(
            path=self._path,
            channels=tuple(self._channels),
            names=self._named,
            note=self.findings.notes.append,
            skip=self.findings.unread.__setitem__,
        )
        buffer, waiting = SampleBuffer(), 0
        try:
            for sample in self._importer.read(request):
                self._add_sample(sample, buffer)
                waiting += 1
                if waiting == _AT_ONCE:
                    waiting = 0
                    columns = buffer.take_columns()
                    if columns is not None:
                        # Only the importer knows how far it is, and it is not asked.
                        yield Piece(0.0, columns)
        # First, for it is one of ours and names its own place.
        except BadFile:
            raise
        except ImportProblem as error:
            raise BadFile(str(self._path), error.place, error.problem, error.remedy) from error
        except Exception as error:
            said = f"the importer {self._name!r} failed: {type(error).__name__}: {error}"
            raise BadFile(str(self._path), "", said) from error
        columns = buffer.take_columns()
        if columns is not None:
            yield Piece(1.0, columns)

    def _add_sample(self, sample: ImportedSample, buffer: SampleBuffer) -> None:
        address, time_us, value = sample
        channel = self._channels.get(address)
        if channel is None:
            raise BadFile(str(self._path), "", f"the description has no channel {address!r}")
        if address in self._texts:
            buffer.add_text(channel, int(time_us), str(value))
            return
        states = self._states[address]
        number = float(states.index(value)) if value in states else float(value)
        # Not a number stands for a gap; infinity cannot be drawn or summed.
        if math.isinf(number):
            raise BadFile(str(self._path), "", f"{address}: {value!r} is no number")
        buffer.add_number(channel, int(time_us), number)

    def close(self) -> None:
        """See `Source.close`."""
