#!/usr/bin/env python3
"""The tools that look at the tree see what they are to see: in small repositories made for it, with a clang-tidy that
finds fault with every source."""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77
FINDS_FAULT = """#!/bin/sh
for last; do :; done
echo "fault in $last"
echo begin >>"$TIDY_LOG"
begun() { [ "$(grep -c begin "$TIDY_LOG")" -ge "$1" ]; }
until begun "${TIDY_WAITS_FOR:-0}"; do :; done
looks=0
until begun "${TIDY_LOOKS_OUT_FOR:-0}" || [ "$looks" -ge 50 ]; do looks=$((looks + 1)); done
echo end >>"$TIDY_LOG"
exit 1
"""


class Repository:
    """A clone with the tools, a build folder and sources, all of it committed."""

    def __init__(self, folder):
        self.root = pathlib.Path(folder) / "clone"
        self.log = pathlib.Path(folder) / "log"
        self.left_out = []  # sources that the build does not compile
        programs = pathlib.Path(folder) / "programs"
        programs.mkdir()
        (programs / "clang-tidy").write_text(FINDS_FAULT)
        (programs / "clang-tidy").chmod(0o755)
        self.environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "TIDY_LOG": str(self.log)}
        self.environment.pop("GYROBENCH_TIDY_BASE", None)
        for tool in ("tidy.py", "floors.py"):
            self.write(f"tests/repository/{tool}", (HERE / tool).read_text())
        self.write(".gitignore", "build/\n")
        self.git("init", "--quiet")

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def git(self, *arguments):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *arguments], cwd=self.root, check=True,
                       capture_output=True)

    def commit(self, **files):
        for name, text in files.items():
            self.write(name.replace("__", "/").replace("_h", ".h").replace("_cc", ".cc"), text)
        self.git("add", "--all")
        self.git("commit", "--quiet", "--allow-empty", "--message", "one more")

    def old(self, **files):
        """Committed so long ago that it does not count as changed."""
        self.commit(**files)
        for _ in range(10):
            self.commit()

    def run(self, tool, *arguments):
        return subprocess.run([sys.executable, f"tests/repository/{tool}", *arguments], cwd=self.root,
                              env=self.environment, capture_output=True, text=True)

    def tidy(self, *arguments):
        sources = [str(path) for path in self.root.rglob("*.cc")
                   if str(path.relative_to(self.root)) not in self.left_out]
        build = self.root / "build"
        build.mkdir(exist_ok=True)
        (build / "compile_commands.json").write_text(json.dumps(
            [{"directory": str(build), "command": f"c++ -c {source}", "file": source} for source in sources]))
        return self.run("tidy.py", "build", *arguments)


class ToolsOfTheRepository(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="gyrobench-tools-")
        self.addCleanup(folder.cleanup)
        self.repository = Repository(folder.name)

    def test_an_old_source_is_not_looked_at(self):
        self.repository.old(base__old_cc="")
        done = self.repository.tidy()
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("no source has changed", done.stdout)

    def test_a_source_that_was_never_added_is_looked_at(self):
        self.repository.old(base__old_cc="")
        self.repository.write("base/fresh.cc", "")
        done = self.repository.tidy()
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("base/fresh.cc", done.stdout)
        self.assertNotIn("base/old.cc", done.stdout)

    def test_a_changed_header_without_a_source_of_its_own_is_seen_by_one_that_includes_it(self):
        self.repository.old(base__user_cc='#include "base/outer.h"\n', base__other_cc="",
                            base__outer_h='#include "base/alone.h"\n', base__alone_h="")
        self.repository.commit(base__alone_h="int changed;\n")
        done = self.repository.tidy()
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("base/user.cc", done.stdout)
        self.assertNotIn("base/other.cc", done.stdout)

    def test_a_changed_header_that_no_source_includes_is_named(self):
        self.repository.old(base__other_cc="")
        self.repository.commit(base__alone_h="int changed;\n")
        done = self.repository.tidy()
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("base/alone.h", done.stdout)

    def test_a_changed_source_that_this_build_does_not_compile_is_named_and_not_passed(self):
        self.repository.old(base__old_cc="")
        self.repository.commit(base__left_cc="int changed;\n")
        self.repository.left_out = ["base/left.cc"]
        done = self.repository.tidy()
        self.assertEqual(done.returncode, SKIPPED, done.stdout)
        self.assertIn("base/left.cc", done.stdout)

    def merged(self, *arguments, **files):
        """A merge of a branch that added a source; `files` as the merge leaves them, changed by nobody before."""
        self.repository.old(base__old_cc="")
        self.repository.git("checkout", "--quiet", "-b", "side")
        self.repository.commit(base__side_cc="int side;\n")
        self.repository.git("checkout", "--quiet", "-")
        self.repository.commit(base__main_cc="int main_line;\n")
        self.repository.git("merge", "--quiet", "--no-ff", "--no-commit", *arguments, "side")
        self.repository.commit(**files)

    def test_what_came_by_a_merge_is_looked_at_and_so_is_what_the_merge_itself_changed(self):
        self.merged(base__old_cc="int by_the_merge;\n")
        done = self.repository.tidy()
        self.assertEqual(done.returncode, 1, done.stdout)
        for name in ("base/side.cc", "base/main.cc", "base/old.cc"):
            self.assertIn(name, done.stdout)

    def test_a_clone_without_history_is_skipped_and_says_so(self):
        self.repository.old(base__old_cc="")
        shallow = self.repository.root.parent / "shallow"
        subprocess.run(["git", "clone", "--quiet", "--depth", "1", self.repository.root.as_uri(), str(shallow)],
                       check=True, capture_output=True)
        self.repository.root = shallow
        done = self.repository.tidy()
        self.assertEqual(done.returncode, SKIPPED, done.stdout)
        self.assertIn("git fetch --unshallow", done.stdout)
        self.repository.write("base/fresh.cc", "")
        self.assertEqual(self.repository.tidy().returncode, 1)

    def test_no_more_sources_at_once_than_asked_for(self):
        self.repository.old()
        self.repository.commit(**{f"base__{name}_cc": "" for name in "abcdefgh"})
        self.repository.environment["TIDY_WAITS_FOR"] = "2"  # the first goes on when a second has begun
        self.repository.environment["TIDY_LOOKS_OUT_FOR"] = "9"  # each stays a while, for more to begin if they may
        self.repository.tidy("--jobs", "2")
        running = most = 0
        for line in self.repository.log.read_text().split():
            running += 1 if line == "begin" else -1
            most = max(most, running)
        self.assertEqual(most, 2)

    def test_the_floors_stand_without_a_file_that_was_deleted_but_not_staged(self):
        self.repository.old(calibration__kept_h="\n" * 40, calibration__kept_cc="void F() {\n}\n",
                            calibration__gone_cc="void G() {\n}\n")
        (self.repository.root / "calibration/gone.cc").unlink()
        done = self.repository.run("floors.py")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    if shutil.which("git") is None:
        print("skipped: git is not installed")
        sys.exit(SKIPPED)
    unittest.main()
