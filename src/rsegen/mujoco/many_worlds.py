"""Thousands of worlds at once, with a robot in each: the physics of `MujocoWorld` in mujoco_warp, on a GPU or without.

    many = ManyWorlds(MujocoWorld(scene, [placed]), 4096)
    many.drive(v, w)
    many.step(1000)
    many.poses()

All worlds begin as the given one. mujoco_warp steps them, and calls back at two places, where kernels do what
`rsegen.mujoco.contacts` does in one world:

    contacts --> planes of belts turned, surfaces moved --> constraints --> wheels' speeds, sliding --> solution

Cost: on a GPU a step of thousands of worlds is one graph of kernels, and nothing waits for the host. Numbers have 32
bits here: a robot is at the same place to a hundredth of a millimetre until it falls or hangs at an edge, where any
difference grows. What breaks it: more contacts or constraints in a world than there is room for, which mujoco_warp
reports, and a robot of more than 32 joints, whose Jacobians are sparse.
"""

from collections.abc import Sequence
from typing import Any

import mujoco_warp as mjw
import numpy as np
import warp as wp

from rsegen.errors import ParameterError
from rsegen.field.stepfield import Array
from rsegen.mujoco import kernels
from rsegen.mujoco.settings import MOTOR_SOLIMP, MOTOR_SOLREF
from rsegen.mujoco.world import MujocoWorld, free_joint_state
from rsegen.robots.drives import Tracks
from rsegen.simulators.poses import Pose

_CONTACTS, _ROWS = 96, 320
"""Contacts and constraints for which there is room in each world: a crawler on blocks has 40 contacts at most."""

_PRECISION, _ITERATIONS = 1e-7, 50
"""Tolerance of the search for contacts, and iterations at most, which take memory: 7 kB for each pair that is near. 32
bits cannot reach the 1e-10 of a single world: the search would fail, and a contact would be missing in that step. With
this tolerance it seldom fails, which is not worth a warning each time."""

_DAMPING = 2 / (MOTOR_SOLIMP[1] * MOTOR_SOLREF[0])
"""Factor of a speed in the reference acceleration of a motor's constraint, as MuJoCo computes it."""


class ManyWorlds:
    """Worlds that begin as a given `MujocoWorld` with a single robot; ParameterError if it has more.

    worlds: their number; device: of Warp, by default its own choice
    model, data: of mujoco_warp; `data.qpos` is (worlds, numbers)
    """

    def __init__(self, world: MujocoWorld, worlds: int, *, device: Any = None) -> None:
        if len(world.robots) != 1:
            raise ParameterError("world", f"{len(world.robots)} robots in it; use a world with one")
        robot, compiled = world.robots[0], world.model
        self.robot, self.worlds = robot, worlds
        with wp.ScopedDevice(device):
            self.model: Any = mjw.put_model(compiled)
            self.data: Any = mjw.put_data(
                compiled, world.data, nworld=worlds, nconmax=_CONTACTS, nccdmax=_CONTACTS // 2, njmax=_ROWS
            )
            self.model.opt.ccd_tolerance.fill_(_PRECISION)
            self.model.opt.ccd_iterations = _ITERATIONS
            self.model.opt.warn_overflow &= ~mjw.OverflowType.EPA_HORIZON
            if self.model.is_sparse:
                many = f"{robot.kind} has {compiled.nv} degrees of freedom; MuJoCo Warp takes 32 at most"
                raise ParameterError("robot", f"{many}, and MuJoCo any number")
            self._keep_shapes(world)
            self._keep_wheels(world)
            # Arrays are made once and written in place, as a captured graph of kernels keeps their addresses.
            self.speeds: Any = wp.zeros((worlds, 2), dtype=wp.float32)
            self.wedged: Any = wp.zeros(worlds, dtype=wp.int32)
            self.centre: Any = wp.full(worlds, np.inf, dtype=wp.float32)
            self._spent: Any = wp.zeros((worlds, compiled.ngeom, 2), dtype=wp.float32)
            self._boxes: Any = wp.zeros(self.data.naconmax, dtype=wp.vec2)
            self.limit = world.belts.limits[0]
        self._gain = world.gains[0]
        self.model.callback.contactfilter, self.model.callback.control = self._turn, self._before_solving
        self._graphs: dict[int, Any] = {}

    def place(self, starts: Sequence[Pose]) -> None:
        """Put the robot of each world at a start of its own, before the first step."""
        qpos = self.data.qpos.numpy()
        for row, start in zip(qpos, starts, strict=True):
            row[:7] = free_joint_state(start)
        self.data.qpos.assign(qpos)

    def put_boxes(self, geoms: slice, centres: Array, halves: Array) -> None:
        """Give each world its own boxes for these static geoms, before the first step.

        centres, halves of the sides: (worlds, boxes, 3), metres
        """
        bounds = np.stack([np.zeros_like(halves), halves], axis=-2)
        values = {"pos": centres, "size": halves, "aabb": bounds, "rbound": np.linalg.norm(halves, axis=-1)}
        for name, own in values.items():
            array = getattr(self.model, f"geom_{name}")
            rows = np.repeat(array.numpy()[:1], self.worlds, axis=0)
            rows[:, geoms] = own
            setattr(self.model, f"geom_{name}", wp.array(rows, dtype=array.dtype, device=array.device))
        # mujoco_warp does not compute the positions of static geoms again.
        places = self.data.geom_xpos.numpy()
        places[:, geoms] = centres
        self.data.geom_xpos.assign(places)

    def find_contacts(self) -> None:
        """Find the contacts of robots and boxes where they were put, without a step."""
        with wp.ScopedDevice(self.data.qpos.device):
            mjw.kinematics(self.model, self.data)
            mjw.collision(self.model, self.data)

    def drive(self, v: Any, w: Any) -> None:
        """Have robots drive at v, m/s forward, and w, rad/s counterclockwise: a number, or one for each world."""
        v, w = np.broadcast_to(v, self.worlds), np.broadcast_to(w, self.worlds)
        drive = self.robot.drive
        if self._base >= 0 and isinstance(drive, Tracks):
            left, right, centre = np.array([*map(drive.classic_turn, v.tolist(), w.tolist())]).T
            self.centre.assign(centre.astype(np.float32))
        else:
            left, right = self.sides(v, w)
        self.speeds.assign(np.stack([left, right], axis=-1).astype(np.float32))

    def sides(self, v: Any, w: Any) -> tuple[Any, Any]:
        """Return the speeds of the left and the right sides, m/s, for v, m/s, and w, rad/s."""
        return self.robot.drive.sides(v, w, self._gain)

    def step(self, steps: int) -> None:
        """Simulate this number of steps."""
        device = self.data.qpos.device
        with wp.ScopedDevice(device):
            if not device.is_cuda:
                self._step(steps)
                return
            if steps in self._graphs:
                wp.capture_launch(self._graphs[steps])
                return
            self._step(steps)  # kernels are compiled before a graph is captured, in which nothing is done
            with wp.ScopedCapture() as capture:
                self._step(steps)
            self._graphs[steps] = capture.graph

    def poses(self) -> Array:
        """Return where the robots' origins are, (worlds, 7): x, y, z in metres and a quaternion, w first."""
        return np.asarray(self.data.qpos.numpy()[:, :7], dtype=float)

    def touches(self, geoms: slice) -> Any:
        """Return the number of contacts with some geoms in each world, an array of Warp, (worlds,)."""
        counts = wp.zeros(self.worlds, dtype=wp.int32, device=self.data.qpos.device)
        contact = self.data.contact
        wp.launch(
            kernels.count_touches,
            dim=self.data.naconmax,
            inputs=[self.data.nacon, contact.geom, contact.worldid, geoms.start, geoms.stop],
            outputs=[counts],
            device=counts.device,
        )
        return counts

    def depths(self) -> Array:
        """Return the depth of the deepest contact in each world, (worlds,), metres; 0 without one."""
        deepest: Any = wp.zeros(self.worlds, dtype=wp.float32, device=self.data.qpos.device)
        contact = self.data.contact
        wp.launch(
            kernels.find_depths,
            dim=self.data.naconmax,
            inputs=[self.data.nacon, contact.dist, contact.worldid],
            outputs=[deepest],
            device=deepest.device,
        )
        depths: Array = deepest.numpy().astype(np.float64)
        return depths

    # A step, and what it calls back.

    def _step(self, steps: int) -> None:
        # The order of `MujocoWorld._step`; `wedged` and `_spent` are for the next step.
        for _ in range(steps):
            if self._wheels:
                wp.launch(
                    kernels.ramp,
                    dim=(self.worlds, self._wheels),
                    inputs=[self.speeds, self._side, self._per_speed, self._most, self._is_written, self._dof],
                    outputs=[self.now, self.data.qvel],
                )
            mjw.step(self.model, self.data)
            if self._has_belts:
                self.wedged.zero_()
                contact = self.data.contact
                wp.launch(
                    kernels.find_wedged,
                    dim=self.data.naconmax,
                    inputs=[
                        self.data.nacon, contact.geom, contact.worldid, contact.efc_address,
                        self.data.efc.force, self._belt, self.limit,
                    ],
                    outputs=[self.wedged],
                )  # fmt: skip
            if self._are_boxes:
                self._spent.zero_()
                contact = self.data.contact
                wp.launch(
                    kernels.find_spent,
                    dim=self.data.naconmax,
                    inputs=[
                        self.data.nacon, contact.geom, contact.worldid, contact.efc_address,
                        self.data.efc.force, self._body, self._boxes,
                    ],
                    outputs=[self._spent],
                )  # fmt: skip

    def _turn(self, model: Any, data: Any) -> None:  # as mujoco_warp calls it
        contact = data.contact
        wp.launch(
            kernels.turn_planes,
            dim=data.naconmax,
            inputs=[
                data.nacon, contact.geom, contact.worldid, data.xmat,
                self._body, self._axis, self._mu, self._are_boxes, self._belt, self.speeds, self.wedged,
                self._base, self.centre, data.xpos, contact.pos, data.cvel, data.subtree_com, model.body_rootid,
                self._spent,
            ],
            outputs=[contact.frame, contact.friction, contact.surfacevel, self._boxes],
        )  # fmt: skip

    def _before_solving(self, model: Any, data: Any) -> None:
        efc, contact = data.efc, data.contact
        if self._wheels:
            wp.launch(
                kernels.add_speeds,
                dim=(self.worlds, self._wheels),
                inputs=[data.ne, data.nf, efc.type, efc.id, self._dof, self.now, _DAMPING],
                outputs=[efc.aref],
            )
        wp.launch(
            kernels.slide,
            dim=data.naconmax,
            inputs=[
                data.nacon, contact.worldid, contact.type, contact.dim, contact.efc_address, contact.friction,
                efc.J, data.qacc, model.nv,
            ],
            outputs=[efc.aref],
        )  # fmt: skip

    # What the kernels look up.

    def _keep_shapes(self, world: MujocoWorld) -> None:
        """Keep, for each geom, its body (-1 if it is not of the robot), axis, friction and the side of its belt."""
        count = world.model.ngeom
        body, belt = np.full(count, -1, dtype=np.int32), np.full(count, -1, dtype=np.int32)
        axis, mu = np.zeros((count, 3), dtype=np.float32), np.zeros((count, 2), dtype=np.float32)
        for geom, own in world.shapes.directions.items():
            body[geom], axis[geom], mu[geom] = own.body, own.axis, (own.mu_axis, own.mu_other)
        for _, side, geom in world.belts.belts:
            belt[geom] = side
        self._has_belts = bool(world.belts.belts)
        self._body: Any = wp.array(body)
        self._belt: Any = wp.array(belt)
        self._axis: Any = wp.array(axis, dtype=wp.vec3)
        self._mu: Any = wp.array(mu, dtype=wp.vec2)
        self._are_boxes = world.shapes.are_boxes
        turns = world.belts.turns.values() if self._are_boxes else ()
        self._base = next((turn.body for turn in turns), -1)

    def _keep_wheels(self, world: MujocoWorld) -> None:
        """Keep, for each wheel, its degree of freedom, side, turn rate per speed of its side, and motor."""
        wheels = world.wheels
        self._wheels = len(wheels.dofs)
        radius = self.robot.drive.radius
        self._dof: Any = wp.array(wheels.dofs, dtype=wp.int32)
        self._side: Any = wp.array(wheels.owner[:, 1], dtype=wp.int32)
        self._per_speed: Any = wp.array(wheels.turns / radius, dtype=wp.float32)
        self._most: Any = wp.array(np.minimum(wheels.most, 1e9), dtype=wp.float32)
        self._is_written = not wheels.react
        self.now = wp.zeros((self.worlds, self._wheels), dtype=wp.float32)
