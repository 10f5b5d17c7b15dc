"""ManiSkill's own AntWalk with a map in its scene, on the CPU: the ant stands on blocks, and a policy learns a step."""

from __future__ import annotations

import importlib
from typing import Any

import pytest

import rsegen
from tests.support.policy_step import learn

pytestmark = [
    pytest.mark.long(reason="ManiSkill, with PyTorch a download of gigabytes"),
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore"),  # its own
]

RECIPE = rsegen.Recipe(seed=7, chunk_size=30, unit_cm=4, boundary="none", obstacles=[rsegen.Random(levels=6)])
RADIUS = 0.08
"""Of the ant's feet, metres."""


def without_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let ManiSkill load a robot of MJCF without a GPU: without what is seen of it."""
    builders = importlib.import_module("sapien.wrapper.actor_builder")
    loader = importlib.import_module("mani_skill.utils.building._mjcf_loader")
    monkeypatch.setattr(loader, "RenderMaterial", lambda *_, **__: None)
    for name in [name for name in dir(builders.ActorBuilder) if name.startswith("add_") and "visual" in name]:
        monkeypatch.setattr(builders.ActorBuilder, name, lambda self, *_, **__: self)


def environment(scene: rsegen.Scene, rise: float) -> Any:
    """AntWalk, as ManiSkill's users extend it: a map in its scene, above which the ant starts."""
    sapien = importlib.import_module("sapien")
    ant = importlib.import_module("mani_skill.envs.tasks.control.ant")
    adapter = importlib.import_module("rsegen.learning.sapien")

    class AntOnBlocks(ant.AntWalk):  # type: ignore[misc,name-defined]  # it has no types here
        def _load_scene(self, options: dict[str, Any]) -> None:
            super()._load_scene(options)
            builder = self.scene.create_actor_builder()
            builder.initial_pose = sapien.Pose()
            adapter.add_map(builder, scene, visual=False)
            self.blocks = builder.build_static(name="blocks")

        def _initialize_episode(self, env_idx: Any, options: dict[str, Any]) -> None:
            super()._initialize_episode(env_idx, options)
            pose = self.agent.keyframes["stand"].pose
            self.agent.robot.set_root_pose(sapien.Pose([*pose.p[:2], pose.p[2] + rise], pose.q))

    return AntOnBlocks(obs_mode="state", reward_mode="dense", sim_backend="cpu", render_backend="none")


def tip_of(foot: Any) -> Any:
    """The middle of the ball at the end of a foot, metres: its capsule begins at the joint."""
    from sapien import Pose

    middle = foot._bodies[0].collision_shapes[0].local_pose.p
    return (foot.pose * Pose(2 * middle)).p[0]


def test_ant_walk_learns_a_step_on_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: it is a download of gigabytes")
    pytest.importorskip("mani_skill", reason="ManiSkill is not installed: with PyTorch it is a download of gigabytes")
    without_looks(monkeypatch)
    scene = rsegen.compose(RECIPE)
    ground = rsegen.Ground(RECIPE, torch.as_tensor(scene.field.levels))
    rise = float(ground.highest(torch.zeros(1, 2), 1.2)[0])
    assert rise == pytest.approx(0.2)
    env = environment(scene, rise)
    now, _ = env.reset(seed=1)
    for _ in range(60):  # it falls, and stands
        now, *_ = env.step(torch.zeros(8))
    feet = [link for link in env.active_links if "foot" in link.name]
    pushes = torch.cat([env.scene.get_pairwise_contact_forces(foot, env.blocks) for foot in feet])
    assert (pushes[:, 2] > 0.1).sum() >= 3
    for foot, push in zip(feet, pushes, strict=True):
        tip = tip_of(foot)
        below, around = float(ground.heights(tip[None, :2])[0]), float(ground.highest(tip[None, :2], RADIUS)[0])
        # It is on its block, or against the edge of a higher one.
        assert below - 1e-3 < tip[2] - RADIUS < around + (1e-3 if push[2] > 0.1 else 0.3)
    assert env.torso_height > 0.55

    pattern = torch.as_tensor(rsegen.scan_points((1.2, 1.2), 0.3))

    def observe() -> Any:
        torso = env.agent.robot.links_map["torso"].pose.p
        return torch.cat([now, ground.scan(pattern, torch.cat([torso, torch.zeros(1, 1)], dim=1))], dim=1)

    def act(actions: Any) -> Any:
        nonlocal now
        now, reward, *_ = env.step(actions[0].clip(-1, 1))
        return reward

    observed, rewards = learn(observe, act, 8, steps=10)
    scans = observed[0, 0, -len(pattern) :]
    assert len(torch.unique(scans.round(decimals=3))) == 6  # levels
    assert (rewards > 0).any()
