#!/usr/bin/env python3
"""What docs/contributing.md promises of how many files a new member touches, counted on members that there are.

A member's files are those that speak of it: its own, the lists it stands in, its test, its row in a table of docs/.
Campaigns and examples that use it are not counted. Prints a table; exit status 1 where a member has more files than
the seam promises, or one of its files is not where the seam says."""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PRODUCT = r"(base|calibration|cli|config|daemon|drivers|export|kinematics|msgs|presentation|procedures|recording|stand)/"

# Seam, member, what speaks of it, where it counts, and how many files at most.
SEAMS = [
    ("effect, memoryless", "bias.g_squared", r"bias\.g_squared|BiasGSquared",
     PRODUCT + r"(?!.*\.lua)|tests/calibration/effects_test", 3),
    ("effect, searched", "angle.ripple", r"angle\.ripple|AngleRipple",
     r"calibration/|export/|presentation/|daemon/|tests/calibration/effects_test", 3),
    ("driver", "encoder", r"drivers/encoder\.h|encoder\.cc|class Encoder\b",
     r"drivers/|daemon/|tests/drivers/encoder_test", 5),
    ("channel", "_FAULT", r"\bfault_t\b|_FAULT\b",
     PRODUCT + r"|docs/subscribe", 4),
    ("export format", "px4", r"px4\.cc|WritePx4|\"px4\"",
     PRODUCT + r"|tests/export/autopilot_test", 4),
    ("procedure", "rates", r"rates\.lua", r"procedures/", 1),
]


def tracked():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    # Git lists a file that was deleted until that is staged.
    return [name for name in listed.stdout.split() if (ROOT / name).is_file()]


def files_of(speaks, counts, files):
    """Files in which the member is spoken of, or whose name does so."""
    speaks, counts = re.compile(speaks, re.M), re.compile(counts)
    for name in files:
        if not counts.match(name):
            continue
        text = (ROOT / name).read_text(encoding="utf-8", errors="replace")
        if name.endswith((".h", ".cc")):
            text = re.sub(r"//.*", "", text)  # a comment may give an example
        if speaks.search(text) or speaks.search(name):
            yield name


def main():
    files = tracked()
    bad = False
    for seam, member, speaks, counts, most in SEAMS:
        found = sorted(files_of(speaks, counts, files))
        too_many = not found or len(found) > most
        bad |= too_many
        print(f"{seam:18}  {member:15}  {len(found)} of at most {most}  {'TOO MANY: ' if too_many else ''}"
              f"{', '.join(found)}")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    if not (ROOT / ".git").exists():
        print("skipped: not a clone")
        sys.exit(77)
    main()
