"""The settings of MuJoCo's physics, each with its reason; docs/mujoco.md has what was measured."""

STEP = 0.001
"""Seconds of a step, as in Gazebo Classic."""

OPTION = {
    "timestep": f"{STEP}",
    "integrator": "implicitfast",
    "cone": "elliptic",
    "impratio": "100",
    "ccd_tolerance": "1e-10",
    "ccd_iterations": "200",
}
"""implicitfast: motors and servos may be stiff. elliptic: friction is as strong along a diagonal. impratio: a robot
that stands on a slope creeps by less.

A wheel of radius r with friction mu rolls up a step h <= r (1 - 1 / sqrt(1 + mu^2)): 9.7 mm for 33 mm and mu = 1. With
this tolerance of the search for contacts it rolls up 9.8 mm, with the default 11.6 mm."""

MULTICCD = "disable"
"""Several contacts of two convex shapes, on by default since 4.0, hold a cylinder at an edge of any height."""

SOLREF, SOLIMP = "0.004 1", "0.8 0.8 0.0001"
"""Contacts as stiff as four steps allow: a robot sinks in by some 10 micrometres. With `slide`, robots that skid turn
as Coulomb's law says at any stiffness: a jackal's sides run against each other 1.487 times as fast as they would roll
(1.487 by statics, 1.5 in its maker's settings), the crawler's 1.19 times (1.19 by statics), at all rates. The share of
0.8 by which a contact is a constraint and not a spring lets a robot between two blocks give way by as little: with 0.99
the crawler is wedged at the frame of README's course at each of 7 starts, with 0.8 it crosses from all 7, as in Gazebo
Classic, and in the same time."""

MOTOR_SOLREF, MOTOR_SOLIMP = (0.004, 1), (0.9999, 0.9999, 0.001, 0.5, 2)
"""Motors of wheels, and joints that follow others: half of a difference in speed is left after a step, and hardly any
under a load."""

TORSIONAL, ROLLING = 0.005, 0.0001
"""Friction coefficients about and along a contact, MuJoCo's defaults; contacts here have sliding friction alone."""

MEMORY = "200M"
"""Memory for contacts and constraints: 40 x 40 blocks with a hundred robots take a tenth."""
