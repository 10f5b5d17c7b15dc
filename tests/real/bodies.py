"""Things that tests put on a field, as SDF, and the worlds that hold them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType

SIZE = 0.04
"""Height and width of every body, metres: less than half a block's width."""

SHAPES: Mapping[str, str] = MappingProxyType(
    {
        "cube": f"<box><size>{SIZE} {SIZE} {SIZE}</size></box>",
        "sphere": f"<sphere><radius>{SIZE / 2}</radius></sphere>",
        "cylinder": f"<cylinder><radius>{SIZE / 2}</radius><length>{SIZE}</length></cylinder>",
    }
)

SIDEWAYS = 3.0
"""Gravity along x, m/s2, in a tilted world: a cube slides where friction is less than 0.3."""

_MASS = 0.05
_MOMENT = 0.4 * _MASS * (SIZE / 2) ** 2


def body(name: str, shape: str, place: tuple[float, float, float]) -> str:
    """A body of 50 g, upright, its lowest point at `place`."""
    x, y, foot = place
    inertia = f"<inertia><ixx>{_MOMENT}</ixx><iyy>{_MOMENT}</iyy><izz>{_MOMENT}</izz></inertia>"
    return f"""\
    <model name="{name}">
      <pose>{x} {y} {foot + SIZE / 2} 0 0 0</pose>
      <link name="link">
        <inertial><mass>{_MASS}</mass>{inertia}</inertial>
        <collision name="collision"><geometry>{SHAPES[shape]}</geometry></collision>
      </link>
    </model>
"""


def furnished(world: Path, models: Iterable[str]) -> Path:
    """A copy of a world beside it, with `models` in it, simulated up to ten times as fast as life.

    Without any throttle a server that stands still would keep a processor busy.
    """
    text = world.read_text()
    end = text.rindex("  </world>")
    throttle = "<real_time_update_rate>{}</real_time_update_rate>"
    text = text[:end].replace(throttle.format(1000), throttle.format(10_000)) + "".join(models) + text[end:]
    copy = world.with_name("furnished.world")
    copy.write_text(text)
    return copy


def tilt(world: Path) -> None:
    """Let gravity push along x too, as if the ground were tilted."""
    text = world.read_text()
    head = '<physics type="ode">'
    assert text.count(head) == 1
    world.write_text(text.replace(head, f"<gravity>{SIDEWAYS} 0 -9.8</gravity>\n    {head}"))
