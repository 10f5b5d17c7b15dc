"""Every launch file of this package can be loaded, and every map has all of its files."""

from pathlib import Path

from launch.launch_description_sources import get_launch_description_from_python_launch_file
import pytest

PACKAGE = Path(__file__).absolute().parents[1]
LAUNCH_FILES = sorted((PACKAGE / 'launch').glob('*.launch.py'))
MAPS = sorted(path.stem for path in (PACKAGE / 'worlds').glob('*.world'))


@pytest.mark.parametrize('file', LAUNCH_FILES, ids=lambda file: file.name)
def test_launch_file_can_be_loaded(file):
    """Read it as ros2 launch does; nothing is started."""
    assert get_launch_description_from_python_launch_file(str(file)).entities


@pytest.mark.parametrize('name', MAPS)
def test_map_is_complete(name):
    """Look for what the launch files open."""
    for path in (
        f'maps/{name}/map.yaml', f'maps/{name}/map.pgm', f'maps/{name}/start_poses.json',
        f'maps/{name}/elevation.json', f'maps/{name}/elevation.npy', f'maps/{name}/friction.npy',
        f'models/{name}/model.sdf', f'urdf/{name}/{name}.urdf',
    ):
        assert (PACKAGE / path).is_file(), path
