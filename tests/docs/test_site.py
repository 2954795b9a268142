"""The checks of the site find the faults they are made for; quoted code exists. test_site.py ROOT DRIVER"""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT, DRIVER = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(2))


class Links(unittest.TestCase):
    def check(self, pages):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in pages.items():
                (pathlib.Path(folder) / name).write_text(text)
            return subprocess.run([sys.executable, ROOT / "docs/site/check_site.py", folder], text=True,
                                  capture_output=True)

    def test_whole(self):
        run = self.check({"a.html": '<h1 id="here"></h1><a href="#here"></a><a href="b.html#there"></a>',
                          "b.html": '<p id="there"><a href="a.html"></a><a href="https://elsewhere/x"></a>'})
        self.assertEqual((run.returncode, run.stdout), (0, "2 pages, 3 links within the site, 0 broken\n"))

    def test_broken(self):
        for link, why in (("b.html", "no such file"), ("#there", "no such place"), ("a.html#there", "no such place")):
            run = self.check({"a.html": f'<h1 id="here"></h1><a href="{link}"></a>'})
            self.assertEqual(run.returncode, 1)
            self.assertIn(f"a.html: {link}: {why}", run.stderr)
        run = self.check({"a.html": '<img src="a.png">'})
        self.assertIn("a.html: a.png: no such file", run.stderr)
        self.assertIn("no pages there", self.check({}).stderr)


class Doxygen(unittest.TestCase):
    def run_doxygen(self, header):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "one.hpp"
            file.write_text(header)
            settings = (ROOT / "docs/site/Doxyfile").read_text() + f"INPUT = {file}\nOUTPUT_DIRECTORY = {folder}\n"
            return subprocess.run(["doxygen", "-"], input=settings, text=True, capture_output=True, cwd=ROOT)

    def test_documented(self):
        run = self.run_doxygen("/// @file\n/// One.\nnamespace myogrowth {\n/// Twice x.\ndouble twice(double x);\n}\n")
        self.assertEqual((run.returncode, run.stderr), (0, ""))

    def test_undocumented(self):
        run = self.run_doxygen("/// @file\n/// One.\nnamespace myogrowth {\ndouble twice(double x);\n}\n")
        self.assertNotEqual(run.returncode, 0)
        self.assertIn("twice(double x) (function) of namespace myogrowth is not documented", run.stderr)

    def test_detail_is_not_for_users(self):
        run = self.run_doxygen("/// @file\n/// One.\nnamespace myogrowth {\nnamespace detail {\nint f();\n}\n}\n")
        self.assertEqual((run.returncode, run.stderr), (0, ""))


class Quoted(unittest.TestCase):
    def test_the_laws_of_contributing_are_the_examples(self):
        page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
        laws = re.findall(r"^```cpp\n(struct .*?^};)$", page, re.M | re.S)
        for law, name in zip(laws, ("include/myogrowth/more/cross_fibre_growth.hpp", "examples/cpp/elastic_law.cpp"), strict=True):
            example = (ROOT / name).read_text(encoding="utf-8")
            lines = [line.split("//")[0].strip().rstrip(";") for line in law.splitlines()]
            self.assertGreater(len([line for line in lines if line]), 8)
            for line in lines:
                self.assertIn(line, example)

    def test_the_drivers_help_has_every_option(self):
        source = (ROOT / "fortran_driver/driver.f90").read_text(encoding="utf-8")
        options = re.findall(r"--[a-z]+", re.search(r"options = '(.*)'", source).group(1))
        self.assertGreater(len(options), 4)
        help_text = subprocess.run([DRIVER, "--help"], capture_output=True, text=True, check=True).stdout
        for option in options:
            self.assertRegex(help_text, rf"(?m)^  {option}\b")


unittest.main()
