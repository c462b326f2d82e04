"""Fourth page, for those who want more: every thing of the description as a tree, with its form."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QHeaderView,
    QInputDialog,
    QLineEdit,
    QMenu,
    QPushButton,
    QSplitter,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from talaia.configurator.description_paths import value_at, with_value
from talaia.configurator.edits import Group, groups_at, with_thing, without_things
from talaia.configurator.errors import ConfiguratorError, NoSuchPlace
from talaia.configurator.form_rows import Row, rows_at, stored_value
from talaia.configurator.qt.form import Form
from talaia.configurator.qt.palette import SPACE
from talaia.configurator.qt.widgets import Card, Inner, Page, make_button, make_label, make_row

if TYPE_CHECKING:
    from collections.abc import Iterator

    from talaia.configurator.description_paths import Path
    from talaia.configurator.qt.editor import Editor
    from talaia.model.site import Site

__all__ = ["DevicesPage"]

_KIND = {
    "devices": "device",
    "signals": "signal",
    "streams": "camera",
    "commands": "command",
    "arguments": "argument",
    "connections": "connection",
}


def things_of(site: Site) -> Iterator[tuple[Path, str]]:
    """List every thing that has a form, with what it is called; a parent before its children."""
    yield (), site.name or "Site"
    if site.ros2 is not None:
        yield ("ros2",), "ROS 2"
    for name in site.connections:
        yield ("connections", name), name
    for word, device in site.devices.items():
        path: Path = ("devices", word)
        yield path, device.name
        if device.drive is not None:
            yield (*path, "drive"), "Driving"
        for name, signal in device.signals.items():
            yield (*path, "signals", name), signal.name
        for name, stream in device.streams.items():
            yield (*path, "streams", name), stream.name
        for name, command in device.commands.items():
            yield (*path, "commands", name), command.name
            for argument, described in command.arguments.items():
                yield (*path, "commands", name, "arguments", argument), described.name or argument


def _kind_name(path: Path) -> str:
    if not path:
        return "site"
    if path[-1] in ("drive", "ros2"):
        return "driving" if path[-1] == "drive" else "connection"
    return _KIND[path[-2]]


def _parent_item(path: Path) -> Path:
    if not path:
        return ()
    return path[:-1] if path[-1] == "drive" and len(path) == 3 else path[:-2]


class DevicesPage(Page):
    """The tree, and the form of the selected thing."""

    def __init__(self, editor: Editor) -> None:
        """Show the open document."""
        super().__init__(
            "Devices and commands",
            "Everything the description can say of each part. Interlocks, enclosures and "
            "recordings are written in the file, and stay as they are.",
        )
        self._editor = editor
        # The tree's items by path; made anew when other things are there.
        self._items: dict[Path, QTreeWidgetItem] = {}
        # What the tree was made for, to know whether names alone have changed.
        self._shown: list[tuple[Path, str]] = []
        split = QSplitter(Qt.Orientation.Horizontal, childrenCollapsible=False)
        split.addWidget(self._make_tree_pane())
        split.addWidget(self._make_detail_pane())
        split.setStretchFactor(0, 2)
        split.setStretchFactor(1, 3)
        split.setSizes([340, 480])
        self.body.addWidget(split, 1)
        QShortcut(
            QKeySequence.StandardKey.Delete,
            self.tree,
            self.remove,
            context=Qt.ShortcutContext.WidgetShortcut,
        )
        editor.changed.connect(self.show_site)
        self.show_site()

    def _make_tree_pane(self) -> QWidget:
        self.tree = QTreeWidget(columnCount=2)
        self.tree.setHeaderLabels(["Thing", "Kind"])
        self.tree.setAccessibleName("Devices and their parts")
        self.tree.setUniformRowHeights(True)
        self.tree.setMinimumHeight(260)
        header = self.tree.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self.tree.currentItemChanged.connect(lambda *_: self._show_details())
        self.add_button = QPushButton("&Add")
        self.add_button.setAccessibleName("Add to the selected item")
        self._menu = QMenu(self.add_button)
        self.add_button.setMenu(self._menu)
        self.remove_button = make_button("&Remove", self.remove)
        left = QWidget()
        body = QVBoxLayout(left)
        body.setContentsMargins(0, 0, 0, 0)
        body.setSpacing(SPACE[1])
        body.addLayout(make_row(self.add_button, self.remove_button, 1))
        body.addWidget(self.tree, 1)
        return left

    def _make_detail_pane(self) -> QWidget:
        card = Card()
        self.title = make_label("", "heading", wrap=True)
        self.hint = make_label("", "muted", wrap=True)
        card.body.addWidget(self.title)
        card.body.addWidget(self.hint)
        self.form = Form()
        self.form.edited.connect(self._apply_edit)
        card.body.addWidget(Inner(self.form), 1)
        card.setMinimumWidth(320)
        return card

    # ── showing ──

    def show_site(self) -> None:
        """Show the site as it is now; the tree is made anew only when its things are others."""
        chosen = self.selected()
        things = list(things_of(self._editor.site))
        if [path for path, _ in things] == [path for path, _ in self._shown]:
            for path, name in things:
                # Renamed in place: a new tree would close what a person opened.
                if self._items[path].text(0) != name:
                    self._items[path].setText(0, name)
        else:
            self._fill_tree(things, chosen)
        self._shown = things
        self._show_details()

    def _fill_tree(self, things: list[tuple[Path, str]], chosen: Path) -> None:
        # What was closed by hand stays so in the new tree.
        closed = {path for path, item in self._items.items() if not item.isExpanded()}
        known = set(self._items)
        # While it is filled the current item changes, and a form would be built for each.
        self.tree.blockSignals(True)  # noqa: FBT003 - Qt's own
        self.tree.clear()
        self._items = {}
        for path, name in things:
            item = QTreeWidgetItem([name, _kind_name(path)])
            if path:
                self._items[_parent_item(path)].addChild(item)
            else:
                self.tree.addTopLevelItem(item)
            self._items[path] = item
        for path, item in self._items.items():
            # Devices begin closed where there are many things.
            is_open = path not in closed if path in known else len(path) < 2 or len(things) < 40
            item.setExpanded(is_open)
        # What was selected is gone: the thing that it stood in comes next.
        while chosen and chosen not in self._items:
            chosen = _parent_item(chosen)
        self.tree.setCurrentItem(self._items[chosen])
        self.tree.blockSignals(False)  # noqa: FBT003 - Qt's own

    def selected(self) -> Path:
        """Give the path of the selected thing; the site where none is."""
        current = self.tree.currentItem()
        return next((path for path, item in self._items.items() if item is current), ())

    def select(self, path: Path, field: Path = ()) -> bool:
        """Select a thing, or the nearest one above, and put the focus into a field of it."""
        exact = path in self._items
        # Ends at the empty path: the site itself is always there.
        while path not in self._items:
            path = path[:-1]
        self.tree.setCurrentItem(self._items[path])
        self.tree.scrollToItem(self._items[path])
        self._show_details()
        if field and exact and self.form.go_to(".".join(field)):
            return True
        self.tree.setFocus(Qt.FocusReason.OtherFocusReason)
        return exact

    def _show_details(self) -> None:
        site, path = self._editor.site, self.selected()
        try:
            thing = value_at(site, path)
        except NoSuchPlace:
            return
        address = "/".join(path[1::2])
        driving = f"{address}: driving"
        is_device = len(path) > 2
        self.title.setText(
            driving
            if path[-1:] == ("drive",)
            else address
            if is_device
            else self._items[path].text(0)
        )
        here = [problem for problem in self._editor.document.problems if problem.spot.node == path]
        wrong = {
            ".".join(problem.spot.field): str(problem) for problem in here if problem.spot.field
        }
        self.hint.setText("\n".join(str(problem) for problem in here if not problem.spot.field))
        self.hint.setVisible(bool(self.hint.text()))
        self.form.show_thing(rows_at(site, path), thing, wrong, path)
        self.remove_button.setEnabled(len(path) > 1)
        self._menu.clear()
        for group in self._show_groups():
            self._menu.addAction(f"{group.title} …").triggered.connect(partial(self._ask, group))

    def _show_groups(self) -> list[Group]:
        site, path = self._editor.site, self.selected()
        here = list(groups_at(site, path))
        # A device can be added from anywhere.
        return here if path == () else [*here, *groups_at(site, ())]

    # ── changing ──

    def _ask(self, group: Group, _checked: object = None) -> None:
        if group.key == "drive":
            self.add(group.key, "")
            return
        name, sure = QInputDialog.getText(
            self, f"Add: {group.title}", "What people call it:", QLineEdit.EchoMode.Normal
        )
        if sure:
            self.add(group.key, name)

    def add(self, key: str, name: str) -> None:
        """Add a thing of a kind to the selected one, or a device to the site, and select it."""
        path = () if key == "devices" else self.selected()
        try:
            site, place = with_thing(self._editor.site, path, key, name)
        except ConfiguratorError as error:
            self._editor.refused.emit(str(error))
            return
        self._editor.apply(f"add {name or 'driving'}", lambda _: site)
        self.select(place, ("name",) if key != "drive" else ("topic",))

    def remove(self) -> None:
        """Remove the selected thing."""
        path = self.selected()
        if len(path) > 1:
            self._editor.apply(f"remove {path[-1]}", lambda site: without_things(site, [path]))

    def _apply_edit(self, field: Row, value: object) -> None:
        path = self.selected()
        self._editor.apply(
            f"change {field.label.lower()} of {path[-1] if path else 'the site'}",
            lambda site: with_value(site, (*path, *field.path), stored_value(field, value)),
        )
