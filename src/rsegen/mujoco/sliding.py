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


def slide(model: Any, data: Any, contact: Any) -> None:
    """Correct the references of contacts, `data.contact`, between the making of constraints and their solution."""
    if not data.ncon:
        return
    # A robot has some ten contacts. For so few, Python's numbers take a quarter of the time of numpy's arrays.
    change = np.empty(data.nefc)
    mujoco.mj_mulJacVec(model, data, change, data.qacc)
    reference = data.efc_aref
    before, left = reference.tolist(), (change - reference).tolist()
    for at, (mu, mu2) in zip(contact.efc_address.tolist(), contact.friction[:, :2].tolist(), strict=True):
        if at >= 0:  # none for one that is near, and does not touch
            reference[at] = before[at] - abs(complex(mu * left[at + 1], mu2 * left[at + 2]))
