"""A robot."""

from __future__ import annotations

from dataclasses import replace

from rsegen.robots.lookup import robot_of_kind

TALL_BURGER = replace(robot_of_kind("burger"), kind="tall_burger", title="a Burger with larger wheels", climbs=0.05)
