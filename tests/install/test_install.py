"""The installed and packaged files, used as a user would: CMake, pkg-config and make, Fortran, as part of a project.

test_install.py BUILD SOURCE CMAKE CXX C FORTRAN WORK [unittest arguments]; every class is a ctest, `Staged` the first.
"""
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
CMAKE, CXX, C, FORTRAN = sys.argv[3:7]
WORK = pathlib.Path(sys.argv[7]).resolve()
STAGE = WORK / "stage" / "usr"
CONSUMER = SOURCE / "tests" / "install" / "consumer"
VERSION = ".".join(re.findall(r"MYOGROWTH_VERSION_\w+ (\d+)", (SOURCE / "include/myogrowth/version.hpp").read_text()))


def run(*command, ok=True, **environment):
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, env={**os.environ, **environment})
    assert not ok or done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout if ok else done.stderr


def exact():
    """G after the consumers' step, from eq. 4 in backward Euler by bisection, and sigma_11 from eqs 1-3."""
    stretch, lateral, dt = 1.2, 0.95, 0.1
    low, high = 1.0, 1.1
    for _ in range(100):
        G = (low + high) / 2
        residual = G - 1 - dt / 0.5 * ((1.1 - G) / 0.1) ** 2 * (stretch / G - 1.01)
        low, high = (G, high) if residual < 0 else (low, G)
    J = stretch * lateral**2
    return G, (16 * math.log(J / G) + 4 * ((stretch / G) ** 2 - 1)) / J


class Case(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory(prefix="myogrowth_")
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def expect_numbers(self, printed):
        for found, wanted in zip(map(float, printed.split()), exact(), strict=True):
            self.assertAlmostEqual(found, wanted, delta=2e-14 * abs(wanted))

    def configure(self, source, *options, ok=True, build="build"):
        return run(CMAKE, "-S", source, "-B", self.folder / build, f"-DCMAKE_CXX_COMPILER={CXX}",
                   f"-DCMAKE_C_COMPILER={C}", f"-DCMAKE_Fortran_COMPILER={FORTRAN}", *options, ok=ok)

    def refused(self, *options, prefix=STAGE):
        """CMake's message where find_package fails; without a language, which is faster."""
        text = self.configure(CONSUMER, f"-DCMAKE_PREFIX_PATH={prefix}", "-DLANGUAGES=NONE", *options, ok=False,
                              build=f"refused{len(list(self.folder.iterdir()))}")
        return " ".join(text.split())


class Staged(Case):
    """Installed as packagers do, into a folder that is not the prefix."""

    def test_it_installs_what_it_says_and_no_more(self):
        shutil.rmtree(WORK, ignore_errors=True)
        run(CMAKE, "--install", BUILD, "--prefix", "/usr", DESTDIR=str(STAGE.parent))
        files = {str(f.relative_to(STAGE)) for f in STAGE.rglob("*") if not f.is_dir()}
        headers = {str(f.relative_to(SOURCE)) for f in (SOURCE / "include/myogrowth").rglob("*.hpp")}
        self.assertLessEqual(headers, files)
        rest = {f for f in files if not re.match(r"include/myogrowth/|lib/(cmake|pkgconfig)/|share/myogrowth/cases/", f)}
        libraries = ["MYOGROWTH", *(f"myogrowth{x}" for x in ("", "_umat", "_vumat", "_vumat_float", "_mgis", "_comsol", "_probe"))]
        minor = VERSION.rsplit(".", 1)[0]
        expected = {"bin/myogrowth_driver", "include/myogrowth.h", "share/doc/myogrowth/copyright", "lib/libmyogrowth_abaqus.so",
                    "share/myogrowth/umat/compile.sh", "share/myogrowth/umat/ABA_PARAM.INC",
                    *(f"lib/lib{x}.so" for x in libraries), f"lib/libmyogrowth.so.{minor}", f"lib/libmyogrowth.so.{VERSION}"}
        self.assertEqual(rest - {"share/myogrowth/myogrowth_umat_single.cpp"}, expected)

    def test_nothing_of_how_we_build_or_where_is_in_it(self):
        for file in [*STAGE.rglob("*.cmake"), *STAGE.rglob("*.pc")]:
            text = file.read_text()
            for word in (str(SOURCE), str(BUILD), str(STAGE), "-march", "-ffast-math", "-Werror", "-O", "myogrowth_own"):
                self.assertNotIn(word, text, file)
        for binary in [STAGE / "bin/myogrowth_driver", *STAGE.glob("lib/*.so")]:
            paths = re.findall(r"\((?:RPATH|RUNPATH)\).*\[(.*)\]", run("readelf", "-d", binary))
            self.assertEqual(paths, ["$ORIGIN/../lib"] if binary.parent.name == "bin" else [], binary)


class FindPackage(Case):
    """By find_package, in C++, C and Fortran; a missing component is named."""

    def test_all_components(self):
        said = self.configure(CONSUMER, f"-DCMAKE_PREFIX_PATH={STAGE}")
        self.assertIn(f"myogrowth {VERSION} in {STAGE}", said)
        self.assertIn(f"mgis: {STAGE}/lib/libmyogrowth_mgis.so", said)
        self.assertIn("usage", run(CMAKE, "--build", self.folder / "build").lower())
        for program in ("headers", "c_api", "umat"):
            self.expect_numbers(run(self.folder / "build" / program))

    def test_the_libraries_need_no_eigen(self):
        self.configure(CONSUMER, f"-DCMAKE_PREFIX_PATH={STAGE}", "-DCOMPONENTS=umat", "-DLANGUAGES=C;Fortran",
                       "-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON")

    def test_what_is_missing_is_named(self):
        self.assertIn("myogrowth has no component 'vumat': there are headers, umat and driver.",
                      self.refused("-DCOMPONENTS=vumat"))
        self.assertIn("'headers' needs Eigen 3.4 or newer, which was not found (Eigen3_DIR).",
                      self.refused("-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON"))
        self.assertIn(f"version: {VERSION}", self.refused("-DVERSION=9"))
        run(CMAKE, "--install", BUILD, "--prefix", self.folder / "headers", "--component", "headers")
        self.assertIn("myogrowth's component 'umat' is not installed in",
                      self.refused("-DCOMPONENTS=headers;umat", prefix=self.folder / "headers"))
        self.configure(CONSUMER, f"-DCMAKE_PREFIX_PATH={self.folder}/headers", "-DCOMPONENTS=headers",
                       "-DLANGUAGES=CXX", build="alone")

    def test_a_project_may_ask_for_old_policies(self):
        run(CMAKE, "--install", BUILD, "--prefix", self.folder / "headers", "--component", "headers")
        project = self.folder / "old"
        project.mkdir()
        (project / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.1)\nproject(old LANGUAGES CXX)\n"
            "find_package(myogrowth REQUIRED COMPONENTS headers)\nmessage(STATUS \"found ${myogrowth_VERSION}\")\n")
        self.assertIn(f"found {VERSION}", self.configure(project, f"-DCMAKE_PREFIX_PATH={self.folder}/headers", build="b"))

    def test_eigen_5_is_accepted(self):
        eigen = self.folder / "eigen5"
        eigen.mkdir()
        where = re.findall(r"-I(\S+)", run("pkg-config", "--cflags", "eigen3"))
        (eigen / "Eigen3Config.cmake").write_text(
            "add_library(Eigen3::Eigen INTERFACE IMPORTED)\n"
            f"set_target_properties(Eigen3::Eigen PROPERTIES INTERFACE_INCLUDE_DIRECTORIES {where[0]})\n"
            'message(STATUS "this is Eigen 5")\n')
        (self.folder / "version.cmake").write_text(
            "include(CMakePackageConfigHelpers)\n"
            f"write_basic_package_version_file({eigen}/Eigen3ConfigVersion.cmake VERSION 5.0.1 "
            "COMPATIBILITY SameMajorVersion ARCH_INDEPENDENT)\n")
        run(CMAKE, "-P", self.folder / "version.cmake")
        said = self.configure(CONSUMER, f"-DCMAKE_PREFIX_PATH={eigen};{STAGE}", "-DCOMPONENTS=headers", "-DLANGUAGES=CXX")
        self.assertIn("this is Eigen 5", said)


class PkgConfig(Case):
    """By pkg-config and a plain Makefile, from a tree that has been moved."""

    def test_make(self):
        moved = self.folder / "elsewhere"
        shutil.copytree(STAGE, moved, symlinks=True)
        shutil.copytree(CONSUMER, self.folder / "project")
        where = {"PKG_CONFIG_PATH": str(moved / "lib/pkgconfig"), "LD_LIBRARY_PATH": str(moved / "lib")}
        run("make", "-C", self.folder / "project", f"CXX={CXX}", f"CC={C}", f"FC={FORTRAN}", **where)
        for program in ("headers", "c_api", "umat"):
            self.expect_numbers(run(self.folder / "project" / program, **where))
        self.assertEqual(run("pkg-config", "--modversion", "myogrowth", **where).strip(), VERSION)
        self.assertEqual(run("pkg-config", "--libs", "myogrowth", **where).strip(), "")


class Subdirectory(Case):
    """As part of another project, by add_subdirectory and FetchContent."""

    def build(self, *options):
        source = SOURCE / "tests/install/subdirectory"
        self.configure(source, f"-DMYOGROWTH_SOURCE={SOURCE}", *options)
        run(CMAKE, "--build", self.folder / "build", "--parallel", "2")
        self.expect_numbers(run(self.folder / "build/headers"))
        commands = json.loads((self.folder / "build/compile_commands.json").read_text())
        return {pathlib.Path(c["file"]).name: c["command"] for c in commands}

    def test_headers_alone(self):
        for fetch in ("OFF", "ON"):
            with self.subTest(fetch=fetch):
                commands = self.build(f"-DFETCH={fetch}")
                self.assertEqual(list(commands), ["headers.cpp"])  # nothing of ours is compiled
                self.assertNotRegex(commands["headers.cpp"], r" -W| -O| -march| -f")
                targets = run(CMAKE, "--build", self.folder / "build", "--target", "help")
                self.assertNotRegex(targets, r"_tests|install/local.*myogrowth")
                run(CMAKE, "--install", self.folder / "build", "--prefix", self.folder / "prefix")
                self.assertFalse(list((self.folder / "prefix").rglob("*")))  # nor installed

    def test_a_library_that_links_it_can_be_exported(self):
        project = self.folder / "library"
        project.mkdir()
        (project / "CMakeLists.txt").write_text(f"""
cmake_minimum_required(VERSION 3.21)
project(library LANGUAGES CXX)
include(FetchContent)
set(MYOGROWTH_INSTALL ON)
FetchContent_Declare(myogrowth SOURCE_DIR {SOURCE})
FetchContent_MakeAvailable(myogrowth)
add_library(library INTERFACE)
target_link_libraries(library INTERFACE myogrowth::myogrowth)
install(TARGETS library EXPORT library)
install(EXPORT library FILE library-config.cmake NAMESPACE library:: DESTINATION lib/cmake/library)
""")
        self.configure(project, build="library_build")
        run(CMAKE, "--install", self.folder / "library_build", "--prefix", self.folder / "prefix")
        user = self.folder / "user"
        user.mkdir()
        (user / "CMakeLists.txt").write_text(f"""
cmake_minimum_required(VERSION 3.21)
project(user LANGUAGES CXX)
find_package(myogrowth REQUIRED)
find_package(library REQUIRED)
add_executable(headers {CONSUMER}/headers.cpp)
target_link_libraries(headers PRIVATE library::library)
""")
        self.configure(user, f"-DCMAKE_PREFIX_PATH={self.folder}/prefix")
        run(CMAKE, "--build", self.folder / "build")
        self.expect_numbers(run(self.folder / "build/headers"))

    def test_with_the_umat(self):
        commands = self.build("-DMYOGROWTH_BUILD_UMAT=ON")
        self.assertNotRegex(commands["umat.f90"], r" -W| -O| -march| -f")
        self.assertIn("-Wall", commands["umat.cpp"])
        self.assertNotIn("-Werror", commands["umat.cpp"])  # our warnings must not stop a user's build
        self.expect_numbers(run(self.folder / "build/umat"))


class Package(Case):
    """The Debian package, unpacked into an empty folder; its driver compared with that of the build tree."""

    def test_deb_and_tar(self):
        run("cpack", "--config", BUILD / "CPackConfig.cmake", "-B", self.folder / "made")
        (deb,), (tar,) = (list((self.folder / "made").glob(p)) for p in ("*.deb", "*.tar.gz"))
        fields = dict(re.findall(r"^ ?([\w-]+): (.*)$", run("dpkg-deb", "--field", deb), re.M))
        self.assertEqual((fields["Package"], fields["Version"]), ("myogrowth", VERSION))
        self.assertEqual(fields["Recommends"], "libeigen3-dev")
        needs = {re.split(r"[ (|]", need.strip())[0] for need in fields["Depends"].split(",")}
        self.assertLessEqual({"libc6", "libgfortran5"}, needs)
        # The driver is linked with only these: no libstdc++, no library of ours, any BLAS.
        self.assertLessEqual(needs, {"libc6", "libgfortran5", "liblapack3", "libblas3", "libgcc-s1"})
        run("dpkg-deb", "-x", deb, self.folder / "root")
        run("tar", "-C", self.folder, "-xzf", tar)
        unpacked = [self.folder / "root/usr", self.folder / tar.name.removesuffix(".tar.gz")]
        for prefix in unpacked:
            for file in prefix.rglob("*"):
                self.assertFalse(file.is_symlink() and file.readlink().is_absolute(), file)
                self.assertFalse(file.lstat().st_mode & 0o022 and not file.is_symlink(), f"{file} is for all to write")
        own = BUILD / "fortran_driver/myogrowth_driver"
        for case in ("shear", "traction_oblique"):
            written = []
            for i, driver in enumerate([own, *(prefix / "bin/myogrowth_driver" for prefix in unpacked)]):
                out = self.folder / f"{case}_{i}"
                run(driver, unpacked[0] / f"share/myogrowth/cases/{case}.nml", "--quiet", "--out", out,
                    LD_LIBRARY_PATH="")
                written.append((out / "history.csv").read_text())
            self.assertGreater(len(written[0].splitlines()), 10)
            self.assertEqual(written[1], written[0])
            self.assertEqual(written[2], written[0])
        for prefix in unpacked:  # somebody else's UMAT: the library of utilities is found
            library = self.folder / "foreign.so"
            run(prefix / "share/myogrowth/umat/compile.sh", SOURCE / "tests/driver/foreign_umat.f", library)
            case = self.folder / "foreign.nml"
            case.write_text("&material props = 1000.0, 0.3, 0.0 nstatv = 12 cmname = 'STEEL' /\n&time duration = 1.0 dt = 0.5 /\n")
            self.assertIn("2 increments", run(prefix / "bin/myogrowth_driver", case, "--umat", library, "--out", self.folder))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[8:]], verbosity=2)
