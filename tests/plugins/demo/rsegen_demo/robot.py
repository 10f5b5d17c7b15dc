"""A robot."""

from __future__ import annotations

from dataclasses import replace

from rsegen.robots.lookup import robot

TALL_BURGER = replace(robot("burger"), kind="tall_burger", title="a Burger with larger wheels", climbs=0.05)
