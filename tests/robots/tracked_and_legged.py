"""A robot on tracks with flippers as SDF, and one on four legs as URDF, both without any plug-in."""

from __future__ import annotations

_INERTIAL = "<inertial><mass>{}</mass><inertia><ixx>{i}</ixx><iyy>{i}</iyy><izz>{i}</izz></inertia></inertial>"
_BELT = (
    '<collision name="{name}_{end}"><pose>{x} 0 0 1.5707963267948966 0 0</pose><geometry><cylinder><radius>{r}</radius>'
    "<length>0.06</length></cylinder></geometry></collision>"
)


def _track(name: str, x: float, y: float, half: float, radius: float, parent: str) -> str:
    """A link of two wheels and what is between them, and the joint that it may turn on."""
    ends = "".join(_BELT.format(name=name, end=end, x=end * half, r=radius) for end in (-1, 1))
    between = (
        f'<collision name="{name}_between"><geometry><box><size>{2 * half} 0.06 {1.98 * radius}</size></box></geometry>'
        "</collision>"
    )
    return (
        f'<link name="{name}"><pose>{x} {y} 0.08 0 0 0</pose>{_INERTIAL.format(2, i=0.02)}{ends}{between}</link>'
        f'<joint name="{name}_joint" type="revolute"><parent>{parent}</parent><child>{name}</child>'
        "<axis><xyz>0 1 0</xyz></axis></joint>"
    )


def tracked() -> str:
    """The text of a robot on tracks: its flippers turn freely if nothing holds them."""
    body = (
        f'<link name="base"><pose>0 0 0.12 0 0 0</pose>{_INERTIAL.format(8, i=0.2)}<collision name="hull"><geometry>'
        "<box><size>0.4 0.2 0.1</size></box></geometry></collision></link>"
    )
    parts = "".join(
        _track(side, 0, y, 0.2, 0.08, "base") + _track(f"{side}_flipper", 0.34, y * 1.4, 0.14, 0.05, side)
        for side, y in (("left", 0.18), ("right", -0.18))
    )
    return f'<sdf version="1.6"><model name="tracked">{body}{parts}</model></sdf>'


_LEG = """\
  <link name="{name}_thigh">
    <inertial><origin xyz="0 0 -0.1"/><mass value="0.5"/>
      <inertia ixx="2e-3" ixy="0" ixz="0" iyy="2e-3" iyz="0" izz="4e-4"/></inertial>
  </link>
  <joint name="{name}_hip" type="revolute"><origin xyz="{x} {y} 0"/><parent link="trunk"/><child link="{name}_thigh"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="30" velocity="10"/></joint>
  <link name="{name}_calf">
    <inertial><origin xyz="0 0 -0.1"/><mass value="0.3"/>
      <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="2e-4"/></inertial>
    <collision><origin xyz="0 0 -0.2"/><geometry><sphere radius="0.02"/></geometry></collision>
  </link>
  <joint name="{name}_knee" type="revolute"><origin xyz="0 0 -0.2" rpy="0 0.3 0"/><parent link="{name}_thigh"/>
    <child link="{name}_calf"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="30" velocity="10"/></joint>
"""


def legged() -> str:
    """The text of a robot on four legs, whose knees are bent; nothing drives its joints."""
    trunk = """\
  <link name="trunk">
    <inertial><mass value="8"/><inertia ixx="0.05" ixy="0" ixz="0" iyy="0.15" iyz="0" izz="0.2"/></inertial>
    <collision><geometry><box size="0.5 0.25 0.1"/></geometry></collision>
  </link>
"""
    legs = "".join(
        _LEG.format(name=f"{front}_{side}", x=x, y=y)
        for front, x in (("front", 0.2), ("rear", -0.2))
        for side, y in (("left", 0.15), ("right", -0.15))
    )
    return f'<robot name="legged">\n{trunk}{legs}</robot>\n'
