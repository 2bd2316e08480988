# SPDX-License-Identifier: Apache-2.0
"""Holds a job template, on standard input, to openjd.schema.json and to the rules between its parts.

openjd.py SCHEMA: prints the first fault and ends with 1, or prints one line on each step.
"""
import json
import re
import sys

import jsonschema
import yaml


def range_values(text):
    """The values of an integer range; no two of its ranges may overlap."""
    values = []
    for part in text.split(","):
        first, last, step = re.fullmatch(r"(-?\d+)(?:-(-?\d+))?(?::(\d+))?", part).groups()
        values += range(int(first), int(last or first) + 1, int(step or 1))
    if len(values) != len(set(values)):
        raise ValueError(f"ranges of {text} overlap")
    return values


def check_references(step, known):
    """Every {{name}} of a step's action is a job's parameter, one of its tasks, or of the session."""
    action = step["script"]["actions"]["onRun"]
    for text in [action["command"], *action.get("args", [])]:
        for name in re.findall(r"\{\{\s*(.*?)\s*\}\}", text):
            if name not in known:
                raise ValueError(f"step {step['name']} names {name}, which is not there")


def count_tasks(step):
    count = 1
    for parameter in step.get("parameterSpace", {}).get("taskParameterDefinitions", []):
        values = parameter["range"]
        count *= len(range_values(values) if parameter["type"] == "INT" else values)
    return count


def check(template):
    session = {"Session.PathMappingRulesFile", "Session.HasPathMappingRules", "Session.WorkingDirectory"}
    job = {f"Param.{p['name']}" for p in template.get("parameterDefinitions", [])}
    steps = []
    for step in template["steps"]:
        for dependency in step.get("dependencies", []):
            if dependency["dependsOn"] not in steps:
                raise ValueError(f"step {step['name']} waits for {dependency['dependsOn']}, which is not before it")
        if step["name"] in steps:
            raise ValueError(f"two steps are called {step['name']}")
        steps.append(step["name"])
        space = step.get("parameterSpace", {}).get("taskParameterDefinitions", [])
        check_references(step, session | job | {f"Task.Param.{p['name']}" for p in space})
        print(f"{step['name']}: {count_tasks(step)} tasks")


template = yaml.safe_load(sys.stdin)
with open(sys.argv[1], encoding="utf-8") as schema:
    jsonschema.Draft202012Validator(json.load(schema)).validate(template)
check(template)
