"""The result of a drive: what was driven, the metrics and trajectory of every robot, and the files of them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path, PurePosixPath

from rsegen.exporters.scene import Scene
from rsegen.recipe.codec import map_json
from rsegen.run.store import write_folder
from rsegen.simulation.driving.contacts import ContactSamples, contacts_csv
from rsegen.simulation.driving.drive_metrics import DriveMetrics, Trajectory
from rsegen.simulation.driving.routes import Wandering
from rsegen.simulation.driving.trajectory_plot import draw_trajectories
from rsegen.simulation.driving.way import PlannedWay
from rsegen.simulation.simulators.live_world import Pose

_PARTS = 5
"""The parts of a robot with the most contacts that are reported; drive.json has all."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class DrivenRobot:
    """One robot of a drive: its name in the world, kind, start pose, metrics and trajectory."""

    name: str
    kind: str
    start: Pose
    metrics: DriveMetrics
    trajectory: Trajectory


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class DriveResult:
    """What `rsegen.drive` gives.

    scene: the map; simulator: title and version; errors: the simulator's error lines; notes: what it does not give;
    contact_samples: simulated seconds and the contacts at that time; way: the one that the robots followed, on that
    route; image: a JPEG of Gazebo's own camera, empty without `picture`.
    """

    scene: Scene
    simulator: str
    route: str
    seed: int
    robots: tuple[DrivenRobot, ...]
    errors: tuple[str, ...]
    contact_samples: ContactSamples
    notes: tuple[str, ...] = ()
    way: PlannedWay | None = None
    image: bytes = b""

    def as_json(self) -> dict[str, object]:
        """The content of drive.json, which `rsegen drive --json` prints."""
        robots = [
            {"name": each.name, "kind": each.kind, "start": asdict(each.start), **asdict(each.metrics)}
            for each in self.robots
        ]
        return {
            "map": self.scene.name,
            "simulator": self.simulator,
            "route": self.route,
            "seed": self.seed,
            **({"way": self.way.as_json()} if self.way else {}),
            "robots": robots,
            "errors": list(self.errors),
            "notes": list(self.notes),
        }

    def report(self) -> Iterator[str]:
        """What `rsegen drive` prints: a line per robot, its contacts, notes and warnings."""
        yield f"{self.scene.name} in {self.simulator}, {self.route}, seed {self.seed}:"
        if self.way:
            yield f"  {_foreseen(self.way)}"
        for robot in self.robots:
            found = robot.metrics
            crossed = "" if self.route == Wandering.name else _crossed(found)
            tipped = f", tipped over {found.tipped}x" if found.tipped else ""
            driven = f"{found.distance:.2f} m in {found.seconds:g} s"
            yield f"  {robot.name}: {driven}{crossed}, stuck {found.stuck:g} s{tipped}"
            if found.touched:
                most = list(found.touched.items())[:_PARTS]
                yield "    contacts of " + ", ".join(f"{part} {share:.0%}" for part, share in most)
        yield from (f"note: {line}" for line in self.notes)
        yield from (f"warning: {line}" for line in dict.fromkeys(self.errors))

    def write(self, folder: str | Path, *, force: bool = False) -> None:
        """Write trajectories, contacts, metrics and pictures into a folder; `force` replaces an earlier drive."""
        write_folder(self._files(), Path(folder), "drive", force=force)

    def _files(self) -> dict[PurePosixPath, list[bytes]]:
        trajectories = {each.name: each.trajectory for each in self.robots}
        files = {f"{name}.csv": _encoded(trajectory.csv()) for name, trajectory in trajectories.items()} | {
            "contacts.csv": _encoded(contacts_csv(self.contact_samples, trajectories)),
            "recipe.json": [map_json(self.scene.recipe, self.scene.index)],
            "drive.json": [json.dumps(self.as_json(), indent=2).encode() + b"\n"],
            "drive.png": [draw_trajectories(self.scene, trajectories, self.way)],
        }
        if self.way:
            files["way.csv"] = _encoded(self.way.csv())
        pictures = {"gazebo.jpg": [self.image]} if self.image else {}
        return {PurePosixPath(name): content for name, content in (files | pictures).items()}


def _foreseen(way: PlannedWay) -> str:
    """What the metrics say of the way that the robots follow."""
    said = {True: "; the robot can climb it", False: "; the robot cannot climb it", None: ""}
    return f"the way across needs a step of {way.least_step * 100:g} cm{said[way.crosses]}"


def _crossed(found: DriveMetrics) -> str:
    return f", crossed the map after {found.crossed:g} s" if found.crossed is not None else ", did not cross the map"


def _encoded(lines: Iterable[str]) -> list[bytes]:
    return [line.encode() for line in lines]
