"""The record of a Gazebo Classic server: where models were, to three digits, which is all that Gazebo writes."""

from __future__ import annotations

import re

from rsegen.simulation.simulators.live_world import Record

_STATE = re.compile(r"<sim_time>(\d+) (\d+)</sim_time>(.*?)</state>", re.DOTALL)
_MODEL = re.compile(r"<model name='([^']+)'>\s*<pose>([^<]+)</pose>")


def record_options(period: float) -> tuple[str, ...]:
    """A server's options, that record a state as text every `period` seconds."""
    return "--record_encoding", "txt", "--record_period", f"{period:g}"


def parse_record(text: str) -> Record:
    """The models of each recorded state."""
    return [
        (
            int(seconds) + int(nanos) / 1e9,
            {name: [float(number) for number in pose.split()] for name, pose in _MODEL.findall(models)},
        )
        for seconds, nanos, models in _STATE.findall(text)
    ]
