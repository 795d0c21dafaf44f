#!/usr/bin/env python3
"""How high the house is: chains of includes, small headers, long files, long functions, each within its bound.

A chain of includes is a file, a header that it includes, one that this includes, and so on: each link is a floor that a
reader climbs, and a reason to build again. A header of a few lines that one file includes is more of a door than of a
room. Prints the figures; exit status 1 where one is beyond its bound, with what to do."""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]

MOST_FLOORS = 9           # of a chain of includes inside calibration/, the file at its top counted
SMALL_HEADER_LINES = 30   # a header of fewer is small ...
MOST_SMALL_SHARE = 0.1    # ... and of all headers at most this share is
MOST_FILE_LINES = 450
MOST_FUNCTION_LINES = 60  # below its first line, to its closing brace


def product_files():
    listed = subprocess.run(["git", "ls-files", "*.h", "*.cc"], cwd=ROOT, capture_output=True, text=True, check=True)
    # Git lists a file that was deleted until that is staged.
    return [name for name in listed.stdout.split() if not name.startswith("tests/") and (ROOT / name).is_file()]


def longest_chain(texts, room):
    """The longest chain of includes between files of a room, from its top."""
    inside = {name for name in texts if name.startswith(room)}
    chains = {}

    def chain_of(name):
        if name not in chains:
            chains[name] = [name]  # ends a cycle, which include guards make harmless
            below = [chain_of(used) for used in re.findall(r'^#include "([^"]+)"', texts[name], re.M) if used in inside]
            chains[name] = [name] + max(below, key=len, default=[])
        return chains[name]

    return max((chain_of(name) for name in sorted(inside)), key=len, default=[])


def function_lengths(text):
    """First line of each function and the lines below it, by the indentation that clang-format gives: from the closing brace up to
    the first line that is indented as it is; 0 outside of classes, 2 in them."""
    lines = text.splitlines()
    for end, last in enumerate(lines):
        if last not in ("}", "  }"):
            continue
        indent = len(last) - 1
        begin = end - 1
        while begin >= 0 and (not lines[begin] or lines[begin].startswith(("#", " " * (indent + 1)))):
            begin -= 1
        if "(" in lines[begin] and not re.match(r" *(if|for|while|switch|do|\}|//)", lines[begin]):
            yield lines[begin].strip(), end - begin


def main():
    texts = {name: (ROOT / name).read_text(encoding="utf-8") for name in product_files()}
    lines = {name: text.count("\n") for name, text in texts.items()}
    problems = []

    chain = longest_chain(texts, "calibration/")
    print(f"longest chain of includes inside calibration/: {len(chain)} floors, at most {MOST_FLOORS}")
    if len(chain) > MOST_FLOORS:
        problems.append("longest chain of includes: " + " -> ".join(chain) + "\n  declare what a header only names "
                        "(`struct Recording;`), include what it uses and no more, or let its source include it")

    headers = [name for name in lines if name.endswith(".h")]
    small = [name for name in headers if lines[name] < SMALL_HEADER_LINES]
    print(f"headers under {SMALL_HEADER_LINES} lines: {len(small)} of {len(headers)}, "
          f"at most {int(MOST_SMALL_SHARE * len(headers))}")
    if len(small) > MOST_SMALL_SHARE * len(headers):
        problems.append("small headers: " + " ".join(small) + "\n  move what one of them declares to the header of the "
                        "thought that it belongs to, or into the one source that uses it")

    longest = max(lines, key=lines.get)
    print(f"longest file: {longest}, {lines[longest]} lines, at most {MOST_FILE_LINES}")
    problems += [f"{name}: {n} lines\n  make two files of its two thoughts"
                 for name, n in lines.items() if n > MOST_FILE_LINES]

    functions = [(n, name, first) for name, text in texts.items() for first, n in function_lengths(text)]
    n, name, first = max(functions)
    print(f"longest of {len(functions)} functions: {name}, `{first}`, {n} lines, at most {MOST_FUNCTION_LINES}")
    problems += [f"{name}: `{first}`: {n} lines\n  give its steps names" for n, name, first in functions
                 if n > MOST_FUNCTION_LINES]

    print("\n".join(problems))
    return 1 if problems else 0


if __name__ == "__main__":
    if not (ROOT / ".git").exists():
        print("skipped: not a clone")
        sys.exit(77)
    sys.exit(main())
