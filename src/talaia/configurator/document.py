"""The description that is open: its changes with undo, its problems, and the text to save.

A change is one step from a whole site to the next; sites share what is equal, so steps are small.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.configurator.description_paths import Spot, find_spot
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.save import save_into_text
from talaia.model.yaml_text.write import write_description

if TYPE_CHECKING:
    from collections.abc import Mapping

    from talaia.model.site import Device, Site

__all__ = ["MAX_STEPS", "Document", "Problem"]

# More than a person takes back; sites share their parts, so a step is small.
MAX_STEPS = 500
_HEAD = (
    "Made by talaia configure, which opens it again; comments of yours stay.",
    "`talaia check` validates it.",
)


class Problem(NamedTuple):
    """What does not fit: in words as `talaia check` says them, and where to go for it."""

    # Path of the finding as `talaia check` prints it: ``$.devices.base.unit``.
    where: str
    problem: str
    remedy: str
    spot: Spot

    def __str__(self) -> str:
        return self.problem + (f"; {self.remedy}" if self.remedy else "")


class _Step(NamedTuple):
    """How the site is after a change, and what the change was."""

    # Empty for the state that the document was opened in.
    what: str
    site: Site


class Document:
    """One description while it is edited."""

    def __init__(
        self, site: Site, text: str = "", elsewhere: Mapping[str, Device] | None = None
    ) -> None:
        """Begin with a site.

        Args:
            site: as it is now.
            text: the YAML it was read from; empty for one that is new, which is then unsaved.
            elsewhere: devices of command files that the site names; they are checked with it, and
                stay where they are.

        """
        # Each change with the site after it; undo and redo move `_now` along this list.
        self._steps = [_Step("", site)]
        self._now = 0
        # The file's text as it was read or written last: a save changes this, comments and all.
        self._text = text
        self._saved: Site | None = site if text else None
        # A new document is not worth a question until somebody has changed it.
        self._blank = None if text else site
        # Read once, at opening; they are in no step and in no saved text.
        self._elsewhere = dict(elsewhere or {})
        # The last checked site and its problems: checks are asked for many times per change.
        self._checked: tuple[Site, tuple[Problem, ...]] | None = None

    @classmethod
    def of_text(cls, text: str, elsewhere: Mapping[str, Device] | None = None) -> Document:
        """Open YAML text.

        Raises:
            DescriptionError: it is not a description.

        """
        return cls(load_site(text), text, elsewhere)

    @property
    def site(self) -> Site:
        """How it is now."""
        return self._steps[self._now].site

    @property
    def opened(self) -> str:
        """The text as it was read or saved last; empty for a new one."""
        return self._text

    @property
    def is_changed(self) -> bool:
        """Whether closing it now would lose something."""
        # Compared, not counted: a change that is undone by hand leaves nothing to save.
        return self.site not in (self._saved, self._blank)

    @property
    def undoes(self) -> str:
        """What `undo` would take back, in words; empty when there is nothing."""
        return self._steps[self._now].what if self._now else ""

    @property
    def redoes(self) -> str:
        """What `redo` would do again, in words; empty when there is nothing."""
        return self._steps[self._now + 1].what if self._now + 1 < len(self._steps) else ""

    def apply_change(self, what: str, site: Site) -> bool:
        """Make a step; false when nothing is different.

        The oldest of more than `MAX_STEPS` steps is forgotten.
        """
        if site == self.site:
            return False
        # What was undone is forgotten: a new change begins another way.
        self._steps[self._now + 1 :] = [_Step(what, site)]
        del self._steps[: max(len(self._steps) - 1 - MAX_STEPS, 0)]
        self._now = len(self._steps) - 1
        return True

    def undo(self) -> bool:
        """Go one step back; false at the beginning."""
        if not self._now:
            return False
        self._now -= 1
        return True

    def redo(self) -> bool:
        """Do again what was undone; false when nothing was."""
        if not self.redoes:
            return False
        self._now += 1
        return True

    def to_yaml(self) -> str:
        """Give the YAML to save, with what a person wrote in the file left as it was.

        Raises:
            DescriptionError: the change cannot be written into the text that was opened.

        """
        return (
            save_into_text(self._text, self.site)
            if self._text
            else write_description(self.site, _HEAD)
        )

    def was_saved(self, text: str) -> None:
        """Take note that ``text``, which `to_yaml` gave, is in the file now."""
        self._text, self._saved = text, self.site

    @property
    def problems(self) -> tuple[Problem, ...]:
        """All that `talaia check` would say."""
        site = self.site
        # By identity: each step has a site of its own, and to compare two whole sites takes longer.
        if self._checked is None or self._checked[0] is not site:
            # Rules may name devices of another file; without them each would be a problem.
            whole = msgspec.structs.replace(site, devices={**self._elsewhere, **site.devices})
            found = tuple(
                Problem(*finding, find_spot(site, finding.where)) for finding in check_site(whole)
            )
            self._checked = (site, found)
        return self._checked[1]
