"""Links of a model on fixed joints as one body, for Gazebo Classic.

Its engine, ODE, holds a fixed joint only about, by a constraint like any other. Between bodies of very different
moments of inertia, such as a frame and a sensor of 10 g, that fails, and the robot is thrown off. A rigid joint makes
two bodies one, so this is the same robot. What names a link that became a part, such as a plug-in, names the whole.
What breaks it: a plug-in that wants the pose of such a link.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from itertools import chain, count
from xml.etree.ElementTree import Element

import numpy as np

from rsegen.field.stepfield import Array
from rsegen.robots.files.sdf_elements import (
    ENDS,
    LUMPED,
    NAMES_A_PART,
    Mass,
    append_inertial,
    put_pose,
    sum_of_masses,
)
from rsegen.robots.files.sdf_shapes import ModelFrames, inertia_tensor, inertials

_SHAPES = ("collision", "visual")


def has_fixed_links(frames: ModelFrames, apart: Collection[str]) -> bool:
    """Return whether links of a model hang on fixed joints; those that are to stay apart do not count."""
    return bool(_fixed(frames, apart))


def make_one(model: Element, frames: ModelFrames, apart: Collection[str]) -> None:
    """Make links on fixed joints parts of the links that they hang on, in a model of links and joints alone.

    apart: links that stay what they are, such as tracks
    """
    # Shapes and masses move first, by the places of the links; then links and joints go, and names are mended.
    above = _fixed(frames, apart)
    parts: dict[str, list[str]] = {}
    for link, _ in frames.links():
        parts.setdefault(head_of(link, above), []).append(link)
    bodies = _bodies(frames)
    for head, links in parts.items():
        if len(links) > 1:
            _put_into(head, links, bodies, frames)
    holders = frames.holders()
    for link in above:
        model.remove(frames.elements[link])
        model.remove(frames.joints[holders[link]])
    joints, plugins = ([inner for part in model.findall(tag) for inner in part.iter()] for tag in ("joint", "plugin"))
    named = [part for part in joints if part.tag in ENDS] + [part for part in plugins if NAMES_A_PART.search(part.tag)]
    for part in named:
        part.text = head_of((part.text or "").strip(), above)


def _fixed(frames: ModelFrames, apart: Collection[str]) -> dict[str, str]:
    """Return the link that each link on a fixed joint hangs on, but for circles and those that stay apart."""
    links = {name for name, _ in frames.links()}
    held_by = Counter(map(frames.child, frames.joints))
    above = {
        frames.child(name): frames.parent(name)
        for name, joint in frames.joints.items()
        if joint.get("type") == "fixed" and held_by[frames.child(name)] == 1
    }
    above = {link: parent for link, parent in above.items() if {link, parent} <= links}
    # A fender on a track is no belt, so it becomes a part of what carries the track.
    carried = {link: above[link] for link in apart if link in above}
    own = {link: head_of(parent, carried) for link, parent in above.items() if link not in apart}
    return {link: parent for link, parent in own.items() if head_of(link, own) not in own}  # no circles


def head_of(link: str, above: Mapping[str, str]) -> str:
    """Return the link at the end of those above a link, by the one above each; of a circle one that is in it."""
    for _ in above:
        link = above.get(link, link)
    return link


def _bodies(frames: ModelFrames) -> dict[str, tuple[Mass, Array]]:
    """Return the body of each link in the frame of its <inertial>, and where that is in the model, (4, 4)."""
    masses, bodies = inertials(frames), {}
    for link, element in frames.links():
        inertial = element.find("inertial")
        place = frames.transform(link) @ (np.eye(4) if inertial is None else frames.local(inertial))
        bodies[link] = Mass(masses[link].mass, np.zeros(3), inertia_tensor(link, element, frames)), place
    return bodies


def _put_into(head: str, links: Collection[str], bodies: Mapping[str, tuple[Mass, Array]], frames: ModelFrames) -> None:
    """Put the masses and shapes of links into one of them; shapes are named as Gazebo names those of lumped links."""
    body, inverse = frames.elements[head], np.linalg.inv(frames.transform(head))
    for inertial in body.findall("inertial"):
        body.remove(inertial)
    append_inertial(body, sum_of_masses((mass, inverse @ place) for mass, place in (bodies[link] for link in links)))
    for link in links:
        for shape in [part for part in frames.elements[link] if part.tag in _SHAPES and link != head]:
            put_pose(shape, inverse @ frames.shape(link, shape))
            # Two links may have shapes of one name: then the name of the link comes in between, and a number last.
            taken, name = {part.get("name") for part in body.findall(shape.tag)}, shape.get("name", "")
            of_link = f"{head}{LUMPED}{link}_{name}"
            names = chain([f"{head}{LUMPED}{name}", of_link], (f"{of_link}_{index}" for index in count(1)))
            shape.set("name", next(free for free in names if free not in taken))
            body.append(shape)
