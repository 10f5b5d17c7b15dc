"""Joints that nothing drives: those that a drive holds, such as an arm's, and those that move, such as a caster's.

What has limits is held: nothing else keeps an arm, a flipper or a leg where it is. A joint with a spring is a
suspension and moves, as does one that turns without end, such as that of a caster. A turret does not, nor the forearm
of a robot, as their motors hold them: its axis is not across, it carries nothing that rolls, nor
anything below the axles, and is on nothing that rolls (unlike the rollers of a wheel). A joint that follows another one
(mimics.py) moves if that one does. Two that follow each other, and carry driven wheels both, about axes that are not
upright, are the two sides of a differential: they move against each other. What breaks it: an arm that hangs on endless
joints across, and a rocker that has no spring and no partner, which becomes stiff.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from xml.etree.ElementTree import Element

from rsegen.gazebo.sdf import numbers
from rsegen.robots.drives import Drive
from rsegen.robots.files.mimics import MOVING, Mimic, first_leader, mimics
from rsegen.robots.files.sdf_elements import put
from rsegen.robots.files.sdf_shapes import ModelFrames, floats
from rsegen.robots.files.wheel_joints import UPRIGHT, is_endless

_ACROSS = 0.7
"""Part of an axis along y of the model from which on what it carries may roll ahead."""


def hold(model: Element, drive: Drive | None, *, follows: bool, steering: Collection[str] = ()) -> tuple[str, ...]:
    """Make the joints that nothing drives fixed, and return their names; without a drive, all that move.

    steering: joints that are held even if they turn without end
    follows: whether the simulator keeps to <mimic>; if not, all joints are as if they had none
    """
    frames = ModelFrames(model, model.get("name", ""))
    wheels = drive.joints if drive else ()
    driven = drive.links(frames.child) if drive else set[str]()
    belts = () if wheels else driven
    followed = mimics(frames) if follows and drive else {}
    free = _differentials(frames, followed, driven)

    def is_held(name: str) -> bool:
        if name in free or name in wheels:
            return False
        joint = frames.joints[name]
        is_stiff = name in steering or frames.child(name) in belts or _is_turret(name, frames, drive)
        return drive is None or is_stiff or not (is_endless(joint) or has_spring(joint))

    # A joint is held or moves as the one that it follows in the end does.
    leaders = {name: first_leader(name, followed) or name for name in frames.joints}
    moving = [name for name, joint in frames.joints.items() if joint.get("type") in MOVING and name not in wheels]
    held = tuple(name for name in moving if is_held(leaders[name]))
    for name in held:
        joint = frames.joints[name]
        joint.set("type", "fixed")
        for element in [*joint.findall("axis"), *joint.findall("physics")]:
            joint.remove(element)
    return held


def turn_to_the_left(model: Element, where: str, turned: Collection[str]) -> None:
    """Turn the axes of wheels to the left, and mend the ratios by which joints follow each other."""
    frames = ModelFrames(model, where)
    for name in turned:
        if (axis := frames.joints[name].find("axis/xyz")) is not None:
            axis.text = numbers([-value for value in floats(axis.text, 3, where)])
    for name, mimic in mimics(frames).items():
        # angle = ratio * leader + offset: a turned follower has -angle, a turned leader -leader.
        element = frames.joints[name].find("axis/mimic")
        sign = -1 if name in turned else 1
        ratio = sign * (-1 if mimic.leader in turned else 1)
        if element is not None and (sign, ratio) != (1, 1):
            values = {"multiplier": ratio * mimic.multiplier, "offset": sign * mimic.offset}
            for child in list(element):
                element.remove(child)
            for tag, value in values.items():
                put(element, tag, numbers([value]))


def has_spring(joint: Element) -> bool:
    """Return whether a joint has a spring, as a suspension has."""
    try:
        return float(joint.findtext("axis/dynamics/spring_stiffness") or 0) > 0
    except ValueError:
        return False


def _is_turret(name: str, frames: ModelFrames, drive: Drive | None) -> bool:
    """Return whether an endless joint is a turret's: no part above or below it rolls, and all is above the axles."""
    if drive is None or not is_endless(frames.joints[name]):
        return False
    carried, inner = {frames.child(name)}, {name}
    for _ in frames.joints:  # as deep as there are joints, as a file may have a circle
        joints = {joint for joint in frames.joints if frames.parent(joint) in carried} - inner
        if not joints:
            break
        inner |= joints
        carried.update(map(frames.child, joints))
    if any(_rolls(joint, frames) for joint in (*inner, *_above(name, frames))):
        return False
    shapes = frames.shapes
    if shapes.whole is None or carried & {*shapes.unknown}:
        return False
    axles = shapes.whole.low[2] + drive.radius
    return all(shapes.known[link].low[2] > axles for link in carried & shapes.known.keys())


def _above(joint: str, frames: ModelFrames) -> list[str]:
    """Return the joints on which a joint hangs."""
    holders, way = frames.holders(), list[str]()
    link = frames.parent(joint)
    while link in holders and holders[link] not in way:  # a file may have a circle
        way.append(holders[link])
        link = frames.parent(way[-1])
    return way


def _rolls(joint: str, frames: ModelFrames) -> bool:
    """Return whether a joint is endless and has its axis across, as a wheel has."""
    return is_endless(frames.joints[joint]) and bool(abs(frames.axis(joint)[1]) >= _ACROSS)


def _differentials(frames: ModelFrames, followed: Mapping[str, Mimic], driven: Collection[str]) -> set[str]:
    """Return the joints of rockers that carry driven links and follow each other."""
    above = frames.holders()
    carrying: set[str] = set()
    waiting = [above[link] for link in driven if link in above]
    while waiting:
        joint = waiting.pop()
        if joint not in carrying:  # a file may have a circle
            carrying.add(joint)
            waiting += [above[link] for link in [frames.parent(joint)] if link in above]
    # What carries a driven link and is no wheel's own joint is a rocker, or a swivel, whose axis is upright.
    wheels = {above[link] for link in driven if link in above}
    rockers = {name for name in carrying - wheels if abs(frames.axis(name)[2]) < UPRIGHT}
    pairs = [(name, mimic.leader) for name, mimic in followed.items() if {name, mimic.leader} <= rockers]
    return {name for pair in pairs for name in pair}
