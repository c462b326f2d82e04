"""Draws what the vehicle's camera sees, in software where there is no graphics card.

EGL is tried first (it uses a graphics card where there is one), then OSMesa. Both draw into
memory, so no screen is needed. A renderer belongs to the thread that made it.
"""

from __future__ import annotations

import importlib
import math
import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
import numpy.typing as npt

from talaia.sim.errors import NoRenderer
from talaia.sim.vehicle.scene import LOOK_GROUP
from talaia.sim.vehicle.vehicle import CAMERA, CAMERA_FIELD

if TYPE_CHECKING:
    from talaia.sim.vehicle.world import World

__all__ = ["HEIGHT", "WAYS", "WIDTH", "Camera", "open_context"]

WIDTH = 640
HEIGHT = 480
WAYS = ("egl", "osmesa")
# What is out of sight is moved here: nobody draws this group.
UNSEEN_GROUP = 5

Context = Any
"""MuJoCo ships no types."""
Open = Callable[[str], Context]


def open_context(way: str) -> Context:
    """Open an OpenGL context that draws into memory.

    Raises:
        Exception: whatever the graphics libraries answer when they cannot.

    """
    # PyOpenGL binds to one platform at import. After a failed try it must be read in again.
    for name in [n for n in sys.modules if n.split(".")[0] == "OpenGL"]:
        del sys.modules[name]
    for name in [n for n in sys.modules if n.startswith(("mujoco.egl", "mujoco.osmesa"))]:
        del sys.modules[name]
    os.environ["PYOPENGL_PLATFORM"] = way
    # MuJoCo's own library looks there to know where to find OpenGL's functions.
    os.environ["MUJOCO_GL"] = way
    context = importlib.import_module(f"mujoco.{way}").GLContext(WIDTH, HEIGHT)
    context.make_current()
    return context


def _first_that_works(open_way: Open, model: Context) -> tuple[str, Context, Context]:
    """Give the way, its OpenGL context, and MuJoCo's own with textures and shapes loaded."""
    asked = os.environ.get("MUJOCO_GL", "").strip().lower()
    reasons: dict[str, str] = {}
    # If the environment names a way, only that is tried.
    for way in (asked,) if asked in WAYS else WAYS:
        try:
            context = open_way(way)
            return way, context, mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        except Exception as error:  # noqa: BLE001 - graphics libraries raise anything at all
            # The try that failed has set it.
            os.environ["MUJOCO_GL"] = asked
            reasons[way] = (str(error).strip() or type(error).__name__).splitlines()[0]
    raise NoRenderer(reasons)


class Camera:
    """A picture of the world from the vehicle, whenever asked.

    Holds a copy of the world's state, so that drawing never waits for physics or the other way
    round. To be made, used and closed in one thread.

    Args:
        world: a world built with ``looks=True``.
        open_way: opens an OpenGL context by name.

    Raises:
        NoRenderer: neither EGL nor OSMesa works here.

    """

    def __init__(self, world: World, *, open_way: Open = open_context) -> None:
        """Open the renderer and load textures and shapes into it."""
        # One drawing thread costs least in all; the picture takes a little longer.
        os.environ.setdefault("LP_NUM_THREADS", "1")
        self._model = world.model
        self.way, self._context, self._drawing = _first_that_works(open_way, self._model)
        self._data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, self._data)
        # What is more than that would not be drawn.
        self._scene = mujoco.MjvScene(model=self._model, maxgeom=2000)
        # Dear to draw in software, and little is lost indoors.
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = False
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = False
        self._option = mujoco.MjvOption()
        # Hulls are for collisions and rays; only looks are drawn.
        self._option.geomgroup[:] = 0
        self._option.geomgroup[LOOK_GROUP] = 1
        # The library asks for one; nothing is ever pushed here.
        self._perturb = mujoco.MjvPerturb()
        self._view = mujoco.MjvCamera()
        self._view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._view.fixedcamid = self._model.camera(CAMERA).id
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._drawing)
        self._rect = mujoco.MjrRect(0, 0, WIDTH, HEIGHT)
        # Written anew for each picture; `render_view` hands out a copy.
        self._pixels = np.zeros((HEIGHT, WIDTH, 3), dtype=np.uint8)
        # All that can be seen, where and how large. The house never moves: worked out once.
        self._looks = np.flatnonzero(self._model.geom_group == LOOK_GROUP)
        self._places = self._data.geom_xpos[self._looks].copy()
        self._sizes = self._model.geom_rbound[self._looks].copy()

    def render_view(self, x: float, y: float, yaw: float) -> npt.NDArray[np.uint8]:
        """Draw what is seen from a pose: RGB of shape (480, 640, 3), the caller's own."""
        self._data.qpos[:3] = (x, y, yaw)
        # Only where things stand: no physics.
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
        self._show_what_is_ahead(yaw)
        mujoco.mjv_updateScene(
            self._model,
            self._data,
            self._option,
            self._perturb,
            self._view,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._scene,
        )
        mujoco.mjr_render(self._rect, self._scene, self._drawing)
        mujoco.mjr_readPixels(self._pixels, None, self._rect, self._drawing)
        # OpenGL's rows run upwards.
        return self._pixels[::-1].copy()

    def _show_what_is_ahead(self, yaw: float) -> None:
        """Leave out what is beside, behind, or smaller than a pixel: two thirds of the house."""
        offset = self._places - self._data.cam_xpos[self._view.fixedcamid]
        depth = math.cos(yaw) * offset[:, 0] + math.sin(yaw) * offset[:, 1]
        aside = math.cos(yaw) * offset[:, 1] - math.sin(yaw) * offset[:, 0]
        half = math.tan(math.radians(CAMERA_FIELD / 2)) * WIDTH / HEIGHT
        reach = self._sizes * math.hypot(1.0, half)
        seen = (depth > -self._sizes) & (np.abs(aside) <= np.maximum(depth, 0.0) * half + reach)
        seen &= self._sizes * HEIGHT > depth
        # Only the camera reads these groups: lidar and contacts know hulls alone.
        self._model.geom_group[self._looks] = np.where(seen, LOOK_GROUP, UNSEEN_GROUP)

    def close(self) -> None:
        """Give the renderer's memory back."""
        self._drawing.free()
        self._context.free()
