"""MuJoCo Playground: a field as the floor of its locomotion environments, and another one in each world (0.2).

    from mujoco_playground import locomotion
    from mujoco_playground._src.locomotion.go1 import go1_constants
    from rsegen.learning.playground import Floor

    floor, scene = Floor(recipe), go1_constants.FEET_ONLY_FLAT_TERRAIN_XML
    go1_constants.FEET_ONLY_FLAT_TERRAIN_XML = floor.write(scene, "rubble.xml")
    env = locomotion.load("Go1JoystickFlatTerrain", config_overrides={"impl": "jax"})
    training = wrapper.wrap_for_brax_training(env, randomization_fn=partial(floor.randomize, rng=keys))

Its robots start at a height above z = 0, which is here the top of the highest block near the middle of the field.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import mujoco
import numpy as np

from rsegen.errors import ParameterError, UserError, refuse_other
from rsegen.field.stepfield import Array, Ints, Levels, StepField
from rsegen.learning.blocks import BELOW
from rsegen.learning.ground import unframed
from rsegen.learning.tile import SAMPLES, corner_heights, highest_near, slope_length
from rsegen.params.sorts import Float, Integer
from rsegen.recipe.batch import build_many
from rsegen.recipe.recipe import Recipe

_BORDER, _RADIUS = Integer(0, 10_000), Float(0.01, 100)


class Floor:
    """The maps of a recipe as the height field that a scene of Playground has as its `floor`.

    border: width of the level ground around a map, in blocks; samples: of heights along each side of a block, which has
    a slope in place of each vertical side; spawn_radius: metres along x and y from the middle, where z = 0 is the top
    of the highest block
    """

    def __init__(self, recipe: Recipe, *, border: int = 10, samples: int = 4, spawn_radius: float = 1.0) -> None:
        refuse_other("recipe", recipe, Recipe)
        if recipe.boundary != "none" or not recipe.is_of_one_friction:
            name = "level_friction" if recipe.boundary == "none" else "boundary"
            raise ParameterError(name, "a height field has one friction and no frames; set only `friction`")
        self.recipe: Recipe = recipe
        self._border, self._samples = _BORDER.check("border", border), SAMPLES.check("samples", samples)
        self._radius = _RADIUS.check("spawn_radius", spawn_radius)
        self._first = self.field(build_many(recipe, [recipe.first_map])[0])
        low = float(self._first.heights.min())
        self._rise = float(self._first.heights.max()) - low or 1.0

    def field(self, levels: Levels) -> StepField:
        """Return a map (n_x, n_y) with its border."""
        own = np.pad(levels, self._border, constant_values=self.recipe.ground_level)
        return unframed(own, self.recipe.block_width_cm / 100, self.recipe.unit_cm / 100)

    def top(self, field: StepField) -> float:
        """Height of the highest block near the middle, metres, which is at z = 0 of the scene."""
        radius = self._radius + slope_length(field.block_width, self._samples)
        return highest_near(field, np.array(field.extent) / 2, radius)

    def scene(self, xml: str) -> str:
        """Return a scene of Playground, MJCF, whose floor is the first map: a plane or a height field is replaced."""
        root = ET.fromstring(xml)  # noqa: S314  # a file of Playground's own
        floors = [geom for geom in root.iter("geom") if geom.get("name") == "floor"]
        if len(floors) != 1:
            raise UserError(f"{len(floors)} geoms are named floor; expected a scene of Playground, which has one")
        asset = root.find("asset")
        if asset is None:
            asset = ET.SubElement(root, "asset")
        floor, heights = floors[0], corner_heights(self._first.heights, self._samples)
        for replaced in [field for field in asset.findall("hfield") if field.get("name") == floor.get("hfield")]:
            asset.remove(replaced)
        low = float(heights.min())
        n_x, n_y = heights.shape
        size = (*np.array(self._first.extent) / 2, self._rise, BELOW)
        ET.SubElement(
            asset,
            "hfield",
            name="rsegen",
            nrow=str(n_y),
            ncol=str(n_x),
            size=" ".join(f"{side:.9g}" for side in size),
            # MJCF has the row of the largest y first, and the compiler scales what it is given from 0 to 1.
            elevation=" ".join(f"{value:.9g}" for value in (heights - low).T[::-1].ravel()),
        )
        floor.attrib.pop("size", None)
        floor.attrib |= {"type": "hfield", "hfield": "rsegen", "friction": f"{self.recipe.friction:.9g}"}
        floor.set("pos", f"0 0 {low - self.top(self._first):.9g}")  # the lowest sample is at the geom's own z = 0
        return ET.tostring(root, encoding="unicode")

    def write(self, scene: Any, path: Any) -> Any:
        """Write the scene of a file with this floor to a path; gives the path as the type that the scene's has."""
        Path(path).write_text(self.scene(Path(scene).read_text("utf-8")), "utf-8")
        return type(scene)(path)

    def indices(self, rng: Any) -> list[int]:
        """Return the index of the map of each world by its key of jax; of a recipe of one map any index."""
        import jax

        words, recipe = np.asarray(jax.vmap(jax.random.bits)(rng)).tolist(), self.recipe
        return words if recipe.maps == 1 else [recipe.indices[word % recipe.maps] for word in words]

    def arrays(self, levels: Ints) -> tuple[Array, Array]:
        """Return `hfield_data` (worlds, samples) and z of the floor (worlds,), metres, for maps (worlds, n_x, n_y)."""
        # The compiled model has one rise for all worlds: samples are shares of that of its map, and may be above 1.
        fields = [self.field(own) for own in levels]
        lows = [float(field.heights.min()) for field in fields]
        data = [
            (corner_heights(field.heights, self._samples).T.ravel() - low) / self._rise
            for field, low in zip(fields, lows, strict=True)
        ]
        places = [low - self.top(field) for field, low in zip(fields, lows, strict=True)]
        return np.array(data, dtype=np.float32), np.array(places, dtype=np.float32)

    def randomize(self, model: Any, rng: Any) -> tuple[Any, Any]:
        """Return a model of MJX with a map for each key, and its in_axes: a `randomization_fn` of Playground."""
        import jax

        data, z = self.arrays(build_many(self.recipe, self.indices(rng)))
        floor = np.flatnonzero(np.asarray(model.geom_type) == mujoco.mjtGeom.mjGEOM_HFIELD).item()
        places = np.repeat(np.asarray(model.geom_pos)[None], len(z), axis=0)
        places[:, floor, 2] = z
        per_world = {"hfield_data": jax.numpy.asarray(data), "geom_pos": jax.numpy.asarray(places)}
        axes = jax.tree_util.tree_map(lambda _: None, model)
        return model.tree_replace(per_world), axes.tree_replace(dict.fromkeys(per_world, 0))
