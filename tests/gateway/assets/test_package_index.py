"""Where packages lie: as ament's own index and rospack find them."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

from talaia.gateway.assets.package_index import PackageIndex

from .package_folders import make_ament_package, make_ros1_package

HAND = {"meshes/hand.stl": b"solid"}


def missing(what: str) -> None:
    if os.environ.get("TALAIA_REQUIRE_ALL"):
        pytest.fail(f"{what} is required here and is missing")
    pytest.skip(f"needs {what}")


def index_of(*, ament="", ros1="") -> PackageIndex:
    return PackageIndex.from_environment({"AMENT_PREFIX_PATH": ament, "ROS_PACKAGE_PATH": ros1})


def test_package_of_the_first_prefix_that_has_it_counts(tmp_path) -> None:
    over, under = (make_ament_package(tmp_path / name, "arm", HAND) for name in ("over", "under"))
    other = make_ament_package(tmp_path / "under", "leg", HAND)
    index = index_of(ament=f"{tmp_path}/over:{tmp_path}/under")
    assert (index.find_folder("arm"), index.find_folder("leg")) == (over, other)
    assert index.folder_of(under / "meshes" / "hand.stl") is None
    assert index.folder_of(other / "meshes" / "hand.stl") == other


def test_ament_itself_finds_the_same(tmp_path) -> None:
    if importlib.util.find_spec("ament_index_python") is None:
        missing("ament_index_python")
    share = make_ament_package(tmp_path, "arm", HAND)
    environment = {"AMENT_PREFIX_PATH": str(tmp_path)}
    asks = "from ament_index_python.packages import get_package_share_directory as find"
    found = subprocess.run(
        [sys.executable, "-c", f"{asks}; print(find('arm'))"],
        env={**os.environ, **environment},
        capture_output=True,
        check=True,
        text=True,
    )
    assert found.stdout.strip() == str(share)
    assert PackageIndex.from_environment(environment).find_folder("arm") == share


def test_folder_that_is_no_package_is_none(tmp_path) -> None:
    make_ament_package(tmp_path, "arm", HAND)
    (tmp_path / "share" / "loose").mkdir()
    index = index_of(ament=str(tmp_path))
    for name in ("loose", "ament_index", "..", ".", "", "arm/..", "arm/meshes", "share", "arm\0"):
        assert index.find_folder(name) is None
    assert index.folder_of(tmp_path / "share" / "loose" / "a.stl") is None


def test_ros1_package_is_found_by_the_name_in_it_but_not_within_another(tmp_path) -> None:
    arm = make_ros1_package(tmp_path, "src/robot/arm_description", "arm", HAND)
    make_ros1_package(tmp_path, "src/robot/arm_description/test", "inner", HAND)
    make_ros1_package(tmp_path, "src/.hidden", "hidden", HAND)
    left_out = make_ros1_package(tmp_path, "src/old/leg", "leg", HAND)
    (left_out.parent / "CATKIN_IGNORE").touch()
    index = index_of(ros1=str(tmp_path / "src"))
    assert index.find_folder("arm") == arm
    for name in ("arm_description", "inner", "hidden", "leg"):
        assert index.find_folder(name) is None
    assert index.folder_of(arm / "meshes" / "hand.stl") == arm
    assert index.folder_of(tmp_path / "hand.stl") is None


def test_rospack_itself_finds_the_same(tmp_path) -> None:
    # Debian's, which is of the machine's own Python.
    if not Path("/usr/lib/python3/dist-packages/rospkg").is_dir():
        missing("rospkg")
    make_ros1_package(tmp_path, "src/robot/arm_description", "arm", HAND)
    environment = {"ROS_PACKAGE_PATH": str(tmp_path / "src"), "HOME": str(tmp_path)}
    found = subprocess.run(
        ["/usr/bin/python3", "-c", "import rospkg; print(rospkg.RosPack().get_path('arm'))"],
        env=environment,
        capture_output=True,
        check=True,
        text=True,
    )
    folder = PackageIndex.from_environment(environment).find_folder("arm")
    assert str(folder) == found.stdout.strip()


def test_link_in_a_circle_is_not_walked(tmp_path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "back").symlink_to(tmp_path)
    assert index_of(ros1=str(tmp_path)).find_folder("arm") is None


def test_what_is_not_an_absolute_folder_is_passed_over() -> None:
    assert index_of(ament="::relative:", ros1="src:").find_folder("arm") is None
