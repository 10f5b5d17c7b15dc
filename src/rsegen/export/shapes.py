"""What is seen and touched of a field: its mesh files, and the shapes of a model that uses them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rsegen.export import sdf
from rsegen.export.obj import mtl, obj
from rsegen.geometry import boxes, meshes, single_boxes, windows
from rsegen.scene import Scene
from rsegen.stepfield import StepField, Window


def mesh_files(scene: Scene, field: StepField, stem: str) -> dict[str, Iterable[bytes]]:
    """The meshes of a field by their path in the map's folder, and the colours; made as they are read."""
    found: dict[str, Iterable[bytes]] = {
        uri: obj(meshes(field, scene.recipe.mesh, part), f"{scene.name}.mtl")
        for uri, part in _parts(scene, field, stem)
    }
    return found | ({f"meshes/{scene.name}.mtl": mtl(scene)} if found else {})


def seen(scene: Scene, field: StepField, stem: str, root: str = "") -> Iterator[sdf.Shape]:
    """The meshes as shapes; their URIs start with `root`."""
    uris = [uri for uri, _ in _parts(scene, field, stem)]
    for number, uri in enumerate(uris):
        yield sdf.mesh(f"visual_{number}" if len(uris) > 1 else "visual", root + uri)


def touched(scene: Scene, field: StepField, stem: str, root: str = "") -> Iterator[sdf.Shape]:
    """The same meshes, or boxes, as the recipe says."""
    if scene.recipe.collision == "mesh":
        for shape in seen(scene, field, stem, root):
            yield shape._replace(name=shape.name.replace("visual", "collision"))
        return
    found = boxes(field) if scene.recipe.collision == "boxes" else single_boxes(field)
    sizes, centres = found.high - found.low, (found.low + found.high) / 2
    for number, (size, centre) in enumerate(zip(sizes.tolist(), centres.tolist(), strict=True)):
        yield sdf.box(f"collision_{number}", size, centre)


def collisions(scene: Scene, field: StepField) -> int:
    """How many shapes can be touched."""
    if scene.recipe.collision == "mesh":
        return sum(1 for _ in _parts(scene, field, ""))
    return len(boxes(field) if scene.recipe.collision == "boxes" else single_boxes(field))


def _parts(scene: Scene, field: StepField, stem: str) -> Iterator[tuple[str, Window]]:
    """Every mesh file and what part of the field is in it: all of it, or a tile that has anything in it."""
    tile = scene.recipe.tile
    for part in windows(field.whole, tile or max(field.shape)):
        if field.stands(part):
            number = f"_{part[0].start // tile}_{part[1].start // tile}" if tile else ""
            yield f"meshes/{stem}{number}.obj", part
