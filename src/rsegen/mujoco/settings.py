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
"""Contacts as stiff as four steps allow: a robot sinks in by some 40 micrometres. The share of 0.8 by which a contact
is a constraint and not a spring is the largest with which robots that skid turn as Coulomb's law says (`let_slide` of
shapes): a jackal's sides run against each other 1.49 times as fast as they would roll (1.487 by statics, 1.5 in its
maker's settings), the crawler's 1.19 times (1.19 by statics), at all rates; with 0.85 the crawler's run 1.04 times at
1.5 rad/s, with 0.99 once."""

TORSIONAL, ROLLING = 0.005, 0.0001
"""Friction coefficients about and along a contact, MuJoCo's defaults; contacts here have sliding friction alone."""

MEMORY = "200M"
"""Memory for contacts and constraints: of 40 x 40 blocks with a hundred robots a tenth."""
