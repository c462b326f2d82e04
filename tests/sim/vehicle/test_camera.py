"""What the vehicle's camera draws."""

from __future__ import annotations

import os
import subprocess
import sys
from ctypes.util import find_library
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from patience import PATIENCE_S
from tests.sim.conftest import missing

import talaia
from talaia.sim.errors import NoRenderer
from talaia.sim.vehicle.camera import Camera
from talaia.sim.vehicle.world import World

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(scope="module")
def world() -> World:
    return World(0, looks=True)


@pytest.fixture
def camera(world: World) -> Iterator[Camera]:
    try:
        camera = Camera(world)
    except NoRenderer as error:
        missing(str(error))
        raise
    yield camera
    camera.close()


def test_it_draws_a_furnished_house(camera: Camera) -> None:
    picture = camera.render_view(0.0, 0.0, 0.0)
    assert picture.shape == (480, 640, 3)
    assert picture.std() > 30
    colours = np.unique(picture.reshape(-1, 3) // 16, axis=0)
    assert len(colours) > 100


def test_another_heading_gives_another_picture_and_the_same_one_the_same(camera: Camera) -> None:
    ahead = camera.render_view(0.0, 0.0, 0.0)
    aside = camera.render_view(0.0, 0.0, 1.0)
    again = camera.render_view(0.0, 0.0, 0.0)
    assert np.array_equal(ahead, again)
    assert np.abs(ahead.astype(int) - aside).mean() > 10


def test_up_is_up(camera: Camera) -> None:
    # From the hall's middle: wooden floor below (red over blue), pale ceiling above.
    picture = camera.render_view(5.0, 0.25, 0.0).astype(int)
    floor, ceiling = picture[-20:, 300:340].mean((0, 1)), picture[:20, 300:340].mean((0, 1))
    assert floor[0] - floor[2] > 30
    assert abs(ceiling[0] - ceiling[2]) < 25


def test_what_is_left_out_behind_the_camera_is_there_when_it_turns(camera: Camera) -> None:
    whole = camera.render_view(0.0, -1.0, -1.2)
    camera.render_view(0.0, -1.0, 2.0)
    assert np.array_equal(camera.render_view(0.0, -1.0, -1.2), whole)


@pytest.mark.parametrize(
    ("broken", "taken"),
    [({"__EGL_VENDOR_LIBRARY_DIRS": "/nonexistent"}, "osmesa"), ({}, "egl")],
)
def test_osmesa_draws_where_egl_cannot(broken: dict[str, str], taken: str) -> None:
    # OpenGL is bound once for a process, so each way is tried in one of its own.
    code = (
        "from talaia.sim.vehicle.world import World; from talaia.sim.vehicle.camera import Camera\n"
        "camera = Camera(World(0, looks=True)); picture = camera.render_view(0.0, 0.0, 0.0)\n"
        "print(camera.way, picture.std() > 30); camera.close()"
    )
    environment = {
        k: v for k, v in os.environ.items() if k not in ("MUJOCO_GL", "PYOPENGL_PLATFORM")
    }
    source = str(Path(talaia.__file__).parents[1])
    run = subprocess.run(
        [sys.executable, "-c", code],
        env=environment | broken | {"PYTHONPATH": source},
        capture_output=True,
        text=True,
        check=False,
    )
    # Where the library is there, not to be able to use it is a fault of ours.
    if "NoRenderer" in run.stderr and not (taken == "osmesa" and find_library("OSMesa")):
        missing(run.stderr.splitlines()[-1])
    assert run.stdout.split() == [taken, "True"], run.stderr


def test_without_any_renderer_the_error_names_the_package(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)

    def none(way: str) -> Any:
        raise ImportError(f"no {way} here")

    with pytest.raises(NoRenderer, match=r"no egl here.*no osmesa here.*apt install libosmesa6"):
        Camera(world, open_way=none)


def test_its_process_ends_with_its_input_even_where_drawing_gets_no_time() -> None:
    pytest.importorskip("rclpy")
    code = (
        "import sys, threading; from talaia.sim.vehicle import images\n"
        "images._ENDS_WITHIN_S = 0.1; poses = images._Poses(sys.stdin.buffer)\n"
        # As one that never gets so far as to end.
        "print('ready', flush=True); threading.Event().wait()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(Path(talaia.__file__).parents[1])},
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as process:  # fmt: skip
        assert process.stdout
        assert process.stdin
        assert process.stdout.readline() == b"ready\n"
        process.stdin.close()
        assert process.wait(PATIENCE_S) == 0
