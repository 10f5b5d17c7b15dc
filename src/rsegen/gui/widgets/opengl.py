"""Whether this display can show the 3D view."""

from __future__ import annotations

from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext

_WITHOUT_GL = ("offscreen", "minimal", "linuxfb", "vnc")
_OPENGL = (3, 2)


def unavailable() -> str:
    """Why this display cannot show a 3D view; empty if it can."""
    platform = QGuiApplication.platformName()
    if platform in _WITHOUT_GL:
        return f"The 3D view needs a display: Qt's platform '{platform}' has none."
    try:
        import pyvistaqt  # noqa: F401  # whether it can be
    except ImportError as error:
        return f"The 3D view needs pyvista and pyvistaqt: {error}."
    return _opengl_missing()


def _opengl_missing() -> str:
    """Why this display has no sufficient OpenGL; empty if it has."""
    context, surface = QOpenGLContext(), QOffscreenSurface()
    surface.create()
    if not context.create() or not context.makeCurrent(surface):
        return "The 3D view needs OpenGL, and this display has none."
    found = context.format().version()
    context.doneCurrent()
    needed, given = (".".join(map(str, version)) for version in (_OPENGL, found))
    return "" if found >= _OPENGL else f"The 3D view needs OpenGL {needed} or later; this display has {given}."
