"""The message types of Gazebo Classic that rsegen sends and receives."""

from __future__ import annotations

from rsegen.simulation.simulators.wire import MessageTypes

CLASSIC = MessageTypes(
    {
        "Time": {"sec": (1, int), "nsec": (2, int)},
        "Vector3d": {"x": (1, float), "y": (2, float), "z": (3, float)},
        "Quaternion": {"x": (2, float), "y": (3, float), "z": (4, float), "w": (5, float)},
        "Pose": {"name": (1, str), "id": (2, int), "position": (3, "Vector3d"), "orientation": (4, "Quaternion")},
        "ImageStamped": {"time": (1, "Time"), "image": (2, bytes)},
        "PosesStamped": {"time": (1, "Time"), "pose": (2, "bytes[]")},
        "Twist": {"linear": (2, "Vector3d"), "angular": (3, "Vector3d")},
        "GzString": {"data": (1, str)},
        "GzString_V": {"data": (1, "text[]")},
        "Mesh": {"filename": (1, str)},
        "Geometry": {"mesh": (8, "Mesh")},
        "Visual": {"geometry": (9, "Geometry")},
        "Link": {"name": (2, str), "pose": (9, "Pose"), "visual": (10, "Visual[]")},
        "Model": {
            "name": (1, str),
            "id": (2, int),
            "is_static": (3, bool),
            "pose": (4, "Pose"),
            "link": (6, "Link[]"),
        },
        "Model_V": {"models": (2, "Model[]")},
        "Factory": {"sdf": (1, str), "sdf_filename": (2, str), "pose": (3, "Pose"), "allow_renaming": (6, bool)},
        "Request": {"id": (1, int), "request": (2, str), "data": (3, str)},
        "Response": {"id": (1, int), "response": (3, str), "type": (4, str), "serialized_data": (5, bytes)},
        "LogControl": {"stop": (2, bool)},
        "WorldControl": {"pause": (1, bool), "step": (2, bool), "multi_step": (3, int)},
        "WorldStatistics": {
            "sim_time": (2, "Time"),
            "pause_time": (3, "Time"),
            "real_time": (4, "Time"),
            "paused": (5, bool),
            "iterations": (6, int),
        },
        "Contact": {"collision1": (1, str), "collision2": (2, str), "position": (3, "Vector3d[]")},
        "Contacts": {"contact": (1, "Contact[]")},
        "Packet": {"stamp": (1, "Time"), "type": (2, str), "serialized_data": (3, bytes)},
        "Publish": {"topic": (1, str), "msg_type": (2, str), "host": (3, str), "port": (4, int)},
        "Subscribe": {
            "topic": (1, str),
            "host": (2, str),
            "port": (3, int),
            "msg_type": (4, str),
            "latching": (5, bool),
        },
    }
)
