"""A gateway on arm64: its image on a distribution's ROS 2, and what it needs is locked.

Such an image is not built here, and nothing of it runs. `make proofs ONLY=arm64` finds a wheel at
the index for each locked package and each Python.
"""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from deploy.arm64_wheels import PYTHONS, locked_pins
from deploy.test_image_recipes import steps
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from talaia import __version__
from talaia.cli.main import main
from talaia.deploy.options import ROS_DISTROS

EXAMPLE = Path(__file__).parents[2] / "examples/agv/site.yaml"


@pytest.mark.parametrize("distro", ROS_DISTROS)
def test_a_gateways_image_is_made_from_a_distributions_own(distro: str, tmp_path: Path) -> None:
    words = ["generate", str(EXAMPLE), "--to", str(tmp_path), "--database", "sqlite"]
    assert main([*words, "--ros-distro", distro, "--arch", "arm64"]) == 0
    recipe = (tmp_path / "gateway.Dockerfile").read_text()
    assert recipe.startswith(f"FROM ros:{distro}-ros-base\n")
    # The image's own ROS 2 is used: the wheels are for another machine, and never beside it.
    assert steps(recipe)[-1][-1] == f"talaia[gateway,fast,objects]=={__version__}"
    assert f"ros-{distro}-nav-msgs" in recipe
    gateway = yaml.safe_load((tmp_path / "compose.yaml").read_text())["services"]["gateway"]
    assert gateway["platform"] == "linux/arm64"


def test_an_image_for_arm64_without_a_distribution_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["generate", str(EXAMPLE), "--to", str(tmp_path / "to"), "--arch", "arm64"]) == 2
    assert "add --ros-distro" in capsys.readouterr().err
    assert not (tmp_path / "to").exists()


@pytest.mark.parametrize("python", PYTHONS)
def test_what_a_gateway_on_arm64_needs_is_locked_and_has_nothing_of_another_machine(
    python: str,
) -> None:
    names = {canonicalize_name(Requirement(each).name) for each in locked_pins(python)}
    assert {"msgspec", "numpy", "rosbags", "websockets", "onnxruntime", "av", "mcap"} <= names
    assert [each for each in names if each.startswith("ros-")] == []
