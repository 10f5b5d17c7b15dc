"""Bags of ROS 2, written by the library rosbags."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from rosbags.rosbag2 import StoragePlugin, Writer


def write_bag(path: Path, topics: Mapping[str, Sequence[Any]], version: Literal[8, 9] = 9, *, store: Any) -> Path:
    """Write a bag in a single file, mcap or db3, with messages of a store's types, and return its path.

    Before version 9 it does not say what the messages are made of.
    """
    plugin = StoragePlugin.MCAP if path.suffix == ".mcap" else StoragePlugin.SQLITE3
    folder = path.parent / f"{path.stem}_folder"
    with Writer(folder, version=version, storage_plugin=plugin) as writer:
        for topic, messages in topics.items():
            kind = messages[0].__msgtype__
            connection = writer.add_connection(topic, kind, typestore=store)
            for number, content in enumerate(messages):
                writer.write(connection, number, store.serialize_cdr(content, kind))
    (file,) = folder.glob(f"*{path.suffix}")
    return file.rename(path)
