"""The message types of Gazebo Sim that rsegen sends and receives; they are the same in all versions since Fortress."""

from __future__ import annotations

from collections.abc import Mapping

from rsegen.simulation.simulators.wire import MessageTypes

SIM = MessageTypes(
    {
        "Time": {"sec": (1, int), "nsec": (2, int)},
        "Header": {"stamp": (1, "Time")},
        "Vector3d": {"x": (2, float), "y": (3, float), "z": (4, float)},
        "Quaternion": {"x": (2, float), "y": (3, float), "z": (4, float), "w": (5, float)},
        "Pose": {
            "header": (1, "Header"),
            "name": (2, str),
            "id": (3, int),
            "position": (4, "Vector3d"),
            "orientation": (5, "Quaternion"),
        },
        "Pose_V": {"header": (1, "Header"), "pose": (2, "Pose[]")},
        "Twist": {"linear": (2, "Vector3d"), "angular": (3, "Vector3d")},
        "Double": {"data": (2, float)},
        "Boolean": {"data": (2, bool)},
        "Empty": {},
        "StringMsg_V": {"data": (2, "text[]")},
        "Entity": {"id": (2, int), "name": (3, str), "type": (4, int)},
        "EntityFactory": {"sdf": (2, str), "pose": (7, "Pose"), "name": (8, str), "allow_renaming": (9, bool)},
        "Contact": {"collision1": (2, "Entity"), "collision2": (3, "Entity"), "position": (4, "Vector3d[]")},
        "Contacts": {"header": (1, "Header"), "contact": (2, "bytes[]")},
        "Mesh": {"filename": (2, str)},
        "Geometry": {"mesh": (9, "Mesh")},
        "Visual": {"geometry": (10, "Geometry")},
        "Link": {"visual": (11, "Visual[]")},
        "Model": {"name": (2, str), "id": (3, int), "pose": (5, "Pose"), "link": (7, "Link[]")},
        "Scene": {"name": (2, str), "model": (9, "Model[]")},
        "WorldControl": {"pause": (2, bool), "step": (3, bool), "multi_step": (4, int)},
        "WorldStatistics": {
            "sim_time": (2, "Time"),
            "real_time": (4, "Time"),
            "paused": (5, bool),
            "iterations": (6, int),
        },
        "Subscriber": {"topic": (1, str)},
        "MessagePublisher": {"ctrl": (1, str), "msg_type": (2, str)},
        "ServicePublisher": {"socket_id": (1, str), "request_type": (2, str), "response_type": (3, str)},
        "Publisher": {
            "topic": (1, str),
            "address": (2, str),
            "process_uuid": (3, str),
            "node_uuid": (4, str),
            "scope": (5, int),
            "msg_pub": (6, "MessagePublisher"),
            "srv_pub": (7, "ServicePublisher"),
        },
        "Discovery": {
            "version": (2, int),
            "process_uuid": (3, str),
            "type": (4, int),
            "sub": (6, "Subscriber"),
            "pub": (7, "Publisher"),
        },
    }
)


def nanoseconds(time: Mapping[str, int] | None) -> int:
    """A message Time; 0 if there is none, as of a message whose time is 0."""
    return (time or {}).get("sec", 0) * 10**9 + (time or {}).get("nsec", 0)
