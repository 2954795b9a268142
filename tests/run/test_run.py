"""./run itself, in a tree of its own with stubs in the place of CMake, apt and Python: seconds, and the real build is left alone.

    test_run.py ROOT [CLASS]
"""
import os
import pathlib
import pty
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(sys.argv.pop(1)).resolve()
REFUSED = ['a"b', "a$b", "a#b", "a;b", "a:b", "a,b", "a|b", "a<b", "a>b", "a`b", "a\\b", "a\nb", "a\tb"]
TAKEN = ["a b", "ä", "a'b", "a&b", "a(b)", "a%b", "a=b", "a*b", "a[b]", "a!b", "-a", "a+b", "{a}^~@b@", " a "]
JOBS_WITHOUT_OPTIONS = ["validate", "study-pictures", "law-pictures", "ccx", "package", "python", "docs", "pictures", "tables", "coverage",
                        "verify", "tidy", "format", "help"]

STUBS = {
    # What it was called with goes to $LOG; a build has a begin and an end. $CMAKE says how it is to fail.
    "cmake": r'''#!/bin/bash
case "$*" in
  *"--target help"*) [ "$CMAKE" != no-list ] || { echo "ninja: broken"; exit 3; }; echo "all: phony" ;;
  *--build*)
    for i in {1..300}; do echo "[$i/300] Building CXX object $i"; done
    echo "begin $*" >>"$LOG"
    if [ "$CMAKE" = broken ]; then echo "FAILED: a.cpp"; echo "a.cpp:1: error: no such thing"; exit 1; fi
    while [ -e "$HOLD_BUILD" ]; do sleep 0.02; done
    mkdir -p build/fortran_driver
    printf '#!/bin/bash\necho "driver in $PWD:" "$@"\necho ran >>"$LOG"\n' >build/fortran_driver/myogrowth_driver
    chmod +x build/fortran_driver/myogrowth_driver
    echo "end $*" >>"$LOG" ;;
  *)
    echo "configure $*" >>"$LOG"
    [ "$CMAKE" != unconfigurable ] || { echo "CMake Error: no Fortran"; exit 1; }
    printf 'CMAKE_HOME_DIRECTORY:INTERNAL=%s\nCMAKE_CACHEFILE_DIR:INTERNAL=%s/build\nCMAKE_GENERATOR:INTERNAL=Ninja\n' "$PWD" "$PWD" >build/CMakeCache.txt ;;
esac
''',
    "ninja": "#!/bin/sh\n",
    "dpkg-query": '#!/bin/sh\n[ -z "$MISSING" ] && echo installed\nexit 0\n',
    "apt-get": r'''#!/bin/bash
case "$*" in
  *update*) [ -z "$NO_NETWORK" ] || { echo "E: Could not resolve the mirror"; exit 100; } ;;
  *) [ -z "$NO_NETWORK" ] || { echo "E: Unable to locate package g++"; exit 100; }
     echo "0 upgraded, 200 newly installed"; for i in {1..200}; do echo "Unpacking $i"; echo "Setting up $i"; done ;;
esac
''',
    "sudo": '#!/bin/sh\nexec "$@"\n',
    "python3": '#!/bin/bash\n[ "$1" = -c ] && exit\necho "python in $PWD:" "$@"\necho ran >>"$LOG"\nwhile [ -e "$HOLD_PROGRAM" ]; do sleep 0.02; done\n',
    "mpirun": '#!/bin/sh\necho "mpirun in $PWD:" "$@"\n',
}


class Run(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp()).resolve()
        self.addCleanup(shutil.rmtree, self.folder)
        self.bin = self.folder / "bin"
        self.bin.mkdir()
        for name, text in STUBS.items():
            (self.bin / name).write_text(text)
            (self.bin / name).chmod(0o755)
        self.log = self.folder / "log"
        self.tree = self.make_tree("tree")
        self.folder.chmod(0o755)

    def make_tree(self, name):
        tree = self.folder / name
        for file in ("run", "cmake/prepare.sh", "examples/dealii/run.sh", "examples/muscle/run.sh", "examples/calculix/build_ccx.sh"):
            (tree / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / file, tree / file)
        return tree

    def environment(self, **more):
        path = f"{self.bin}:{os.environ['PATH']}"
        return {**os.environ, "PATH": path, "LOG": str(self.log), "MYOGROWTH_CCX": "/bin/true", "CMAKE": "", **more}

    def run_job(self, *arguments, tree=None, cwd=None, command=None, user=None, **more):
        """Status, standard output and standard error."""
        tree = tree or self.tree
        p = subprocess.run([*(command or [tree / "run"]), *arguments], cwd=cwd or tree, env=self.environment(**more), text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, user=user, errors="replace")
        return p.returncode, p.stdout, p.stderr

    def start(self, *arguments, **more):
        p = subprocess.Popen([self.tree / "run", *arguments], cwd=self.tree, env=self.environment(**more), text=True,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
        self.addCleanup(p.communicate)
        return p

    def logged(self):
        return self.log.read_text().splitlines() if self.log.exists() else []

    def wait_for(self, text):
        for _ in range(400):
            if any(line.startswith(text) for line in self.logged()):
                return
            time.sleep(0.02)
        self.fail(f"no '{text}' in {self.logged()}")

    def refuses(self, text, *arguments, **more):
        status, out, err = self.run_job(*arguments, **more)
        self.assertNotEqual(status, 0)
        self.assertRegex(err, text)
        self.assertEqual(len(err.rstrip("\n").split("\n")), 1, err)
        self.assertEqual(out, "")


class Help(Run):
    def jobs(self):
        source = (ROOT / "run").read_text(encoding="utf-8").rpartition('case "$job" in')[2]
        return [job for line in re.findall(r"^  ([a-z][a-z |-]*)\)", source, re.M) for job in line.split(" | ")]

    def test_every_job_has_a_line_in_the_help_and_the_other_way_round(self):
        status, out, _ = self.run_job("help")
        self.assertEqual(status, 0)
        self.assertGreater(len(self.jobs()), 20)
        self.assertEqual(sorted(re.findall(r"^  ([a-z][a-z-]*)\b", out, re.M)), sorted(set(self.jobs()) - {"--help", "-h"}))
        self.assertEqual(self.run_job(), (0, out, ""))

    def test_the_jobs_that_pages_and_workflows_name_exist(self):
        files = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob(".github/**/*.*"), ROOT / ".ci/run"]
        named = {(job, file) for file in files for job in re.findall(r"\./run +([a-z][a-z-]*)", file.read_text(encoding="utf-8"))}
        self.assertGreater(len({job for job, _ in named}), 15)
        self.assertEqual([(job, file) for job, file in sorted(named) if job not in self.jobs()], [])

    def test_unknown_jobs_and_options_are_refused_before_anything_is_built(self):
        status, _, err = self.run_job("cubes")
        self.assertEqual(status, 2)
        self.assertIn("no job 'cubes'", err)
        for job in JOBS_WITHOUT_OPTIONS:
            self.refuses(f"^./run {job}: takes no options, found '--fast'", job, "--fast")
        self.refuses("no preset 'fast'", "test", "release", "fast")
        for seconds in ("0", "x", "-3", "1 2"):
            self.refuses("whole number of seconds", "fuzz", seconds)
        self.refuses("no option '--fast'", "release", "--fast")
        self.refuses("needs the source file of a UMAT", "umat")
        self.refuses("comes first, found '--out'", "umat", "--out", "folder")
        self.refuses("expected cube or cylinder, found 'ball'", "fenicsx", "ball")
        for option in ("--ranks", "--prm", "--mesh"):
            self.refuses(f"{option} needs a value", "mpi", option)
            self.refuses(f"{option} needs a value", "mpi", option, "")
            self.refuses(f"{option} is given twice", "mpi", option, "2", option, "2")
        self.refuses("no option 'x'", "mpi", "x")
        for arguments in (["--ranks", "2"], ["PART=all"], ["PART=loops", "PART=weak"]):
            self.refuses("expected PART= and some of loops,krylov,ranks,weak,muscle,answer, found '" + " ".join(arguments), "mpi-bench", *arguments)
        self.refuses("no option '--fast' \\(--update\\)", "instructions", "--fast")
        self.refuses("--ranks 0: must be", "mpi", "--ranks", "0")
        self.assertEqual(self.logged(), [])


class Lock(Run):
    def setUp(self):
        super().setUp()
        self.held = self.folder / "held"
        self.held.write_text("")
        self.addCleanup(self.held.unlink, missing_ok=True)

    def release_when_it_waits(self, second, text):
        """Lets the first go on as soon as the second says that it waits."""
        said = ""
        while "waits" not in said:
            line = second.stderr.readline()
            self.assertTrue(line, said)
            said += line
        self.held.unlink()
        self.assertIn(text, said)

    def steps(self):
        return [line.split()[0] for line in self.logged() if line != "ran"]

    def test_the_second_waits_for_the_first_and_says_for_whom(self):
        first = self.start("driver", HOLD_BUILD=str(self.held))
        self.wait_for("begin")
        second = self.start("cube")
        self.release_when_it_waits(second, f"./run cube: waits for ./run driver (process {first.pid}), which uses build/")
        self.assertEqual((first.wait(), second.wait()), (0, 0))
        self.assertEqual(self.steps(), ["configure", "begin", "end"] * 2)

    def test_tests_of_two_presets_wait_too(self):
        (self.bin / "ctest").write_text('#!/bin/sh\necho "tests $*" >>"$LOG"\nwhile [ -e "$HOLD_TESTS" ]; do sleep 0.02; done\n')
        (self.bin / "ctest").chmod(0o755)
        first = self.start("test", "release", HOLD_TESTS=str(self.held))
        self.wait_for("tests --preset release")
        second = self.start("test", "clang")
        self.release_when_it_waits(second, "./run test: waits for ./run test")
        self.assertEqual((first.wait(), second.wait()), (0, 0))
        self.assertEqual(self.steps(), ["configure", "begin", "end", "tests"] * 2)

    def test_three_in_a_fresh_clone(self):
        runs = [self.start("driver") for _ in range(3)]
        self.assertEqual([r.wait() for r in runs], [0, 0, 0])
        self.assertEqual(self.steps(), ["configure", "begin", "end"] * 3)

    def test_a_killed_run_leaves_no_lock(self):
        first = self.start("driver", HOLD_BUILD=str(self.held))
        self.wait_for("begin")
        os.killpg(first.pid, signal.SIGKILL)
        first.wait()
        status, _, err = self.run_job("driver")
        self.assertEqual(status, 0)
        self.assertNotIn("waits", err)

    def test_compilers_that_outlive_a_killed_run_keep_the_lock(self):
        first = self.start("driver", HOLD_BUILD=str(self.held))
        self.wait_for("begin")
        first.kill()
        first.wait()
        second = self.start("driver")
        self.release_when_it_waits(second, f"waits for ./run driver (process {first.pid})")
        self.assertEqual(second.wait(), 0)
        self.assertEqual(self.steps(), ["configure", "begin", "end"] * 2)

    def test_the_lock_goes_with_a_folder_that_was_removed(self):
        first = self.start("driver", HOLD_BUILD=str(self.held))
        self.wait_for("begin")
        shutil.rmtree(self.tree / "build")
        status, _, err = self.run_job("driver")
        self.assertEqual(status, 0)
        self.assertNotIn("waits", err)
        self.held.unlink()
        first.wait()

    def test_programs_keep_no_lock_but_that_of_their_default_folder(self):
        first = self.start("cube", HOLD_PROGRAM=str(self.held))
        self.wait_for("ran")
        self.assertNotIn("waits", self.run_job("driver")[2])
        for arguments in (["--out", "mine"], ["--help"]):
            other = self.start("cube", *arguments)
            self.assertNotIn("waits", other.communicate()[1])
        self.assertIsNone(first.poll())
        second = self.start("cube")
        self.release_when_it_waits(second, f"./run cube: waits for ./run cube (process {first.pid}), which uses out/cube/")
        self.assertEqual((first.wait(), second.wait()), (0, 0))


class BuildFolder(Run):
    def spoil(self, line, text):
        self.assertEqual(self.run_job("driver")[0], 0)
        cache = self.tree / "build/CMakeCache.txt"
        name = line.partition(":")[0]
        old = [kept for kept in cache.read_text().splitlines() if not kept.startswith(name + ":")]
        cache.write_text("\n".join([*old, line]) + "\n")
        self.refuses(text + r".*: remove build/$", "driver")

    def test_a_moved_tree(self):
        self.assertEqual(self.run_job("driver")[0], 0)
        moved = self.folder / "moved"
        self.tree.rename(moved)
        self.refuses(f"build/ was made for the tree in {self.tree}, not for this one: remove build/", "driver", tree=moved)
        shutil.rmtree(moved / "build")
        self.assertEqual(self.run_job("driver", tree=moved)[0], 0)

    def test_a_copied_build_folder(self):
        self.spoil("CMAKE_CACHEFILE_DIR:INTERNAL=/old/build", "was made as /old/build, and moved")

    def test_another_generator(self):
        self.spoil("CMAKE_GENERATOR:INTERNAL=Unix Makefiles", "was made for Unix Makefiles, not for Ninja")

    def test_another_compiler(self):
        self.spoil("CMAKE_CXX_COMPILER:STRING=/bin/true", "compiler /bin/true, but g\\+\\+ is now")

    def test_a_compiler_that_is_gone(self):
        self.spoil("CMAKE_Fortran_COMPILER:STRING=/opt/old/gfortran", "with /opt/old/gfortran, which is not there any more")

    def test_a_file_in_its_place(self):
        (self.tree / "build").write_text("")
        self.refuses("is no folder: remove build", "driver")

    @unittest.skipIf(os.getuid() != 0, "root only: needs a second user")
    def test_another_users_build_folder_and_a_tree_that_is_not_mine(self):
        self.log.write_text("")
        self.log.chmod(0o666)
        self.refuses(f"cannot make the folder {self.tree}/build: .*clone it", "driver", user=65534)
        self.assertEqual(self.run_job("driver")[0], 0)
        self.refuses("build/ has files of the user root, which you may not write: remove build/", "driver", user=65534)

    def test_cmakes_own_fault_is_shown_in_full(self):
        status, _, err = self.run_job("driver", CMAKE="unconfigurable")
        self.assertEqual(status, 1)
        self.assertIn("CMake Error: no Fortran", err)


class Paths(Run):
    def test_folders_that_cmake_cannot_take_are_refused_in_one_sentence(self):
        for name in REFUSED:
            with self.subTest(name):
                self.refuses("has one of .* in its name.*: rename it", "cube", tree=self.make_tree(name))
                self.assertEqual(self.logged(), [])

    def test_other_folders_work(self):
        for name in TAKEN:
            with self.subTest(name):
                tree = self.make_tree(name)
                status, out, err = self.run_job("driver", "x", tree=tree)
                self.assertEqual((status, out), (0, f"driver in {tree}: x\n"), err)

    def test_cmake_takes_the_folders_that_are_not_refused(self):
        project = self.folder / "".join(TAKEN)
        project.mkdir()
        (project / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.21)\nproject(p LANGUAGES C)\nadd_library(l SHARED l.c)\n"
                                                "add_executable(m m.c)\ntarget_link_libraries(m l)\n")
        (project / "l.c").write_text("int l(void) { return 0; }\n")
        (project / "m.c").write_text("int l(void);\nint main(void) { return l(); }\n")
        for command in (["cmake", "-G", "Ninja", "-S", ".", "-B", "build"], ["cmake", "--build", "build"], ["build/m"]):
            p = subprocess.run(command, cwd=project, capture_output=True, text=True)
            self.assertEqual(p.returncode, 0, p.stdout + p.stderr)


class Names(Run):
    def setUp(self):
        super().setUp()
        self.here = self.folder / "elsewhere"
        self.here.mkdir()

    def test_relative_names_are_those_of_where_the_user_stands(self):
        t, here = self.tree, self.here
        pictures = f"{t}/examples/common/pictures.py"
        for arguments, said in (
                (["driver", "case.nml", "--umat", "./lib.so"], f"driver in {here}: case.nml --umat ./lib.so"),
                (["cube", "--out", "mine"], f"python in {here}: {t}/fortran_driver/cube.py --driver {t}/build/fortran_driver/myogrowth_driver --out mine\n"),
                (["cube"], f"/myogrowth_driver --out {t}/out/cube\n"),
                (["fit", "mydata.csv", "--out", "here"],
                 f"python in {here}: {pictures} fit {t}/build/examples/study_fit mydata.csv --out here\n"),
                (["fit", "--set", "tau=2", "a/b.c.csv"], f"--out {t}/out/fit/b.c --set tau=2 a/b.c.csv"),
                (["protocol", "a.csv"], f"python in {here}: {pictures} protocol {t}/build/examples/study_protocol --out {t}/out/protocol a.csv"),
                (["protocol", "--design", "1.1"], f"--out {t}/out/design --design 1.1"),
                (["sensitivity"], f"--out {t}/out/sensitivity"),
                (["cylinder", "--resume"], f"python in {here}: {t}/examples/calculix/cylinder.py --ccx /bin/true "
                                           f"--library-dir {t}/build/abi --out {t}/out/cylinder --resume"),
                (["studies", "--write", "my.md"], f"--out {t}/out/studies --paper {t}/out/paper --write my.md")):
            with self.subTest(arguments):
                status, out, err = self.run_job(*arguments, cwd=here)
                self.assertEqual(status, 0, err)
                self.assertIn(said, out)
        # From the tree itself the default folders are named as short as the help names them.
        self.assertIn("--out out/fit/mydata mydata.csv", self.run_job("fit", "mydata.csv")[1])

    def test_mpi(self):
        stub = (self.bin / "cmake").read_text().replace("all: phony", "muscle: phony")
        (self.bin / "cmake").write_text(stub)
        t, here = self.tree, self.here
        muscle = f"{t}/build/examples/dealii/muscle"
        status, out, err = self.run_job("mpi", "--prm", "my.prm", "Output/Folder=mine", cwd=here)
        self.assertEqual((status, out), (0, "mpirun -n 2 muscle my.prm Output/Folder=mine\n"
                                            f"mpirun in {here}: -n 2 {muscle} my.prm Output/Folder=mine\n"), err)
        self.assertEqual(self.run_job("mpi", "Time/End=1", cwd=here)[1].splitlines(keepends=True)[1],
                         f"mpirun in {here}: -n 2 {muscle} {t}/examples/dealii/biceps.prm Output/Folder={t}/out/mpi Time/End=1\n")
        self.assertEqual(self.run_job("mpi", "--entries", cwd=here)[1], f"mpirun in {here}: -n 1 {muscle} --help\n")

    def test_muscle(self):
        """The mesh is checked before the solver is built; only the report, a deck and the options need no solver."""
        stub = (self.bin / "cmake").read_text().replace("all: phony", "muscle: phony")
        (self.bin / "cmake").write_text(stub)
        t, here = self.tree, self.here
        job, program = f"{t}/examples/muscle/muscle.py", f"--program {t}/build/examples/dealii/muscle"
        status, out, err = self.run_job("muscle", "m.inp", "--unit", "mm", "Time/End=7", cwd=here)
        self.assertEqual((status, out), (0, f"python in {here}: {job} {program} --out {t}/out/muscle m.inp --unit mm Time/End=7\n"), err)
        log = self.logged()
        self.assertEqual(log[0], "ran")  # Python, that checks
        self.assertTrue(any(line.startswith("begin --build") and "--target muscle" in line for line in log), log)
        self.assertIn(f"{program} --out mine m.inp --unit mm", self.run_job("muscle", "--out", "mine", "m.inp", "--unit", "mm", cwd=here)[1])
        self.assertIn(f"{program} --out out/muscle\n", self.run_job("muscle")[1])
        self.assertEqual(self.run_job("muscle", "--entries", cwd=here)[1],
                         f"mpirun in {here}: -n 1 {t}/build/examples/dealii/muscle --help\n")
        for words in (["--check"], ["--export", "calculix"], ["--export=abaqus"], ["--help"]):
            self.log.write_text("")
            status, out, err = self.run_job("muscle", "m.inp", "--unit", "mm", *words, cwd=here)
            self.assertEqual((status, self.logged()), (0, ["ran"]), err)
            self.assertIn(" ".join(["m.inp --unit mm", *words]), out)
        self.log.write_text("")
        python = (self.bin / "python3").read_text().replace("echo ran", 'case "$*" in *--check*) echo "no mesh" >&2; exit 2 ;; esac; echo ran')
        (self.bin / "python3").write_text(python)
        self.assertEqual(self.run_job("muscle", "no.inp", "--unit", "mm"), (2, "", "no mesh\n"))
        self.assertEqual(self.logged(), [])

    def test_muscle_is_skipped_without_deal_ii(self):
        self.assertEqual(self.run_job("muscle")[0], 77)
        self.assertEqual(self.run_job("muscle", "m.inp", "--check")[0], 0)

    def test_mpi_is_skipped_without_deal_ii_but_a_broken_build_is_no_skip(self):
        self.assertEqual(self.run_job("mpi")[0], 77)
        status, _, err = self.run_job("mpi", CMAKE="no-list")
        self.assertEqual(status, 1, err)
        self.assertIn("cannot list the build's targets", err)

    def test_however_it_is_started(self):
        said = f"driver in {self.here}: x\n"
        link = self.here / "linked"
        link.symlink_to(self.tree / "run")
        for command in ([link], ["sh", self.tree / "run"], ["bash", "../tree/run"], ["./linked"]):
            self.assertEqual(self.run_job("driver", "x", cwd=self.here, command=command)[:2], (0, said))
        through = self.folder / "through"
        through.symlink_to(self.tree)
        self.assertEqual(self.run_job("driver", "x", cwd=self.here, command=[through / "run"])[:2], (0, said))
        self.assertEqual(self.run_job("driver", "x", cwd=self.tree, command=["sh", "run"])[:2], (0, f"driver in {self.tree}: x\n"))

    def test_whatever_the_environment_is(self):
        said = f"driver in {self.here}: x\n"
        for more in ({"CDPATH": "/:/tmp:/usr"}, {"GREP_OPTIONS": "-v"}, {"LC_ALL": "tr_TR.UTF-8"}, {"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE"},
                     {"POSIXLY_CORRECT": "1"}, {"TMPDIR": "/nonexistent"}):
            self.assertEqual(self.run_job("driver", "x", cwd=self.here, command=["../tree/run"], **more)[:2], (0, said), more)
        command = ["env", "-u", "HOME", "-u", "TERM", self.tree / "run"]
        self.assertEqual(self.run_job("driver", "x", cwd=self.here, command=command)[:2], (0, said))
        (self.here / "ccx").symlink_to("/bin/true")
        self.assertEqual(self.run_job("ccx", cwd=self.here, MYOGROWTH_CCX="./ccx")[1], f"{self.here}/./ccx\n")


class Quiet(Run):
    def test_a_build_is_two_lines_where_output_is_no_terminal(self):
        status, out, err = self.run_job("driver")
        self.assertEqual((status, out), (0, f"driver in {self.tree}:\n"))
        self.assertRegex(err, r"\Abuilding myogrowth_driver \(release\)\nbuilt in \d+ s\n\Z")

    def test_a_build_moves_on_a_terminal(self):
        here, there = pty.openpty()
        subprocess.run([self.tree / "run", "driver"], env=self.environment(TERM="xterm"), stdout=subprocess.DEVNULL, stderr=there)
        os.close(there)
        said = b""
        try:
            while chunk := os.read(here, 65536):
                said += chunk
        except OSError:  # the end, as Linux says it
            pass
        os.close(here)
        self.assertIn(b"[300/300] Building", said)

    def test_errors_are_shown_in_full_and_are_the_status(self):
        status, out, err = self.run_job("cube", CMAKE="broken")
        self.assertEqual((status, out), (1, ""))
        self.assertIn("FAILED: a.cpp\na.cpp:1: error: no such thing\n./run cube: building myogrowth_driver failed (above)\n", err)
        self.assertNotIn("[300/300]", err)
        self.assertNotIn("ran", self.logged())

    def test_the_status_is_that_of_the_program(self):
        for status in (1, 3, 75):
            (self.bin / "python3").write_text(f'#!/bin/bash\n[ "$1" = -c ] && exit\nexit {status}\n')
            for job in ("cube", "fit", "protocol", "sensitivity", "cylinder", "studies"):
                self.assertEqual(self.run_job(job, "a.csv")[0], status, job)

    def test_apt_is_two_lines(self):
        status, _, err = self.run_job("driver", MISSING="1")
        self.assertEqual(status, 0)
        self.assertRegex(err, r"\Ainstalling g\+\+ gfortran cmake .*\ninstalled\nbuilding ")
        self.assertNotIn("\r", err)

    def test_without_network_what_is_missing_is_named(self):
        status, out, err = self.run_job("driver", MISSING="1", NO_NETWORK="1")
        self.assertEqual((status, out), (1, ""))
        self.assertIn("E: Unable to locate package g++", err)
        self.assertRegex(err, r"./run driver: could not install g\+\+ gfortran cmake ninja-build .*: install them")
        self.assertEqual(self.logged(), [])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])
