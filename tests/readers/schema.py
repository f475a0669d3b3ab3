"""Judges JSON files by a JSON Schema and prints, per file, what is wrong."""

import json
import sys

import jsonschema

with open(sys.argv[1], encoding="utf-8") as file:
    schema = json.load(file)
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)
found = []
for path in sys.argv[2:]:
    with open(path, encoding="utf-8") as file:
        document = json.load(file)
    found.append([f"{error.json_path}: {error.message[:200]}" for error in validator.iter_errors(document)])
print(json.dumps(found))
