"""The world of a course: a field in its construction, robots on their marks, bodies in the air."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from benchmarks.contact.constructions import Construction
from benchmarks.contact.courses import DROP, course, drops, nothing, starts
from rsegen import StepField
from rsegen.driving.world_file import add_systems
from rsegen.robots.files.simulator_shapes import with_capsules
from tests.real.bodies import body
from tests.real.burger import BURGER_WHEELS, EVERYTHING, RADIUS, Start, Wheels, burger

ROBOTS: Mapping[str, Wheels] = {
    "soft": BURGER_WHEELS,
    "light": BURGER_WHEELS._replace(
        friction="<friction><ode><mu>100000</mu><mu2>100000</mu2></ode></friction>",
        moments=(1.12e-5, 1.12e-5, 2.07e-5),
        gain=0.01,
    ),
    "stiff": BURGER_WHEELS._replace(contact="", friction=""),
    "sphere": BURGER_WHEELS._replace(shape=f"<sphere><radius>{RADIUS}</radius></sphere>"),
    "ball": BURGER_WHEELS,
}
"""A TurtleBot3's soft wheels; the same light and without a direction of friction; Gazebo's default contact; spheres;
the first once more, whose caster is a ball in Gazebo Sim too, where the others have capsules, as rsegen writes them."""

TOGETHER: Mapping[str, Sequence[Sequence[str]]] = {
    "classic": [["soft", "light", "stiff", "sphere"]],
    "sim": [["soft"], ["sphere"], ["ball"]],
}
"""The robots that are in one world: in Gazebo Classic all, which pass through one another; in Gazebo Sim, whose engine
does not let them and knows no soft wheels, three sorts, each in a world of its own."""

_FRICTION = "<friction><ode><mu>1</mu><mu2>1</mu2></ode></friction>"

_WORLD = f"""\
<?xml version="1.0"?>
<sdf version="1.6">
  <world name="course">
    <physics type="ode">
      <max_step_size>0.001</max_step_size>
      <real_time_update_rate>2000</real_time_update_rate>
    </physics>
    <model name="ground_plane">
      <static>true</static>
      <link name="link">
        <collision name="collision">
          <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
          <surface>{_FRICTION}</surface>
        </collision>
      </link>
    </model>
{{models}}
  </world>
</sdf>
"""


def field_of(construction: Construction, seed: int) -> StepField:
    """The field of a seed; nothing for a construction without levels."""
    return course(seed) if construction.levels else nothing()


def robots_on(field: StepField, kinds: Sequence[str]) -> Iterator[tuple[str, str, tuple[str, int], Start]]:
    """Name, robot, ground and heading, and start of each: the soft one everywhere, the others where it is hardest."""
    for place, start in starts(field).items():
        ground, heading = place
        for robot in kinds:
            if robot == "soft" or (ground != "plain" and heading % 90):
                yield f"{robot}_{place[0]}_{place[1]}", robot, place, start


def written(construction: Construction, field: StepField, folder: Path, backend: str, kinds: Sequence[str]) -> Path:
    """The world's file in a folder, with the files that it names, and with these robots."""
    models = [_model(construction, field, folder)] if construction.levels else []
    masks = {robot: 1 << number for number, robot in enumerate(ROBOTS)}
    for name, robot, _, start in robots_on(field, kinds):
        model = burger(name, start, ROBOTS[robot], masks[robot] if len(kinds) > 1 else EVERYTHING, backend)
        models.append(model if robot == "ball" else with_capsules(model, backend))
    if construction.levels:
        models += [body(drop.name, drop.shape, (drop.x, drop.y, drop.top + DROP)) for drop in drops(field)]
    path = folder / "course.world"
    root = ET.fromstring(_WORLD.format(models="".join(models)).encode())  # noqa: S314  # ours
    add_systems(root[0], backend)
    path.write_bytes(ET.tostring(root))
    return path


def _model(construction: Construction, field: StepField, folder: Path) -> str:
    collisions = []
    kd = f"<kd>{construction.kd}</kd>" if construction.kd else ""
    for number, shape in enumerate(construction.shapes(field)):
        for name, content in shape.files(f"shape_{number}").items():
            (folder / name).write_bytes(content)
        x, y, z = shape.centre
        geometry = shape.geometry(f"shape_{number}").replace("file://", f"file://{folder}/")
        surface = f"<surface><contact><ode>{kd}</ode></contact>{_FRICTION}</surface>"
        collisions.append(
            f'<collision name="collision_{number}"><pose>{x} {y} {z + construction.lift} 0 0 0</pose>'
            f"<geometry>{geometry}</geometry>{surface}</collision>\n"
        )
    link = f'<link name="link">{construction.link}{"".join(collisions)}</link>'
    return f'<model name="field">{link}{construction.held}</model>\n'
