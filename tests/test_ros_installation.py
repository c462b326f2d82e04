"""Which ROS 2 is used: a sourced one, or the wheels; never both in one process."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from talaia.ros_installation import (
    FoundRos,
    RosOrigin,
    bridge_command,
    choose_ros,
    find_ros,
)

PYTHON = f"{sys.version_info.major}.{sys.version_info.minor}"
WHEELS = FoundRos(
    package="/venv/lib/python3.11/site-packages/rclpy",
    wheels=True,
    libraries=["/venv/b.libs", "/venv/a.libs"],
    installations=[],
    python="3.11",
    machine="x86_64",
)
NOTHING = WHEELS._replace(package="", wheels=False, libraries=[])


def sourced(python: str, folder: str = "/opt/ros/jazzy") -> dict[str, str]:
    """What a ``setup.bash`` sets."""
    return {
        "AMENT_PREFIX_PATH": f"/srv/ws/install:{folder}",
        "PYTHONPATH": f"{folder}/lib/python{python}/site-packages:/mine",
        "LD_LIBRARY_PATH": f"{folder}/lib:/usr/local/cuda/lib",
    }


def test_a_sourced_ros_of_this_python_is_used_as_it_is() -> None:
    choice = choose_ros(WHEELS, sourced("3.11"))
    assert (choice.origin, choice.environment) == (RosOrigin.SOURCED, {})
    assert choice.where == "/opt/ros/jazzy/lib/python3.11/site-packages"


def test_a_ros_sourced_for_another_python_is_taken_out_where_there_are_wheels() -> None:
    choice = choose_ros(WHEELS, sourced("3.10", "/opt/ros/humble"))
    assert choice.origin is RosOrigin.WHEELS
    assert "for Python 3.10" in choice.reason
    assert choice.environment["LD_LIBRARY_PATH"] == "/venv/a.libs:/venv/b.libs:/usr/local/cuda/lib"
    assert choice.environment["PYTHONPATH"] == "/mine"
    # Its message definitions are still found.
    assert "AMENT_PREFIX_PATH" not in choice.environment


def test_a_gateway_uses_a_ros_of_another_python_by_a_process_of_that_python() -> None:
    for found in (WHEELS, NOTHING):
        choice = choose_ros(found, sourced("3.10", "/opt/ros/humble"), bridged=True)
        assert (choice.origin, choice.python) == (RosOrigin.BRIDGED, "python3.10")
        assert choice.where == "/opt/ros/humble/lib/python3.10/site-packages"
    # One of this Python is still loaded as it is.
    assert choose_ros(NOTHING, sourced("3.11"), bridged=True).origin is RosOrigin.SOURCED
    named = choose_ros(WHEELS, {"TALAIA_ROS_PYTHON": "/srv/env/bin/python"}, bridged=True)
    assert bridge_command(named) == ["/srv/env/bin/python", "-u"]


def test_a_ros_that_nobody_sourced_is_found_and_its_setup_is_read_first() -> None:
    packages = {
        "/opt/ros/humble": "/opt/ros/humble/local/lib/python3.10/dist-packages",
        "/opt/ros/jazzy": "/opt/ros/jazzy/lib/python3.99/site-packages",
    }
    found = NOTHING._replace(machine="aarch64", packages=packages)
    choice = choose_ros(found, {}, bridged=True)
    assert choice.origin is RosOrigin.BRIDGED
    assert bridge_command(choice) == [
        "/bin/bash", "-c", '. "$0" && exec "$@"', "/opt/ros/jazzy/setup.bash", "python3.99", "-u"
    ]  # fmt: skip
    # Wheels are installed on purpose.
    assert choose_ros(WHEELS._replace(packages=packages), {}, bridged=True).origin is (
        RosOrigin.WHEELS
    )


@given(st.permutations(["/venv/a.libs", "/venv/b.libs", "/venv/c.libs"]))
def test_the_wheels_libraries_are_in_the_same_order_at_every_start(libraries: list[str]) -> None:
    found = WHEELS._replace(libraries=libraries)
    choice = choose_ros(found, {})
    assert choice.environment["LD_LIBRARY_PATH"] == "/venv/a.libs:/venv/b.libs:/venv/c.libs"
    # What was started so is not started anew.
    assert choose_ros(found, choice.environment).environment == {}


@pytest.mark.parametrize(
    ("found", "environment", "words"),
    [
        (NOTHING, sourced("3.10"), "a gateway uses it by a process of its own"),
        (
            NOTHING._replace(installations=["/opt/ros/jazzy"]),
            {},
            "source /opt/ros/jazzy/setup.bash",
        ),
        (NOTHING, {}, "pip install 'talaia[ros2]'"),
        (NOTHING._replace(machine="aarch64"), {}, "install ROS 2 and source its setup.bash"),
    ],
)
def test_where_there_is_none_it_is_said_what_to_do(
    found: FoundRos, environment: dict[str, str], words: str
) -> None:
    choice = choose_ros(found, environment)
    assert choice.origin is RosOrigin.NONE
    assert words in choice.remedy


def run(folder: Path, script: str, **more: str) -> subprocess.CompletedProcess[str]:
    """Run a script in a fresh process that knows nothing of the ROS of this one."""
    clean = {
        name: value
        for name, value in os.environ.items()
        if name not in {"LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE", "AMENT_PREFIX_PATH"}
    }
    source = str(Path(__file__).resolve().parents[1] / "src")
    path = os.pathsep.join([*filter(None, [more.pop("PYTHONPATH", "")]), source])
    file = folder / "script.py"
    file.write_text(f"from talaia.ros_installation import use_ros\n{script}")
    return subprocess.run(
        [sys.executable, str(file)],
        env={**clean, "PYTHONPATH": path, **more},
        capture_output=True,
        text=True,
        check=False,
    )


def test_with_wheels_the_process_begins_anew_and_rclpy_works(tmp_path: Path) -> None:
    if not find_ros().wheels:
        pytest.skip("the ROS 2 wheels are not installed")
    done = run(tmp_path, "print(use_ros().origin)\nimport rclpy\nrclpy.init()\nrclpy.shutdown()\n")
    assert (done.stdout, done.returncode) == ("wheels\n", 0), done.stderr


def test_beside_a_sourced_ros_no_package_of_the_wheels_is_loaded(tmp_path: Path) -> None:
    if not find_ros().wheels:
        pytest.skip("the ROS 2 wheels are not installed")
    # What stands for a sourced ROS: its Python packages, by which Python would find it.
    prefix = tmp_path / "opt/ros/jazzy"
    packages = prefix / f"lib/python{PYTHON}/site-packages"
    for name, text in (("rclpy/__init__.py", ""), ("rclpy/context.py", ""), ("std_msgs.py", "")):
        (packages / name).parent.mkdir(parents=True, exist_ok=True)
        (packages / name).write_text(text)
    script = (
        "import os\nprint(use_ros().origin, os.environ.get('LD_LIBRARY_PATH', ''))\n"
        "import rclpy, std_msgs\nprint(rclpy.__file__, std_msgs.__file__)\n"
        "try:\n    import nav_msgs\nexcept ModuleNotFoundError as error:\n    print(error)\n"
    )
    done = run(tmp_path, script, AMENT_PREFIX_PATH=str(prefix), PYTHONPATH=f"{packages}{os.sep}")
    chosen, files, refused = done.stdout.splitlines()
    assert chosen == "sourced "
    assert [Path(word).is_relative_to(prefix) for word in files.split()] == [True, True]
    assert refused == "the sourced ROS 2 has no package nav_msgs; install it there"


def test_a_process_that_runs_is_not_begun_anew_for_the_order_alone(tmp_path: Path) -> None:
    if not find_ros().wheels:
        pytest.skip("the ROS 2 wheels are not installed")
    script = "import os\nfirst = os.environ['LD_LIBRARY_PATH']\nuse_ros(ordered={})\nprint(first)\n"
    paths = [run(tmp_path, script.format(ordered)).stdout for ordered in (False, True, True)]
    assert len({frozenset(path.strip().split(":")) for path in paths}) == 1
    # Where the order was asked for, the process that goes on is the second.
    assert paths[1] == paths[2]
    assert paths[1].strip().split(":") == sorted(paths[1].strip().split(":"))


def test_another_package_of_that_name_is_named_and_not_advised_again(tmp_path: Path) -> None:
    (tmp_path / "rclpy.py").write_text("'''A stub, as the package index has them.'''\n")
    # Before the environment's own packages, so that it is found first.
    done = run(
        tmp_path,
        "from talaia import ros_installation as module\n"
        "found = module.find_ros()._replace(wheels=False)\n"
        "module.find_ros = lambda: found\nuse_ros()\n",
        PYTHONPATH=str(tmp_path),
    )
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert f"rclpy of {tmp_path} cannot be used" in last
    assert "pip uninstall rclpy" in last
