"""Documents keep their promises: links lead somewhere, named files, presets and commands exist.

The commands themselves are run by tests/end_to_end/test_documents.py, procedures' snippets by tests/procedures.
"""
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1])


def documents():
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True,
                            check=True).stdout
    # Git lists a file that was deleted until that is staged.
    return [ROOT / name for name in listed.split() if (ROOT / name).is_file()]


def check_links(path, text):
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text):
        if "://" not in target and not (path.parent / target).exists():
            yield f"link to {target}, which is not there"


def check_named_files(text):
    rooms = "base|cli|cmake|config|daemon|docs|drivers|export|kinematics|msgs|procedures|presentation|recording|calibration|scripts|stand|tests"
    for name in re.findall(rf"`((?:{rooms})/[A-Za-z0-9_./-]+\.[a-z]+)`", text):
        if "NAME" not in name and not list(ROOT.glob(name)):
            yield f"names {name}, which is not there"


def check_presets(text):
    presets = {p["name"] for p in json.loads((ROOT / "CMakePresets.json").read_text())["configurePresets"]}
    for name in re.findall(r"--preset ([a-z]+)", text):
        if name not in presets:
            yield f"names preset {name}, which is not in CMakePresets.json"


def check_commands(text):
    program = BUILD / "bin/gyrobench"
    if not program.exists():
        return
    known = set(re.findall(r"^  ([a-z]+)", subprocess.run(
        [program, "--help"], capture_output=True, text=True).stdout, re.M))
    for line in re.findall(r"^\$? ?gyrobench ([a-z]+)", text, re.M):
        if line not in known:
            yield f"shows `gyrobench {line}`, which is no command"


def main():
    problems = []
    for path in documents():
        text = path.read_text()
        for check in (lambda t, p=path: check_links(p, t), check_named_files, check_presets, check_commands):
            problems += [f"{path.relative_to(ROOT)}: {problem}" for problem in check(text)]
    if not documents():
        problems.append("no document found")
    print("\n".join(problems) or f"documents: {len(documents())} pages keep their promises")
    return 1 if problems else 0


sys.exit(main())
