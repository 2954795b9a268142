"""The Python module against the paper's law by hand, differences of itself, and the one-element driver."""
import copy
import csv
import dataclasses
import decimal
import fractions
import os
import pathlib
import pickle
import re
import subprocess
import sys
import threading

import numpy as np
import pytest

import myogrowth
from myogrowth import MyogrowthError, Parameters, State, Status, parameters, simulate, update

MUSCLE = Parameters()


def points(shape, seed=1):
    """F near the identity, oblique fibres and sarcomere numbers of growing points."""
    random = np.random.default_rng(seed)
    F = np.eye(3) * 1.12 + 0.05 * random.uniform(-1, 1, (*shape, 3, 3))
    n0 = random.normal(size=(*shape, 3))
    return F, State(G=random.uniform(1, 1.02, shape), n0=n0)


def by_hand(muscle, F, n0, G):
    """Cauchy stress of eqs 1 to 3 as they are written."""
    n0 = n0 / np.linalg.norm(n0)
    Fe = F @ np.linalg.inv(np.eye(3) + (G - 1) * np.outer(n0, n0))
    Je = np.linalg.det(Fe)
    return (muscle.c1 * np.log(Je) * np.eye(3) + muscle.c2 * (Fe @ Fe.T - np.eye(3))) / np.linalg.det(F)


def test_stress_and_growth_by_hand():
    F, state = points((4, 5))
    step = update(MUSCLE, F, 0.1, state)
    assert step.stress.shape == (4, 5, 3, 3) and step.state.G.shape == (4, 5)
    assert np.all(step.state.G > state.G)
    for point in np.ndindex(4, 5):
        np.testing.assert_allclose(step.stress[point], by_hand(MUSCLE, F[point], state.n0[point], step.state.G[point]),
                                   rtol=0, atol=1e-13 * MUSCLE.c1)
        stretch = np.linalg.norm(F[point] @ state.n0[point]) / np.linalg.norm(state.n0[point])
        G, G_n = step.state.G[point], state.G[point]
        k_g = ((MUSCLE.G_max - G) / (MUSCLE.G_max - 1)) ** MUSCLE.gamma / MUSCLE.tau
        assert G - G_n - 0.1 * k_g * max(stretch / G - MUSCLE.lambda_crit, 0) == pytest.approx(0, abs=1e-15)
        assert step.lambda_e[point] == pytest.approx(stretch / G)
        assert step.J[point] == pytest.approx(np.linalg.det(F[point]))


def test_measures_are_one_stress():
    F, state = points((6,))
    sigma, P, S = (update(MUSCLE, F, 0.1, state, measure=m).stress for m in ("cauchy", "first_piola", "second_piola"))
    np.testing.assert_allclose(P @ F.swapaxes(-1, -2), sigma * np.linalg.det(F)[:, None, None], atol=1e-12)
    np.testing.assert_allclose(F @ S, P, atol=1e-12)
    assert np.abs(P - P.swapaxes(-1, -2)).max() > 0.01  # else a transposed P would pass


@pytest.mark.parametrize("measure", ["cauchy", "first_piola", "second_piola"])
def test_tangent_by_differences(measure):
    F, state = points((3,))
    h = 1e-6
    D = update(MUSCLE, F, 0.1, state, measure=measure, tangent=True).tangent
    assert D.shape == (3, 3, 3, 3, 3)
    np.testing.assert_array_less(1e-3, np.abs(D - np.einsum("pijkl->pklij", D)).max((1, 2, 3, 4)))  # they grow

    def stress(F_):
        step = update(MUSCLE, F_, 0.1, state, measure=measure)
        return step.stress * (step.J[:, None, None] if measure == "cauchy" else 1)

    for k in range(3):
        for l in range(3):
            e = np.zeros((3, 3))
            e[k, l] = 1
            if measure == "first_piola":
                dF, size = np.broadcast_to(e, F.shape), 1
            elif measure == "cauchy":  # no spin: the Jaumann rate is the plain rate
                dF, size = (e + e.T) / 2 @ F, np.linalg.det(F)[:, None, None]
            else:  # F^T dF = dE
                dF, size = np.linalg.inv(F).swapaxes(-1, -2) @ ((e + e.T) / 2), 1
            slope = (stress(F + h * dF) - stress(F - h * dF)) / (2 * h * size)
            np.testing.assert_allclose(D[..., k, l], slope, rtol=0, atol=2e-8 * np.abs(D).max())


def test_nothing_that_comes_in_is_changed():
    F, state = points((7,))
    kept = F.copy(), state.G.copy(), state.n0.copy()
    F.flags.writeable = state.G.flags.writeable = state.n0.flags.writeable = False
    update(MUSCLE, F, 0.1, state, tangent=True)
    for before, after in zip(kept, (F, state.G, state.n0)):
        np.testing.assert_array_equal(before, after)


def test_views_lists_and_shapes():
    F, state = points((4,))
    whole = update(MUSCLE, F, 0.1, state)
    wide = np.zeros((4, 3, 6))
    wide[..., ::2] = F
    np.testing.assert_array_equal(update(MUSCLE, wide[..., ::2], 0.1, state).stress, whole.stress)
    np.testing.assert_array_equal(update(MUSCLE, np.asfortranarray(F), 0.1, state).stress, whole.stress)
    single = update(MUSCLE, F[2].tolist(), 0.1, State(G=state.G[2], n0=list(state.n0[2])))
    np.testing.assert_allclose(single.stress, whole.stress[2], atol=1e-13)
    assert single.stress.shape == (3, 3) and single.energy.shape == ()
    empty = update(MUSCLE, np.zeros((0, 3, 3)), 0.1, tangent=True)
    assert empty.tangent.shape == (0, 3, 3, 3, 3)
    again = update(MUSCLE, F, 0.1, whole.state)  # what comes out goes in
    assert np.all(again.state.G >= whole.state.G)


def test_simulate_is_update_with_free_sides():
    time = np.linspace(0, 5, 51)
    h = simulate(MUSCLE, time, np.minimum(1 + 0.1 * time, 1.1))
    F = np.zeros((51, 3, 3))
    F[:, 0, 0], F[:, 1, 1], F[:, 2, 2] = h.stretch, h.lateral, h.lateral
    state = State()
    for i in range(51):
        step = update(MUSCLE, F[i], 0.1 if i else 0.0, state, measure="first_piola")
        state = step.state
        assert state.G == pytest.approx(h.G[i], rel=1e-14)
        assert step.stress[0, 0] == pytest.approx(h.force[i], abs=1e-12)
        assert abs(step.stress[1, 1]) < 1e-12 and abs(step.stress[2, 2]) < 1e-12
        assert step.J == pytest.approx(h.J[i]) and step.lambda_e == pytest.approx(h.lambda_e[i])


def test_the_papers_six_weeks():
    """Exact values of tests/verification/history_test.cpp, to the second-order step's error."""
    time = np.linspace(0, 42, 8401)
    h = simulate(Parameters(integration="midpoint_flow"), time, np.minimum(1 + 0.1 * time, 1.1))
    for day, exact in ((1, 1.06301), (2, 1.04078), (4, 1.02867), (6, 1.02386), (14, 1.01698), (42, 1.01213)):
        assert h.lambda_e[np.searchsorted(time, day - 1e-9)] == pytest.approx(exact, abs=7e-6)
    assert simulate(MUSCLE, time, 1.1).G[-1] == pytest.approx(1.08686, abs=1e-5)


@pytest.mark.skipif("MYOGROWTH_DRIVER" not in os.environ, reason="MYOGROWTH_DRIVER names no driver")
def test_the_driver_has_the_same_history(tmp_path):
    """fortran_driver/cases/cube.nml: the paper's cube, sides free, in the one-element driver with its UMAT."""
    case = pathlib.Path(__file__).parents[2] / "fortran_driver/cases/cube.nml"
    subprocess.run([os.environ["MYOGROWTH_DRIVER"], case, "--out", tmp_path / "cube"], check=True, capture_output=True)
    with next((tmp_path / "cube").glob("history*.csv")).open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    time, G = (np.array([float(row[name]) for row in rows]) for name in ("time", "G"))
    h = simulate(MUSCLE, time, [float(row["lambda"]) for row in rows])
    np.testing.assert_allclose(h.G, G, rtol=1e-6)


def test_status_is_the_c_apis():
    header = (pathlib.Path(__file__).parents[2] / "abi/myogrowth.h").read_text()
    listed, = re.findall(r"enum myogrowth_status \{(.*?)\};", header, re.S)
    assert {name: int(number) for name, number in re.findall(r"MYOGROWTH_(\w+) = (\d+)", listed)} == {
        status.name: int(status) for status in Status}


def test_parameters_are_the_librarys_table():
    table = {p.name: p for p in parameters()}
    assert set(table) | {"n0_1", "n0_2", "n0_3", "frame", "tolerance", "hybrid"} == {
        entry[0] for entry in myogrowth._core.parameters()}
    assert (table["tau"].unit, table["tau"].allowed, table["c1"].unit) == ("time", "> 0", "stress")
    assert Parameters(**{p.name: p.default for p in parameters()}) == MUSCLE
    # Each arrives where it belongs.
    some = Parameters(c1=20, c2=5, tau=2, gamma=3, G_max=1.4, lambda_crit=1.02, energy="grown",
                      integration="midpoint_flow", tau_rev=3, gamma_rev=1, G_min=0.6, lambda_crit_rev=0.99)
    assert some._props().tolist() == [20, 5, 2, 3, 1.4, 1.02, 0, 0, 0, 0, 1, 1, 0, 3, 1, 0.6, 0.99, 0]


@pytest.mark.parametrize("given, message", [
    ({"G_max": 0.9}, "G_max = 0.9: largest relative serial sarcomere number, must be finite and > 1."),
    ({"c1": -4}, "c1 = -4: first Lame constant, must be finite and > -2/3 c2"),
    ({"tau": float("nan")}, "tau = nan: time constant of growth, must be finite and > 0."),
    ({"tau": "fast"}, "tau = 'fast': must be a number"),
    ({"tau_rev": 1}, "G_min = 0: smallest relative serial sarcomere number"),
    ({"energy": "deformed"}, "energy = 'deformed': must be 'reference' or 'grown'"),
])
def test_bad_parameters(given, message):
    with pytest.raises(MyogrowthError) as error:
        Parameters(**given)
    assert message in error.value.message and error.value.status == Status.BAD_PARAMETER
    assert error.value.point is None


def test_unknown_names_list_what_there_is():
    with pytest.raises(TypeError, match="Parameters has no 'growth_time': it has c1, c2, tau, gamma, G_max, "):
        Parameters(growth_time=1)
    with pytest.raises(TypeError, match="State has no 'g': it has G, stretch, n0"):
        State(g=1)


def test_points_that_fail():
    F, state = points((2, 3))
    F[1, 2] = np.diag([1.0, 1.0, -1.0])
    with pytest.raises(MyogrowthError) as error:
        update(MUSCLE, F, 0.1, state, measure="first_piola")
    assert (error.value.status, error.value.point) == (Status.INVERTED, (1, 2))
    assert str(error.value) == "point 1, 2: det F = -1: must be > 0"

    F[0, 1, 0, 0] = np.nan
    step = update(MUSCLE, F, 0.1, state, tangent=True, raise_on_failure=False)
    assert step.status.tolist() == [[0, Status.NOT_FINITE, 0], [0, 0, Status.INVERTED]]
    assert np.all(np.isnan(step.stress[1, 2])) and np.all(np.isnan(step.tangent[0, 1]))
    assert step.state.G[1, 2] == state.G[1, 2]
    others = step.status == 0
    np.testing.assert_array_equal(step.stress[others], update(MUSCLE, F[others], 0.1, State(
        G=state.G[others], n0=state.n0[others])).stress)

    with pytest.raises(MyogrowthError, match="point 0: no fibre"):
        update(MUSCLE, np.eye(3)[None], 0.1, State(n0=(0, 0, 0)))
    with pytest.raises(MyogrowthError, match="^det F = 0: must be > 0"):
        update(MUSCLE, np.zeros((3, 3)), 0.1)
    for G in (0, -1, np.nan):
        with pytest.raises(MyogrowthError, match="G = .*: must be > 0"):
            update(MUSCLE, np.eye(3), 0.1, State(G=G))


@pytest.mark.parametrize("call, message", [
    (lambda: update(MUSCLE, np.eye(2), 0.1), r"F has shape \(2, 2\): must be \(..., 3, 3\)"),
    (lambda: update(MUSCLE, "F", 0.1), "F: must be numbers"),
    (lambda: update(MUSCLE, np.eye(3), 0.1, measure="kirchhoff"), "measure = 'kirchhoff': must be 'cauchy' or"),
    (lambda: update(MUSCLE, np.eye(3)[None], 0.1, State(G=[1, 1])), r"state.G has shape \(2,\): must broadcast"),
    (lambda: simulate(MUSCLE, [0, 1, 1], 1.1), "time: must be finite and increase"),
    (lambda: simulate(MUSCLE, [-1e308, 1e308], 1.1), r"point 1: stretch = 1.1 at time 1e\+308: a result is beyond the range"),
    (lambda: simulate(MUSCLE, [], 1.1), "time has shape"),
    (lambda: simulate(MUSCLE, [0, 1], [1, 1, 1]), "stretch has shape"),
    (lambda: simulate(MUSCLE, [0, 1], [1, -1]), "point 1: stretch = -1: must be finite and > 0"),
    (lambda: simulate(MUSCLE, [0, 1], 1.1, G=0), "G = 0: must be > 0"),
])
def test_bad_arguments(call, message):
    with np.errstate(all="raise"), pytest.raises(ValueError, match=message):
        call()


def test_wrong_kinds():
    with pytest.raises(TypeError, match="muscle: must be Parameters"):
        update([16, 4, 0.5, 2, 1.1, 1.01], np.eye(3), 0.1)
    with pytest.raises(TypeError, match="state: must be a State"):
        update(MUSCLE, np.eye(3), 0.1, 1.0)


EYE = np.eye(3)
ENDLESS = []
ENDLESS.append(ENDLESS)
LOSSY = [  # what NumPy itself would turn into doubles, or drop a part of
    (np.ma.array(1.1 * EYE, mask=EYE == 0), "masked, with 6 hidden values"),
    ([np.ma.array(row, mask=[False, True, False]) for row in 1.1 * EYE], "masked, with 1 hidden"),
    (1.1 * EYE + 0j, "must be real"),
    ((1.1 * EYE).astype(np.complex64), "must be real"),
    ((1.1 * EYE).astype(str), "must be numbers"),
    ((1.1 * EYE).astype(bytes), "must be numbers"),
    ((1.1 * EYE).astype(object), "must be numbers, is .* of type object"),
    ([[1, 0, 0], [0, None, 0], [0, 0, 1]], "must be numbers"),
    ([[1, 0, 0], [0, True, 0], [0, 0, 1]], "must be numbers, is True"),
    (EYE == 1, "must be numbers, is .* of type bool"),
    (np.zeros((3, 3), "datetime64[D]"), "must be numbers"),
    (np.zeros((3, 3), "timedelta64[D]"), "must be numbers"),
    (np.zeros((3, 3), [("a", float)]), "must be numbers"),
    ([[1, 0, 0], [0, 2**53 + 1, 0], [0, 0, 1]], r"integers must be within"),
    ([[1, 0, 0], [0, 10**400, 0], [0, 0, 1]], "integers must be within"),
    ([[1.5, 0, 0], [0, 2**53 + 1, 0], [0, 0, 1]], "integers must be within"),
    ([np.array([1.5, 0, 0]), np.array([0, 2**53 + 1, 0]), [0, 0, 1]], "integers must be within"),
    ([np.array([1.5, 0, 0]), np.array([False, True, False]), [0, 0, 1]], "must be numbers, is .* of type bool"),
    (EYE * np.longdouble("1e4000"), "within the range of double"),
    (EYE.view(type("Quantity", (np.ndarray,), {})), "must be a plain array, is a Quantity"),
    ([[1, 0], [0, 1, 0], [0, 0, 1]], "must be numbers"),
    (None, "must be numbers"),
    (ENDLESS, "must be numbers"),
]


@pytest.mark.parametrize("F, message", LOSSY)
def test_what_would_lose_something_is_refused_by_name(F, message):
    with pytest.raises(ValueError, match="^F: .*" + message):
        update(MUSCLE, F, 0.1)
    row = F[0] if isinstance(F, np.ndarray) else F
    for name, call in (("state.G", lambda x: update(MUSCLE, np.broadcast_to(EYE, (3, 3, 3)), 0.1, State(G=x))),
                       ("state.stretch", lambda x: update(MUSCLE, np.broadcast_to(EYE, (3, 3, 3)), 0.1, State(stretch=x))),
                       ("state.n0", lambda x: update(MUSCLE, EYE, 0.1, State(n0=x))),
                       ("time", lambda x: simulate(MUSCLE, x, 1.1)), ("stretch", lambda x: simulate(MUSCLE, [0, 1, 2], x))):
        with pytest.raises(ValueError, match=f"^{name}: .*"):
            call(row)


@pytest.mark.parametrize("value", [1j, True, "0.1", None, [0.1], np.array([0.1]), np.ma.masked, decimal.Decimal(1),
                                   fractions.Fraction(1, 2), np.datetime64("2020-01-01"), 10**400, np.longdouble("1e4000")])
def test_single_numbers(value):
    with pytest.raises(ValueError, match="^dt"):
        update(MUSCLE, EYE, value)
    with pytest.raises(ValueError, match="^G"):
        simulate(MUSCLE, [0, 1], 1.1, G=value)
    for parameter in parameters():
        if parameter.name not in ("energy", "integration"):
            with pytest.raises(MyogrowthError, match=f"^{parameter.name} = .*: must be a number"):
                Parameters(**{parameter.name: value})


def test_every_kind_of_float_and_integer_is_the_same_number():
    F = np.array([[1.125, 0.25, 0], [0, 1, 0], [0, 0, 1]])
    wanted = update(MUSCLE, F, 0.125).stress
    for kind in ("f2", "f4", ">f4", "<f8", ">f8", np.longdouble):
        np.testing.assert_array_equal(update(MUSCLE, F.astype(kind), np.float32(0.125)).stress, wanted)
    turned = F[::-1, ::-1].copy()[::-1, ::-1]
    np.testing.assert_array_equal(update(MUSCLE, np.asmatrix(turned), np.array(0.125)).stress, wanted)
    np.testing.assert_array_equal(update(MUSCLE, np.ma.array(F), 0.125).stress, wanted)  # nothing is hidden
    assert simulate(Parameters(c1=16), np.arange(3, dtype=">i2"), np.float16(1.125)).G[-1] == simulate(
        MUSCLE, [0.0, 1, 2], 1.125).G[-1]


@pytest.mark.parametrize("call, message", [
    (lambda: update(MUSCLE, EYE, np.nan), "^dt = nan: must be finite"),
    (lambda: update(MUSCLE, EYE, np.inf, raise_on_failure=False), "^dt = inf: must be finite"),
    (lambda: update(MUSCLE, np.broadcast_to(EYE, (3, 3, 3)), 0.1, State(n0=1.0)), r"state.n0 has shape \(\)"),
    (lambda: update(MUSCLE, np.broadcast_to(EYE, (3, 3, 3)), 0.1, State(n0=np.ones((3, 1)))), r"state.n0 has shape \(3, 1\)"),
    (lambda: update(MUSCLE, np.broadcast_to(EYE, (2, 3, 3, 3)), 0.1, State(G=np.ones(3))), r"state.G has shape \(3,\)"),
    (lambda: simulate(MUSCLE, [0, 1], [1.1]), r"stretch has shape \(1,\)"),
    (lambda: simulate(MUSCLE, [0, np.nan], 1.1), "time: must be finite .* is nan after 0 in entry 1"),
    (lambda: simulate(MUSCLE, [0, 1], 1.1, G=np.inf), "G = inf: must be > 0 and finite"),
    (lambda: update(MUSCLE, EYE, 0.1, measure=["cauchy"]), r"measure = \['cauchy'\]: must be"),
    (lambda: Parameters(energy=np.array(["grown", "grown"])), "^energy = .*: must be 'reference' or 'grown'"),
])
def test_more_bad_arguments(call, message):
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.parametrize("call, message", [
    (lambda: update(MUSCLE, EYE, 0.1, tangent="no"), "tangent = 'no': must be True or False"),
    (lambda: update(MUSCLE, EYE, 0.1, raise_on_failure=0), "raise_on_failure = 0: must be True or False"),
    (lambda: Parameters(16, 4), "Parameters takes its values by name, e.g. c1=16"),
    (lambda: State(1.1), "State takes its values by name, e.g. G=1.1"),
])
def test_more_wrong_kinds(call, message):
    with pytest.raises(TypeError, match=message):
        call()


def test_every_number_of_a_point_that_failed_is_nan():
    """One point for each thing that can be wrong; nothing speaks of the UMAT's PROPS and STATEV."""
    F = np.broadcast_to(1.1 * EYE, (9, 3, 3)).copy()
    G, stretch, n0 = np.ones(9), np.ones(9), np.tile([1.0, 0, 0], (9, 1))
    F[1, 0, 1], F[2, 0, 0], F[3], n0[4], n0[5, 1], G[6], stretch[7], G[8] = np.nan, -1, 1e200 * EYE, 0, np.inf, 0, 0, -np.inf
    state = State(G=G, stretch=stretch, n0=n0)
    kinds = [Status.OK, Status.NOT_FINITE, Status.INVERTED, Status.NOT_FINITE, Status.NO_FIBRE, *[Status.BAD_STATE] * 4]
    for integration in ("backward_euler", "midpoint_flow"):
        muscle = Parameters(integration=integration)
        step = update(muscle, F, 0.1, state, tangent=True, raise_on_failure=False)
        assert step.status.tolist() == kinds
        assert step.failed.tolist() == [False] + 8 * [True]
        for values in (step.stress, step.tangent, step.energy, step.lambda_e, step.J, step.Je):
            assert np.isfinite(values[0]).all() and np.isnan(values[1:]).all()
        for after, before in ((step.state.G, G), (step.state.stretch, stretch), (step.state.n0, n0)):
            np.testing.assert_array_equal(after[1:], before[1:])
    texts = ["", r"F\[0, 1\] = nan: must be finite", "det F = -1.21: must be > 0", "not finite: a result is beyond",
             "no fibre: n0 = 0", r"n0\[1\] = inf: must be finite", "G = 0: must be > 0 and finite", "stretch = 0: must be > 0 and finite",
             "G = -inf: must be > 0 and finite"]
    for i in range(1, 9):
        with pytest.raises(MyogrowthError, match="^" + texts[i]) as error:
            update(MUSCLE, F[i], 0.1, State(G=G[i], stretch=stretch[i], n0=n0[i]))
        assert error.value.status == kinds[i] and error.value.point == ()
        assert not re.search("PROPS|STATEV|DEPVAR|DFGRD", str(error.value))
    with pytest.raises(MyogrowthError, match=r"^point 1: F\[0, 1\] = nan.* \(7 more of 9 points failed\)$"):
        update(MUSCLE, F, 0.1, state)


def test_nothing_speaks_of_entries_by_number():
    for parameter in parameters():
        assert not re.search(r"PROPS|NPROPS|DEPVAR|\d\d-\d\d", parameter.meaning + parameter.allowed)
    for bad in (-100, np.nan, np.inf):
        for parameter in parameters():
            if parameter.name not in ("energy", "integration"):
                given = {"tau_rev": 1, "gamma_rev": 1, "G_min": 0.5, "lambda_crit_rev": 0.9, parameter.name: bad}
                with pytest.raises(MyogrowthError, match=f"^{parameter.name} = ") as error:
                    Parameters(**given)
                assert not re.search(r"PROPS|NPROPS|DEPVAR|\d\d-\d\d", str(error.value))


def test_parameters_stay_checked_and_can_be_copied_and_sent():
    muscle = Parameters(tau=2, energy="grown")
    with pytest.raises(dataclasses.FrozenInstanceError, match="tau"):
        muscle.tau = -1
    with pytest.raises(dataclasses.FrozenInstanceError, match="Gmax"):
        muscle.Gmax = 1.2
    with pytest.raises(MyogrowthError, match="^tau = -1: "):
        dataclasses.replace(muscle, tau=-1)
    assert isinstance(Parameters(tau=np.array(2)).tau, float)
    for same in (copy.copy(muscle), copy.deepcopy(muscle), pickle.loads(pickle.dumps(muscle))):
        assert same == muscle and hash(same) == hash(muscle)
    with pytest.raises(MyogrowthError) as error:
        update(muscle, -EYE[None], 0.1)
    back = pickle.loads(pickle.dumps(error.value))
    assert (back.status, back.point, str(back)) == (Status.INVERTED, (0,), str(error.value))
    step = pickle.loads(pickle.dumps(update(muscle, 1.1 * EYE, 0.1)))
    assert step.state.G > 1


HOSTILE = [0, 1, -1, 1.1, np.nan, np.inf, -np.inf, 1e308, 1e-320, True, None, "x", b"1", 1j, [], [[]], {}, object(), np.array(1.0),
           np.ones(1), np.ones(2), 1.1 * EYE, np.zeros((0, 3, 3)), np.full((2, 3, 3), np.nan), np.tile(EYE, (4, 1, 1)),
           EYE.astype("f2"), np.ma.array(EYE, mask=EYE > 0), np.ma.masked, 10**30, range(3), np.zeros(3, "M8[s]"), np.ones((4, 3)),
           np.ones(4), "cauchy", "first_piola", [1, 0, 0], np.arange(5), lambda: 1, *LOSSY[4][:1], MUSCLE, State()]


def test_hostile_calls():
    """Whatever comes in: a result whose failed points are NaN, or one line that begins with a name of Python's."""
    random = np.random.default_rng(4)

    def pick():
        return HOSTILE[random.integers(len(HOSTILE))]

    def often(good):
        return good if random.random() < 0.7 else pick()

    names = ("F", "dt", "state", "muscle", "measure", "tangent", "raise_on_failure", "time", "stretch", "G", "n0", "det F", "no fibre",
             "not finite", "point", *(p.name for p in parameters()))
    worked = refused = 0
    for i in range(4000):
        try:
            if i % 3 == 0:
                step = update(often(MUSCLE), often(np.tile(1.1 * EYE, (4, 1, 1))), often(0.1), State(G=often(1.0), n0=often((1, 0, 0))),
                              measure=often("cauchy"), tangent=often(True), raise_on_failure=bool(random.integers(2)))
                for values in (step.stress, step.energy, step.lambda_e, step.J, step.Je):
                    assert np.isfinite(values[~step.failed]).all() and np.isnan(values[step.failed]).all()
            elif i % 3 == 1:
                simulate(often(MUSCLE), often(np.linspace(0, 5, 5)), often(1.1), G=often(1.0))
            else:
                Parameters(**{p.name: pick() for p in parameters() if random.random() < 0.1})
            worked += 1
        except (ValueError, TypeError) as error:
            text = str(error)
            assert text.startswith(names) and "\n" not in text and len(text) < 300 and not re.search("PROPS|STATEV", text), text
            refused += 1
    assert worked > 500 and refused > 1500, (worked, refused)


def test_others_may_run_while_the_law_works():
    """The main thread counts while another is in one long call: it could not if the call kept the GIL."""
    F, state = points((50_000,))
    done, counted = threading.Event(), 0
    result = []

    def work():
        result.append(update(MUSCLE, F, 0.1, state, tangent=True))
        done.set()

    time = np.linspace(0, 42, 200_001)
    history = []
    thread = threading.Thread(target=work)
    thread.start()
    while not done.is_set():
        counted += 1
        history.append(simulate(MUSCLE, time[:1000], 1.1).G[-1])
    thread.join()
    assert counted > 1 and len(set(history)) == 1
    np.testing.assert_array_equal(result[0].stress[:100], update(MUSCLE, F[:100], 0.1, State(
        G=state.G[:100], n0=state.n0[:100])).stress)


def test_the_example_says_what_it_cannot_write(tmp_path):
    example = pathlib.Path(__file__).parents[2] / "examples/python/six_weeks.py"
    (tmp_path / "six_weeks.png").write_text("older")
    for folder, stdout, said in ((tmp_path / "six_weeks.png", "/dev/null", "cannot be made a folder: there is a file of that name"),
                                 (tmp_path, "/dev/full", "standard output cannot be written: No space left on device")):
        with open(stdout, "w") as out:
            done = subprocess.run([sys.executable, example, folder], stdout=out, stderr=subprocess.PIPE, text=True)
        assert done.returncode == 1 and said in done.stderr and done.stderr.count("\n") == 1


def test_the_page_that_says_how_to_start(capsys):
    """The code of docs/getting-started.md runs and prints what the paper's law gives with gamma = 1.5."""
    page = (pathlib.Path(__file__).parents[2] / "docs/getting-started.md").read_text(encoding="utf-8")
    code, = re.findall(r"^```python\n(.*?)^```", page, re.M | re.S)
    exec(code, {})
    first, *table = capsys.readouterr().out.splitlines()
    assert [float(x) for x in first.split()] == pytest.approx([1.0606199, 1.0887300], abs=1e-6)
    assert len(table) == len(parameters()) and table[0].startswith("c1 stress > -2/3 c2")


# ---- Elastic laws

LAWS = {"Roehrle": 8, "Blemker": 11, "Ehret": 8}


@pytest.mark.parametrize("name", LAWS)
def test_elastic_law_grows_and_its_tangent_is_the_derivative(name):
    muscle = Parameters(elastic=myogrowth.law(name))
    state = State(n0=(1, 0.5, -0.3))
    F = np.eye(3) + 0.12 * np.array([[1, 0.3, 0], [-0.2, 0.1, 0.2], [0, 0.1, -0.3]])
    step = update(muscle, F, 0.1, state, measure="first_piola", tangent=True, activation=0.2)
    assert step.state.G > 1 and step.state.G == update(MUSCLE, F, 0.1, state).state.G  # eq. 4 needs the stretch only
    h = 1e-6
    for k in range(3):
        for L in range(3):
            d = np.zeros((3, 3))
            d[k, L] = h
            difference = (update(muscle, F + d, 0.1, state, measure="first_piola", activation=0.2).stress
                          - update(muscle, F - d, 0.1, state, measure="first_piola", activation=0.2).stress) / (2 * h)
            assert np.abs(difference - step.tangent[:, :, k, L]).max() < 1e-6 * np.abs(step.tangent).max()
    passive = update(muscle, F, 0.1, state, measure="first_piola")
    assert np.abs(step.stress - passive.stress).max() > 1  # kPa: it is active
    assert simulate(muscle, [0, 1], 1.1).G[-1] == simulate(MUSCLE, [0, 1], 1.1).G[-1]
    assert len(myogrowth.law_parameters(name)) == LAWS[name] and pickle.loads(pickle.dumps(muscle)) == muscle


def test_elastic_law_of_4C():
    # The passive cube of 4C's regression test: sides free, the fibre compressed to a half.
    muscle = Parameters(elastic=myogrowth.law("Ehret", alpha=15, beta=1, gamma_e=5, kappa=100, w0=0.8))
    assert simulate(muscle, [0], 0.5).cauchy[0] == pytest.approx(-25.913195669478583, abs=1e-12)


def test_a_stiff_elastic_law_has_a_strip():
    # docs/laws.md advises a kappa of 1e4 for law 3, whose volume term is then out of range a few percent away.
    muscle = Parameters(elastic=myogrowth.law("Ehret", kappa=1e4))
    history = simulate(muscle, [0, 1, 42], [0.8, 1.1, 1.1], activation=1)
    assert np.abs(history.J / history.G - 1).max() < 1e-3 and history.G[-1] > 1.07


def test_tendon_has_its_published_parameters():
    values = dict(zip((p.name for p in myogrowth.law_parameters("Blemker")), myogrowth.law("Blemker", tendon=1, kappa=500).values))
    assert [values[name] for name in ("G1", "G2", "kappa", "lambda_star", "L1", "L2")] == [50, 50, 500, 1.03, 2700, 46.4]
    assert myogrowth.law("Blemker", tendon=0) == myogrowth.law("Blemker")
    assert myogrowth.law("Blemker", tendon=1, G1=3).values[:2] == (3, 50)


def test_activation_may_be_beyond_its_bounds_by_rounding():
    muscle = Parameters(elastic=myogrowth.law("Roehrle"))
    F = np.diag([1.05, 0.98, 0.98])
    assert update(muscle, F, 0, activation=1 + 1e-12).stress[0, 0] == update(muscle, F, 0, activation=1).stress[0, 0]
    assert simulate(muscle, [0], 1.1, activation=-1e-12).force[0] == simulate(muscle, [0], 1.1).force[0]
    for wrong in (1.00000001, -0.5, -1, np.nan):
        with pytest.raises(MyogrowthError, match=f"activation = {wrong:.12g}: must be >= 0 and <= 1$"):
            update(muscle, F, 0, activation=wrong)


@pytest.mark.parametrize("wrong, message", [
    (lambda: Parameters(elastic=myogrowth.Law("Ehret", ("x",) * 8)), "alpha: must be numbers"),
    (lambda: myogrowth.law("Hill"), "law 'Hill': must be 'Roehrle' or 'Blemker' or 'Ehret'"),
    (lambda: myogrowth.law("Ehret", G1=1), "law 'Ehret' has no 'G1': it has alpha, beta"),
    (lambda: myogrowth.law("Ehret", alpha="x"), "alpha: must be numbers"),
    (lambda: Parameters(elastic=myogrowth.law("Ehret", w0=1.1)), "^w0 = 1.1: weight of the isotropic part, must be finite and >= 0"),
    (lambda: Parameters(elastic="Ehret"), "elastic: must be a Law"),
    (lambda: Parameters(elastic=myogrowth.law("Ehret"), c1=20), "c1 = 20: is of the neo-Hookean law, and the elastic law is Ehret"),
    (lambda: Parameters(elastic=myogrowth.law("Ehret"), G_max=0.9), "^G_max = 0.9: largest"),
    (lambda: update(MUSCLE, np.eye(3), 0.1, activation=0.5), "activation = 0.5: must be 0: the neo-Hookean law"),
    (lambda: update(Parameters(elastic=myogrowth.law("Blemker")), np.eye(3), 0.1, activation=1.5), "activation = 1.5: must be >= 0 and <= 1"),
    (lambda: simulate(Parameters(elastic=myogrowth.law("Blemker")), [0], 1.1, activation=-1), "activation = -1: must be >= 0"),
])
def test_what_is_wrong_with_an_elastic_law_is_named(wrong, message):
    with pytest.raises((ValueError, TypeError), match=message):
        wrong()


# ---- Arrays where they lie: memory orders, out=, threads=

MEASURES = ["cauchy", "first_piola", "second_piola"]
NAMES = ("stress", "tangent", "energy", "lambda_e", "J", "Je", "status")


def numbers(step):
    """All arrays of a Step by their names."""
    return {**{name: getattr(step, name) for name in NAMES if getattr(step, name) is not None},
            **{name: getattr(step.state, name) for name in ("G", "stretch", "n0")}}


def same_bits(a, b):
    a, b = numbers(a), numbers(b)
    return a.keys() == b.keys() and all(a[name].tobytes() == b[name].tobytes() for name in a)


@pytest.mark.parametrize("measure", MEASURES)
def test_every_memory_order_gives_the_same_bits(measure):
    F, state = points((5, 41))
    F[1, 3], state.G[2, 7] = -F[1, 3], np.nan  # two that fail
    G, n0 = np.asarray(state.G), np.asarray(state.n0)
    options = dict(measure=measure, tangent=True, raise_on_failure=False)
    whole = update(MUSCLE, F, 0.1, state, **options)
    assert whole.failed.sum() == 2

    wide = np.zeros((10, 82, 7, 5))
    wide[::2, ::2, ::3, ::2] = F
    unaligned = np.zeros(F.size * 8 + 1, np.int8)[1:].view(float).reshape(F.shape)
    unaligned[...] = F
    views = {"Fortran": np.asfortranarray(F), "negative": F[::-1, ::-1, ::-1, ::-1].copy()[::-1, ::-1, ::-1, ::-1],
             "a part": wide[::2, ::2, ::3, ::2], "columns": F.swapaxes(-1, -2).copy().swapaxes(-1, -2),
             "components first": np.moveaxis(np.moveaxis(F, (-2, -1), (0, 1)).copy(), (0, 1), (-2, -1)),
             "points turned": F.swapaxes(0, 1).copy().swapaxes(0, 1), "big endian": F.astype(">f8"), "unaligned": unaligned}
    for name, view in views.items():
        assert same_bits(update(MUSCLE, view, 0.1, state, **options), whole), name
        other = State(G=np.asfortranarray(G), n0=n0[::-1, :, ::-1].copy()[::-1, :, ::-1])
        assert same_bits(update(MUSCLE, view, 0.1, other, **options), whole), name
    flat = update(MUSCLE, F.reshape(-1, 3, 3), 0.1, State(G=G.ravel(), n0=n0.reshape(-1, 3)), **options)
    assert flat.tangent.tobytes() == whole.tangent.tobytes()
    one = update(MUSCLE, np.broadcast_to(F[0, 0], (2, 3, 3, 3)), 0.1, State(G=G[0, 0], n0=n0[0, 0]), **options)
    assert one.tangent[1, 2].tobytes() == whole.tangent[0, 0].tobytes()  # steps of zero


@pytest.mark.parametrize("muscle", [MUSCLE, Parameters(elastic=myogrowth.law("Blemker")), Parameters(integration="midpoint_flow")])
@pytest.mark.parametrize("n", [0, 1, 31, 33, 1000])
def test_threads_give_the_same_bits(muscle, n):
    F, state = points((n,))
    F[n // 2:n // 2 + 1] *= -1
    options = dict(measure="first_piola", tangent=True, raise_on_failure=False)
    one = update(muscle, F, 0.1, state, **options)
    assert one.failed.sum() == min(n, 1)
    for threads in (2, 3, np.int64(8), 1024):
        assert same_bits(update(muscle, F, 0.1, state, threads=threads, **options), one)
    if n > 1:
        with pytest.raises(MyogrowthError, match=f"^point {n // 2}: det F = "):
            update(muscle, F, 0.1, state, threads=2)


@pytest.mark.parametrize("threads, kind", [(0, ValueError), (-1, ValueError), (1025, ValueError), (1.0, TypeError), (True, TypeError),
                                           ("2", TypeError), (None, TypeError)])
def test_wrong_threads(threads, kind):
    with pytest.raises(kind, match=r"^threads = .*: must be"):
        update(MUSCLE, EYE, 0.1, threads=threads)


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("shape", [(), (7,), (3, 40)])
def test_out_is_written_and_returned(measure, shape):
    F, state = points(shape)
    fresh = update(MUSCLE, F, 0.1, state, measure=measure, tangent=True)
    other = update(MUSCLE, 1.01 * F, 0.2, state, measure=measure, tangent=True)
    again = update(MUSCLE, F, 0.1, state, measure=measure, tangent=True, out=other)
    assert same_bits(again, fresh)
    assert all(numbers(again)[name] is numbers(other)[name] for name in numbers(other))
    given = {"stress": np.full((*shape, 3, 3), np.nan), "G": np.full(shape, np.nan)}
    some = update(MUSCLE, F, 0.1, state, measure=measure, tangent=True, out=given)
    assert same_bits(some, fresh) and some.stress is given["stress"] and some.state.G is given["G"]
    # A history with two Steps in turn.
    a, b = update(MUSCLE, F, 0.1, state, measure=measure), update(MUSCLE, F, 0.0, state, measure=measure)
    for _ in range(3):
        a, b = update(MUSCLE, F, 0.1, a.state, measure=measure, out=b), a
    plain = state
    for _ in range(4):
        step = update(MUSCLE, F, 0.1, plain, measure=measure)
        plain = step.state
    assert same_bits(a, step)


def test_out_may_be_a_file(tmp_path):
    F, state = points((7,))
    file = np.lib.format.open_memmap(tmp_path / "stress.npy", "w+", float, (7, 3, 3))
    step = update(MUSCLE, F, 0.1, state, out={"stress": file})
    assert step.stress is file and same_bits(step, update(MUSCLE, F, 0.1, state))
    assert np.array_equal(np.load(tmp_path / "stress.npy", mmap_mode="r"), step.stress)


def read_only(array):
    array.flags.writeable = False
    return array


@pytest.mark.parametrize("out, message", [
    (lambda F, state: {"stress": np.empty((6, 3, 3), "f4")}, "^out: stress must have dtype float64, has float32"),
    (lambda F, state: {"stress": np.empty((6, 3, 3), ">f8")}, "^out: stress must have dtype float64, has >f8"),
    (lambda F, state: {"status": np.empty(6)}, "^out: status must have dtype int32, has float64"),
    (lambda F, state: {"stress": np.empty((5, 3, 3))}, r"^out: stress must have shape \(6, 3, 3\), has \(5, 3, 3\)"),
    (lambda F, state: {"tangent": np.empty((6, 6, 6))}, r"^out: tangent must have shape \(6, 3, 3, 3, 3\), has \(6, 6, 6\)"),
    (lambda F, state: {"G": np.empty((6, 1))}, r"^out: G must have shape \(6,\), has \(6, 1\)"),
    (lambda F, state: {"stress": np.empty((12, 3, 3))[::2]}, "^out: stress must be C-contiguous and aligned"),
    (lambda F, state: {"stress": np.empty((6, 3, 3), order="F")}, "^out: stress must be C-contiguous and aligned"),
    (lambda F, state: {"energy": np.zeros(49, np.int8)[1:].view(float)}, "^out: energy must be C-contiguous and aligned"),
    (lambda F, state: {"stress": read_only(np.empty((6, 3, 3)))}, "^out: stress is read-only"),
    (lambda F, state: {"stress": np.broadcast_to(np.zeros((3, 3)), (6, 3, 3))}, "^out: stress must be C-contiguous"),
    (lambda F, state: {"stress": F}, "^out: stress overlaps F: must have memory of its own"),
    (lambda F, state: {"n0": state.n0}, "^out: n0 overlaps state.n0"),
    (lambda F, state: {"G": state.G}, "^out: G overlaps state.G"),
    (lambda F, state: {"J": state.G[::-1][::-1]}, "^out: J overlaps state.G"),
    (lambda F, state: dict.fromkeys(("J", "Je"), np.empty(6)), "^out: Je overlaps J"),
    (lambda F, state: {"stress": [0.0]}, r"^out: stress must be a NumPy array, is \[0.0\]"),
    (lambda F, state: {"stress": np.ma.zeros((6, 3, 3))}, "^out: stress must be a NumPy array"),
    (lambda F, state: {"sigma": np.empty((6, 3, 3))}, "^out: has 'sigma': must be of stress, tangent, energy, G"),
    (lambda F, state: update(MUSCLE, F[:5], 0.1), r"^out: stress must have shape \(6, 3, 3\), has \(5, 3, 3\)"),
])
def test_wrong_out(out, message):
    F, state = points((6,))
    with pytest.raises(ValueError, match=message):
        update(MUSCLE, F, 0.1, state, tangent=True, out=out(F, state))
    step = update(MUSCLE, F, 0.1, state, tangent=True)
    with pytest.raises(ValueError, match="^out: stress overlaps F|^out: G overlaps state.G"):  # its own state
        update(MUSCLE, step.stress, 0.1, step.state, tangent=True, out=step)
    with pytest.raises(ValueError, match="^out: has 'tangent': must be of stress, energy, .*, unless tangent=True$"):
        update(MUSCLE, F, 0.1, state, out=step)
    with pytest.raises(TypeError, match="^out: must be a Step, or a dict"):
        update(MUSCLE, F, 0.1, state, out=np.empty((6, 3, 3)))


@pytest.mark.parametrize("measure", MEASURES)
def test_nothing_of_the_size_of_the_data_is_made_on_the_way(measure):
    """With out= the memory does not grow: whatever the layout of doubles, and by threads."""
    import tracemalloc
    F, state = points((20_000,))
    for view in (F, np.asfortranarray(F), F[::-1]):
        step = update(MUSCLE, view, 0.1, state, measure=measure, tangent=True)
        tracemalloc.start()
        update(MUSCLE, view, 0.1, state, measure=measure, tangent=True, out=step, threads=2)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 50_000, peak  # F has 1.4 MB
