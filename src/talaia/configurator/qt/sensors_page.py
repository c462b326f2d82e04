"""Second page: sensors from a list or of one's own, each with its details."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QItemSelectionModel, QModelIndex, QPoint, QSortFilterProxyModel, Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QAbstractItemView,
    QGridLayout,
    QHeaderView,
    QLabel,
    QLineEdit,
    QSplitter,
    QTableView,
    QVBoxLayout,
    QWidget,
)

from talaia.configurator.description_paths import value_at, with_value
from talaia.configurator.edits import NewSensor, free_number, with_sensor, without_things
from talaia.configurator.form_rows import Row, rows_at
from talaia.configurator.presets import OTHERS, SENSORS, SensorKind
from talaia.configurator.qt.form import Form
from talaia.configurator.qt.palette import SPACE
from talaia.configurator.qt.signals_table import REMOVE, SignalsTable
from talaia.configurator.qt.widgets import (
    Card,
    ComboBox,
    Inner,
    Number,
    Page,
    make_button,
    make_label,
    make_row,
)
from talaia.model.units.unit import UNITS

if TYPE_CHECKING:
    from talaia.configurator.description_paths import Path
    from talaia.configurator.qt.editor import Editor

__all__ = ["SensorsPage"]


class SensorsPage(Page):
    """The list of sensors, what adds to it, and the details of the selected one."""

    def __init__(self, editor: Editor) -> None:
        """Show the open document."""
        super().__init__(
            "Sensors",
            "Choose a type, or Others for a custom one. A sensor is heard on /metric under its "
            "name and number, unless you say where else it comes from.",
        )
        self._editor = editor
        self.body.addWidget(self._make_adding_card())
        self.body.addWidget(self._make_list_pane(), 1)
        QShortcut(
            QKeySequence.StandardKey.Delete,
            self.table,
            self.remove_selected,
            context=Qt.ShortcutContext.WidgetShortcut,
        )
        editor.changed.connect(self.show_site)
        self._choose_kind()
        self.show_site()

    # ── adding ──

    def _make_adding_card(self) -> QWidget:
        card = Card()
        self.kind = ComboBox()
        for kind in (*SENSORS, OTHERS):
            self.kind.addItem(kind.name, kind)
        self.kind.setMaxVisibleItems(30)
        self.name = QLineEdit()
        self.name.setPlaceholderText("only for Others")
        self.number = Number(1, 9999, 1)
        self.unit = ComboBox()
        self.unit.addItem("none", "")
        for unit in UNITS.values():
            if unit.symbol:
                self.unit.addItem(f"{unit.symbol}  ({unit.name})", unit.symbol)
        self.add_button = make_button("Add sensor", self.add, "main")
        grid = QGridLayout()
        grid.setHorizontalSpacing(SPACE[1])
        fields: tuple[tuple[str, QWidget, int], ...] = (
            ("&Type", self.kind, 3),
            ("Na&me", self.name, 3),
            ("N&umber", self.number, 1),
            ("U&nit", self.unit, 3),
        )
        for column, (text, widget, stretch) in enumerate(fields):
            title = QLabel(text)
            title.setBuddy(widget)
            widget.setAccessibleName(f"{text.replace('&', '')} of the new sensor")
            grid.addWidget(title, 0, column)
            grid.addWidget(widget, 1, column)
            grid.setColumnStretch(column, stretch)
        grid.addWidget(self.add_button, 1, len(fields))
        card.body.addLayout(grid)
        self.kind.currentIndexChanged.connect(lambda _: self._choose_kind())
        self.name.textChanged.connect(lambda _: self._suggest_number())
        self.name.returnPressed.connect(self.add)
        return card

    def _chosen_kind(self) -> SensorKind:
        kind = self.kind.currentData()
        # Qt gives a NamedTuple back as the tuple it is.
        return kind if isinstance(kind, SensorKind) else SensorKind(*kind)

    def _choose_kind(self) -> None:
        kind = self._chosen_kind()
        own = not kind.word
        self.name.setEnabled(own)
        if not own:
            self.name.clear()
        self.unit.setCurrentIndex(max(self.unit.findData(kind.unit), 0))
        self._suggest_number()

    def _suggest_number(self) -> None:
        self.number.setValue(free_number(self._editor.site, self._chosen_kind(), self.name.text()))

    def add(self) -> None:
        """Add what is chosen, and select it."""
        new = NewSensor(
            self._chosen_kind(),
            self.number.value(),
            self.name.text(),
            self.unit.currentData() or "",
        )
        if self._editor.apply(f"add {new.word}", lambda site: with_sensor(site, new)):
            path = self._model.find(new.word)
            if path is not None:
                self.select(path)
            self._suggest_number()
        elif not new.kind.word and not new.name.strip():
            self.name.setFocus()

    # ── the list ──

    def _make_list_pane(self) -> QWidget:
        self._model = SignalsTable(self)
        self._shown = QSortFilterProxyModel(self)
        self._shown.setSourceModel(self._model)
        self._shown.setFilterCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        self._shown.setFilterKeyColumn(-1)
        self.filter = QLineEdit(clearButtonEnabled=True, placeholderText="Filter")
        self.filter.setAccessibleName("Filter the sensors")
        self.filter.textChanged.connect(self._shown.setFilterFixedString)
        self.table = QTableView()
        self.table.setModel(self._shown)
        self.table.setAccessibleName("Sensors")
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.table.setTabKeyNavigation(False)
        self.table.setShowGrid(False)
        self.table.verticalHeader().hide()
        self.table.setMinimumHeight(190)
        header = self.table.horizontalHeader()
        header.setHighlightSections(False)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        header.setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(REMOVE, QHeaderView.ResizeMode.Fixed)
        header.setMinimumSectionSize(26)
        for column, width in ((1, 60), (2, 80), (3, 130), (4, 46), (REMOVE, 28)):
            self.table.setColumnWidth(column, width)
        self.table.clicked.connect(self._on_clicked)
        self._model.switched.connect(self._first_page)
        self.table.selectionModel().selectionChanged.connect(lambda *_: self._show_details())
        self.remove_button = make_button("&Remove", self.remove_selected)
        self.count = make_label("", "muted")
        left = QWidget()
        body = QVBoxLayout(left)
        body.setContentsMargins(0, 0, 0, 0)
        body.setSpacing(SPACE[1])
        body.addLayout(make_row(self.filter, self.remove_button))
        body.addWidget(self.table, 1)
        body.addWidget(self.count)
        split = QSplitter(Qt.Orientation.Horizontal, childrenCollapsible=False)
        split.addWidget(left)
        split.addWidget(self._make_detail_pane())
        split.setStretchFactor(0, 3)
        split.setStretchFactor(1, 2)
        split.setSizes([520, 330])
        return split

    def _make_detail_pane(self) -> QWidget:
        card = Card()
        self.details = make_label("", "heading", wrap=True)
        card.body.addWidget(self.details)
        self.form = Form()
        self.form.edited.connect(self._apply_edit)
        card.body.addWidget(Inner(self.form), 1)
        card.setMinimumWidth(290)
        return card

    def show_site(self) -> None:
        """Show the site as it is now; what was selected stays so where it is still there."""
        chosen = self.selected()
        self._model.show_site(self._editor.site)
        self._select_paths(chosen)
        total = self._model.rowCount()
        self.count.setText(
            "No sensors yet. Add one above, or use Find on robot."
            if not total
            else f"{total} sensor{'s' if total != 1 else ''}; Del removes the selected ones."
        )
        self._suggest_number()
        self._show_details()

    def selected(self) -> list[Path]:
        """Give the paths of the selected sensors."""
        rows = self.table.selectionModel().selectedRows()
        return [self._model.path(self._shown.mapToSource(row).row()) for row in rows]

    def select(self, path: Path, field: Path = ()) -> bool:
        """Select one sensor and, where asked for, put the focus into a field of it."""
        if self._model.row_of(path) is None:
            return False
        self.filter.clear()
        self._select_paths([path])
        self._show_details()
        if field:
            return self.form.go_to(".".join(field))
        return True

    def _select_paths(self, paths: list[Path]) -> None:
        chosen = self.table.selectionModel()
        flags = QItemSelectionModel.SelectionFlag
        chosen.clearSelection()
        for path in paths:
            number = self._model.row_of(path)
            if number is None:
                continue
            index = self._shown.mapFromSource(self._model.index(number, 0))
            chosen.setCurrentIndex(index, flags.Select | flags.Rows)
            self.table.scrollTo(index)

    def _on_clicked(self, index: QModelIndex) -> None:
        if index.column() == REMOVE:
            self._remove_paths([self._model.path(self._shown.mapToSource(index).row())])

    def remove_selected(self) -> None:
        """Remove what is selected, as one step."""
        self._remove_paths(self.selected())

    def _remove_paths(self, paths: list[Path]) -> None:
        if not paths:
            return
        numbers = [number for path in paths if (number := self._model.row_of(path)) is not None]
        what = paths[0][3] if len(paths) == 1 else f"{len(paths)} sensors"
        if self._editor.apply(f"remove {what}", lambda site: without_things(site, paths)):
            # The next one, so that Del can be pressed again.
            last = self._model.rowCount() - 1
            if last >= 0:
                self._select_paths([self._model.path(min(numbers[0], last))])

    def _first_page(self, path: Path, on: object) -> None:
        self._editor.apply(
            f"{'show' if on else 'hide'} {path[3]} on the first page",
            lambda site: with_value(site, (*path, "primary"), bool(on)),
        )

    # ── details ──

    def _show_details(self) -> None:
        paths = self.selected()
        self.remove_button.setEnabled(bool(paths))
        if len(paths) != 1:
            self.form.clear()
            told = f"{len(paths)} sensors selected" if paths else "Select a sensor for its details."
            self.details.setText(told)
            return
        site, path = self._editor.site, paths[0]
        self.details.setText(f"{path[1]}/{path[3]}")
        wrong = {
            ".".join(problem.spot.field): str(problem)
            for problem in self._editor.document.problems
            if problem.spot.node == path
        }
        self.form.show_thing(rows_at(site, path), value_at(site, path), wrong, path)

    def _apply_edit(self, field: Row, value: object) -> None:
        paths = self.selected()
        if len(paths) == 1:
            self._editor.apply(
                f"change {field.label.lower()} of {paths[0][3]}",
                lambda site: with_value(site, (*paths[0], *field.path), value),
            )

    def click_remove(self, path: Path) -> QPoint:
        """Give where a click removes a sensor, in the table's own view."""
        number = self._model.row_of(path)
        assert number is not None  # noqa: S101 - the caller shows it
        index = self._shown.mapFromSource(self._model.index(number, REMOVE))
        return self.table.visualRect(index).center()
