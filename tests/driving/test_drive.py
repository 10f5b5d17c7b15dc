"""`rsegen.drive` refuses wrong values before anything is started, and names the parameter."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

import rsegen
from rsegen.errors import FileError, NoSimulator, ParameterError
from rsegen.robots.lookup import robot_of_kind
from rsegen.simulators.embedded import EMBEDDED
from tests.simulators.standins import PROGRAMS, put

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the stand-ins are shell scripts")
RECIPE = rsegen.Recipe(name="course", seed=1, chunk_size=2)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"robot": "burgr"}, "robot: unknown robot 'burgr'; did you mean 'burger'"),
        ({"robots": 0}, "robots: 0 is outside 1..100"),
        ({"duration": 0}, r"duration: 0 is outside 0\.1\.\."),
        ({"route": "strait"}, "route: 'strait' is not one of straight, random"),
        ({"seed": -1}, r"seed: -1 is outside 0\.\."),
        ({"map": 7}, "map: there is no map 7 in the recipe; use an index or name, course_0000$"),
        ({"speed": 1}, "speed: is for the robot of a file; 'burger' has its own"),
        ({"robot": robot_of_kind("jackal"), "turn": 1}, "turn: is for the robot of a file; 'jackal' has its own"),
        ({"picture": True}, "picture: needs a folder"),
        ({"picture": True, "output": "out", "simulator": "classic"}, "picture: Gazebo's camera needs a screen"),
        ({"simulator": "clasic"}, "simulator: unknown simulator 'clasic'; did you mean 'classic'"),
        ({"simulator": "gazebo"}, "simulator: unknown simulator 'gazebo'; did you mean 'sim' or 'classic'"),
        ({"simulator": "classic", "motors": "reaction"}, "motors: is for MuJoCo; 'classic' has its own motors"),
        ({"video": True}, "video: needs a folder"),
    ],
)
def test_wrong_values_name_the_parameter(given: dict[str, Any], message: str, programs: Path) -> None:
    with pytest.raises(ParameterError, match=f"^{message}"):
        rsegen.drive(RECIPE, **given)


def test_a_world_without_a_recipe_is_refused(programs: Path, tmp_path: Path) -> None:
    put(programs, PROGRAMS["classic"])
    world = tmp_path / "other.world"
    world.write_text("<sdf version='1.6'><world name='other'/></sdf>")
    with pytest.raises(FileError, match=r"other\.world: no recipe\.json next to it"):
        rsegen.drive(world)


@pytest.mark.parametrize(("output", "said"), [("out", "nothing was changed in out"), (None, "")])
@pytest.mark.parametrize("recorder", ["record_drive", "record_embedded"])
def test_a_drive_that_is_stopped_changes_nothing(
    recorder: str, output: str | None, said: str, programs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    if recorder == "record_embedded" and not EMBEDDED:
        pytest.skip("the capability mujoco is not here")
    put(programs, PROGRAMS["classic"])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(f"rsegen.driving.recording.{recorder}", stopped)
    with pytest.raises(KeyboardInterrupt, match=f"^{said}$"):
        rsegen.drive(RECIPE, output=output, simulator="classic" if recorder == "record_drive" else None)
    assert not any(tmp_path.joinpath("out").glob("**"))


def test_without_gazebo_classic_the_script_says_how_to_install_it(programs: Path) -> None:
    with pytest.raises(NoSimulator, match="Gazebo Classic is not installed; to install it: "):
        rsegen.drive(RECIPE, simulator="classic")
