"""What a message about a model, of either Gazebo, says of its meshes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def mesh_file(model: Mapping[str, Any]) -> str:
    """The file of the first mesh that is seen of a model; empty if there is none."""
    return next(_mesh_files(model), "")


def _mesh_files(model: Mapping[str, Any]) -> Iterator[str]:
    visuals = (visual for link in model.get("link", []) for visual in link.get("visual", []))
    for visual in visuals:
        if file := visual.get("geometry", {}).get("mesh", {}).get("filename"):
            yield file
