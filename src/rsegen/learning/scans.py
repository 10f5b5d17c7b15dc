"""Scans of the ground with the errors of sensors and maps: noise, steps, lost rays, a delay, a map that drifts.

    sensor = ScanSensor(pattern=scan_points(), noise=0.02, dropout=0.05, delay=2)
    state = sensor.start(ground, poses)                          # at a reset
    seen, state = sensor.sense(ground, poses, state, rng)        # at each step, (..., points)

Idea: the sensor has no memory of its own. What it remembers, the last scans and the drift of each robot, is a value
that goes in and comes out, so all of it can be compiled (`jax.jit`) and stays on the device. Errors come in the order
of a real sensor: the map is next to the robot, a ray is noisy, a number has steps, a ray is lost, the message is late.

Random numbers come from a Generator of numpy or torch, or from a key of jax, each of the library of the ground.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from numbers import Real
from typing import Annotated, Any, NamedTuple

from rsegen.errors import ParameterError, shown
from rsegen.learning.arrays import array_like, draws_of, library_of
from rsegen.learning.ground import Ground
from rsegen.learning.patterns import check_pattern, scan_points
from rsegen.params.sorts import Float, Integer, validate


class ScanState(NamedTuple):
    """State of a sensor: the last scans, (delay + 1, ..., points), newest first; the drift, (..., 3), metres."""

    scans: Any
    drift: Any


@dataclass(frozen=True, kw_only=True, slots=True)
class ScanSensor:
    """A sensor of the heights around robots; without its errors it gives `Ground.scan`.

    Parameters
    ----------
    pattern : array, shape (points, 2), optional
        x and y in the robot's frame, metres, by default `scan_points()`; an array of the device is sent there once.
    lost : float, default 0
        Height of a ray that does not come back, metres from the robot's z.
    """

    pattern: Any = field(default_factory=scan_points, compare=False)
    noise: Annotated[float, Float(0, 1000, unit="m", help="standard deviation of each height")] = 0.0
    step: Annotated[float, Float(0, 1000, unit="m", help="heights are multiples of this; 0: any")] = 0.0
    dropout: Annotated[float, Float(0, 1, help="share of rays that do not come back")] = 0.0
    delay: Annotated[int, Integer(0, 1000, help="scans by which what is seen is late")] = 0
    drift: Annotated[
        float, Float(0, 1000, unit="m", help="standard deviation of what a map drifts along x, y and z, per scan")
    ] = 0.0
    lost: float = 0.0

    def __post_init__(self) -> None:
        validate(self)
        _, pattern = library_of("pattern", self.pattern)
        check_pattern(pattern)
        lost: object = self.lost  # a number, and NaN too, which marks lost rays
        if not isinstance(lost, Real):
            raise ParameterError("lost", f"{shown(lost)} is not a number, in metres")
        object.__setattr__(self, "pattern", pattern)

    def start(self, ground: Ground, poses: Any, worlds: Any = None) -> ScanState:
        """Return the state at a reset: nothing has drifted, and the past scans are the one from here, without errors.

        poses: (..., 4), x, y, z [m], yaw, as for `Ground.scan`.
        """
        poses = ground.own("poses", poses, 4)
        scan = ground.scan(self.pattern, poses, worlds)
        return ScanState(ground.library.stack([scan] * (self.delay + 1), 0), 0.0 * poses[..., :3])

    def restart(self, state: ScanState, is_new: Any, fresh: ScanState) -> ScanState:
        """Return a state that is `fresh` for robots for which `is_new` (...,) is true, and as it was for the others."""
        library, scans = library_of("state", state.scans)
        mask = array_like(scans, library_of("is_new", is_new)[1])
        if tuple(mask.shape) != tuple(state.drift.shape[:-1]):
            problem = f"of shape {tuple(mask.shape)}; expected {tuple(state.drift.shape[:-1])}, one for each robot"
            raise ParameterError("is_new", problem)
        pairs = zip(state, fresh, strict=True)
        return ScanState(*(library.where(mask[..., None] != 0, new, old) for old, new in pairs))

    def sense(
        self, ground: Ground, poses: Any, state: ScanState, random: Any, worlds: Any = None
    ) -> tuple[Any, ScanState]:
        """Return what is seen, (..., points), metres from each robot's z, and the next state.

        random: a Generator of numpy or torch, None for torch's own, or a key of jax, which is another one at each call.
        """
        poses, library = ground.own("poses", poses, 4), ground.library
        if len(state.scans) != self.delay + 1:
            raise ParameterError(
                "state", f"of {len(state.scans)} scans for a delay of {self.delay}; use that of `start`"
            )
        if state.drift.shape != poses[..., :3].shape:
            robots = tuple(poses.shape[:-1])
            raise ParameterError(
                "state", f"of robots of shape {tuple(state.drift.shape[:-1])}; the poses are of {robots}"
            )
        if state.scans.shape[-1] != len(self.pattern):
            problem = f"of {state.scans.shape[-1]} points for a pattern of {len(self.pattern)}; use that of `start`"
            raise ParameterError("state", problem)
        # A map that drifts is scanned as by a robot that drifts the other way: its pose takes the drift.
        draws = draws_of(random, library)
        drift = state.drift + self.drift * next(draws)("normal", state.drift) if self.drift else state.drift
        moved = library.concatenate([poses[..., :3] + drift, poses[..., 3:]], -1)
        scan = ground.scan(self.pattern, moved, worlds)
        if self.noise:
            scan = scan + self.noise * next(draws)("normal", scan)
        if self.step:
            scan = library.round(scan / self.step) * self.step
        if self.dropout:
            scan = library.where(next(draws)("uniform", scan) < self.dropout, self.lost, scan)
        scans = library.concatenate([scan[None], state.scans[:-1]], 0)
        return scans[self.delay], ScanState(scans, drift)
