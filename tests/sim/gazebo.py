"""A headless Gazebo Classic for tests: loads a world, simulates so many steps, tells what is where, and is gone."""

from __future__ import annotations

import math
import os
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from sim.messages import Message, parse

HARMLESS = ("Can't open display", "Unable to open audio device", "Header is empty", "Data was empty, try again")
"""Errors of every server that has neither screen nor loudspeaker, and of those that a `gz` command has just left."""

ATTEMPTS = 4
"""Gazebo 11.1's server now and then dies or hangs while a `gz` command connects to it or leaves."""

PATIENCE = 20.0
"""Seconds for a world to load, and for a server to answer."""

SET_UP = Path(".cache", "rsegen", "gazebo-classic")
"""Where scripts/gazebo-classic sets it up, below the user's home."""

_COLOUR_CODE = re.compile(r"\x1b\[[0-9;]*m")


class Lost(Exception):
    """A server that died or no longer answers; the end of its log."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Pose:
    """Where a model stands, metres, and how it is turned, radians."""

    x: float
    y: float
    z: float
    yaw: float
    pitch: float = 0.0
    roll: float = 0.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Run:
    """What a world was like at its end: where every model stood, and the error lines of the server's log."""

    poses: Mapping[str, Pose]
    errors: Sequence[str]


@dataclass(frozen=True, kw_only=True, slots=True)
class Gazebo:
    """An installed Gazebo Classic 11: the folder that holds `gzserver` and `gz`."""

    commands: Path
    patience: float = PATIENCE

    def run(self, world: Path, steps: int, models: Path | None = None) -> Run:
        """Simulate a world from its beginning; `models` is the folder where model:// is looked for.

        The server runs in the world's folder, against which Gazebo 11.1 resolves relative mesh URIs. The same world
        and steps give the same poses; a world with which every attempt is lost raises Lost.
        """
        return self._attempt(world, steps, models, left=ATTEMPTS - 1)

    def _attempt(self, world: Path, steps: int, models: Path | None, left: int) -> Run:
        try:
            return self._once(world, steps, models)
        except Lost:
            if not left:
                raise
        return self._attempt(world, steps, models, left - 1)

    def _once(self, world: Path, steps: int, models: Path | None) -> Run:
        with self.serving(world, models) as server:
            server.step(steps)
            return Run(poses=server.poses(), errors=server.errors())

    @contextmanager
    def serving(self, world: Path, models: Path | None = None, *recording: str) -> Iterator[Server]:
        """A server that has loaded a world and stands still; its record begins when the world is complete."""
        with tempfile.TemporaryDirectory() as home:
            environment = _environment(home, models)
            record, log = Path(home, "record"), Path(home, "log")
            options = ["--verbose", "--pause", "--record", "--record_path", str(record), *recording]
            command = [str(self.commands / "gzserver"), *options, world.name]
            with log.open("w") as output, _started(command, environment, world.parent, output) as process:
                state = record / "state.log"
                server = Server(gz=self.commands / "gz", environment=environment, log=log, state=state, process=process)
                server.wait_for(state, self.patience)
                yield server


@dataclass(frozen=True, kw_only=True, slots=True)
class Server:
    """A running server, which stands still unless it is stepped."""

    gz: Path
    environment: Mapping[str, str]
    log: Path
    state: Path
    process: subprocess.Popen[str]

    def wait_for(self, file: Path, patience: float) -> None:
        """Wait until the server has made a file."""
        end = time.monotonic() + patience
        while not file.exists():
            if self.process.poll() is not None or time.monotonic() > end:
                raise Lost(self._end_of_log())
            time.sleep(0.02)

    def step(self, steps: int) -> None:
        """Simulate so many steps, as fast as the world's physics allows."""
        self.begin(steps)
        done, end = 0, time.monotonic() + PATIENCE
        while done < steps:
            before, done = done, self._steps()
            end = time.monotonic() + PATIENCE if done > before else end
            if time.monotonic() > end:
                raise Lost(f"stands still at step {done} of {steps}")

    def begin(self, steps: int) -> None:
        """Have it simulate so many steps, and do not wait for them."""
        self._gz("world", "--multi-step", str(steps))

    def told(self, *arguments: str) -> None:
        """Run a command of `gz`; one that sends a message returns when a subscriber has been sent it."""
        if "Unable" in (answer := self._gz(*arguments)):
            raise Lost(answer)

    def end(self) -> None:
        """Have it finish its record and go."""
        _end(self.process)

    def poses(self) -> dict[str, Pose]:
        """Where every model stands, by its name."""
        told = self._told("topic", "--request", "entity_list")
        models = parse(told).parts.get("models")
        if not models:
            raise Lost(f"no models in: {told}")
        return {model.values["name"]: _pose(model.parts["pose"][0]) for model in models}

    def links(self) -> dict[str, Pose]:
        """Where every link stands in its model, by its full name."""
        models = parse(self._told("topic", "--request", "entity_list")).parts["models"]
        links = [link for model in models for link in model.parts["link"]]
        return {link.values["name"]: _pose(link.parts["pose"][0]) for link in links}

    def errors(self) -> list[str]:
        """The error lines of the log so far, without the harmless ones."""
        return [line for line in self._lines() if "[Err]" in line and not any(known in line for known in HARMLESS)]

    def _steps(self) -> int:
        """How many steps have been simulated since the start."""
        told = self._told("topic", "--echo", "~/world_stats", "--unformatted", "--duration", "1")
        counts = re.findall(r"iterations: (\d+)", told)
        if not counts:
            raise Lost(f"no count of iterations in: {told}")
        return int(counts[-1])

    def _told(self, *arguments: str) -> str:
        """What a `gz` command prints, which is something."""
        if told := self._gz(*arguments):
            return told
        raise Lost(self._end_of_log())

    def _gz(self, *arguments: str) -> str:
        with _started([str(self.gz), *arguments], self.environment, Path.cwd(), subprocess.PIPE) as command:
            try:
                return command.communicate(timeout=PATIENCE)[0]
            except subprocess.TimeoutExpired:
                raise Lost(self._end_of_log()) from None

    def _end_of_log(self) -> str:
        return "\n".join(["the server is dead or silent; its log ends with:", *self._lines()[-20:]])

    def _lines(self) -> list[str]:
        return _COLOUR_CODE.sub("", self.log.read_text(errors="replace")).splitlines()


def installed() -> Gazebo | None:
    """A Gazebo Classic 11: the one on PATH, else the one that scripts/gazebo-classic has set up."""
    on_path = shutil.which("gzserver")
    set_up = Path.home() / SET_UP
    folders = [Path(on_path).parent] if on_path else []
    folders += [set_up / "bin"] if (set_up / "complete").exists() else []
    found = (folder for folder in folders if "version 11" in printed(str(folder / "gzserver"), "--version"))
    commands = next(found, None)
    return Gazebo(commands=commands) if commands else None


def printed(*command: str) -> str:
    """Both outputs of a command; nothing where there is no such command or it does not end."""
    try:
        return subprocess.run(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60, check=False
        ).stdout
    except (FileNotFoundError, subprocess.TimeoutExpired):
        return ""


def _environment(home: str, models: Path | None) -> dict[str, str]:
    """A port, a home and a log folder of its own; no model database in the internet, no screen."""
    inherited = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    return inherited | {
        "HOME": home,
        "GAZEBO_IP": "127.0.0.1",
        "GAZEBO_MASTER_URI": f"http://127.0.0.1:{_free_port()}",
        "GAZEBO_MODEL_DATABASE_URI": "",
        "GAZEBO_MODEL_PATH": str(models or ""),
    }


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


@contextmanager
def _started(
    command: Sequence[str], environment: Mapping[str, str], folder: Path, output: IO[str] | int
) -> Iterator[subprocess.Popen[str]]:
    """A process in a group of its own, which is ended with all that it started."""
    process = subprocess.Popen(
        command, env=environment, cwd=folder, stdout=output, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )
    try:
        yield process
    finally:
        _end(process)


def _end(process: subprocess.Popen[str]) -> None:
    """Ask first; what hangs at its exit is killed."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
    try:
        process.wait(5)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    if process.stdout:
        process.stdout.close()


def _pose(message: Message) -> Pose:
    x, y, z = message.parts["position"][0].numbers("x", "y", "z")
    a, b, c, w = message.parts["orientation"][0].numbers("x", "y", "z", "w")
    yaw = math.atan2(2 * (w * c + a * b), 1 - 2 * (b * b + c * c))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * b - c * a))))
    roll = math.atan2(2 * (w * a + b * c), 1 - 2 * (a * a + b * b))
    return Pose(x=x, y=y, z=z, yaw=yaw, pitch=pitch, roll=roll)
