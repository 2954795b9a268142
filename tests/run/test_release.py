"""What ./run release checks and makes, in a small repository with a ./run of its own.

    test_release.py ROOT
"""
import datetime
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv.pop(1)).resolve()

VERSION = "#define MYOGROWTH_VERSION_MAJOR 1\n#define MYOGROWTH_VERSION_MINOR 2\n#define MYOGROWTH_VERSION_PATCH 3\n"
CITATION = "cff-version: 1.2.0\nversion: 1.2.3\ndate-released: 2026-01-31\n"
CHANGELOG = ("# Changelog\n\n## [Unreleased]\n\n## [1.2.3] - 2026-01-31\n### Added\n- A law.\n### Fixed\n- A fault.\n\n"
             "## [1.2.2] - 2026-01-01\n### Added\n- All.\n")
RUN = """#!/bin/sh
echo "$1" >>"$(dirname "$0")/out/log"
case "$1" in
  test) exit $(cat build/test_status) ;;
  package)
    rm -rf out/package; mkdir -p out/package build/abi
    echo deb $SOURCE_DATE_EPOCH >out/package/myogrowth_1.2.3_amd64.deb; echo tar >out/package/myogrowth-1.2.3-Linux.tar.gz
    echo umat >build/abi/myogrowth_umat_single.cpp; exit $(cat build/package_status) ;;
esac
"""


class Release(unittest.TestCase):
    def setUp(self):
        self.tree = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.tree)
        for name, text in {"include/myogrowth/version.hpp": VERSION, "CITATION.cff": CITATION, "CHANGELOG.md": CHANGELOG, "run": RUN,
                           "cmake/release.py": (ROOT / "cmake/release.py").read_text(encoding="utf-8"), ".gitignore": "/out/\n/build/\n",
                           "build/test_status": "0", "build/package_status": "0", "out/log": ""}.items():
            path = self.tree / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        (self.tree / "run").chmod(0o755)
        self.git("init", "-q")
        self.commit()

    def git(self, *arguments):
        return subprocess.run(["git", "-c", "user.name=n", "-c", "user.email=e", *arguments], cwd=self.tree, check=True,
                              capture_output=True, text=True).stdout

    def commit(self):
        self.git("add", "-A")
        self.git("commit", "-q", "--allow-empty", "-m", "m")

    def release(self, *arguments):
        p = subprocess.run([sys.executable, self.tree / "cmake/release.py", *arguments], cwd=self.tree, capture_output=True, text=True)
        return p.returncode, p.stdout, p.stderr

    def refuses(self, *texts):
        status, out, err = self.release("--tested")
        self.assertEqual((status, out), (1, ""))
        self.assertEqual(len(err.splitlines()), len(texts), err)
        for text in texts:
            self.assertIn(text, err)
        self.assertEqual((self.tree / "out/log").read_text(), "")

    def change(self, name, old, new):
        path = self.tree / name
        text = path.read_text(encoding="utf-8")
        self.assertIn(old, text)
        path.write_text(text.replace(old, new), encoding="utf-8")
        self.commit()

    def test_what_it_makes(self):
        status, out, err = self.release()
        self.assertEqual(status, 0, err)
        self.assertEqual((self.tree / "out/log").read_text(), "test\npackage\n")
        names = ["SHA256SUMS", "myogrowth-1.2.3-Linux.tar.gz", "myogrowth_1.2.3_amd64.deb", "myogrowth_umat_single.cpp", "notes.md"]
        self.assertEqual(out.split(), [f"out/release/{name}" for name in names])
        made = self.tree / "out/release"
        self.assertEqual((made / "notes.md").read_text(), "### Added\n- A law.\n### Fixed\n- A fault.\n")
        self.assertRegex((made / "myogrowth_1.2.3_amd64.deb").read_text(), r"^deb \d{9,}\n$")
        sums = dict(reversed(line.split("  ")) for line in (made / "SHA256SUMS").read_text().splitlines())
        self.assertEqual(sorted(sums), names[1:4])
        for name, digest in sums.items():
            self.assertEqual(digest, hashlib.sha256((made / name).read_bytes()).hexdigest())

    def test_tested_leaves_out_the_tests_and_failing_ones_stop_it(self):
        self.assertEqual(self.release("--tested")[0], 0)
        self.assertEqual((self.tree / "out/log").read_text(), "package\n")
        (self.tree / "build/test_status").write_text("8")
        status, _, err = self.release()
        self.assertEqual(status, 1)
        self.assertIn("./run test ended with status 8: nothing is released", err)
        self.assertEqual((self.tree / "out/log").read_text(), "package\ntest\n")

    def test_a_package_that_fails_leaves_no_old_release(self):
        self.assertEqual(self.release("--tested")[0], 0)
        (self.tree / "build/package_status").write_text("1")
        status, _, err = self.release("--tested")
        self.assertEqual(status, 1)
        self.assertIn("./run package ended with status 1", err)
        self.assertFalse((self.tree / "out/release").exists())

    def test_a_package_of_another_version(self):
        self.change("run", "myogrowth_1.2.3_", "myogrowth_1.2.2_")
        status, _, err = self.release("--tested")
        self.assertEqual(status, 1)
        self.assertIn("expected one .deb of version 1.2.3, ./run package made ['myogrowth_1.2.2_amd64.deb']", err)

    def test_versions_that_differ(self):
        self.change("CITATION.cff", "version: 1.2.3", "version: 1.2.2")
        self.refuses("CITATION.cff: version 1.2.2, but include/myogrowth/version.hpp has 1.2.3")

    def test_a_version_without_an_entry(self):
        self.change("CHANGELOG.md", "[1.2.3]", "[1.2.4]")
        self.refuses("CHANGELOG.md: the newest entry is 1.2.4, expected '## [1.2.3] - YYYY-MM-DD'")

    def test_an_entry_that_is_not_the_newest(self):
        self.change("include/myogrowth/version.hpp", "PATCH 3", "PATCH 2")
        self.change("CITATION.cff", "1.2.3", "1.2.2")
        self.refuses("the newest entry is 1.2.3, expected '## [1.2.2]")

    def test_an_entry_without_brackets_is_none(self):
        self.change("CHANGELOG.md", "[1.2.3]", "1.2.3")
        self.refuses("expected '## [1.2.3] - YYYY-MM-DD'")

    def test_dates(self):
        for date, text in ((" - unreleased", "has the date 'unreleased'"), ("", "has the date ''"), (" - 2026-02-30", "has the date '2026-02-30'"),
                           (" - 31-01-2026", "has the date '31-01-2026'")):
            self.change("CHANGELOG.md", "[1.2.3] - 2026-01-31", "[1.2.3]" + date)
            self.refuses(text, "CITATION.cff: date-released 2026-01-31, but CHANGELOG.md has")
            self.change("CHANGELOG.md", "[1.2.3]" + date, "[1.2.3] - 2026-01-31")
        tomorrow = (datetime.date.today() + datetime.timedelta(2)).isoformat()
        self.change("CHANGELOG.md", "2026-01-31", tomorrow)
        self.change("CITATION.cff", "2026-01-31", tomorrow)
        self.refuses("which is yet to come")

    def test_an_entry_without_changes_and_unknown_headings(self):
        self.change("CHANGELOG.md", "### Added\n- A law.\n### Fixed\n- A fault.\n", "")
        self.refuses("names no change under a heading")
        self.change("CHANGELOG.md", "2026-01-31\n", "2026-01-31\n### News\n- A law.\n")
        self.refuses("has the heading 'News', allowed: Added, Changed")

    def test_lines_that_are_unreleased(self):
        self.change("CHANGELOG.md", "## [Unreleased]\n", "## [Unreleased]\n### Added\n- More.\n")
        self.refuses("[Unreleased] is not empty")

    def test_a_tree_with_changes(self):
        (self.tree / "new.txt").write_text("")
        self.refuses("1 files that are not committed: new.txt")
        (self.tree / "new.txt").unlink()
        with open(self.tree / "CHANGELOG.md", "a") as f:
            f.write("\n")
        self.refuses("1 files that are not committed: CHANGELOG.md")

    def test_tags(self):
        self.git("tag", "v1.2.3")
        self.assertEqual(self.release("--tested")[0], 0)
        (self.tree / "out/log").write_text("")
        self.commit()
        self.refuses("v1.2.3 is released already")
        self.git("tag", "-d", "v1.2.3")
        self.git("tag", "v1.3.0")
        self.refuses("this commit has the tag v1.3.0, but include/myogrowth/version.hpp has 1.2.3")

    def test_no_repository(self):
        shutil.rmtree(self.tree / ".git")
        self.refuses("./run release: git status --porcelain: fatal: not a git repository")


class ThisTree(unittest.TestCase):
    def test_the_citation_has_the_version_of_the_header(self):
        header = (ROOT / "include/myogrowth/version.hpp").read_text(encoding="utf-8")
        numbers = re.findall(r"#define MYOGROWTH_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", header)
        self.assertRegex((ROOT / "CITATION.cff").read_text(encoding="utf-8"), rf"(?m)^version: {re.escape('.'.join(numbers))}$")


if __name__ == "__main__":
    unittest.main()
