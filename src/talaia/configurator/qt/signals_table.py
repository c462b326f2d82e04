"""All signals of a site as a table, for views."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from PySide6.QtCore import (
    QAbstractTableModel,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    Qt,
    Signal,
)

from talaia.model.connection import (
    AlpacaSource,
    DerivedSource,
    HttpSource,
    IndiSource,
    MqttSource,
    OnvifSource,
    ProcessSource,
    RosSource,
    SocketioSource,
)

if TYPE_CHECKING:
    from talaia.configurator.description_paths import Path
    from talaia.model.site import Signal as SiteSignal, Site, Source

__all__ = ["REMOVE", "SignalsTable"]

_HEADS = ("Name", "Unit", "Device", "Comes from", "1st", "")
_TIPS = ("", "", "", "", "Shown on the first page", "Remove")
# Columns of the two that a click changes something in.
FIRST_PAGE, REMOVE = 4, 5
Index = QModelIndex | QPersistentModelIndex


class _Shown(NamedTuple):
    """A row: where the signal is, and the signal."""

    path: Path
    signal: SiteSignal


class SignalsTable(QAbstractTableModel):
    """One row for each signal, in the order of the description.

    Signals:
        switched: a path, and whether it is wanted on the first page.

    """

    switched = Signal(object, object)

    def __init__(self, parent: QObject) -> None:
        """Begin empty."""
        super().__init__(parent)
        # As shown, in the order of the description.
        self._rows: list[_Shown] = []
        # Row by path; made with the rows.
        self._places: dict[Path, int] = {}

    def show_site(self, site: Site) -> None:
        """Show this site's signals; the same ones are only drawn again."""
        rows = [
            _Shown(("devices", device_id, "signals", word), signal)
            for device_id, device in site.devices.items()
            for word, signal in device.signals.items()
        ]
        # No reset: it would take the selection and the place of the scroll bar away.
        if [row.path for row in rows] == [row.path for row in self._rows]:
            self._rows = rows
            if rows:
                last = self.index(len(rows) - 1, len(_HEADS) - 1)
                self.dataChanged.emit(self.index(0, 0), last)
            return
        self.beginResetModel()
        self._rows = rows
        self._places = {row.path: number for number, row in enumerate(rows)}
        self.endResetModel()

    def path(self, number: int) -> Path:
        """Give the path of a row."""
        return self._rows[number].path

    def row_of(self, path: Path) -> int | None:
        """Give the row of a path; none where it has no row."""
        return self._places.get(path)

    def find(self, word: str) -> Path | None:
        """Give the path of the signal of that word that was added last."""
        found = [row.path for row in self._rows if row.path[3] == word]
        return found[-1] if found else None

    def rowCount(self, parent: Index | None = None) -> int:  # noqa: N802 - Qt's name
        """Say how many signals there are."""
        # A valid parent is a cell, and cells of a table have no rows below them.
        return 0 if parent is not None and parent.isValid() else len(self._rows)

    def columnCount(self, parent: Index | None = None) -> int:  # noqa: N802 - Qt's name
        """Say how many columns there are."""
        return 0 if parent is not None and parent.isValid() else len(_HEADS)

    def headerData(  # noqa: N802 - Qt's name
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> object:
        """Name a column."""
        if orientation is not Qt.Orientation.Horizontal:
            return None
        if role == Qt.ItemDataRole.DisplayRole:
            return _HEADS[section]
        return _TIPS[section] if role == Qt.ItemDataRole.ToolTipRole else None

    def flags(self, index: Index) -> Qt.ItemFlag:
        """Let the first-page column be checked."""
        base = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        return base | Qt.ItemFlag.ItemIsUserCheckable if index.column() == FIRST_PAGE else base

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Give what a cell shows, and what it says to a screen reader."""
        path, signal = self._rows[index.row()]
        if role == Qt.ItemDataRole.CheckStateRole and index.column() == FIRST_PAGE:
            return Qt.CheckState.Checked if signal.primary else Qt.CheckState.Unchecked
        if role == Qt.ItemDataRole.DisplayRole:
            texts = (
                signal.name,
                signal.unit or ("" if signal.type == "number" else signal.type),
                path[1],
                _origin_text(signal.source),
                "",
                "✕",
            )
            return texts[index.column()]
        if role == Qt.ItemDataRole.AccessibleTextRole and index.column() in (FIRST_PAGE, REMOVE):
            if index.column() == REMOVE:
                return f"Remove {signal.name}"
            return f"{signal.name} on the first page: {'yes' if signal.primary else 'no'}"
        if role == Qt.ItemDataRole.ToolTipRole:
            return (
                _origin_text(signal.source)
                if index.column() == 3
                else _TIPS[index.column()] or None
            )
        return None

    def setData(  # noqa: N802 - Qt's name
        self, index: Index, value: object, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        """Pass a tick in the first-page column on; the description decides what is shown."""
        if role != Qt.ItemDataRole.CheckStateRole or index.column() != FIRST_PAGE:
            return False
        # Not set here: the change goes through the editor, and comes back as another site.
        self.switched.emit(self._rows[index.row()].path, Qt.CheckState(value) is not _OFF)
        return True


_OFF = Qt.CheckState.Unchecked


def _origin_text(source: Source) -> str:
    """Say in a few words where a signal comes from."""
    match source:
        case RosSource(topic="", parameter=parameter):
            return parameter
        case RosSource(topic=topic, name=name, field=field):
            return f"{topic} · {name or field}" if name or field else topic
        case IndiSource(property=name, element=element):
            return f"{name} · {element}" if element else name
        case MqttSource(topic=place, path=path) | HttpSource(get=place, path=path):
            return f"{place} · {path}" if path else place
        case SocketioSource(namespace=place, name=name, path=path):
            return " · ".join(part for part in (place, name, path) if part)
        case AlpacaSource(property=name) | OnvifSource(ptz=name):
            return name
        case ProcessSource(run=line) | DerivedSource(expression=line):
            return line
        case _:
            return ""
