"""A check for OpenGL, which the 3D view needs; `python -m rsegen.gui.widgets.opengl` prints its version."""

from __future__ import annotations

import sys

from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext

_WITHOUT_GL = ("offscreen", "minimal", "linuxfb", "vnc")
_OPENGL = (3, 2)


def unavailable() -> str:
    """Return why this display cannot show a 3D view; empty if it can."""
    platform = QGuiApplication.platformName()
    if platform in _WITHOUT_GL:
        return f"The 3D view needs a display: Qt's platform '{platform}' has none."
    try:
        import pyvistaqt  # noqa: F401  # whether it can be
    except ImportError as error:
        return f"The 3D view needs pyvista and pyvistaqt: {error}."
    return _opengl_missing()


def _opengl_missing() -> str:
    """Return why this display has no sufficient OpenGL; empty if it has."""
    found = _version()
    if found is None:
        return "The 3D view needs OpenGL, and this display has none."
    needed, given = (".".join(map(str, version)) for version in (_OPENGL, found))
    return "" if found >= _OPENGL else f"The 3D view needs OpenGL {needed} or later; this display has {given}."


def _version() -> tuple[int, int] | None:
    """The version of OpenGL of this display; None if it has none."""
    context, surface = QOpenGLContext(), QOffscreenSurface()
    surface.create()
    if not context.create() or not context.makeCurrent(surface):
        return None
    found = context.format().version()
    context.doneCurrent()
    return found[0], found[1]


def main() -> int:
    """Print the version of OpenGL, or why it does not do; gives the exit code."""
    application = QGuiApplication(sys.argv[:1])
    platform = application.platformName()
    problem = f"Qt's platform '{platform}' has no display" if platform in _WITHOUT_GL else _opengl_missing()
    print(problem or ".".join(map(str, _version() or ())))  # noqa: T201  # a command
    return 1 if problem else 0


if __name__ == "__main__":
    sys.exit(main())
