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
import platform
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from deploy.linked_environment import make_linked_environment

from talaia import __version__
from talaia.cli.main import main
from talaia.sim.ros_domain import reserve_domain

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
# What images build a package with that has no wheel.
BUILDERS = ("setuptools",)
TABLE_HEAD = """# What the images' recipes install

Made by `make proofs ONLY=images`: the steps of the recipes, run from the index into clean \
environments, and what came.

"""
# The Python of a distribution's own ROS 2, and that of the gateway in its image.
DISTROS = {"humble": "3.10"}
GATEWAYS_PYTHON = "3.12"
# Wheels that stand for what the image of `ros:<distro>` and its recipe bring from Debian packages.
ROS_WHEELS = (
    "ros-rclpy[fastrtps]", "ros-std-msgs", "ros-std-srvs", "ros-geometry-msgs", "ros-sensor-msgs",
    "ros-nav-msgs",
)  # fmt: skip
TALKER = ROOT / "tests/gateway/taps/topics_peer.py"


def run(*words: str | Path, **more: str) -> str:
    done = subprocess.run(
        [str(each) for each in words],
        env={**CLEAN, **more},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{words}:\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    return done.stdout


def steps(recipe: str) -> list[list[str]]:
    """Give the steps that are written as lists of words, as Docker runs them: without a shell."""
    return [json.loads(found) for found in re.findall(r"^RUN (\[.*\])$", recipe, re.MULTILINE)]


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Talaia's own wheels, built from this tree, by the name of their package."""
    folder = tmp_path_factory.mktemp("wheels")
    for part in (".", "packages/models", "packages/simulators"):
        run(
            sys.executable,
            "-m",
            "build",
            "--wheel",
            "--no-isolation",
            "--outdir",
            folder,
            ROOT / part,
        )
    made = {each.name.split("-")[0]: each for each in folder.glob("*.whl")}
    assert set(made) == {"talaia", "talaia_models", "talaia_simulators"}
    return made


@pytest.fixture(scope="module")
def wheel(wheels: dict[str, Path]) -> Path:
    """Talaia itself."""
    return wheels["talaia"]


def test_the_wheels_carry_what_is_made_and_whose_work_it_is(wheels: dict[str, Path]) -> None:
    with zipfile.ZipFile(wheels["talaia_models"]) as packed:
        notice = packed.read("talaia/objects/models/CREDITS.md").decode()
        carried = {
            script: hashlib.sha256(packed.read(f"talaia/objects/models/{name}.onnx")).hexdigest()
            for name, script in (
                ("nanodet", "make_detector.py"),
                ("centerface", "make_face_detector.py"),
            )
        }
    for script, found in carried.items():
        assert f'SHA256 = "{found}"' in (ROOT / "tools" / script).read_text()
    for each in (
        "Copyright 2020-2021 RangiLyu",
        "Apache License",
        "(c) 2021 Vladimir Mandic",
        "Star-Clouds",
    ):
        assert each in notice
    names = zipfile.ZipFile(wheels["talaia"]).namelist()
    assert "talaia/web/static/index.html" in names
    assert [each for each in names if "/node_modules/" in each or each.endswith(".new")] == []


def test_no_robot_carries_simulators_and_none_without_cameras_their_detectors(
    wheels: dict[str, Path],
) -> None:
    inside = {name: set(zipfile.ZipFile(made).namelist()) for name, made in wheels.items()}
    assert not [each for each in inside["talaia"] if each.startswith("talaia/sim/")]
    assert not [each for each in inside["talaia"] if each.endswith(".onnx")]
    assert "talaia/sim/vehicle/vehicle.py" in inside["talaia_simulators"]
    # They lie in one folder when they are installed, and none overwrites another's file.
    for one, other in (
        ("talaia", "talaia_models"),
        ("talaia", "talaia_simulators"),
        ("talaia_models", "talaia_simulators"),
    ):
        assert inside[one] & inside[other] == set()
    # All of the tree is in one of them.
    sources = {str(path.relative_to(ROOT / "src")) for path in (ROOT / "src/talaia").rglob("*.py")}
    assert sources <= set().union(*inside.values())


def test_what_is_built_says_the_version_of_the_checkout(wheels: dict[str, Path]) -> None:
    assert wheels["talaia"].name == f"talaia-{__version__}-py3-none-any.whl"
    assert wheels["talaia_simulators"].name.split("-")[1] == __version__
    with zipfile.ZipFile(wheels["talaia"]) as packed:
        assert packed.read("talaia/version.txt").decode() == f"{__version__}\n"
    with zipfile.ZipFile(wheels["talaia_simulators"]) as packed:
        (name,) = (each for each in packed.namelist() if each.endswith("/METADATA"))
        assert f"Requires-Dist: talaia=={__version__}\n" in packed.read(name).decode()


# Beside other work an installation takes minutes; a limit is for one that never ends.
@pytest.mark.timeout(1800)
@pytest.mark.parametrize(
    ("image", "words"), [("hub", ("hub", "--help")), ("gateway", ("gateway", "--help"))]
)
def test_the_install_steps_of_an_image_work_in_a_clean_environment(
    image: str, words: tuple[str, ...], wheels: dict[str, Path], tmp_path: Path
) -> None:
    folder, place = tmp_path / "deployment", tmp_path / "environment"
    wheel = wheels["talaia"]
    given = [str(wheels[name]) for name in ("talaia", "talaia_models")]
    assert main(["generate", str(EXAMPLE), "--to", str(folder), "--wheel", *given]) == 0
    recipe = (folder / f"{image}.Dockerfile").read_text()
    assert {"COPY wheels/ /wheels/", "COPY locks/ /locks/"} <= set(recipe.splitlines())
    *locked, own = steps(recipe)
    assert own[:2] == ["pip", "install"]
    # What is of others comes by its hash, and Talaia from its folder alone.
    assert all({"--require-hashes", "-r"} <= set(each) for each in locked)
    assert "--no-index" in own
    if FROM_INDEX:
        run(sys.executable, "-m", "venv", "--without-pip", place)
    else:
        make_linked_environment(place, wheel, own[-1], *BUILDERS)
    pip = (sys.executable, "-m", "pip", "--python", place / "bin/python")
    for step in (*locked, own):
        words_here = (re.sub("^/(?=wheels|locks)", f"{folder}/", each) for each in step[1:])
        run(*pip, *words_here, *([] if FROM_INDEX else ["--no-index"]))
    (entry,) = re.findall(r"^ENTRYPOINT (\[.*\])$", recipe, re.MULTILINE)
    program = place / "bin" / json.loads(entry)[0]
    assert run(program, "--version").strip() == f"talaia {__version__}"
    assert "usage: talaia" in run(program, *words)
    assert run(*pip, "check").startswith("No broken requirements")
    if image == "hub":
        # From here it packs itself, and what it writes is the wheel that it came from.
        run(program, "generate", EXAMPLE, "--to", tmp_path / "again")
        (packed,) = (tmp_path / "again/wheels").glob("talaia-*.whl")
        assert content_of(packed) == content_of(wheel)
        assert packed.name == wheel.name
    if table := os.environ.get("TALAIA_PROOF_TABLE"):
        came = run(*pip, "list", "--format", "freeze").replace("\n", "\n- ").rstrip("- \n")
        # The first of them.
        begins = image == "hub"
        with Path(table).open("w" if begins else "a") as file:
            file.write(TABLE_HEAD if begins else "")
            file.write(f"## What came for `{own[-1]}`\n\n- {came}\n\n")


def content_of(wheel: Path) -> dict[str, str]:
    """Give what a wheel holds, by name; its list of files stands in another order."""
    with zipfile.ZipFile(wheel) as packed:
        content = {
            each: hashlib.sha256(packed.read(each)).hexdigest()
            for each in packed.namelist()
            if not each.endswith("/RECORD")
        }
        (record,) = (each for each in packed.namelist() if each.endswith("/RECORD"))
        rows = "\n".join(sorted(packed.read(record).decode().splitlines()))
    return {**content, "RECORD": rows}


def python_of(version: str) -> str:
    """Give a Python of this machine; one that is found by name may be pyenv's, and not there."""
    named = shutil.which(f"python{version}")
    kept = Path.home().glob(f".pyenv/versions/{version}.*/bin/python")
    for found in (*([named] if named else []), *map(str, kept)):
        if subprocess.run([found, "--version"], capture_output=True, check=False).returncode == 0:
            return found
    raise AssertionError(f"there is no python{version} here")


def lay_managed_python(folder: Path) -> None:
    """Put this machine's Python where uv has the one that it downloads: it is of no index."""
    which = "import sys, platform; print(sys.base_prefix, platform.python_version())"
    prefix, version = run(python_of(GATEWAYS_PYTHON), "-c", which).split()
    place = folder / f"cpython-{version}-linux-{platform.machine()}-gnu"
    place.mkdir(parents=True)
    for part in Path(prefix).iterdir():
        (place / part.name).symlink_to(part)


def seen_by_a_probe(program: Path, ros_python: Path) -> list[str]:
    """Give the topics that an image's gateway sees by the ROS 2 of another Python."""
    with reserve_domain() as reservation:
        ros = {
            "ROS_DOMAIN_ID": str(reservation.domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        }
        talker = subprocess.Popen(
            [sys.executable, str(TALKER)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
            env={**os.environ, **ros},
        )
        assert talker.stdin is not None
        try:
            talker.stdin.write('{"do": "open", "topic": "/words"}\n')
            talker.stdin.flush()
            words = ("probe", "--ros2", "--seconds", "10", "--json")
            said = run(program, *words, TALAIA_ROS_PYTHON=str(ros_python), **ros)
        finally:
            talker.stdin.close()
            talker.wait(30)
    return [topic["topic"] for topic in json.loads(said)["topics"]]


@pytest.mark.skipif(
    not FROM_INDEX, reason="uv and ROS come from the index: make proofs ONLY=images"
)
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("distro", DISTROS)
def test_the_install_steps_of_an_image_on_ros_work_and_its_gateway_sees_a_robot(
    distro: str, wheels: dict[str, Path], tmp_path: Path
) -> None:
    folder, root = tmp_path / "deployment", tmp_path / "root"
    given = [str(wheels[name]) for name in ("talaia", "talaia_models")]
    words = ["generate", str(EXAMPLE), "--to", str(folder), "--wheel", *given]
    assert main([*words, "--ros-distro", distro, "--arch", "arm64"]) == 0
    recipe = (folder / "gateway.Dockerfile").read_text()
    places = dict(re.findall(r"(UV_PYTHON_INSTALL_DIR)=(\S+)", recipe))
    places = {key: f"{root}{place}" for key, place in places.items()}
    lay_managed_python(Path(places["UV_PYTHON_INSTALL_DIR"]))
    ros_own = python_of(DISTROS[distro])
    # uv does not read pip's settings.
    settings = run(sys.executable, "-m", "pip", "config", "list")
    if found := re.search(r"^global\.index-url='(.+)'", settings, re.MULTILINE):
        places["UV_DEFAULT_INDEX"] = found[1]
    stand_ins = {"python3": ros_own, "/wheels": str(folder / "wheels")}
    for step in steps(recipe):
        here = [f"{root}{word}" if word.startswith("/opt/") else word for word in step]
        here = [re.sub("^/(?=locks/)", f"{folder}/", word) for word in here]
        run(*(stand_ins.get(word, word) for word in here), **places)
    (entry,) = re.findall(r"^ENTRYPOINT (\[.*\])$", recipe, re.MULTILINE)
    program = Path(f"{root}{json.loads(entry)[0]}")
    assert run(program, "--version").strip() == f"talaia {__version__}"
    assert "usage: talaia" in run(program, "gateway", "--help")
    own = program.parent / "python"
    version = run(own, "-c", "import platform; print(platform.python_version())").strip()
    assert version.startswith(GATEWAYS_PYTHON)
    came = run(root / "opt/uv/bin/uv", "pip", "freeze", "--python", own)
    # The image's ROS 2 is used, and its wheels are not there.
    assert not re.search("^ros-", came, re.MULTILINE)
    run(ros_own, "-m", "venv", root / "ros")
    run(root / "ros/bin/python", "-m", "pip", "install", "--quiet", *ROS_WHEELS)
    assert "/words" in seen_by_a_probe(program, root / "ros/bin/python")
    if table := os.environ.get("TALAIA_PROOF_TABLE"):
        with Path(table).open("a") as file:
            wanted = steps(recipe)[-1][-1]
            file.write(
                f"## What came for `{wanted}` on `ros:{distro}-ros-base`\n\n"
                f"The steps of the recipe for arm64, run on {platform.machine()}: Python "
                f"{version} of this machine stood for the one that uv downloads, and ROS 2's "
                f"wheels of Python {DISTROS[distro]} for the image's. The gateway's probe saw a "
                "topic through them.\n\n- " + came.strip().replace("\n", "\n- ") + "\n\n"
            )


def test_a_gateways_image_has_what_its_connections_need(tmp_path: Path) -> None:
    site = tmp_path / "site.yaml"
    site.write_text(OLD)
    assert main(["generate", str(site), "--to", str(tmp_path / "old")]) == 0
    recipe = (tmp_path / "old/gateway.Dockerfile").read_text()
    assert steps(recipe)[-1][-1] == f"talaia[gateway,fast,recording]=={__version__}"
    assert "python3-rospy" in recipe
    assert main(["generate", str(EXAMPLE), "--to", str(tmp_path / "new")]) == 0
    recipe = (tmp_path / "new/gateway.Dockerfile").read_text()
    # It has a camera, and whether objects are seen on its pictures may be chosen later.
    assert steps(recipe)[-1][-1] == f"talaia[gateway,fast,ros2,objects]=={__version__}"
    assert "apt-get" not in recipe


@pytest.mark.parametrize(
    ("at", "extras"), [("hub", "hub,arrow,chats,fast,objects"), ("gateway", "hub,arrow,chats,fast")]
)
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
    assert steps(recipe)[-1][-1] == f"talaia[{extras}]=={__version__}"
