"""Which database a site that is started on this machine keeps its accounts and history in."""

from __future__ import annotations

from typing import TYPE_CHECKING
from urllib.parse import quote

from PySide6.QtWidgets import QGridLayout, QLabel, QLineEdit, QWidget

from talaia.configurator.qt.palette import SPACE
from talaia.configurator.qt.widgets import ComboBox

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["DATABASE_NAMES", "DATABASE_VARIABLE", "DatabaseChoice", "database_url"]

# As `talaia generate` and database URLs call them.
DATABASE_NAMES = {
    "sqlite": "SQLite",
    "mariadb": "MariaDB",
    "postgresql": "PostgreSQL",
}
# What the hub reads; a password in it stands in no process list and in no file.
DATABASE_VARIABLE = "TALAIA_DATABASE_URL"
# Names a file that holds it; read where the variable is empty.
_FILE_VARIABLE = "TALAIA_DATABASE_URL_FILE"
# For a person who started the configurator with the variable set.
_AS_SET = "environment"


def database_url(kind: str, address: str, password: str) -> str:
    """Give the URL of a database server; empty when the address is not ``user@host/database``.

    Args:
        kind: ``mariadb`` or ``postgresql``.
        address: ``user@host:port/database``; the port may be left out.
        password: of the user; empty for none.

    """
    user, at, place = address.strip().rpartition("@")
    host, _, name = place.partition("/")
    if not (user and at and host and name):
        return ""
    secret = f":{quote(password, safe='')}" if password else ""
    return f"{kind}://{quote(user, safe='')}{secret}@{host}/{quote(name, safe='')}"


class DatabaseChoice(QWidget):
    """A choice of the engine, and for a server its address and password."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        """Offer SQLite first, or what ``environment`` names."""
        super().__init__()
        self.kind = ComboBox()
        if environment.get(DATABASE_VARIABLE) or environment.get(_FILE_VARIABLE):
            self.kind.addItem(f"As {DATABASE_VARIABLE} says", _AS_SET)
        for word, name in DATABASE_NAMES.items():
            self.kind.addItem(f"{name} (a file)" if word == "sqlite" else f"{name} server", word)
        self.kind.setAccessibleName("Database on this machine")
        self.address = QLineEdit(placeholderText="user@host/database")
        self.address.setAccessibleName("Address of the database server")
        self.password = QLineEdit(echoMode=QLineEdit.EchoMode.Password)
        self.password.setAccessibleName("Password of the database user")
        self._titles: list[QLabel] = []
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(SPACE[1])
        fields = (
            ("Data&base", self.kind, 2),
            ("Ser&ver", self.address, 3),
            ("Pass&word", self.password, 2),
        )
        for column, (text, widget, stretch) in enumerate(fields):
            title = QLabel(text)
            title.setBuddy(widget)
            self._titles.append(title)
            grid.addWidget(title, 0, column)
            grid.addWidget(widget, 1, column)
            grid.setColumnStretch(column, stretch)
        self.kind.currentIndexChanged.connect(lambda _: self._show_fields())
        self._show_fields()

    @property
    def is_server(self) -> bool:
        """Whether a server has to be named."""
        return self.kind.currentData() in {"mariadb", "postgresql"}

    def environment(self) -> dict[str, str] | None:
        """Give what the started programs get beside this one's environment.

        None when a server is chosen and its address is no ``user@host/database``.
        """
        if self.kind.currentData() == _AS_SET:
            return {}
        if not self.is_server:
            # Empty counts as unset: the file in the data folder.
            return {DATABASE_VARIABLE: "", _FILE_VARIABLE: ""}
        url = database_url(self.kind.currentData(), self.address.text(), self.password.text())
        return {DATABASE_VARIABLE: url} if url else None

    def _show_fields(self) -> None:
        for widget in (self.address, self.password, *self._titles[1:]):
            widget.setVisible(self.is_server)
