"""Which shared memory a ROS 2 process owns."""

from pathlib import Path

__all__ = ["segments_of"]

SHARED = Path("/dev/shm")  # noqa: S108


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
