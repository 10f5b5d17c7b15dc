"""Contacts that slide press as those that do not: Coulomb's friction, in place of MuJoCo's convex one.

MuJoCo's contacts are the solution of a convex problem. In it what friction does not stop of a slip adds mu times itself
to the direction of the normal, and what slides is thrown up: a box of coefficient 1 hops by 3 mm at 1 m/s, and a robot
that skids rocks from side to side and hardly turns. That share is taken off again before contacts are solved, as it was
in the step before; while a contact slides steadily its normal force comes within a factor mu^2 / (1 + mu^2) a step.

Source: De Saxce and Feng, The bipotential method, 1998; Acary and others, A formulation of the linear discrete Coulomb
friction problem via convex optimization, 2011. Cost: a product with the Jacobian a step. What breaks it: a coefficient
far above 1, with which it comes slowly.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

_TANGENTS = np.array([1, 2])
"""Rows of a contact's friction, after that of its normal."""


def slide(model: Any, data: Any) -> None:
    """Correct the references of contacts, between the making of constraints and their solution."""
    first = data.contact.efc_address
    is_active = first >= 0
    normals = first[is_active]
    if not len(normals):
        return
    change = np.empty(data.nefc)
    mujoco.mj_mulJacVec(model, data, change, data.qacc)
    reference = data.efc_aref
    tangents = normals[:, None] + _TANGENTS
    left = (change[tangents] - reference[tangents]) * data.contact.friction[is_active, :2]
    reference[normals] -= np.sqrt((left * left).sum(axis=1))
