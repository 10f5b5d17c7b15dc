"""Robots as MJCF, MuJoCo's format: the robot of two_wheels with included defaults, and parts that others have."""

from __future__ import annotations

from pathlib import Path

DEFAULTS = """\
<mujoco>
  <default>
    <default class="hub">
      <joint axis="0 0 1" damping="0.01" armature="0.001"/>
      <velocity kv="2" ctrlrange="-10 10" forcerange="-1.5 1.5"/>
    </default>
    <default class="tyre"><geom type="cylinder" size="0.05 0.01" mass="0.2" friction="0.9 0.005 0.0001"/></default>
    <default class="seen"><geom contype="0" conaffinity="0" mass="0" group="2" rgba="1 0 0 1"/></default>
  </default>
</mujoco>
"""

BALL = '<geom name="ball" type="sphere" size="0.02" pos="-0.15 0 -0.03" mass="0.1" condim="1" priority="1"/>'

WHEELS = """\
      <body name="left_wheel" pos="0 0.15 0" euler="-90 0 0"><joint name="left_hub" class="hub"/><geom class="tyre"/>
      </body>
      <body name="right_wheel" pos="0 -0.15 0" euler="-90 0 0"><joint name="right_hub" class="hub"/><geom class="tyre"/>
      </body>
"""

MOTORS = '<velocity joint="left_hub" class="hub"/><velocity joint="right_hub" class="hub"/>'


def two_wheels_mjcf(  # noqa: PLR0913  # what tests change
    folder: Path,
    *,
    more: str = "",
    ball: str = BALL,
    wheels: str = WHEELS,
    motors: str = MOTORS,
    assets: str = "",
    turned: str = "0 0 0",
    compiler: str = '<compiler angle="degree" eulerseq="xyz" meshdir="meshes"/>',
    after: str = "",
) -> Path:
    """Write the robot of two wheels and a ball into a folder, and return its file.

    more: elements in its first body; turned: the angles at which its first body is; after: elements at the end
    """
    (folder / "defaults.xml").write_text(DEFAULTS)
    file = folder / "rover.xml"
    file.write_text(f"""\
<mujoco model="little rover">
  {compiler}
  <include file="defaults.xml"/>
  <asset>{assets}</asset>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <light pos="0 0 3"/>
    <body name="base" pos="3 2 0.05" euler="{turned}">
      <freejoint/>
      <geom name="hull" type="box" size="0.15 0.1 0.04" pos="-0.05 0 0.04" mass="3"/>
      <geom name="shell" class="seen" type="ellipsoid" size="0.1 0.1 0.05" pos="0 0 0.08"/>
      {ball}
{wheels}{more}
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
  {after}
</mujoco>
""")
    return file
