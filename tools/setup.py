"""Make .venv, the object detector and the built pages, or see at once that all are up to date.

    python3 tools/setup.py demo     what `make demo` needs
    python3 tools/setup.py dev      what `make test` and the checks need besides

Runs with the system's own Python and nothing else. As root on Debian or Ubuntu it installs the
Debian packages that are missing; as anybody else it names the command that does.
"""

from __future__ import annotations

import ctypes.util
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

from choose_python import choose_python

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
STATIC = ROOT / "src" / "talaia" / "web" / "static"
MODULES = ROOT / "web" / "node_modules"

# Debian's ROS 1, INDI's server with its drivers, what checks a deployment's files, and what Qt
# draws with: only the tests need them, each known by a file of its own.
DIST = "/usr/lib/python3/dist-packages"
TESTED_WITH = {
    # For the pictures of the simulated observatory under ROS 1.
    "python3-numpy": f"{DIST}/numpy",
    "python3-rospy": f"{DIST}/rospy",
    "python3-roslaunch": f"{DIST}/roslaunch",
    "python3-rosmaster": f"{DIST}/rosmaster",
    "python3-rosmsg": f"{DIST}/rosmsg",
    "python3-rosservice": f"{DIST}/rosservice",
    "python3-rostopic": f"{DIST}/rostopic",
    "python3-actionlib": f"{DIST}/actionlib",
    "python3-std-msgs": f"{DIST}/std_msgs",
    "python3-std-srvs": f"{DIST}/std_srvs",
    "python3-sensor-msgs": f"{DIST}/sensor_msgs",
    "python3-geometry-msgs": f"{DIST}/geometry_msgs",
    "python3-nav-msgs": f"{DIST}/nav_msgs",
    "indi-bin": "/usr/bin/indiserver",
    "mosquitto": "/usr/sbin/mosquitto",
    "mosquitto-clients": "/usr/bin/mosquitto_pub",
    "docker-compose": "/usr/bin/docker-compose",
    "systemd": "/usr/bin/systemd-analyze",
    "fonts-dejavu-core": "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
    "libegl1": "/usr/share/doc/libegl1",
    "libgl1": "/usr/share/doc/libgl1",
    "libxkbcommon0": "/usr/share/doc/libxkbcommon0",
    "libdbus-1-3": "/usr/share/doc/libdbus-1-3",
    "dbus": "/usr/bin/dbus-daemon",
    "libfontconfig1": "/usr/share/doc/libfontconfig1",
}

# Servers that tests judge by and that would run on for good where they are installed: only CI,
# which wants every test, gets them. Without them these tests skip, and say so.
JUDGES = {
    "prometheus": "/usr/bin/prometheus",
    # Before several hubs, and behind them.
    "haproxy": "/usr/sbin/haproxy",
    "nats-server": "/usr/sbin/nats-server",
    # A provider of sign-ins (OpenID Connect).
    "glewlwyd": "/usr/bin/glewlwyd",
    "astrometry.net": "/usr/bin/solve-field",
    "astrometry-data-tycho2-10-19-littleendian": (
        "/usr/share/astrometry/index-tycho2-12.littleendian.fits"
    ),
}

# A Chromium without its window, which computes half as much; not every distribution has it, and
# without it the tests drive Chromium itself.
LIGHTER = {"chromium-headless-shell": "/usr/bin/chromium-headless-shell"}


def main(wanted: str) -> int:
    """Bring the tree to the wanted state; 0 when it is there."""
    if sys.version_info < (3, 11):
        return fail(
            f"Python 3.11 or newer is needed; this is {sys.version.split()[0]}",
            "install a newer one and run: make PYTHON=python3.12 demo",
        )
    if debian_packages(wanted):
        return 1
    if wanted == "dev" and os.environ.get("TALAIA_REQUIRE_ALL"):
        install_optional(JUDGES, "they could not be installed; their tests skip")
    if wanted == "dev":
        install_optional(LIGHTER, "it could not be installed; the tests take longer")
    if python_packages(wanted):
        return 1
    detector()
    return pages(wanted)


def debian_packages(wanted: str) -> int:
    """Install, or name, what comes from Debian: a venv, an OpenGL without a screen, a browser."""
    missing = []
    if not (VENV / "bin" / "python").exists() and not importlib.util.find_spec("ensurepip"):
        missing.append("python3-venv")
    if not (ctypes.util.find_library("OSMesa") or has_egl()):
        missing += ["libegl1", "libegl-mesa0", "libgl1-mesa-dri"]
    # The tests try both ways to draw; a product that has one of them needs no other.
    if wanted == "dev" and os.geteuid() == 0 and not ctypes.util.find_library("OSMesa"):
        missing.append("libosmesa6")
    if wanted == "dev" and not browser():
        missing.append("chromium")
    if wanted == "dev":
        missing += [name for name, file in TESTED_WITH.items() if not Path(file).exists()]
    if not missing:
        return 0
    names = " ".join(missing)
    if os.geteuid() != 0 or not shutil.which("apt-get"):
        return fail(f"missing from the system: {names}", f"run: sudo apt install {names}")
    say(f"installing Debian packages: {names}")
    quiet = {
        "stdout": subprocess.DEVNULL,
        "env": {**os.environ, "DEBIAN_FRONTEND": "noninteractive"},
    }
    install = ["apt-get", "install", "-y", "-q", "--no-install-recommends", *missing]
    if subprocess.run(install, check=False, stderr=subprocess.DEVNULL, **quiet).returncode == 0:
        return 0
    subprocess.run(["apt-get", "update", "-q"], check=False, **quiet)
    if subprocess.run(install, check=False, **quiet).returncode:
        return fail(f"apt-get could not install {names}", f"run: apt-get install {names}")
    return 0


def install_optional(packages: dict[str, str], otherwise: str) -> None:
    """Install what tests use where it is there, if that can be done; else say what follows."""
    absent = [name for name, file in packages.items() if not Path(file).exists()]
    if not absent or os.geteuid() != 0 or not shutil.which("apt-get"):
        return
    say(f"installing Debian packages: {' '.join(absent)}")
    done = subprocess.run(
        ["apt-get", "install", "-y", "-q", "--no-install-recommends", *absent],
        check=False,
        stdout=subprocess.DEVNULL,
        env={**os.environ, "DEBIAN_FRONTEND": "noninteractive"},
    )
    if done.returncode:
        say(otherwise)


def has_egl() -> bool:
    """Tell whether EGL can render without a screen: the library, Mesa's, and a driver behind it."""
    drivers = [*Path("/usr").glob("lib*/*/dri/*_dri.so"), *Path("/usr").glob("lib*/dri/*_dri.so")]
    libraries = (ctypes.util.find_library("EGL"), ctypes.util.find_library("EGL_mesa"))
    return all(libraries) and bool(drivers)


def browser() -> str | None:
    """Find a Chromium for the tests."""
    names = ("chromium", "chromium-browser", "google-chrome")
    return next((found for name in names if (found := shutil.which(name))), None)


def python_packages(wanted: str) -> int:
    """Install the locked packages into .venv, and this tree as an editable package."""
    lock = ROOT / "requirements" / f"{wanted}.txt"
    stamp = VENV / f".talaia-{wanted}"
    judging = ROOT / "requirements" / "judges.txt"
    state = digest(lock, judging, ROOT / "pyproject.toml")
    others = [VENV / ".talaia-dev"] if wanted == "demo" else []
    dev_state = digest(ROOT / "requirements" / "dev.txt", judging, ROOT / "pyproject.toml")
    if stamp.exists() and stamp.read_text() == state:
        return 0
    if any(each.exists() and each.read_text() == dev_state for each in others):
        return 0
    if not (VENV / "bin" / "python").exists():
        # Whoever says `make PYTHON=…` gets that one.
        program = sys.executable if os.environ.get("TALAIA_THIS_PYTHON") else choose_python()
        quicker = program != sys.executable
        say(f"making .venv with {program}" + (", which is quicker" if quicker else ""))
        if subprocess.run([program, "-m", "venv", str(VENV)], check=False).returncode:
            return fail("the virtual environment could not be made", "is python3-venv installed?")
    say(f"installing {lock.relative_to(ROOT)} into .venv (a few minutes the first time)")
    pip = [
        str(VENV / "bin" / "python"),
        "-m",
        "pip",
        "install",
        "-q",
        "--disable-pip-version-check",
        # An old pip would install what comes as sources without saying what it was.
        "--use-pep517",
    ]
    if subprocess.run([*pip, "--require-hashes", "-r", str(lock)], check=False).returncode:
        return fail("the locked packages could not be installed", "see pip's message above")
    judged = [*pip, "--no-deps", "--require-hashes", "-r", str(judging)]
    if wanted == "dev" and subprocess.run(judged, check=False).returncode:
        return fail("what tests judge by could not be installed", "see pip's message above")
    editable = [*pip, "--no-deps", "--no-build-isolation", "-e", str(ROOT)]
    if subprocess.run(editable, check=False).returncode:
        return fail("this tree could not be installed into .venv", "see pip's message above")
    stamp.write_text(state)
    return 0


def detector() -> None:
    """Make the files that see objects and find faces on pictures; without them the rest works."""
    for script, problem in (
        ("make_detector.py", "nothing sees objects on cameras' pictures; all the rest works"),
        ("make_face_detector.py", "pictures that are to be blurred do not leave their gateway"),
    ):
        make = [str(VENV / "bin" / "python"), str(ROOT / "tools" / script)]
        if subprocess.run(make, cwd=ROOT, check=False).returncode:
            fail(
                problem,
                f"once there is a network, run: {Path(make[0]).relative_to(ROOT)} tools/{script}",
            )


def pages(wanted: str) -> int:
    """Build the pages when a source of theirs is newer than the build."""
    sources = sorted(
        path
        for path in (ROOT / "web").rglob("*")
        if path.is_file() and not {"node_modules", "mock", "dist"} & set(path.parts)
    )
    state = digest(*sources)
    stamp = STATIC / ".sources"
    built = stamp.exists() and stamp.read_text() == state
    tools = wanted != "dev" or (MODULES / ".talaia-lock").exists()
    if built and tools:
        return 0
    node = [str(VENV / "bin" / "python"), str(ROOT / "tools" / "node.py")]
    lock = digest(ROOT / "web" / "package-lock.json")
    mark = MODULES / ".talaia-lock"
    if not mark.exists() or mark.read_text() != lock:
        say("installing what builds the pages")
        if subprocess.run([*node, "ci", "--no-audit", "--no-fund"], check=False).returncode:
            return fail("the pages' build tools could not be installed", "see npm's message above")
        mark.write_text(lock)
    if not built:
        say("building the pages")
        quiet = subprocess.run([*node, "run", "build"], check=False, capture_output=True, text=True)
        if quiet.returncode:
            print(quiet.stdout, quiet.stderr, sep="\n", file=sys.stderr)
            return fail("the pages could not be built", "see the messages above")
        stamp.write_text(state)
    return 0


def digest(*paths: Path) -> str:
    """Name the content of files, with their places."""
    total = hashlib.sha256()
    for path in paths:
        total.update(str(path.relative_to(ROOT)).encode() + b"\0")
        total.update(path.read_bytes() if path.exists() else b"")
    return total.hexdigest()


def say(sentence: str) -> None:
    """Tell what takes time."""
    print(f"talaia set-up: {sentence} …", flush=True)


def fail(problem: str, remedy: str) -> int:
    """Tell what is wrong and what to do."""
    print(f"talaia set-up: {problem}\n  {remedy}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1] if len(sys.argv) > 1 else "dev"))
