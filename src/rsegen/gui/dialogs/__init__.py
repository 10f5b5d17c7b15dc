"""Dialogs that the window opens; each tells its result by a signal, and knows its parent only as a widget."""
