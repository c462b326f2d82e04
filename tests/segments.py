"""Which shared memory a ROS 2 process owns, and the table of a crash loop."""

import os
from pathlib import Path

__all__ = ["segments_of", "write_crash_row"]

SHARED = Path("/dev/shm")  # noqa: S108
HEAD = """\
| killed (`kill -9`) | times | segments they left | room they took, MB | left at the end |
| --- | --: | --: | --: | --: |
"""


def segments_of(pid: int) -> set[Path]:
    """Give the segments (not the ports) that a process owns: whose lock files it has locked.

    Who only reads another's segment has its lock file open, too.
    """
    held = {each.readlink() for each in Path(f"/proc/{pid}/fd").iterdir() if each.is_symlink()}
    owned = {
        int(words[5].rpartition(":")[2])
        for line in Path("/proc/locks").read_text().splitlines()
        if (words := line.split())[1] == "FLOCK" and words[3] == "WRITE" and words[4] == str(pid)
    }
    return {
        each.with_name(each.name.removesuffix("_el"))
        for each in held
        if each.parent == SHARED
        and each.name.endswith("_el")
        and "port" not in each.name
        and each.exists()
        and each.stat().st_ino in owned
    }


def write_crash_row(killed: str, times: int, room: dict[Path, int]) -> None:
    """Put a row into the proof's table, if there is one, in place of a former one.

    Args:
        killed: what was killed.
        times: how often.
        room: the segments that the dead owned, and what each took (bytes).

    """
    if not (target := os.environ.get("TALAIA_PROOF_TABLE")):
        return
    table, begin = Path(target), f"| {killed} | "
    rows = table.read_text().splitlines()[2:] if table.exists() else []
    left = sum(each.exists() for each in room)
    mine = f"{begin}{times} | {len(room)} | {sum(room.values()) / 1e6:,.0f} | {left} |"
    kept = [each for each in rows if not each.startswith(begin)]
    table.write_text(HEAD + "\n".join([*kept, mine]) + "\n")
