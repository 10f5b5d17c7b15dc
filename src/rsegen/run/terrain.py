"""What is known of the tiles of a terrain, as the file next to its world."""

from __future__ import annotations

import json

from rsegen.recipe.terrain import Terrain


def tiles_json(terrain: Terrain, robot_size: tuple[float, float] | None = None) -> bytes:
    """Return the content of NAME_0000.json: difficulty, kind and origin of each tile; metres, radians.

    robot_size: length and width of a robot, for which each tile gets an even place to start
    """
    spots = {} if robot_size is None else {"spots": terrain.spots(robot_size, evenest=True)[:, :, 0].tolist()}
    known = {
        "name": terrain.name,
        "tile_size": list(terrain.tile_size),
        "difficulty": terrain.difficulties.tolist(),
        "kinds": list(terrain.kinds),
        "origins": terrain.origins.tolist(),
        **spots,
    }
    return json.dumps(known).encode() + b"\n"
