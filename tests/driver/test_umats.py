"""Other people's UMATs in the driver: the utilities that they call, their sources, names and states.

test_umats.py DRIVER UTILITIES SOURCE [unittest arguments]; every class is a ctest.
"""
import csv
import ctypes
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

DRIVER, UTILITIES, SOURCE = (pathlib.Path(p).resolve() for p in sys.argv[1:4])
COMPILE = SOURCE / "fortran_driver/umat/compile.sh"
FOREIGN = SOURCE / "tests/driver/foreign_umat.f"
ROWS, COLUMNS = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
CASE = """&material
  props = 1000.0, 0.3, {what}
  nstatv = 12
  cmname = '{name}'
  statev_names = 'E11', 'E22', 'E33', 'E12', 'E13', 'E23', 'RATE', 'PMAX', 'PRESS', 'MISES', 'PLACE'
  statev_initial = 11*0.0, 5.0
/
&time duration = 1.0  dt = 0.25 /
&face name = 'x-' /
&face name = 'y-' /
&face name = 'z-' /
&face name = 'x+' time = 0.0, 1.0 value = 0.0, 0.1 /
"""
UMAT = """subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, &
  temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, dfgrd0, dfgrd1, &
  noel, npt, layer, kspt, kstep, kinc)
  {include}
  character*80 cmname
  dimension stress(ntens), statev(nstatv), ddsdde(ntens, ntens), dstran(ntens), ps(3), an(3, 3)
  ddsdde = 0
  do i = 1, ntens
    ddsdde(i, i) = 100
  end do
  stress = stress + 100*dstran
  {more}
end subroutine
"""
INCLUDE = "include 'ABA_PARAM.INC'"
C = """void {name}(double* stress, double* statev, double* ddsdde, double* sse, double* spd, double* scd, double* rpl,
  double* ddsddt, double* drplde, double* drpldt, double* stran, double* dstran)
{{ for (int i = 0; i < 6; ++i) {{ ddsdde[7 * i] = 100; stress[i] += 100 * dstran[i]; }} statev[0] = 7; }}"""


class Folder(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory(prefix="myogrowth_")
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name).resolve()

    def write(self, name, text):
        (self.folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return self.folder / name

    def compile(self, source):
        return subprocess.run([COMPILE, source, self.folder / "umat.so"], stderr=subprocess.PIPE, text=True)

    def run_umat(self, source, case, *options):
        done = self.compile(source)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        if isinstance(case, str):
            case = self.write("case.nml", case)
        out = self.folder / "out"
        done = subprocess.run([DRIVER, *([case] if case else []), "--umat", self.folder / "umat.so", "--out", "out", *options],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=60, cwd=self.folder)
        self.rows = []
        if (out / "history.csv").exists():
            with open(out / "history.csv") as f:
                self.rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]
        return done


class Utilities(unittest.TestCase):
    """Against NumPy, which knows nothing of Abaqus's order of components."""

    @classmethod
    def setUpClass(cls):
        cls.library = ctypes.CDLL(str(UTILITIES))
        cls.random = np.random.default_rng(1)

    def call(self, name, *arguments):
        def address(a):
            return ctypes.byref(ctypes.c_int(a)) if isinstance(a, int) else a.ctypes.data_as(ctypes.c_void_p)

        getattr(self.library, name + "_")(*map(address, arguments))

    def tensors(self):
        """Components, the tensor, LSTR, NDI and NSHR: of solids, plane strain, plane stress, a rod, with and without shear."""
        for ndi, nshr in ((3, 3), (3, 1), (2, 1), (3, 0), (1, 0), (1, 1), (2, 3), (3, 2)):
            for lstr in (1, 2):
                for scale in (1.0, 1e-9, 1e12):
                    a = np.zeros((3, 3))
                    for k in [*range(ndi), *range(3, 3 + nshr)]:
                        a[ROWS[k], COLUMNS[k]] = a[COLUMNS[k], ROWS[k]] = scale * self.random.standard_normal()
                    yield self.components(a, lstr, ndi, nshr), a, lstr, ndi, nshr

    @staticmethod
    def components(a, lstr, ndi, nshr):
        s = [a[i, i] for i in range(ndi)] + [(lstr if lstr == 2 else 1) * a[ROWS[k], COLUMNS[k]] for k in range(3, 3 + nshr)]
        return np.array(s)

    def test_principal_values_and_directions(self):
        for s, a, *kind in self.tensors():
            expected = np.linalg.eigh(a)[0]
            ps, only, an = np.full(3, 9.0), np.full(3, 9.0), np.full((3, 3), 9.0, order="F")
            self.call("sprind", s, ps, an, *kind)
            self.call("sprinc", s, only, *kind)
            scale = np.abs(a).max()
            np.testing.assert_allclose(ps, expected, rtol=0, atol=1e-14 * scale)
            np.testing.assert_allclose(only, expected, rtol=0, atol=1e-14 * scale)
            for k in range(3):  # AN(k, :) is the direction of PS(k)
                np.testing.assert_allclose(a @ an[k], ps[k] * an[k], rtol=0, atol=3e-14 * scale)
            np.testing.assert_allclose(an @ an.T, np.eye(3), rtol=0, atol=1e-14)
            self.assertAlmostEqual(np.linalg.det(an), 1, delta=1e-14)

    def test_equal_principal_values(self):
        for a in (np.zeros((3, 3)), 7 * np.eye(3), np.diag([1.0, 1.0, 3.0])):
            ps, an = np.full(3, 9.0), np.full((3, 3), 9.0, order="F")
            self.call("sprind", self.components(a, 1, 3, 3), ps, an, 1, 3, 3)
            np.testing.assert_allclose(ps, np.diag(a), rtol=0, atol=1e-14)
            np.testing.assert_allclose(an.T @ np.diag(ps) @ an, a, rtol=0, atol=1e-14)

    def test_not_a_number_stays_one(self):
        ps, an = np.zeros(3), np.zeros((3, 3), order="F")
        self.call("sprind", np.array([1, 2, np.nan, 0, 0, 0]), ps, an, 1, 3, 3)
        self.assertTrue(np.isnan(ps).any())

    def test_invariants(self):
        for s, a, lstr, ndi, nshr in self.tensors():
            if lstr == 2:
                continue
            first, second = np.zeros(1), np.zeros(1)
            self.call("sinv", s, first, second, ndi, nshr)
            deviator = a - np.trace(a) / 3 * np.eye(3)
            scale = np.abs(a).max()
            self.assertAlmostEqual(first[0] / scale, np.trace(a) / 3 / scale, delta=1e-15)
            self.assertAlmostEqual(second[0] / scale, math.sqrt(1.5 * (deviator * deviator).sum()) / scale, delta=1e-14)

    def test_rotation(self):
        for s, a, lstr, ndi, nshr in self.tensors():
            R = np.asfortranarray(np.linalg.qr(self.random.standard_normal((3, 3)))[0])
            turned = np.full(ndi + nshr, 9.0)
            self.call("rotsig", s, R, turned, lstr, ndi, nshr)
            expected = self.components(R @ a @ R.T, lstr, ndi, nshr)
            np.testing.assert_allclose(turned, expected, rtol=0, atol=4e-15 * np.abs(s).max())
            self.call("rotsig", s, R, s, lstr, ndi, nshr)  # in place
            np.testing.assert_array_equal(s, turned)


class Foreign(Folder):
    """foreign_umat.f, as its user runs it."""

    def run_case(self, what=0, name="STEEL"):
        return self.run_umat(FOREIGN, CASE.format(what=what, name=name))

    def test_states_and_stress(self):
        done = self.run_case()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, "^note: .*umat.so: has, and this driver does not call, USDFLD\n$")
        self.assertEqual(list(self.rows[0]), "time,E11,E22,E33,E12,E13,E23,RATE,PMAX,PRESS,MISES,PLACE,SDV12,s11,s22,s33,s12,s13,s23,"
                         "reaction,iterations".split(","))
        self.assertEqual(len(self.rows), 5)
        first, last = self.rows[0], self.rows[-1]
        self.assertEqual((first["E11"], first["s11"], first["SDV12"], last["SDV12"]), (0, 0, 5, 5))
        self.assertAlmostEqual(last["PLACE"], 111 / 2, delta=1e-12)  # the mean of the points' places, by SDVINI
        self.assertAlmostEqual(last["s11"], 1000 * math.log(1.1), delta=0.01)
        self.assertAlmostEqual(last["s22"], 0, delta=1e-8)
        for name, value in (("PMAX", last["s11"]), ("MISES", last["s11"]), ("PRESS", last["s11"] / 3)):
            self.assertAlmostEqual(last[name], value, delta=1e-8)
        self.assertAlmostEqual(last["RATE"], 0.025 / (1.0875 * 0.25), delta=1e-12)
        self.assertRegex((self.folder / "out/umat.msg").read_text(), "CALLS +1\n")

    def test_uexternaldb(self):
        self.run_case()
        log = [line.split() for line in (self.folder / "out/case.log").read_text().splitlines()]
        self.assertEqual([line[0] for line in log], ["0"] + 4 * ["1", "2"] + ["3"])
        self.assertEqual(log[3][1:4], ["0.25", "0.25", "2"])
        self.assertEqual(log[4][1:4], ["0.50", "0.25", "2"])
        self.assertEqual(log[0][4:], ["0", "1"])

    def test_what_ends_the_run_is_no_success(self):
        for what, text in ((1, "UMAT: calls XIT"), (2, ""), (3, "UMAT: error: out of range")):
            done = self.run_case(what)
            self.assertEqual(done.returncode, 2)
            self.assertIn(text, done.stderr)
            self.assertIn("the UMAT ended the run, after time 5.00000E-01. history.csv has the rows up to there.", done.stderr)
            self.assertEqual(len(self.rows), 3)
        done = self.run_case(name="COPPER")
        self.assertEqual(done.returncode, 2)
        self.assertIn("UMAT: error: COPPER is no material of mine, NSTATV = 12, factor 1.0000000E+000\n", done.stderr)

    def test_a_state_that_is_no_number_is_said(self):
        done = self.run_case(4)
        self.assertEqual(done.returncode, 0)
        self.assertIn("note: STATEV(7), RATE, is not a number at time 0.75", done.stderr)
        self.assertTrue(math.isnan(self.rows[3]["RATE"]) and math.isfinite(self.rows[2]["RATE"]))

    def test_too_few_states(self):
        case = CASE.format(what=0, name="STEEL").replace("nstatv = 12", "nstatv = 5")
        case = "".join(line + "\n" for line in case.splitlines() if "statev_" not in line)
        done = self.run_umat(FOREIGN, case)
        self.assertEqual(done.returncode, 1)
        self.assertIn("the SDVINI writes to STATEV(11), and there are nstatv = 5\n", done.stderr)

    def test_a_warning(self):
        self.assertIn("UMAT: warning: 100 of 12\n", self.run_case(5).stderr)

    def test_a_path_that_begins_at_rest(self):
        rows = ["time,F11,F12,F13,F21,F22,F23,F31,F32,F33", "0,1,0,0,0,1,0,0,0,1", "1,1.1,0,0,0,1,0,0,0,1"]
        path = self.write("F.csv", "\n".join(rows))
        done = self.run_umat(FOREIGN, CASE.format(what=0, name="STEEL"), "--path", path)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([round(row["E11"], 14) for row in self.rows], [0, round(0.1 / 1.05, 14)])
        path = self.write("F.csv", "\n".join([rows[0], rows[2]]))
        done = self.run_umat(FOREIGN, CASE.format(what=0, name="STEEL"), "--path", path)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("note: STATEV(7), RATE, is not a number at time 1", done.stderr)


class Sources(Folder):
    """What a UMAT may be written in, and what is wrong with one."""

    PULL = "&material props = 1.0 nstatv = 1 {more} /\n" + CASE.split("/\n", 1)[1]

    def works(self, name, text):
        done = self.run_umat(self.write(name, text), self.PULL.format(more=""))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertGreater(self.rows[-1]["s11"], 9)
        return self.rows[-1]["SDV1"]

    def test_forms(self):
        free = UMAT.format(include=INCLUDE, more="statev(1) = kinc")
        self.assertEqual(self.works("umat.f90", free), 4)
        self.assertEqual(self.works("umat.for", "!DIR$ FREEFORM\n" + free), 4)
        self.assertEqual(self.works("umat.f90", free.replace("\n", "\r\n")), 4)
        self.assertEqual(self.works("umat.f", "#define FOUR 4\n" + fixed(UMAT.format(include=INCLUDE, more="statev(1) = FOUR"))), 4)
        self.write("part.inc", "      statev(1) = 8\n")
        self.assertEqual(self.works("umat.f", fixed(UMAT.format(include=INCLUDE, more="include 'part.inc'"))), 8)

    def test_free_form_under_an_ending_of_fixed_form(self):
        source = self.write("umat.f", UMAT.format(include=INCLUDE, more=""))
        done = self.compile(source)
        self.assertEqual(done.returncode, 0)
        self.assertEqual(done.stderr, f"note: {source} is not in fixed form; it is taken as free form, in which it compiles\n")
        # An error in either form is shown in the form that the file is written in, without those of the other form.
        wrong = UMAT.format(include="implicit none", more=40*"x = stress(1)\n  ").replace("stress(ntens)", "stress(ntens))")
        for line, text in ((6, wrong), (7, "c...  a comment\n" + fixed(wrong))):  # the first of many errors in its own form
            done = self.compile(self.write("umat.f", text))
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, rf"^\S*umat.f:{line}:\d+:\n")
        self.write("part.inc", "      x = = 1\n")  # errors in an included file tell nothing of the form
        done = self.compile(self.write("umat.f", "\n\n" + fixed(UMAT.format(include=INCLUDE, more="include 'part.inc'"))))
        self.assertRegex(done.stderr, r"^\S*part.inc:1:\d+:\n")

    def test_included_files_as_on_windows(self):
        (self.folder / "Sub").mkdir()
        self.write("Sub/Part.INC", "      INCLUDE 'Deeper.F'\r\n")
        self.write("Sub/deeper.f", "      statev(1) = 9\n")
        more = "include '{}'"
        for name in ("Sub\\part.inc", "Sub/PART.inc", "Sub\\Part.INC "):
            text = "C     From Windows\n" + fixed(UMAT.format(include='INCLUDE  "Aba_Param.inc "', more=more.format(name)))
            self.assertEqual(self.works("umat.for", text.replace("\n", "\r\n").encode("utf-8-sig")), 9)
        text = fixed(UMAT.format(include=INCLUDE, more=more.format("sub/part.inc") + " ! caf"))
        self.assertEqual(self.works("umat.f", text.encode().replace(b"! caf", b"! caf\xe9")), 9)  # not UTF-8
        done = self.compile(self.write("umat.f", fixed(UMAT.format(include=INCLUDE, more=more.format("Other.inc")))))
        self.assertIn("Other.inc", done.stderr)

    def test_a_path_begins_at_the_file_that_names_it(self):
        (self.folder / "Sub").mkdir()
        self.write("Sub/part.inc", "      INCLUDE 'deeper.inc'\n      include 'deeper.inc'\n")
        self.write("Sub/deeper.inc", "      statev(1) = statev(1) + 1")  # no end of line
        for directive in ("include", "#include"):
            text = fixed(UMAT.format(include=INCLUDE, more="statev(1) = 0\n  include 'Sub/part.inc'"))
            self.assertEqual(self.works("umat.f", text.replace("\tinclude 'Sub", f"{directive} 'Sub".rjust(16))), 2)
        self.write("Sub/deeper.inc", "      statev(1) = = 1\n")
        done = self.compile(self.folder / "umat.f")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"(?m)^\S*/Sub/deeper.inc:1:")  # and not of the whole, in lines of its own

    def test_directives_as_intels_preprocessor_takes_them(self):
        self.write("part.inc", "  #define TEN 10\n#IFDEF TEN\n      statev(1) = TEN\n  # else\n      statev(1) = 0\n#ENDIF\n")
        text = fixed(UMAT.format(include=INCLUDE, more="#INCLUDE 'part.inc'")).replace("\t#", "#").replace("\tinclude", "      #include")
        self.assertEqual(self.works("umat.f", text), 10)
        text = fixed(UMAT.format(include=INCLUDE, more="statev(1) = 1 +1"))
        self.assertEqual(self.works("umat.f", text.replace("1 +1", "1\n     #+1")), 2)  # a # in column 6 continues the line

    def test_operators_of_its_own(self):
        module = """module operators
  interface operator(.plus.)
    module procedure plus
  end interface
contains
  real*8 function plus(a, b)
    real*8, intent(in) :: a, b
    plus = a + b
  end function
  real*8 function twice(a)
    real*8, intent(in) :: a
    twice = a.plus.a
  end function
end module
"""
        text = UMAT.format(include="use operators\n  " + INCLUDE, more="statev(1) = twice(dtime)")
        self.assertEqual(self.works("umat.f90", module + text), 0.5)
        text = UMAT.format(include=INCLUDE + "\n  structure /pair/\n    real*8 a\n  end structure\n  record /pair/ p",
                           more="p.a = 3\n  statev(1) = p.a")  # DEC's, whose components have dots
        self.assertEqual(self.works("umat.f90", text), 3)

    def test_functions_of_abaqus_are_integers(self):
        more = "statev(1) = get_thread_id() + 10*getnumthreads()"  # real by their first letter, were it not for the header
        for name in ("SMAAspUserSubroutines.hdr", "SMAASPUSERUTILITIES.HDR"):
            text = f"#include <{name}>\n" + UMAT.format(include=f"include 'aba_param_dp.INC'\n#include <{name}>", more=more)
            self.assertEqual(self.works("umat.f90", text), 10)
            self.assertEqual(self.works("umat.f", fixed(text).replace("\t#", "#")), 10)

    def test_headers_of_abaqus(self):
        text = "#include <SMAAspUserSubroutines.hdr>\n" + UMAT.format(include=INCLUDE, more="call MutexLock(1)\n  statev(1) = 6")
        self.assertEqual(self.works("umat.f90", text), 6)
        for header, name in (("omi_for_c.h", "FOR_NAME(umat, UMAT)"), ("aba_for_c.h", "FOR_NAME(umat)")):
            text = f"#include <{header}>\n" + C.format(name=name)
            self.assertEqual(self.works("umat.c", text), 7)
            self.assertEqual(self.works("umat.cpp", "#include <Eigen/Dense>\n" + text.replace("void", 'extern "C" void')), 7)

    def test_getvrm(self):
        call = "call getvrm('S', ps, an, jarray, flgray, jrcd, 1, 2, cmname, 3)"
        uvarm = f"subroutine uvarm(u)\n  {INCLUDE}\n  {call}\nend subroutine\n"  # which the driver does not call
        source = self.write("umat.f90", UMAT.format(include=INCLUDE, more="") + uvarm)
        done = self.run_umat(source, self.PULL.format(more=""))
        self.assertEqual(done.returncode, 0)
        self.assertGreater(self.rows[-1]["s11"], 9)
        done = self.run_umat(self.write("umat.f90", UMAT.format(include=INCLUDE, more=call)), self.PULL.format(more=""))
        self.assertEqual(done.returncode, 2)
        self.assertIn("UMAT: calls GETVRM, and the driver has no such results to give\n", done.stderr)

    def test_entries(self):
        for name in ("umat_", "umat", "UMAT", "UMAT_"):
            self.assertEqual(self.works("umat.c", C.format(name=name)), 7)
            self.assertEqual(self.works("umat.cpp", 'extern "C" ' + C.format(name=name)), 7)
        done = self.run_umat(self.write("umat.c", C.format(name="vumat_")), self.PULL.format(more=""))
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "it has none of the symbols umat_, umat, UMAT and UMAT_; it has, and this driver does not call, VUMAT\n$")
        text = UMAT.format(include=INCLUDE, more="") + "subroutine sigini\nend subroutine\nsubroutine uanisohyper_inv\nend subroutine\n"
        done = self.run_umat(self.write("umat.f90", text), self.PULL.format(more=""))
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stderr, "^note: .*: has, and this driver does not call, SIGINI UANISOHYPER_INV\n$")

    def test_its_own_routines_come_first(self):
        own = UMAT.format(include=INCLUDE, more="call sprind(stress, ps, an, 1, 3, 3)\n  statev(1) = ps(1)")
        own += "subroutine sprind(s, ps, an, l, i, j)\n  real*8 s(6), ps(3), an(3, 3)\n  ps = 42\nend subroutine\n"
        self.assertEqual(self.works("umat.f90", own), 42)
        subprocess.run(["gfortran", "-shared", "-fPIC", "-w", "-J", self.folder, "-I", COMPILE.parent, self.folder / "umat.f90", "-o",
                        self.folder / "plain.so"], check=True)  # by the user, without -Bsymbolic
        done = subprocess.run([DRIVER, self.folder / "case.nml", "--umat", self.folder / "plain.so", "--out", self.folder],
                              stdout=subprocess.PIPE, text=True)
        if b"__asan_init" not in DRIVER.read_bytes():  # which allows no RTLD_DEEPBIND
            self.assertIn(" 42.000000 ", done.stdout)

    def test_what_is_wrong_is_said(self):
        for name, text, message in (
                ("umat.txt", "x", "umat.txt: the ending must be"),
                ("umat.f90", "subroutine umat(\n", "umat.f90: does not compile"),
                ("umat.f", "      CALL X(\n", "umat.f: does not compile")):
            done = self.compile(self.write(name, text))
            self.assertEqual(done.returncode, 1)
            self.assertIn(message, done.stderr)
        self.assertIn("there is no such file", self.compile(self.folder / "no.f").stderr)
        missing = UMAT.format(include=INCLUDE, more="call getpropertytable('a', 'b', ps, i)")
        done = self.run_umat(self.write("umat.f90", missing), self.PULL.format(more=""))
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "undefined symbol: getpropertytable_ \\(neither in it nor among the utilities")
        wrong = UMAT.format(include=INCLUDE, more="call sprinc(stress, ps, 3, 3, 3)")
        done = self.run_umat(self.write("umat.f90", wrong), self.PULL.format(more=""))
        self.assertEqual(done.returncode, 2)
        self.assertIn("called with LSTR = 3, NDI = 3, NSHR = 3; allowed are 1 and 2, 1 to 3, 0 to 3", done.stderr)

    def test_names_in_the_namelist(self):
        source = self.write("umat.f90", UMAT.format(include=INCLUDE, more=""))
        for more, message in (
                ("cmname = ''", "cmname = '': must have 1 to 80 characters"),
                (f"cmname = '{81 * 'x'}'", "must have 1 to 80 characters"),
                ("statev_names = 'a', 'b'", "has 2 names: there are nstatv = 1 state variables"),
                ("nstatv = 2 statev_names = 'a', 'a'", "name 2, a, is given twice"),
                ("statev_names = 'S11'", "name 1, S11, is that of another column"),
                ("statev_names = 'a,b'", "name 1 must be 1 to 40 letters"),
                ("statev_names = ''", "name 1 must be 1 to 40 letters"),
                ("statev_names = a", "value 1 must be a text in quotes"),
                (f"statev_names = '{41 * 'x'}'", "value 1 has more than 40 characters"),
                ("statev_names(2) = 'a'", "takes no subscript")):
            case = self.PULL.format(more=more)
            if "nstatv" in more:
                case = case.replace("nstatv = 1 ", "")
            done = self.run_umat(source, case)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, "case.nml:1: &material: ")
            self.assertIn(message, done.stderr)

    def test_thousands_of_states(self):
        source = self.write("umat.f90", UMAT.format(include=INCLUDE, more="statev(nstatv) = 5"))
        done = self.run_umat(source, self.PULL.replace("nstatv = 1 ", "nstatv = 3000 ").format(more=""))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual((self.rows[-1]["SDV2999"], self.rows[-1]["SDV3000"]), (0, 5))

    def test_too_few_states_and_properties(self):
        done = self.run_umat(self.write("umat.f90", UMAT.format(include=INCLUDE, more="statev(200) = 1")), self.PULL.format(more=""))
        self.assertEqual(done.returncode, 1)
        self.assertIn("the UMAT writes to STATEV(200), and there are nstatv = 1\n", done.stderr)
        more = "statev(20) = statev(20) + dstran(1)"  # of what was there before
        done = self.run_umat(self.write("umat.f90", UMAT.format(include=INCLUDE, more=more)), self.PULL.format(more=""))
        self.assertEqual(done.returncode, 1)
        self.assertIn("the UMAT writes to STATEV(20), and there are nstatv = 1\n", done.stderr)
        source = UMAT.format(include=INCLUDE, more="statev(1) = props(2)").replace("ps(3)", "ps(3), props(nprops)")
        done = self.run_umat(self.write("umat.f90", source), self.PULL.format(more=""))
        self.assertIn("note: the UMAT computes with entries beyond PROPS(1): &material needs more props\n", done.stderr)
        self.assertIn("STATEV(1), SDV1, is not a number", done.stderr)
        source = UMAT.format(include=INCLUDE, more="stress(1) = stress(1) + exp(0*statev(5))*dstran(1)")
        done = self.run_umat(self.write("umat.f90", source), self.PULL.format(more=""))
        self.assertEqual(done.returncode, 2)
        told = "note: the UMAT computes with entries beyond STATEV(1): &material needs a larger nstatv\n"
        self.assertEqual(done.stderr.count(told), 1, done.stderr)

    def test_without_a_case(self):
        done = self.run_umat(self.write("umat.f90", UMAT.format(include=INCLUDE, more="")), None)
        self.assertIn("is given the 9 PROPS of myogrowth's default run, and 8 STATEV", done.stderr)


def fixed(free):
    """Free form as fixed form, with a tab before each statement."""
    lines, continued = [], False
    for line in free.splitlines():
        lines.append(("     1" if continued else "\t") + line.strip().rstrip("&"))
        continued = line.endswith("&")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
