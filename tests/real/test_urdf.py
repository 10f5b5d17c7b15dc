"""Gazebo Classic's own reader of URDF judges: it makes the same links and joints of a file, with the same masses."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pytest

from rsegen.robots.files.sdf_file import from_file
from rsegen.robots.files.sdf_shapes import ModelFrames, inertials, tensor_of
from rsegen.simulators.base import Installation
from rsegen.simulators.process import command_output
from tests.robots.urdf_robots import Limb, tree, two_wheels_urdf

DIGITS = 2e-5
"""Relative error of Gazebo Classic's numbers, which have six digits."""

LIMBS = tuple(
    Limb(
        parent=max(number - 1 - number % 3, 0),
        kind=kind,
        place=(0.1 * number, -0.2, 0.3, 0.5, -0.4, 0.3 * number),
        axis=(0.1, 0.2 * number, 0.3),
        mass=0 if number == 4 else number + 1,
        centre=(0.01, 0.02 * number, -0.03, 0.1, 0.2, 0.3),
        size=(0.1, 0.2, 0.3),
    )
    for number, kind in enumerate(("", "fixed", "revolute", "fixed", "fixed", "continuous", "prismatic", "fixed"))
)
"""A tree with masses on fixed joints, one link without a mass among them."""


@pytest.mark.parametrize("text", [two_wheels_urdf(), tree(LIMBS)], ids=["two wheels", "tree"])
def test_gazebo_classic_reads_the_same_robot(gazebo_classic: Installation, tmp_path: Path, text: str) -> None:
    file = tmp_path / "mine.urdf"
    file.write_text(text)
    theirs = ElementTree.fromstring(command_output([gazebo_classic.commands["gz"], "sdf", "-p", file]))
    ours = ElementTree.fromstring(from_file(file).text)
    models = [ModelFrames(model, "model") for model in (ours, theirs.find("model")) if model is not None]
    assert len(models) == 2
    mine, gazebos = models
    assert set(mine.elements) == set(gazebos.elements)
    assert set(mine.joints) == set(gazebos.joints)
    for name, link in mine.elements.items():
        place, other = (frames.transform(name) for frames in models)
        np.testing.assert_allclose(place, other, atol=DIGITS)
        mass, centre = inertials(mine)[name]
        assert mass == pytest.approx(inertials(gazebos)[name].mass, rel=DIGITS)
        np.testing.assert_allclose(centre, inertials(gazebos)[name].centre, atol=DIGITS)
        tensor, other = (tensor_in_model(frames, name) for frames in models)
        np.testing.assert_allclose(tensor, other, atol=DIGITS * np.abs(other).max())
        for tag in ("collision", "visual"):
            shapes = [{each.get("name"): each for each in frames.elements[name].findall(tag)} for frames in models]
            assert set(shapes[0]) == set(shapes[1])
            for shape in shapes[0]:
                place, other = mine.shape(name, shapes[0][shape]), gazebos.shape(name, shapes[1][shape])
                np.testing.assert_allclose(place, other, atol=DIGITS)
        assert [friction(each) for each in link.findall("collision")] == [
            friction(each) for each in gazebos.elements[name].findall("collision")
        ]
    for name, joint in mine.joints.items():
        assert joint.get("type") == gazebos.joints[name].get("type")
        np.testing.assert_allclose(mine.joint(name), gazebos.joint(name), atol=DIGITS)
        np.testing.assert_allclose(mine.axis(name), gazebos.axis(name), atol=DIGITS)
        for end, default in (("lower", "-1e16"), ("upper", "1e16")):
            ends = [float(each.joints[name].findtext(f"axis/limit/{end}", default)) for each in models]
            assert ends[0] == ends[1]


def tensor_in_model(frames: ModelFrames, name: str) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """The tensor of inertia of a link, along the axes of the model."""
    link = frames.elements[name]
    inertial = link.find("inertial")
    assert inertial is not None
    moments = [float(inertial.findtext(f"inertia/{each}", "")) for each in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")]
    turn = (frames.transform(name) @ frames.local(inertial))[:3, :3]
    return np.asarray(turn @ tensor_of(moments) @ turn.T)


def friction(collision: Element) -> Sequence[float]:
    texts = (collision.findtext(f"surface/friction/ode/{tag}") for tag in ("mu", "mu2"))
    return [float(text) for text in texts if text]
