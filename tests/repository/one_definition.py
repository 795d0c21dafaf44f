#!/usr/bin/env python3
"""That no two types of one namespace share a name. In two rooms each builds by itself, and the linker then keeps one
constructor for both: a program that is wrong without a word (C++20 [basic.def.odr]). Prints the pairs; exit status 1
where there is one."""
import collections
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

OPENS = re.compile(r"^(?:inline )?namespace(?: ([\w:]+))? \{")
CLOSES = re.compile(r"^\}  // namespace")
TYPE = re.compile(r"^(?:struct|class|enum class|enum) (\w+)(?: final)?(?: :[^:].*)? \{")
ALIAS = re.compile(r"^using (\w+) = ")


def types_of(text):
    """Full names of the types that a file defines for others, with their lines."""
    spaces = []
    for number, line in enumerate(text.split("\n"), 1):
        if found := OPENS.match(line):
            spaces.append(found[1])
        elif CLOSES.match(line) and spaces:
            spaces.pop()
        elif (found := TYPE.match(line) or ALIAS.match(line)) and None not in spaces:
            yield "::".join([*spaces, found[1]]), number


def defined_twice(texts):
    places = collections.defaultdict(list)
    for name, text in texts.items():
        for full_name, number in types_of(text):
            places[full_name].append(f"{name}:{number}")
    return {name: where for name, where in places.items() if len(where) > 1}


def main():
    listed = subprocess.run(["git", "ls-files", "*.h", "*.cc"], cwd=ROOT, capture_output=True, text=True, check=True)
    files = [name for name in listed.stdout.split() if (ROOT / name).is_file()]
    twice = defined_twice({name: (ROOT / name).read_text() for name in files})
    for name, where in sorted(twice.items()):
        print(f"{name} is defined in {' and in '.join(where)}: give one of them another name")
    print(f"one_definition: {len(files)} files, {len(twice)} names of two types")
    return 1 if twice else 0


if __name__ == "__main__":
    sys.exit(main())
