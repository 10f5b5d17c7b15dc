"""A program that plays `gz`, and the server behind it: its world is a file of JSON beside it.

It knows what the manuals of gz-transport and gz-sim say of `gz service` and `gz topic`.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

WORD = re.compile(r'(\w+)\s*:\s*("(?:[^"\\]|\\.)*"|[^\s{}]+)|(\w+)\s*\{|(\})')
TYPES = {
    "control": ("WorldControl", "Boolean"),
    "create": ("EntityFactory", "Boolean"),
    "remove": ("Entity", "Boolean"),
    "set_pose": ("Pose", "Boolean"),
    "scene/info": ("Empty", "Scene"),
}
FIRST: dict[str, Any] = {
    "steps": 0,
    "paused": True,
    "told": [],
    "models": {"ground_plane": {"id": 8, "static": True, "pose": {}}},
}


def read(text: str) -> dict[str, Any]:
    whole: dict[str, Any] = {}
    inside = [whole]
    for name, value, opened, closed in WORD.findall(text):
        if closed:
            inside.pop()
        elif opened:
            inside.append(inside[-1].setdefault(opened, {}))
        else:
            inside[-1][name] = json.loads(value)
    assert len(inside) == 1
    return whole


def written(message: dict[str, Any], margin: str = "") -> str:
    lines = []
    for name, value in message.items():
        for one in value if isinstance(value, list) else [value]:
            inner = f" {{\n{written(one, margin + '  ')}{margin}}}" if isinstance(one, dict) else f": {json.dumps(one)}"
            lines.append(f"{margin}{name}{inner}\n")
    return "".join(lines)


def served(state: dict[str, Any], name: str, asked: dict[str, Any]) -> dict[str, Any]:
    models = state["models"]
    if name == "scene/info":
        return {"name": "lab", "model": [{"name": each, **model_of(models[each])} for each in models]}
    if name == "control":
        state["paused"] = asked.get("pause", False)
        state["steps"] += asked.get("multi_step", 0) if state["paused"] else 0
    if name == "create":
        found = re.search(r'<model name="(\w+)">', asked["sdf"])
        assert found
        static = "<static>true" in asked["sdf"]
        models[found[1]] = {"id": 9 + len(models), "static": static, "pose": asked["pose"]}
    if name == "remove":
        assert asked["type"] == 2
        del models[asked["name"]]
    if name == "set_pose":
        models[asked.pop("name")]["pose"] = asked
    return {"data": True}


def model_of(model: dict[str, Any]) -> dict[str, Any]:
    """As the scene tells it, with the place that it had at first, which is no more than that."""
    link = {"name": "link", "id": 100 + model["id"], "pose": {"position": {"x": 9.0}, "orientation": {"w": 1.0}}}
    return {"id": model["id"], "pose": {"position": {"z": 99.0}, "orientation": {"w": 1.0}}, "link": link}


def heard(state: dict[str, Any], name: str) -> dict[str, Any]:
    if name == "stats":
        seconds, rest = divmod(state["steps"], 1000)
        time = {key: value for key, value in (("sec", seconds), ("nsec", rest * 10**6)) if value}
        told = {"sim_time": time, "real_time": {"sec": 7}, "iterations": state["steps"], "paused": state["paused"]}
        return {key: value for key, value in told.items() if value or key == "sim_time"}
    moving = name == "dynamic_pose/info"
    there = [(each, model) for each, model in state["models"].items() if not (moving and model["static"])]
    poses = [{"name": each, "id": model["id"], **model["pose"]} for each, model in there]
    links = [{"name": "link", "id": 100 + model["id"], "position": {"x": 9.0}} for _, model in there]
    return {"header": {"stamp": {"sec": 3}}, "pose": poses + links}


def main(*words: str) -> str:
    file = Path(sys.argv[0]).with_suffix(".json")
    state = json.loads(file.read_text()) if file.exists() else FIRST
    match words:
        case ("sim", "--versions"):
            return "8.9.0\n"
        case ("service", "-l"):
            return "/gazebo/worlds\n" + "".join(f"/world/lab/{name}\n" for name in TYPES)
        case ("service", "-s", name, "--reqtype", asked, "--reptype", answered, "--timeout", _, "--req", text):
            short = name.removeprefix("/world/lab/")
            assert (asked, answered) == tuple(f"gz.msgs.{each}" for each in TYPES[short])
            output_of = served(state, short, read(text))
            file.write_text(json.dumps(state))
            return written(output_of) + "\n"
        case ("topic", "-e", "-t", name, "-n", "1"):
            return written(heard(state, name.removeprefix("/world/lab/"))) + "\n"
        case ("topic", "-t", name, "-m", type_name, "-p", text):
            state["told"].append([name, type_name, read(text)])
            file.write_text(json.dumps(state))
            return ""
    raise SystemExit(f"gz: {words} is not known")


if __name__ == "__main__":
    sys.stdout.write(main(*sys.argv[1:]))
