# SPDX-License-Identifier: Apache-2.0
"""The tables of keys in docs/scene-format.md, by the program's schema.

key_tables.py [--update] PROGRAM PAGE.md: in the page, what stands between `<!-- keys PREFIX… -->` and `<!-- end of keys
-->` is a table of the keys with one of these prefixes, but for keys that a longer prefix of another table has. Without
--update: exit status 1 where a table is another, or a key is in none."""

import json
import re
import subprocess
import sys

TABLE = re.compile(r"<!-- keys ([^>]*) -->\n.*?<!-- end of keys -->", re.S)


def has_prefix(key, prefix):
    return key == prefix or key.startswith((prefix + ".", prefix + "["))


def choose_table(key, tables):
    """The table with the longest prefix of a key; None: there is none."""
    fits = [(len(prefix), table) for table in tables for prefix in table.split() if has_prefix(key, prefix)]
    return max(fits)[1] if fits else None


def make_row(key):
    values = key["values"] if key["type"] != "section" else key["values"].replace("a mapping", "mapping")
    default = f"`{key['default']}`" if key.get("default") else ""
    cells = [f"`{key['key']}`", values, default, key["meaning"]]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def make_table(names, keys, tables):
    rows = [make_row(key) for key in keys if choose_table(key["key"], tables) == names]
    head = ["| key | value | default | meaning |", "| --- | --- | --- | --- |"]
    return "\n".join([f"<!-- keys {names} -->", *head, *rows, "<!-- end of keys -->"])


def main():
    words = sys.argv[1:]
    is_update = words[0] == "--update"
    program, page = words[1:] if is_update else words
    schema = json.loads(subprocess.run([program, "schema", "--json"], capture_output=True, text=True, check=True).stdout)
    with open(page) as file:
        text = file.read()
    tables = TABLE.findall(text)
    missing = [key["key"] for key in schema["keys"] if not choose_table(key["key"], tables)]
    new = TABLE.sub(lambda match: make_table(match[1], schema["keys"], tables), text)
    if missing:
        print(f"{page}: no table has {', '.join(missing)}", file=sys.stderr)
    if is_update:
        with open(page, "w") as file:
            file.write(new)
    elif new != text:
        print(f"{page}: its tables of keys are old: python3 tests/docs/key_tables.py --update PROGRAM {page}",
              file=sys.stderr)
    return 1 if missing or (new != text and not is_update) else 0


sys.exit(main())
