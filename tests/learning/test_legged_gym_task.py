"""legged_gym's own task of the A1 on a terrain, every function of it, with MuJoCo in the place of Isaac Gym.

legged_gym is not a package, and Isaac Gym comes from no index: RSEGEN_LEGGED_GYM names a folder that has the first.
"""

from __future__ import annotations

import os
import sys
from functools import partial
from types import ModuleType, SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

import rsegen
from rsegen.learning.legged_gym import StepFieldTerrain
from rsegen.learning.mujoco import add_terrain
from tests.support.late_import import LateImport
from tests.support.policy_step import learn

torch = LateImport("torch", reason="PyTorch is not installed: it is a download of gigabytes")

RUBBLE = rsegen.Recipe(seed=7, chunk_size=20, unit_cm=2, boundary="none", obstacles=[rsegen.Random(levels=6)])
COURSE = rsegen.Terrain(recipes=[RUBBLE], rows=3, columns=2, border=20)
WORLDS, FOOT = 6, 0.02
LEGS = ("FL", "FR", "RL", "RR")
JOINTS = [f"{leg}_{part}_joint" for leg in LEGS for part in ("hip", "thigh", "calf")]
BODIES = ["base", *(f"{leg}_{part}" for leg in LEGS for part in ("hip", "thigh", "calf", "foot"))]


def _robot(spec: Any, world: int) -> None:
    """Add a quadruped of the A1's size, whose parts touch blocks alone."""
    touch = {"contype": 0, "conaffinity": 1, "condim": 3}
    shapes = mujoco.mjtGeom
    base = spec.worldbody.add_body(name=f"{world}_base", pos=[0, 0, 5 + world])
    base.add_freejoint()
    base.add_geom(type=shapes.mjGEOM_BOX, size=[0.13, 0.1, 0.05], mass=6, **touch)
    for leg in LEGS:
        x, y = (0.18 if leg[0] == "F" else -0.18), (0.05 if leg[1] == "L" else -0.05)
        parent, place = base, [x, y, 0]
        below = ([0, 1.7 * y, 0], [0, 0, -0.2], [0, 0, -0.2])
        for part, axis, end in zip(("hip", "thigh", "calf"), ([1, 0, 0], [0, 1, 0], [0, 1, 0]), below, strict=True):
            parent = parent.add_body(name=f"{world}_{leg}_{part}", pos=place)
            parent.add_joint(name=f"{world}_{leg}_{part}_joint", axis=axis, armature=0.01)
            parent.add_geom(type=shapes.mjGEOM_CAPSULE, fromto=[0, 0, 0, *end], size=[0.015, 0, 0], mass=0.4, **touch)
            place = end
        foot = parent.add_body(name=f"{world}_{leg}_foot", pos=place)
        foot.add_geom(type=shapes.mjGEOM_SPHERE, size=[FOOT, 0, 0], mass=0.05, **touch)


class Gym:
    """Functions that legged_gym asks of Isaac Gym, by MuJoCo; what is not here does nothing."""

    def __init__(self, step: float) -> None:
        spec = mujoco.MjSpec()
        spec.option.timestep = step
        for world in range(WORLDS):
            _robot(spec, world)
        self.spec: Any = spec
        self.roots, self.forces = torch.zeros(WORLDS, 13), torch.zeros(WORLDS * len(BODIES), 3)
        self.joints, self.torques = torch.zeros(WORLDS * 12, 2), torch.zeros(WORLDS, 12)

    def __getattr__(self, name: str) -> Any:
        return lambda *_, **__: None

    def add_triangle_mesh(self, _: Any, vertices: Any, triangles: Any, params: Any) -> None:
        """Put the boxes of the terrain where the mesh is to be, as MuJoCo's own meshes are convex."""
        corner = vertices.reshape(-1, 3).min(axis=0)[:2] + np.array([params.transform.p.x, params.transform.p.y])
        add_terrain(self.spec, COURSE, [*corner + np.array(COURSE.field.extent) / 2, 0])
        self.model = self.spec.compile()
        self.data = mujoco.MjData(self.model)
        named = [[self.model.body(f"{world}_{body}").id for body in BODIES] for world in range(WORLDS)]
        self.bodies = np.array(named)
        own = [self.model.joint(f"{world}_{joint}") for world in range(WORLDS) for joint in JOINTS]
        self.qpos, self.dofs = (np.array([getattr(joint, at)[0] for joint in own]) for at in ("qposadr", "dofadr"))
        free = self.model.body_jntadr[self.bodies[:, 0]]
        self.free_qpos, self.free_dofs = self.model.jnt_qposadr[free], self.model.jnt_dofadr[free]

    def get_asset_dof_count(self, _: Any) -> int:
        return len(JOINTS)

    def get_asset_rigid_body_count(self, _: Any) -> int:
        return len(BODIES)

    def get_asset_dof_names(self, _: Any) -> list[str]:
        return JOINTS

    def get_asset_rigid_body_names(self, _: Any) -> list[str]:
        return BODIES

    def get_asset_dof_properties(self, _: Any) -> Any:
        kinds = [(name, np.float32) for name in ("lower", "upper", "velocity", "effort")]
        return np.array([(-3, 3, 21, 33.5)] * len(JOINTS), dtype=kinds)

    def get_asset_rigid_shape_properties(self, _: Any) -> list[Any]:
        return []

    def find_actor_rigid_body_handle(self, _: Any, __: Any, name: str) -> int:
        return BODIES.index(name)

    def acquire_actor_root_state_tensor(self, _: Any) -> Any:
        return self.roots

    def acquire_dof_state_tensor(self, _: Any) -> Any:
        return self.joints

    def acquire_net_contact_force_tensor(self, _: Any) -> Any:
        return self.forces

    def set_actor_root_state_tensor_indexed(self, _: Any, states: Any, worlds: Any, count: int) -> None:
        assert len(worlds) == count
        for world in worlds.tolist():
            x, y, z, i, j, k, w, *speeds = states[world].tolist()
            self.data.qpos[self.free_qpos[world] + np.arange(7)] = x, y, z, w, i, j, k
            self.data.qvel[self.free_dofs[world] + np.arange(6)] = speeds

    def set_dof_state_tensor_indexed(self, _: Any, states: Any, worlds: Any, count: int) -> None:
        assert len(worlds) == count
        every, rows = states.view(WORLDS, 12, 2).numpy(), worlds.numpy()
        self.data.qpos[self.qpos.reshape(WORLDS, 12)[rows]] = every[rows, :, 0]
        self.data.qvel[self.dofs.reshape(WORLDS, 12)[rows]] = every[rows, :, 1]

    def set_dof_actuation_force_tensor(self, _: Any, torques: Any) -> None:
        self.data.qfrc_applied[self.dofs] = torques.numpy().ravel()

    def simulate(self, _: Any) -> None:
        mujoco.mj_step(self.model, self.data)

    def refresh_dof_state_tensor(self, _: Any) -> None:
        self.joints[:, 0] = torch.tensor(self.data.qpos[self.qpos])
        self.joints[:, 1] = torch.tensor(self.data.qvel[self.dofs])

    def refresh_actor_root_state_tensor(self, _: Any) -> None:
        for world in range(WORLDS):
            x, y, z, w, i, j, k = self.data.qpos[self.free_qpos[world] + np.arange(7)].tolist()
            speeds, turned = self.data.qvel[self.free_dofs[world] + np.arange(6)], np.zeros(3)
            mujoco.mju_rotVecQuat(turned, speeds[3:], np.array([w, i, j, k]))
            self.roots[world] = torch.tensor([x, y, z, i, j, k, w, *speeds[:3], *turned])

    def refresh_net_contact_force_tensor(self, _: Any) -> None:
        mujoco.mj_rnePostConstraint(self.model, self.data)
        self.forces[:] = torch.tensor(self.data.cfrc_ext[self.bodies.ravel(), 3:])


def _quat_rotate(quaternion: Any, vector: Any, sign: float = 1.0) -> Any:
    """Rotate vectors by quaternions x, y, z, w, or back."""
    axis, w = quaternion.reshape(-1, 4)[:, :3] * sign, quaternion.reshape(-1, 4)[:, 3:]
    own = vector.reshape(-1, 3)
    across = 2 * torch.linalg.cross(axis, own)
    return (own + w * across + torch.linalg.cross(axis, across)).view(vector.shape)


def _uniform(low: float, high: float, shape: Any, device: str) -> Any:
    return (high - low) * torch.rand(*shape, device=device) + low


def stand_in_for_isaac_gym(monkeypatch: pytest.MonkeyPatch, gym: Gym) -> None:
    """Make the modules that legged_gym imports of Isaac Gym, and of its trainer."""

    def point(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> SimpleNamespace:
        return SimpleNamespace(x=x, y=y, z=z)

    modules: dict[str, dict[str, Any]] = {
        "isaacgym": {},
        "isaacgym.gymapi": {
            "acquire_gym": lambda: gym,
            "AssetOptions": SimpleNamespace,
            "Transform": SimpleNamespace,
            "TriangleMeshParams": lambda: SimpleNamespace(transform=SimpleNamespace(p=point())),
            "Vec3": point,
        },
        "isaacgym.gymtorch": {"wrap_tensor": lambda tensor: tensor, "unwrap_tensor": lambda tensor: tensor},
        "isaacgym.gymutil": {"parse_device_str": lambda device: (device, 0)},
        "isaacgym.terrain_utils": {},
        "isaacgym.torch_utils": {
            "get_axis_params": lambda value, axis: [value * (index == axis) for index in range(3)],
            "normalize": partial(torch.nn.functional.normalize, dim=-1),
            "quat_apply": _quat_rotate,
            "quat_rotate_inverse": partial(_quat_rotate, sign=-1.0),
            "to_torch": partial(torch.tensor, dtype=torch.float),
            "torch_rand_float": _uniform,
        },
        "rsl_rl": {},
        "rsl_rl.env": {"VecEnv": object},
        "rsl_rl.runners": {"OnPolicyRunner": object},
    }
    for name, names in modules.items():
        module = ModuleType(name)
        vars(module).update(names)
        monkeypatch.setitem(sys.modules, name, module)
        if "." in name:
            parent, _, last = name.partition(".")
            setattr(sys.modules[parent], last, module)


@pytest.mark.long(reason="legged_gym, which is no package, with PyTorch")
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::UserWarning")  # torch.meshgrid's, of legged_gym
def test_its_a1_stands_on_blocks_and_a_policy_learns_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    folder = os.environ.get("RSEGEN_LEGGED_GYM")
    if not folder:
        pytest.skip("RSEGEN_LEGGED_GYM names no folder with legged_gym, which is no package")
    torch.manual_seed(3)
    gym = Gym(step=0.005)
    stand_in_for_isaac_gym(monkeypatch, gym)
    monkeypatch.syspath_prepend(folder)
    from legged_gym.envs import A1RoughCfg
    from legged_gym.envs.base import legged_robot

    # The middle is at most 1 m from the origin of its tile, and a foot 0.4 m from it.
    monkeypatch.setattr(legged_robot, "Terrain", partial(StepFieldTerrain, COURSE, spawn_radius=1.4))
    cfg = A1RoughCfg()
    cfg.env.num_envs, cfg.noise.add_noise, cfg.domain_rand.push_robots = WORLDS, False, False
    cfg.domain_rand.randomize_friction = False
    cfg.rewards.scales.base_height, cfg.rewards.only_positive_rewards = -5.0, False  # above the heights it measures
    task = legged_robot.LeggedRobot(cfg, SimpleNamespace(dt=0.005, use_gpu_pipeline=False), None, "cpu", headless=True)
    seen, _ = task.reset()
    for _ in range(50):  # 1 s: they fall, and stand
        seen, *_ = task.step(torch.zeros(WORLDS, 12))
    assert (task.episode_length_buf == 51).all()
    pushes = task.contact_forces[:, task.feet_indices, 2].numpy()
    assert ((pushes > 1).sum(axis=1) >= 3).all()
    feet = gym.data.xpos[gym.bodies[:, 4::4]].copy()
    feet[..., :2] += cfg.terrain.border_size - np.array(COURSE.field.extent) / 2
    feet[..., 2] -= FOOT
    ground = COURSE.ground()
    below, around = ground.heights(feet), ground.highest(feet, FOOT)
    # On top of a block, or against the edge of a higher one.
    assert (feet[..., 2] > below - 0.004).all()
    assert (feet[..., 2] < around + 0.001)[pushes > 1].all()
    assert (feet[..., 2] < below + 0.001).sum() >= 18
    assert len(np.unique(below)) >= 4
    assert (task.measured_heights.std(dim=1) > 0.005).all()
    levels = task.measured_heights.numpy() / COURSE.field.unit
    assert levels == pytest.approx(levels.round(), abs=1e-4)
    assert len(np.unique(levels.round())) >= 5

    def observe() -> Any:
        return seen

    def act(actions: Any) -> Any:
        nonlocal seen
        seen, _, rewards, *_ = task.step(actions)
        return rewards.clone()

    observed, _ = learn(observe, act, 12, steps=8)
    assert observed.shape == (8, WORLDS, 235)
    assert (observed[0, :, 48:].std(dim=1) > 0.02).all()  # the heights

    # Those that walked far enough start in the next row, and those that did not in an easier one.
    task.terrain_levels[:] = 1
    task.root_states[:3, 0], task.root_states[3:, :2] = task.env_origins[:3, 0] + 1.2, task.env_origins[3:, :2]
    task.commands[:, 0] = 1.0
    task.reset_idx(torch.arange(WORLDS))
    assert task.terrain_levels.tolist() == [2, 2, 2, 0, 0, 0]
    kinds = task.terrain_types.tolist()
    assert kinds == [0, 0, 0, 1, 1, 1]
    expected = task.terrain.env_origins[[2, 2, 2, 0, 0, 0], kinds]
    assert task.env_origins.numpy() == pytest.approx(expected, abs=1e-6)
