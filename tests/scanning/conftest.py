"""Meshes of few blocks are looked at with fewer points than those of many need."""

import pytest

from rsegen.scanning import meshes


@pytest.fixture
def few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fourth of the points that are spread and kept: still 400 on each of 200 blocks."""
    monkeypatch.setattr(meshes, "_SAMPLED", meshes._SAMPLED // 4)
    monkeypatch.setattr(meshes, "_SPREAD", meshes._SPREAD // 4)
