"""Scenes as text, of dictionaries."""

import json


def toml(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(item) for item in value) + "]"
    return json.dumps(value) if isinstance(value, (str, bool)) else repr(value)


def scene_text(scene):
    return "".join(f"{key} = {toml(value)}\n" for key, value in scene.items())
