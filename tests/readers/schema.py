"""Judges JSON files by JSON Schemas and prints, per file, what is wrong.

usage: schema.py SCHEMA FILE [SCHEMA FILE]…
"""

import json
import sys

import jsonschema

found = []
validators = {}
for schema_path, path in zip(sys.argv[1::2], sys.argv[2::2], strict=True):
    if schema_path not in validators:
        with open(schema_path, encoding="utf-8") as file:
            schema = json.load(file)
        jsonschema.Draft202012Validator.check_schema(schema)
        validators[schema_path] = jsonschema.Draft202012Validator(schema)
    with open(path, encoding="utf-8") as file:
        document = json.load(file)
    found.append([f"{error.json_path}: {error.message[:200]}" for error in validators[schema_path].iter_errors(document)])
print(json.dumps(found))
