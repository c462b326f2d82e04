"""The simulated world: the vehicle's physics and what its sensors measure.

No ROS, no rendering and no clock: time passes by `World.step`. The same seed and the same steps
give the same world, faster than real time.

The base moves on a plane, driven by bounded forces towards the wanted velocities, as wheels with
grip do; wheel contacts of a rigid-body engine slip by tens of per cent, which no odometry would
explain. Walls and furniture stop it: what it meets is stronger than its motors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from talaia.sim.vehicle import furniture, house, occupants
from talaia.sim.vehicle.description.floor_map import draw_map
from talaia.sim.vehicle.drives.kinematics import TRACK, WHEEL_RADIUS
from talaia.sim.vehicle.scene import HULL_GROUP, SceneBuilder
from talaia.sim.vehicle.vehicle import (
    BODY,
    CAMERA_FIELD,
    LIDAR_HEIGHT,
    RADIUS,
    add_vehicle,
    set_friction,
)

__all__ = ["STEP_S", "Motion", "World"]

STEP_S = 0.005
"""Time step of the physics (s)."""

LIDAR_RANGE = (0.12, 8.0)
SONAR_RANGE = (0.02, 4.0)
SONAR_BEARINGS = (math.pi / 4, 0.0, -math.pi / 4)
SONAR_FIELD = 0.26
"""Opening of an ultrasonic cone (rad)."""

Array = npt.NDArray[np.float64]
Model = Any
"""MuJoCo ships no types."""


@dataclass(frozen=True)
class Motion:
    """Where the vehicle is and how it moves.

    Attributes:
        x: metres from where it started, along its first heading.
        y: metres, to the left of that.
        yaw: heading (rad, -pi..pi).
        speed: forward (m/s).
        slip: to its left (m/s); without wheels that move it sideways only a collision does that.
        turn: counter-clockwise (rad/s).
        acceleration: forward (m/s²).
        left: angle the left wheel has turned (rad).
        right: angle the right wheel has turned (rad).

    """

    x: float
    y: float
    yaw: float
    speed: float
    slip: float
    turn: float
    acceleration: float
    left: float
    right: float


class World:
    """The house with the vehicle in it.

    Args:
        seed: decides how light furniture stands, textures and sensor noise.
        looks: whether to build what a camera sees; collisions are the same either way.
        friction: rolling friction of the wheels (N per m/s).
        track_width: distance between the wheels (m).
        furnished: whether it is the house; an open floor has nothing on it.

    Attributes:
        floor_map: of the house, as it stands at the start.

    """

    WHEEL_RADIUS = WHEEL_RADIUS
    WHEEL_BASE = TRACK

    def __init__(
        self,
        seed: int = 0,
        *,
        looks: bool = False,
        friction: float = 0.0,
        track_width: float = WHEEL_BASE,
        furnished: bool = True,
    ) -> None:
        """Build the model and put the vehicle at its start."""
        self._track_width = track_width
        # One for each use, so that textures do not change where furniture stands.
        layout, paint, noise = (np.random.default_rng([seed, part]) for part in range(3))
        spec = _empty_model()
        stage = SceneBuilder(spec, paint, furniture.FINISHES | occupants.FINISHES, looks=looks)
        if furnished:
            house.build_house(stage, layout)
        add_vehicle(stage)
        self.floor_map = draw_map(stage.hulls, LIDAR_HEIGHT)
        self.model: Any = spec.compile()
        set_friction(self.model, friction, track_width)
        self._data: Any = mujoco.MjData(self.model)
        self._noise = noise
        # Rays leave its own shapes out.
        self._body: int = self.model.body(BODY).id
        # Time that is not simulated yet because it is less than a physics step (s).
        self._pending = 0.0
        # Angles that the left and the right wheel have turned (rad).
        self._wheels = [0.0, 0.0]
        # Mean forward acceleration of the last step (m/s²), for the inertial sensor.
        self._acceleration = 0.0
        # Something was touched during the last step.
        self._touching = False
        self._lidar_angles: Array = np.radians(np.arange(360.0))
        # Rays meet hulls only, as collisions do: what only a camera sees does not stop a lidar.
        self._groups = np.zeros(6, dtype=np.uint8)
        self._groups[HULL_GROUP] = 1
        mujoco.mj_forward(self.model, self._data)

    def step(self, seconds: float, speed: float, turn: float, *, lateral: float = 0.0) -> Motion:
        """Let time pass while the motors pull towards the wanted velocities.

        Args:
            seconds: how long; fractions of a physics step are carried over to the next call.
            speed: wanted, forward (m/s).
            turn: wanted, counter-clockwise (rad/s).
            lateral: wanted, to the left (m/s); with none the wheels' grip holds it.

        """
        data = self._data
        data.ctrl[:] = (speed, lateral, turn)
        self._pending += seconds
        # The small term keeps a sum of rounded fractions from losing a step.
        steps = int(self._pending / STEP_S + 1e-6)
        self._pending -= steps * STEP_S
        before = self._forward_speed()
        self._touching = False
        for _ in range(steps):
            mujoco.mj_step(self.model, data)
            self._touching = self._touching or data.ncon > 0
            forward, spin = self._forward_speed(), float(data.qvel[2])
            for wheel, side in enumerate((-1, 1)):
                # Kinematics of a differential drive: each wheel rolls on a circle about the
                # point the vehicle turns on; it never slips lengthwise.
                rolled = forward + side * spin * self._track_width / 2
                self._wheels[wheel] += rolled * STEP_S / self.WHEEL_RADIUS
        if steps:
            self._acceleration = (self._forward_speed() - before) / (steps * STEP_S)
        return self.current_motion()

    def current_motion(self) -> Motion:
        """Tell where the vehicle is and how it moves."""
        x, y, yaw = (float(value) for value in self._data.qpos[:3])
        vx, vy, spin = (float(value) for value in self._data.qvel[:3])
        # MuJoCo gives the velocity in the world's axes; odometry has it in the vehicle's.
        c, s = math.cos(yaw), math.sin(yaw)
        return Motion(
            x=x,
            y=y,
            yaw=math.remainder(yaw, 2 * math.pi),
            speed=c * vx + s * vy,
            slip=c * vy - s * vx,
            turn=spin,
            acceleration=self._acceleration,
            left=self._wheels[0],
            right=self._wheels[1],
        )

    @property
    def touching(self) -> bool:
        """Whether the vehicle touched anything during the last step."""
        return self._touching

    def place_vehicle(self, x: float, y: float, yaw: float) -> None:
        """Put the vehicle somewhere, standing still."""
        self._data.qpos[:3] = (x, y, yaw)
        self._data.qvel[:3] = 0.0
        mujoco.mj_forward(self.model, self._data)

    def move_vehicle(self, x: float, y: float, yaw: float) -> None:
        """Move the vehicle by so much (m, rad, in the world's axes); it goes on as fast as it was.

        Its velocity turns with it: it belongs to the wheels, not to the floor.
        """
        vx, vy = (float(value) for value in self._data.qvel[:2])
        c, s = math.cos(yaw), math.sin(yaw)
        self._data.qvel[:2] = (c * vx - s * vy, s * vx + c * vy)
        self._data.qpos[:3] += (x, y, yaw)
        mujoco.mj_forward(self.model, self._data)

    def scan_lidar(self) -> npt.NDArray[np.float32]:
        """Measure all around: 360 distances (m) from straight ahead, counter-clockwise.

        What is too near or too far is infinite, as a lidar driver reports it.
        """
        distances = self._cast_rays(self._lidar_angles, LIDAR_RANGE[1])
        # The ranging error: a standard deviation of 4 mm.
        distances += self._noise.normal(0.0, 0.004, distances.shape)
        bad = (distances < LIDAR_RANGE[0]) | (distances > LIDAR_RANGE[1])
        distances[bad] = math.inf
        return distances.astype(np.float32)

    def measure_sonars(self) -> tuple[float, float, float]:
        """Measure left, front and right: the nearest thing in each cone (m), 4.0 for nothing."""
        # Five rays stand for the cone: the nearest echo is what an ultrasonic sensor reports.
        spread: Array = np.linspace(-SONAR_FIELD / 2, SONAR_FIELD / 2, 5)
        angles: Array = np.concatenate([spread + bearing for bearing in SONAR_BEARINGS]).astype(
            np.float64
        )
        # Rays begin in the vehicle's middle, the sensors sit on its rim.
        distances = self._cast_rays(angles, SONAR_RANGE[1]).reshape(3, 5).min(axis=1) - RADIUS
        distances += self._noise.normal(0.0, 0.005, 3)
        left, front, right = np.clip(distances, *SONAR_RANGE)
        return float(left), float(front), float(right)

    def measuring_noise(self, deviation: float) -> float:
        """Give a measuring error, from the world's own seed."""
        return float(self._noise.normal(0.0, deviation))

    def _cast_rays(self, angles: Array, cutoff: float) -> Array:
        count = len(angles)
        headings = angles + float(self._data.qpos[2])
        vectors = np.zeros((count, 3))
        vectors[:, 0] = np.cos(headings)
        vectors[:, 1] = np.sin(headings)
        origin = np.array([self._data.qpos[0], self._data.qpos[1], LIDAR_HEIGHT])
        found = np.zeros(count, dtype=np.int32)
        distances = np.zeros(count)
        mujoco.mj_multiRay(
            self.model,
            self._data,
            origin,
            vectors.ravel(),
            self._groups,
            1,
            self._body,
            found,
            distances,
            None,
            count,
            cutoff,
        )
        distances[found < 0] = math.inf
        return distances

    def _forward_speed(self) -> float:
        yaw = float(self._data.qpos[2])
        vx, vy = float(self._data.qvel[0]), float(self._data.qvel[1])
        return math.cos(yaw) * vx + math.sin(yaw) * vy


def _empty_model() -> Model:
    """Give a model with light and nothing else."""
    spec = mujoco.MjSpec()
    spec.option.timestep = STEP_S
    # Implicit: stays stable at this step although the motors' velocity control is stiff.
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # The vehicle slides on two axes and a hinge, so that weight would only cost contacts.
    spec.option.gravity = (0.0, 0.0, 0.0)
    spec.visual.global_.offwidth = 640
    spec.visual.global_.offheight = 480
    spec.visual.global_.fovy = CAMERA_FIELD
    spec.visual.quality.offsamples = 0
    spec.visual.quality.numslices = 10
    spec.visual.quality.numstacks = 6
    spec.visual.map.znear = 0.005
    spec.visual.headlight.ambient = (0.48, 0.47, 0.46)
    spec.visual.headlight.diffuse = (0.10, 0.10, 0.10)
    spec.visual.headlight.specular = (0.05, 0.05, 0.05)
    for direction, strength in (
        ((0.35, 0.60, -0.75), 0.36),
        ((-0.70, -0.25, -0.40), 0.24),
        ((0.2, -0.1, 1.0), 0.40),
    ):
        spec.worldbody.add_light(
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            pos=(0.0, 0.0, 2.0),
            dir=direction,
            diffuse=(strength, strength * 0.98, strength * 0.94),
            ambient=(0.0, 0.0, 0.0),
            specular=(0.15, 0.15, 0.15),
            castshadow=False,
        )
    return spec
