"""A world of an embedded simulator in its own process, in which time runs as in a server until it is paused.

So its cost can be measured like a Gazebo's, by the CPU time and memory of a process. Requests and answers are pickled
values on the process's stdin and stdout; it simulates between them, in pieces of some milliseconds, in real time or as
fast as it can. It ends with its stdin, so with the program that has started it. Cost: a look for a request per piece.
What breaks it: a world that needs longer for a piece than somebody waits for an answer.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from queue import Empty, SimpleQueue
from threading import Thread
from typing import IO, Any, NoReturn

from rsegen.errors import RsegenError, SimulatorFailed
from rsegen.params.plugins import failure, failure_of_plugin, with_plugins
from rsegen.recipe.recipe import Recipe
from rsegen.robots.lookup import DrivableRobot
from rsegen.scene.scene import compose
from rsegen.simulators.embedded import EmbeddedWorld, PlacedRobot, embedded_simulator
from rsegen.simulators.live_world import Clock, RunningWorld
from rsegen.simulators.poses import Pose

_PIECE = 0.02
"""Simulated seconds between two looks for a request."""

_NEVER = 1e9
"""Seconds between two rows of a record that nobody reads."""

_GOES = 10.0
"""Seconds within which the process ends when its stdin does; it is killed then."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Task:
    """The task of a process: a map of a recipe, robots at their starts, in real time or as fast as it can."""

    simulator: str
    recipe: Recipe
    robots: Sequence[PlacedRobot]
    is_real: bool


class EmbeddedProcess(RunningWorld):
    """A world in a process. SimulatorFailed if its physics fails, or the process has ended."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process, self.pid = process, process.pid

    def clock(self) -> Clock:
        """Return the clock now."""
        return Clock(**self._ask("clock"))

    def poses(self) -> Mapping[str, Pose]:
        """Return the pose of every robot, by its name."""
        return dict(self._ask("poses"))

    def drive(self, name: str, robot: DrivableRobot, v: float, w: float) -> None:
        """Have a robot drive at v, m/s forward, and w, rad/s counterclockwise, from now on."""
        self._ask("drive", name, v, w)

    def step(self, steps: int) -> None:
        """Simulate this number of steps of a paused world, as fast as possible."""
        self._ask("step", steps)

    def pause(self) -> None:
        """Stop simulation time."""
        self._ask("pause")

    def unpause(self) -> None:
        """Let simulation time run."""
        self._ask("unpause")

    def _ask(self, method: str, *values: object) -> Any:
        """Return the answer of a method of _Runner in the process."""
        try:
            _send(self._process.stdin, (method, values))
            is_done, answer = pickle.load(self._process.stdout)  # type: ignore[arg-type]  # noqa: S301  # of our process
        except (EOFError, OSError, pickle.UnpicklingError):
            raise SimulatorFailed("the process of the simulator has ended") from None
        if not is_done:
            raise SimulatorFailed(answer)
        return answer


@contextmanager
def world_in_process(task: Task) -> Iterator[EmbeddedProcess]:
    """Yield the world of a task, paused, in a process that ends with this context; SimulatorFailed if it cannot."""
    process = subprocess.Popen(
        [sys.executable, "-m", "rsegen.simulators.embedded_process"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONSAFEPATH": "1"},  # it imports nothing from this folder
        start_new_session=True,  # Ctrl-C is for us
    )
    try:
        world = EmbeddedProcess(process)
        try:
            _send(process.stdin, with_plugins(partial(_loaded, task)))
        except OSError:
            raise SimulatorFailed("the process of the simulator has ended") from None
        world.clock()  # when it is loaded
        yield world
    finally:
        for pipe in filter(None, (process.stdin, process.stdout)):
            with suppress(OSError):  # what was to be sent is for nobody
                pipe.close()
        try:
            process.wait(_GOES)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _send(pipe: IO[bytes] | None, value: object) -> None:
    assert pipe is not None  # noqa: S101  # each process has its pipes
    pickle.dump(value, pipe)
    pipe.flush()


# In the process.


class _Runner:
    """A world that runs by the clock between requests: simulated seconds, and wall seconds without pauses."""

    def __init__(self, task: Task, world: EmbeddedWorld) -> None:
        self._world, self._is_real = world, task.is_real
        self._robots = {placed.name: placed.robot for placed in task.robots}
        self._steps, self._real = 0, 0.0
        self._since: float | None = None  # when it was unpaused

    @property
    def is_running(self) -> bool:
        """Return whether time runs."""
        return self._since is not None

    def go_on(self) -> float:
        """Simulate a piece, and return the seconds to wait until the next one."""
        self.step(round(_PIECE / self._world.step_seconds))
        return max(self._simulated - self._wall, 0.0) if self._is_real else 0.0

    def clock(self) -> dict[str, Any]:
        """Return the values of a Clock."""
        values = {"simulated": self._simulated, "real": self._wall}
        return values | {"steps": self._steps, "paused": not self.is_running}

    def poses(self) -> dict[str, Pose]:
        """Return the poses of all robots."""
        return dict(self._world.poses())

    def drive(self, name: str, v: float, w: float) -> None:
        """Have a robot drive."""
        self._world.drive(name, self._robots[name], v, w)

    def step(self, steps: int) -> None:
        """Simulate steps."""
        self._world.step(steps)
        self._steps += steps

    def pause(self) -> None:
        """Stop time."""
        self._real, self._since = self._wall, None

    def unpause(self) -> None:
        """Let time run."""
        self._since = self._since or time.monotonic()

    @property
    def _simulated(self) -> float:
        return round(self._steps * self._world.step_seconds, 6)

    @property
    def _wall(self) -> float:
        return self._real + (time.monotonic() - self._since if self._since else 0.0)


def _loaded(task: Task) -> _Runner:
    simulator = embedded_simulator(task.simulator)
    assert simulator is not None  # noqa: S101  # it was chosen by its name
    return _Runner(task, simulator.world(compose(task.recipe), task.robots, period=_NEVER))


def _answer(runner: _Runner, request: tuple[str, Sequence[Any]]) -> tuple[bool, Any]:
    """Return whether a request is met, and the answer, or why it is not."""
    method, values = request
    try:
        return True, getattr(runner, method)(*values)
    except (Exception, SystemExit) as error:  # it may be a plug-in's simulator, and fail in any way
        return False, _reason(error)


def _reason(error: BaseException) -> str:
    """Return why the simulator cannot go on, in words."""
    return str(error) if isinstance(error, RsegenError) else failure_of_plugin(error) or failure(error)


def _next(requests: SimpleQueue[Any], runner: _Runner) -> Any:
    """Return the next request, None for the end; the world goes on until there is one, if time runs."""
    # Seconds to wait for a request: without end while it is paused (None), not at all if no time is left (0).
    wait: float | None = None
    while True:
        if runner.is_running:
            wait = runner.go_on()
        try:
            return requests.get(block=wait != 0.0, timeout=wait)
        except Empty:
            continue


def _run(requests: SimpleQueue[Any], answers: IO[bytes]) -> None:
    """Load the world of the first request, and answer the others until the last one, or until the physics fails."""
    try:
        runner = requests.get()()
        while (request := _next(requests, runner)) is not None:
            _send(answers, _answer(runner, request))
    except BrokenPipeError:
        raise
    except (Exception, SystemExit) as error:  # between two requests: the next ones get the reason
        while requests.get() is not None:
            _send(answers, (False, _reason(error)))


def main() -> NoReturn:
    """Simulate what comes by stdin, until it ends."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print is no answer
    requests: SimpleQueue[Any] = SimpleQueue()

    def read() -> None:
        try:
            while True:
                requests.put(pickle.load(sys.stdin.buffer))  # noqa: S301  # of the program that has started this one
        except EOFError:
            pass
        finally:  # also if what comes cannot be unpickled
            requests.put(None)

    Thread(target=read, daemon=True).start()
    with suppress(BrokenPipeError):  # nobody waits for an answer
        _run(requests, answers)
    os._exit(0)  # the thread may wait for a request


if __name__ == "__main__":
    main()
