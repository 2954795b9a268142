"""Writes docs/verification.md: every claim, the tests that check it, and the figure that they print.

verify.py BUILD [--write PAGE [--log LOG ...] | --check PAGE]

--write runs the tests of every claim with ctest and puts what they print into the page. With --log it takes the output
from existing logs of ctest (Testing/Temporary/LastTest.log). --check, which is a test itself, runs nothing: the page must
have exactly the claims below, and ctest must know every test that they name.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
from typing import NamedTuple, Optional

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples/common"))
import files  # noqa: E402  shared by all Python programs

SKIPPED = 77
NUMBER = r"([-+0-9.e]+)"


class Claim(NamedTuple):
    text: str
    tests: str  # a regular expression for the whole name of a test in ctest
    prints: Optional[str] = None  # what they print; # is a number
    figure: Optional[str] = None  # how it is reported: {0} the largest of the pattern's first number, {0-} the smallest
    optional: bool = False  # its tests are left out where what they need is missing


CLAIMS = {
    "The law": [
        Claim("agrees with an independent evaluation in 50 digits: 3,000 points, random oblique fibres, F up to 60 % off identity, large "
              "rotations, Δt up to 10⁴ τ, γ 0.5 to 4, both energy conventions; tangents compared with differences of the reference's own "
              "time step",
              r"verification\.Kinds/Accuracy\..*",
              "worst relative error: G #  lambda_e #  psi #  stress #  DDSDDE #  dP/dF #  dS/dE #",
              "worst relative error: G {0}, λe {1}, ψ {2}, stress {3}, DDSDDE {4}, dP/dF {5}, dS/dE {6}"),
        Claim("the local solve always converges, for growth and removal: Δt/τ from 1e-12 to 1e300, γ from 0 to 20; in its bracket and at the root",
              r"fuzz\.solver", "# steps, # grew or shrank, # iterations on average, # at most, # failures",
              "{0} steps, {1} of them grew or shrank: {2} iterations on average, {3} at most, {4} failures"),
        Claim("the local solve for steps chosen to be hard, compared with 50 digits: growth and removal", r"unit\.GrowthSolve\.Hard.*",
              "worst error: G #, dG/dlambda #", "worst relative error: G {0}, dG/dλ {1}"),
        Claim("without growth the kernel is the elastic law bit for bit", r"unit\.Kernel\.WithoutGrowthItIsTheElasticLawBitForBit"),
        Claim("F = Fg with the fibre along an axis gives exactly zero stress", r"unit\.Kernel\.FreeGrowthIsStressFreeExactly"),
        Claim("the kernel agrees with the paper's formulas as they are written", r"unit\.Kernel\.AgreesWithTheDefinitions"),
        Claim("the law is objective", r"unit\.Kernel\.ObjectiveUnderRotation"),
        Claim("plane stress: the stress across the plane is zero, the condensed tangent is that of the solid; thickness and tangent "
              "compared with 50 digits",
              r"unit\.(Fibres/)?PlaneStress\.(Frees|Against).*", "worst: stress across #, tangent #",
              "worst: stress across {0} (c1 + c2), tangent {1}"),
        Claim("the elastic laws 1 to 3 agree with an independent evaluation in 50 digits: growing, any activation, oblique fibres, both "
              "energy conventions; tangents compared with differences of the reference's own time step",
              r"verification\.AccuracyOfLaws\.AgainstFiftyDigits.*", "worst relative error: stress #  DDSDDE #  psi #",
              "worst relative error: stress {0}, DDSDDE {1}, ψ {2} (limited by the reference's integral)"),
        Claim("growth with any elastic law: the tangent is the complex step of the discrete update, also with removal and second order",
              r"unit\.ElasticLaw\.TangentOfTheGrowingMuscle.*"),
        Claim("growth with any elastic law: for the neo-Hookean one the general formula is the closed form, to 1e-13",
              r"unit\.FibreGrowthOf\.TheNeoHookeanLawGivesTheClosedForm"),
        Claim("two more growth laws, by a sensed stretch and across the fibre: one root for any step, the tangent is that of the step",
              r"unit\.(SensedStretch|CrossFibreGrowth)\..*"),
        Claim("law 3 gives the values of two of 4C's regression tests, to 1e-12 and 1e-9", r"unit\.Ehret\..*Of4C"),
    ],
    "Time integration": [
        Claim("the time step is of first order", r"verification\.History\.BackwardEulerConvergesWithOrderOne", "orders # to #",
              "orders {0-} to {1}"),
        Claim("the second-order time step is of second order", r"verification\.History\.MidpointFlowConvergesWithOrderTwo",
              "orders # to #", "orders {0-} to {1}"),
        Claim("the time step converges to the exact solution for held stretch", r"verification\.History\.HeldStretchReferenceValues",
              "extrapolated G off by # at most", "extrapolated G within {0}"),
        Claim("10 % stretch ramped over a day and held: λe is 1.0630 on day 1 and 1.0121 on day 42",
              r"verification\.History\.RampThenHoldReferenceValues"),
        Claim("the flow agrees with a Runge-Kutta method with very short steps", r"unit\.GrowthFlow\.IsTheFlow",
              "worst difference to Runge-Kutta: #", "worst difference {0}"),
    ],
    "Hosts": [
        Claim("the UMAT is the core bit for bit", r"abi\.Umat\.IsTheCoreBitForBit"),
        Claim("the C API is the core bit for bit", r"abi\.CApi\.IsTheCoreBitForBit"),
        Claim("CalculiX's library is the core bit for bit, by both interfaces", r"abi\.Ccx\.BothAreTheCoreBitForBit"),
        Claim("the VUMAT is the UMAT in the rotated basis", r"abi\.Vumat\.IsTheUmatInTheTurnedBasis"),
        Claim("several threads get the same results as one", r"abi\.(threads|Umat\.TwoThreadsGetTheSameAsOne|Vumat\.TwoThreadsGetTheSameAsOne)"),
        Claim("each library needs only libm and libc, and exports only its own names", r"abi\..*_needs_and_exports"),
        Claim("global Newton is quadratic with the UMAT's tangent, for an oblique fibre under traction; of first order where a host "
              "keeps only its symmetric part", r"driver\.Newton",
              "order # to # in # iterations; symmetrised: # on average in # iterations",
              "order {0-} to {1} in {2} iterations; symmetrised: order {3} in {4}"),
        Claim("the one-element driver reproduces the closed forms, balances its tractions and cuts back", r"driver\.Cases"),
        Claim("other people's UMATs run in the driver as they are: fixed and free form, included files, Abaqus's utilities, UEXTERNALDB, "
              "SDVINI; principal values are NumPy's", r"driver\.(Utilities|Foreign|Sources|OtherUmats)"),
        Claim("the libraries for hosts but the probe need no glibc newer than 2.29; the UMAT with MYOGROWTH_OLD_GLIBC none newer than 2.14", r"abi\.(old_)?glibc",
              optional=True),
        Claim("in CalculiX, six element types: state and reactions agree with the one-element driver",
              r"calculix\.(Pull|Prescribed|Traction)", "; worst: state #, reaction #",
              "worst difference: state {0} (the last digit that CalculiX prints), reactions {1} of the largest"),
        Claim("in CalculiX, global Newton is quadratic", r"calculix\.Newton", " orders # to #", "orders {0-} to {1}"),
        Claim("the cylinder, half way along: λe is that of eq. 4 at its stretch, the force is that of the stress by hand",
              r"calculix\.Coarse", "lambda_e #, force # of itself", "λe within {0}, force within {1} of itself"),
        Claim("UMAT, VUMAT, CalculiX's and MGIS's libraries, C API and C++ get the same numbers, with each elastic law, active and growing",
              r"abi\.Hosts\.AgreeWithOneAnother", "hosts agree with one another: # at worst", "{0}"),
        Claim("CalculiX and deal.II agree on the same cylinder", r"mpi\.CalculiX", optional=True),
        Claim("on deal.II with MPI, 1, 2 and 3 ranks agree, also after a restart; Newton is quadratic; a homogeneous brick agrees with "
              "the library's point; nearly incompressible muscle does not lock", r"mpi\.(Ranks|Restart|Newton|Homogeneous|Locking)", optional=True),
        Claim("on deal.II, a cube with each elastic law, active and growing, agrees with the UMAT in the driver, and a free contraction with "
              "4C's value; Newton is quadratic", r"(mpi|muscle\.solver)\.Laws", optional=True),
        Claim("a real muscle's solver: bricks of tetrahedra, hexahedra and wedges agree with the library's point; fibres converge; it does "
              "not lock; 1, 2 and 3 ranks agree", r"muscle\.solver\.(Elements|Fibres|Locking|Ranks)", optional=True),
        Claim("in FEniCSx, cube and cylinder agree with the one-element driver and with CalculiX; Newton is quadratic; two processes agree",
              r"fenicsx\..*", "differences reaction # lambda_e_mean # G_mean #",
              "against CalculiX: reaction {0}, mean λe {1}, mean G {2}", optional=True),
        Claim("FEBio's plugin in a mock of the classes that it touches: stress, state and tangent are the law's; with FEBio's own elastic "
              "materials the tangent is that of the step", r"hosts\.Febio.*\..*"),
        Claim("on Windows (mingw-w64, under Wine): the C API, the rows of 50 digits, SIMD packs and a corpus of hard calls",
              r"windows\..*", optional=True),
        Claim("through MGIS each operator is the derivative of the step, in four hypotheses",
              r"hosts\.Mgis\.EveryOperatorIsTheDerivativeOfTheStep"),
        Claim("with the recipes for MOOSE, COMSOL, Elmer, WARP3D and MFEM, in mock hosts that reproduce these codes' calling conventions, the "
              "numbers are the law's",
              r"hosts\.(Moose|Comsol|Elmer|Warp3d|CodeAster|Mfem)\..*"),
    ],
    "Other parts": [
        Claim("many points at once on SIMD packs agree with point by point, and the bits of a point do not depend on its neighbours", r"unit\.batch"),
        Claim("the same on aarch64 (NEON, under an emulator)", r"neon\..*", optional=True),
        Claim("many points with an elastic law, law 1 on SIMD packs, agree with point by point", r"unit\.BatchOfLaws\..*",
              optional=True),
        Claim("95 % intervals of fitted parameters contain the truth, in 200 runs", r"studies\.Fit"),
        Claim("installed or packaged, CMake, pkg-config, C and Fortran find the library and get its numbers", r"install\..*"),
        Claim("the paper's law written as a growth law of one's own agrees with the kernel; other laws have the tangent of their step", r"unit\.GrowthLaw\..*"),
        Claim("the example in CONTRIBUTING: its tangent compared with differences", r"example\.cross_fibre_growth",
              "dP/dF against differences: #", "{0} of its norm"),
        Claim("the Python module, compared with values by hand, with differences and with the one-element driver", r"python\.module",
              "# passed", "{0} tests passed"),
        Claim("the manual's tables are those of the code", r"docs\.manual_tables"),
        Claim("every public symbol has a comment; no link of the site is broken", r"docs\.(site|links)",
              "# pages, # links within the site, # broken", "{0} pages, {1} links, {2} broken"),
    ],
}

INTRODUCTION = """# Verification

This page is for readers who want to know how far they can trust the library. It lists every claim, the tests of
`./run test` that check it, and the figure that they print.

`./run verify` runs the tests and writes this page; a test checks that the tests of every claim exist. Where there is
no figure, the test asserts what the claim says.

**What has not been verified:** nothing here was run in Abaqus. The model was compared with the paper's text and
figures, [claim by claim](biceps.md), and with figures from abstracts of [published studies](studies.md), not with raw
measurements on muscles.
"""


def known_tests(build):
    listed = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], check=True, capture_output=True, text=True)
    return {test["name"]: test for test in json.loads(listed.stdout)["tests"]}


def names_of(claim, known):
    return [name for name in known if re.fullmatch(claim.tests, name)]


def run(build, names):
    """Runs the tests; ctest's log of them."""
    pattern = "^(" + "|".join(re.escape(name) for name in names) + ")$"
    if subprocess.run(["ctest", "--test-dir", build, "-j", "2", "-R", pattern, "--output-on-failure"]).returncode != 0:
        sys.exit("a claim's test failed")
    return build / "Testing/Temporary/LastTest.log"


def outputs_of(logs):
    """What every test of the logs printed, if it passed or skipped itself."""
    entry = re.compile(r"^\d+/\d+ Test: (.*?)\n.*?^Output:\n-+\n(.*?)^<end of output>.*?^Test (Passed|Skipped)", re.S | re.M)
    return {name: (output, verdict) for log in logs
            for name, output, verdict in entry.findall(log.read_text(encoding="utf-8", errors="replace"))}


def figure(claim, output):
    """The claim's figure from all that its tests print: the worst of every number."""
    pattern = NUMBER.join(re.escape(part) for part in claim.prints.split("#"))
    found = re.findall(pattern, output)
    if not found:
        sys.exit(f"{claim.tests}: does not print '{claim.prints}'")
    columns = list(zip(*[f if isinstance(f, tuple) else (f,) for f in found]))

    def pick(match):
        column = columns[int(match.group(1))]
        text = (min if match.group(2) else max)(column, key=float)
        return f"{int(text):,}" if re.fullmatch(r"\d{4,}", text) else text

    return re.sub(r"\{(\d+)(-?)\}", pick, claim.figure)


def named(claim):
    """The tests of a claim, written for a reader."""
    return f"`{claim.tests}`".replace("\\", "").replace(".*", "*").replace("|", "\\|")


def report(build, logs):
    outputs = outputs_of(logs)  # before ctest is asked what it knows: that begins LastTest.log anew
    known = known_tests(build)
    claimed = {claim.text: names_of(claim, known) for claims in CLAIMS.values() for claim in claims}
    for text, names in claimed.items():
        if not names or not all("command" in known[name] for name in names):
            sys.exit(f"{text}: its tests do not exist, or are not built: {names}")
    if not logs:
        outputs = outputs_of([run(build, sum(claimed.values(), []))])
    compiler = re.search(r"CMAKE_CXX_COMPILER:\w+=(.*)", (build / "CMakeCache.txt").read_text()).group(1)
    text = [INTRODUCTION, "These figures: " + subprocess.run([compiler, "--version"], capture_output=True, text=True)
            .stdout.splitlines()[0] + ".\n"]
    for section, claims in CLAIMS.items():
        text.append(f"## {section}\n\n| claim | figure | tests |\n|---|---|---|")
        for claim in claims:
            names = claimed[claim.text]
            missing = [name for name in names if name not in outputs]
            if missing:
                sys.exit(f"{claim.text}: not in the log, or failed: {missing}")
            if any(outputs[name][1] == "Skipped" for name in names):
                said = "not run here: its host is missing"
            else:
                said = figure(claim, "\n".join(outputs[name][0] for name in names)) if claim.prints else ""
            text.append(f"| {claim.text} | {said} | {named(claim)} |")
        text.append("")
    return "\n".join(text)


def check(build, page):
    text, known = page.read_text(encoding="utf-8"), known_tests(build)
    rows = re.findall(r"^\| (.*) \| (.*) \| (`.*`) \|$", text, re.M)
    claims = [claim for section in CLAIMS.values() for claim in section]
    faults = []
    if [(row[0], row[2]) for row in rows] != [(claim.text, named(claim)) for claim in claims]:
        faults.append(f"{page}: its claims are not those of {__file__}: ./run verify")
    faults += [f"{claim.text}: a figure is missing: ./run verify" for claim, row in zip(claims, rows)
               if claim.prints and not row[1]]
    missing = [claim.tests for claim in claims if not claim.optional and not names_of(claim, known)]
    if missing and any(name.endswith("_NOT_BUILT") for name in known):
        print("not all tests are built here; not found:", *missing)
        sys.exit(SKIPPED)
    faults += [f"{tests}: a claim names it, and ctest does not know it" for tests in missing]
    if faults:
        sys.exit("\n".join(faults))
    print(f"{len(claims)} claims, {sum(len(names_of(claim, known)) for claim in claims)} tests")


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    p.add_argument("build", type=pathlib.Path)
    what = p.add_mutually_exclusive_group(required=True)
    what.add_argument("--write", type=pathlib.Path)
    what.add_argument("--check", type=pathlib.Path)
    p.add_argument("--log", type=pathlib.Path, nargs="+", default=[])
    a = p.parse_args()
    if a.write:
        files.write_text(a.write, report(a.build.resolve(), a.log))
    else:
        check(a.build.resolve(), a.check)


if __name__ == "__main__":
    with files.faults_in_one_line("verify.py"):
        main()
