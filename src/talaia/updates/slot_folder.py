"""The folder of a gateway's releases: `releases/VERSION/`, the link `current`, and the state.

Whatever is written takes the other's place whole, and the state is written before what it allows.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from talaia.updates.errors import UpdateError
from talaia.updates.slots import (
    SlotPhase,
    SlotState,
    begin_trial,
    begin_update,
    confirm_trial,
    end_trial,
    mark_allowed,
    mark_installed,
    recover_state,
    slot_to_run,
    version_order,
    withdraw_permission,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from talaia.updates.signed_release import SignedRelease

__all__ = ["RunnableSlot", "SlotFolder"]

_STATE, _LOCK, _LINKED, _CURRENT = "update.json", "update.lock", "linked", "current"
_MOST_STATE = 64 * 1024


class RunnableSlot(NamedTuple):
    """What a start runs.

    Attributes:
        version: of the release.
        program: its ``talaia``.
        on_trial: whether it is still to be shown that it works.

    """

    version: str
    program: Path
    on_trial: bool


class SlotFolder:
    """Keeps the releases below one folder."""

    def __init__(self, root: Path, checkpoint: Callable[[str], None] = lambda _: None) -> None:
        """Use ``root``; ``checkpoint`` is called between any two changes of the disk."""
        self._root = root
        # Tests end here as a power cut would.
        self._checkpoint = checkpoint

    def slot_path(self, version: str) -> Path:
        """Give the folder of a release."""
        # What is no version could lead elsewhere.
        version_order(version)
        return self._root / "releases" / version

    def read_state(self) -> SlotState:
        """Read how it stands.

        Raises:
            UpdateError: there are no releases here, or the state is damaged.

        """
        try:
            with (self._root / _STATE).open("rb") as file:
                return msgspec.json.decode(file.read(_MOST_STATE), type=SlotState)
        except FileNotFoundError as error:
            raise UpdateError(
                f"{self._root} holds no releases; begin with: talaia update setup"
            ) from error
        except (OSError, msgspec.DecodeError) as error:
            raise UpdateError(f"{self._root / _STATE} cannot be read: {error}") from error

    # `build` has all of a release on disk when it returns: the state then says that it is whole.
    def set_up(self, release: SignedRelease, build: Callable[[list[Path], Path], None]) -> None:
        """Install the first release, which becomes the current one."""
        with self._locked():
            if (self._root / _STATE).exists():
                raise UpdateError(
                    f"{self._root} holds releases already; use: talaia update install"
                )
            self._build_slot(release, build)
            self._write_state(SlotState(current=release.manifest.version))
            self._point_link(release.manifest.version)

    def install_release(
        self,
        release: SignedRelease,
        build: Callable[[list[Path], Path], None],
        *,
        downgrade: bool = False,
    ) -> None:
        """Install a release beside the one that runs; it waits there for the gateway.

        Raises:
            UpdateError: it may not be installed, or cannot.

        """
        with self._locked():
            before = self.read_state()
            state = begin_update(before, release.manifest.version, downgrade=downgrade)
            if state.previous == state.candidate:
                # It is made anew, and until then none to go back to.
                state = msgspec.structs.replace(state, previous="")
            self._write_state(state)
            try:
                self._build_slot(release, build)
            except (UpdateError, OSError) as error:
                self._write_state(end_trial(state, f"cannot be installed: {error}"))
                self._remove_others()
                raise
            self._write_state(mark_installed(state))

    def allow_trial(self) -> None:
        """Let the next start try what waits; asked by a gateway that is at rest."""
        with self._locked():
            self._write_state(mark_allowed(self.read_state()))

    def withdraw_trial(self) -> None:
        """Take that back: something moves again."""
        with self._locked():
            self._write_state(withdraw_permission(self.read_state()))

    def start_slot(self) -> RunnableSlot:
        """Say what this start runs, and count it if it is a trial."""
        with self._locked():
            state = recover_state(self.read_state())
            if state.phase in (SlotPhase.ALLOWED, SlotPhase.TRYING):
                state = begin_trial(state)
            self._write_state(state)
            with contextlib.suppress(FileNotFoundError):
                (self._root / _LINKED).unlink()
            self._checkpoint("the mark of a link removed")
            # An end between state and link would leave it behind.
            self._point_link(state.current)
            self._remove_others()
            version = slot_to_run(state)
            program = self.slot_path(version) / "bin" / "talaia"
            return RunnableSlot(version, program, state.phase is SlotPhase.TRYING)

    def keep_candidate(self) -> None:
        """Keep what is tried, as the current release."""
        with self._locked():
            state = confirm_trial(self.read_state())
            self._write_state(state)
            self._point_link(state.current)
            self._remove_others()

    def leave_candidate(self, why: str) -> None:
        """Go back to the current release."""
        with self._locked():
            self._write_state(end_trial(self.read_state(), why))
            self._remove_others()

    def mark_linked(self, version: str) -> None:
        """Note that the gateway of this release has its link to the hub."""
        (self._root / _LINKED).write_text(version, encoding="utf-8")

    def is_linked(self, version: str) -> bool:
        """Tell whether the gateway of this release has had its link since its start."""
        with contextlib.suppress(OSError):
            return (self._root / _LINKED).read_text(encoding="utf-8") == version
        return False

    def _build_slot(
        self, release: SignedRelease, build: Callable[[list[Path], Path], None]
    ) -> None:
        slot = self.slot_path(release.manifest.version)
        wheels = self._root / "wheels"
        for folder in (slot, wheels):
            # Of an update that was cut off.
            shutil.rmtree(folder, ignore_errors=True)
            self._checkpoint("a folder of before removed")
            folder.mkdir(parents=True, mode=0o700)
        build(release.unpack_wheels(wheels), slot)
        self._checkpoint("built")
        if not (slot / "bin" / "talaia").exists():
            raise UpdateError("the release brings no program")
        shutil.rmtree(wheels, ignore_errors=True)

    def _write_state(self, state: SlotState) -> None:
        fresh = self._root / f".{_STATE}"
        with fresh.open("wb") as file:
            file.write(msgspec.json.encode(state))
            file.flush()
            os.fsync(file.fileno())
        self._checkpoint("state written aside")
        fresh.replace(self._root / _STATE)
        self._sync_root()
        self._checkpoint("state written")

    def _point_link(self, version: str) -> None:
        """Lead `current` to a release, for service managers and people."""
        target = Path("releases") / version
        link, fresh = self._root / _CURRENT, self._root / f".{_CURRENT}"
        if link.is_symlink() and link.readlink() == target:
            return
        with contextlib.suppress(FileNotFoundError):
            fresh.unlink()
        fresh.symlink_to(target)
        self._checkpoint("link made aside")
        fresh.replace(link)
        self._sync_root()
        self._checkpoint("link made")

    def _remove_others(self) -> None:
        """Remove releases that nothing needs any more."""
        state = self.read_state()
        needed = {state.current, state.previous, state.candidate}
        for path in (self._root / "releases").iterdir():
            if path.name not in needed:
                shutil.rmtree(path, ignore_errors=True)
                self._checkpoint("a release removed")

    def _sync_root(self) -> None:
        number = os.open(self._root, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)

    @contextlib.contextmanager
    def _locked(self) -> Iterator[None]:
        self._root.mkdir(parents=True, exist_ok=True, mode=0o700)
        with (self._root / _LOCK).open("w") as file:
            try:
                # An installation takes minutes: nobody waits behind it.
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                raise UpdateError("another update is being installed; try again later") from error
            yield
