"""What the images' recipes install, installed: in a clean virtual environment, by their own words.

Docker itself does not run here; the steps it would run are read from the recipes, and those of
pip are run as they stand. `wheels/` and a ``pip`` beside the environment stand for the image's.

What Talaia's wheel asks for is there already, linked, so that no index is asked; `make
proofs ONLY=images` has everything come from the index instead.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from deploy.linked_environment import make_linked_environment

from talaia import __version__
from talaia.cli.main import main

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples/agv/site.yaml"
OLD = """\
talaia: 1
site: old
name: Old
connections: {old: {kind: ros1}}
devices: {a: {name: A}}
recording: {topics: [/odom]}
"""
IMAGE = "sensor_msgs/msg/Image"
CLEAN = {
    key: value
    for key, value in os.environ.items()
    if key not in ("PYTHONPATH", "LD_LIBRARY_PATH", "VIRTUAL_ENV", "PYTHONHOME")
}
# What is installed is run twice and thrown away: nothing is compiled that is never imported.
CLEAN["PIP_COMPILE"] = "0"
FROM_INDEX = "TALAIA_PROOF_TABLE" in os.environ


def run(*words: str | Path) -> str:
    done = subprocess.run(
        [str(each) for each in words], env=CLEAN, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{words}:\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    return done.stdout


def steps(recipe: str) -> list[list[str]]:
    """Give the steps that are written as lists of words, as Docker runs them: without a shell."""
    return [json.loads(found) for found in re.findall(r"^RUN (\[.*\])$", recipe, re.MULTILINE)]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Talaia's own wheel, built from this tree."""
    folder = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT)
    (made,) = folder.glob("*.whl")
    return made


def test_the_wheel_carries_what_is_made_and_whose_work_it_is(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as packed:
        names = packed.namelist()
        (notice,) = (
            packed.read(each).decode()
            for each in names
            if each.endswith(".dist-info/licenses/src/talaia/objects/CREDITS.md")
        )
        carried = hashlib.sha256(packed.read("talaia/objects/models/nanodet.onnx")).hexdigest()
    assert f'SHA256 = "{carried}"' in (ROOT / "tools/make_detector.py").read_text()
    assert "talaia/web/static/index.html" in names
    for each in ("Copyright 2020-2021 RangiLyu", "Apache License", "(c) 2021 Vladimir Mandic"):
        assert each in notice
    assert [each for each in names if "/node_modules/" in each or each.endswith(".new")] == []


# Beside other work an installation takes minutes; a limit is for one that never ends.
@pytest.mark.timeout(1800)
@pytest.mark.parametrize(
    ("image", "words"), [("hub", ("hub", "--help")), ("gateway", ("gateway", "--help"))]
)
def test_the_install_steps_of_an_image_work_in_a_clean_environment(
    image: str, words: tuple[str, ...], wheel: Path, tmp_path: Path
) -> None:
    folder, place = tmp_path / "deployment", tmp_path / "environment"
    assert main(["generate", str(EXAMPLE), "--to", str(folder), "--wheel", str(wheel)]) == 0
    recipe = (folder / f"{image}.Dockerfile").read_text()
    assert "COPY wheels/ /wheels/" in recipe
    (install,) = steps(recipe)
    assert install[:2] == ["pip", "install"]
    if FROM_INDEX:
        run(sys.executable, "-m", "venv", "--without-pip", place)
    else:
        make_linked_environment(place, wheel, install[-1])
    pip = (sys.executable, "-m", "pip", "--python", place / "bin/python")
    run(
        *pip,
        *(str(folder / "wheels") if each == "/wheels" else each for each in install[1:]),
        *([] if FROM_INDEX else ["--no-index"]),
    )
    (entry,) = re.findall(r"^ENTRYPOINT (\[.*\])$", recipe, re.MULTILINE)
    program = place / "bin" / json.loads(entry)[0]
    assert run(program, "--version").strip() == f"talaia {__version__}"
    assert "usage: talaia" in run(program, *words)
    assert run(*pip, "check").startswith("No broken requirements")
    if table := os.environ.get("TALAIA_PROOF_TABLE"):
        came = run(*pip, "list", "--format", "freeze").replace("\n", "\n- ").rstrip("- \n")
        with Path(table).open("w" if image == "hub" else "a") as file:
            file.write(f"## What came for `{install[-1]}`\n\n- {came}\n\n")


def test_a_gateways_image_has_what_its_connections_need(tmp_path: Path) -> None:
    site = tmp_path / "site.yaml"
    site.write_text(OLD)
    assert main(["generate", str(site), "--to", str(tmp_path / "old")]) == 0
    recipe = (tmp_path / "old/gateway.Dockerfile").read_text()
    assert steps(recipe)[0][-1] == f"talaia[gateway,recording]=={__version__}"
    assert "python3-rospy" in recipe
    assert main(["generate", str(EXAMPLE), "--to", str(tmp_path / "new")]) == 0
    recipe = (tmp_path / "new/gateway.Dockerfile").read_text()
    # It has a camera, and whether objects are seen on its pictures may be chosen later.
    assert steps(recipe)[0][-1] == f"talaia[gateway,ros2,objects]=={__version__}"
    assert "apt-get" not in recipe


@pytest.mark.parametrize(("at", "extras"), [("hub", "hub,objects"), ("gateway", "hub")])
def test_a_hubs_image_sees_objects_where_a_camera_wants_it_to(
    at: str, extras: str, tmp_path: Path
) -> None:
    site = tmp_path / "site.yaml"
    stream = (
        f"{{front: {{name: Front, source: {{topic: /i, type: {IMAGE}}}, detect: {{at: {at}}}}}}}"
    )
    site.write_text(OLD.replace("{name: A}", f"{{name: A, streams: {stream}}}"))
    words = ["generate", str(site), "--to", str(tmp_path / "to"), "--database", "sqlite"]
    assert main(words) == 0
    recipe = (tmp_path / "to/hub.Dockerfile").read_text()
    assert steps(recipe)[0][-1] == f"talaia[{extras}]=={__version__}"
