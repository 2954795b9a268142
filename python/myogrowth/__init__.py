"""Stretch-driven skeletal-muscle growth over NumPy arrays: the law of myogrowth, one step or a whole history::

    import numpy as np, myogrowth

    muscle = myogrowth.Parameters()                          # the paper's Table 1, in kPa and days
    time = np.linspace(0, 42, 4201)
    history = myogrowth.simulate(muscle, time, np.minimum(1 + 0.1 * time, 1.1))
    history.G[-1], history.lambda_e.max()                    # 1.0869, 1.063

    step = myogrowth.update(muscle, F, dt=0.1, measure="first_piola", tangent=True)   # F: (..., 3, 3)
    step.stress, step.tangent, step.state                    # (..., 3, 3), (..., 3, 3, 3, 3)
    step = myogrowth.update(muscle, F_next, dt=0.1, state=step.state)

Arrays are in NumPy's natural order: F[..., i, J], dP_dF[..., i, J, k, L]. Nothing that comes in is changed; the GIL is
released while the law works, so threads may call it side by side. Units are yours, one for stress and one for time.
"""
from __future__ import annotations

import dataclasses
import enum
import functools
import re
from typing import Any, Literal, NamedTuple, Optional, Tuple, TypeVar, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

__version__: str = _core.version()
__all__ = ["History", "MyogrowthError", "Parameter", "Parameters", "State", "Status", "Step", "parameters",
           "simulate", "update"]

Floats = NDArray[np.float64]
Measure = Literal["cauchy", "first_piola", "second_piola"]

_MEASURES = {"cauchy": 0, "first_piola": 1, "second_piola": 2}
_CHOICES = {"energy": ("reference", "grown"), "integration": ("backward_euler", "midpoint_flow")}


class Status(enum.IntEnum):
    """What became of a point."""

    OK = 0
    NOT_FINITE = 1  #: NaN or infinity in F or dt, or a result beyond the range of double
    INVERTED = 2  #: det F <= 0: take a smaller step
    NO_FIBRE = 3  #: the fibre has no length
    BAD_STATE = 4  #: G or the fibre of the state is not allowed
    BAD_PARAMETER = 5  #: a parameter is not allowed
    BAD_ARGUMENT = 6  #: an argument is not allowed


class MyogrowthError(ValueError):
    """A point, or a parameter, that has no result.

    status: why. point: its index in the leading shape of F (for simulate: the row of the history), () for a single
    point, None where it is no point's fault. message: what was wrong and what is allowed.
    """

    def __init__(self, status: int, point: Optional[Tuple[int, ...]], message: str):
        self.status, self.point, self.message = Status(status), point, message
        super().__init__(f"point {', '.join(map(str, point))}: {message}" if point else message)


class Parameter(NamedTuple):
    """One parameter of the law, as the library's own table has it."""

    name: str  #: as in Parameters
    unit: str  #: "stress", "time" or "-"
    meaning: str  #: in words
    allowed: str  #: in words
    default: Any  #: the paper's Table 1 (kPa, days); extensions are off


_Class = TypeVar("_Class", bound=type)


def _names_unknown(cls: _Class) -> _Class:
    """Lets a dataclass say which names it knows when it is given one that it does not."""
    made = cls.__init__
    names = [field.name for field in dataclasses.fields(cls)]

    @functools.wraps(made)
    def __init__(self: Any, **given: Any) -> None:
        for name in given:
            if name not in names:
                raise TypeError(f"{cls.__name__} has no {name!r}: it has {', '.join(names)}")
        made(self, **given)

    cls.__init__ = __init__
    return cls


@_names_unknown
@dataclasses.dataclass(frozen=True)
class Parameters:
    """The material: elasticity (eq. 3), growth (eq. 4), and the extensions. Given by name, checked when made.

    Defaults: the paper's Table 1, in kPa and days. `parameters()` lists units, meaning and what is allowed.
    """

    c1: float = 16.0  #: first Lame constant [stress], > -2/3 c2
    c2: float = 4.0  #: second Lame constant [stress], > 0
    tau: float = 0.5  #: time constant of growth [time], > 0
    gamma: float = 2.0  #: shape exponent of the adaptation function [-], >= 0
    G_max: float = 1.1  #: largest relative serial sarcomere number [-], > 1
    lambda_crit: float = 1.01  #: elastic fibre stretch above which sarcomeres are added [-], > 0
    energy: Literal["reference", "grown"] = "reference"  #: volume that psi is counted per
    integration: Literal["backward_euler", "midpoint_flow"] = "backward_euler"  #: of first, of second order in time
    tau_rev: float = 0.0  #: time constant of removal [time]; 0: nothing is removed, and the next three are not used
    gamma_rev: float = 0.0  #: shape exponent of removal [-], >= 0
    G_min: float = 0.0  #: smallest relative serial sarcomere number [-], > 0 and < 1
    lambda_crit_rev: float = 0.0  #: elastic stretch below which they are removed [-], > 0 and <= lambda_crit

    def __post_init__(self) -> None:
        for name, allowed in _CHOICES.items():
            if getattr(self, name) not in allowed:
                raise MyogrowthError(Status.BAD_PARAMETER, None,
                                     f"{name} = {getattr(self, name)!r}: must be {' or '.join(map(repr, allowed))}")
        for field in dataclasses.fields(self):
            if field.name not in _CHOICES and not isinstance(getattr(self, field.name), (int, float, np.number)):
                raise MyogrowthError(Status.BAD_PARAMETER, None,
                                     f"{field.name} = {getattr(self, field.name)!r}: must be a number")
        status, message = _core.check(self._props())
        if status != Status.OK:
            # The C API counts entries, PROPS(5) = 0.9: G_max, ...; here they have names alone.
            raise MyogrowthError(status, None, re.sub(r"PROPS\(\d+\) = (.+?): (\w+), ", r"\2 = \1: ", message))

    def _props(self) -> Floats:
        """PROPS of the C API. The fibre is left out: it comes with the state, and 0 is then an error."""
        props = np.zeros(len(_SYMBOLS))
        for i, symbol in enumerate(_SYMBOLS):
            if hasattr(self, symbol):
                value = getattr(self, symbol)
                props[i] = _CHOICES[symbol].index(value) if symbol in _CHOICES else value
        return props


_SYMBOLS = [symbol for symbol, *_ in _core.parameters()]


def parameters() -> Tuple[Parameter, ...]:
    """Name, unit, meaning, what is allowed, and default of every parameter."""
    table = {symbol: (unit, meaning, allowed) for symbol, unit, meaning, allowed, _ in _core.parameters()}
    listed = []
    for field in dataclasses.fields(Parameters):
        unit, meaning, allowed = table[field.name]
        if field.name in _CHOICES:
            meaning = {"energy": "volume that psi is counted per", "integration": "of eq. 4 in time"}[field.name]
            allowed = " or ".join(map(repr, _CHOICES[field.name]))
        listed.append(Parameter(field.name, unit, meaning, allowed, field.default))
    return tuple(listed)


@_names_unknown
@dataclasses.dataclass(frozen=True)
class State:
    """What points remember from one step to the next, and their fibre. Each broadcasts to the points of F."""

    G: Union[float, Floats] = 1.0  #: relative serial sarcomere number [-], > 0; a number or (...)
    stretch: Union[float, Floats] = 1.0  #: total fibre stretch lambda [-], > 0, for integration="midpoint_flow"
    n0: ArrayLike = (1.0, 0.0, 0.0)  #: reference fibre direction, any length > 0; (3,) or (..., 3)


@dataclasses.dataclass(frozen=True)
class Step:
    """Result of update for points of the leading shape (...)."""

    stress: Floats  #: (..., 3, 3): sigma_ij, P_iJ or S_IJ [stress]
    tangent: Optional[Floats]  #: (..., 3, 3, 3, 3), see update [stress]; None if not asked for
    energy: Floats  #: (...): psi per unit reference volume [stress]
    state: State  #: at the end of the step
    lambda_e: Floats  #: (...): elastic fibre stretch, the relative sarcomere length [-]
    J: Floats  #: (...): det F [-]
    Je: Floats  #: (...): J/G [-]
    status: NDArray[np.int32]  #: (...): a Status for every point


def _full(six: Floats) -> Floats:
    """The symmetric tensors (..., 3, 3) of six components, 11 22 33 12 13 23."""
    return six[..., _SIX]


_SIX = np.array([[0, 3, 4], [3, 1, 5], [4, 5, 2]])


def _array(name: str, value: Any) -> Floats:
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: must be numbers, is {value!r}") from None


def _over_points(name: str, value: Any, shape: Tuple[int, ...]) -> Floats:
    array = _array(name, value)
    try:
        return np.broadcast_to(array, shape)
    except ValueError:
        raise ValueError(f"{name} has shape {array.shape}: must broadcast to {shape}, the points of F") from None


def _demand_positive(name: str, values: Floats) -> None:
    bad = ~(values > 0)
    if bad.any():
        point = tuple(int(i) for i in np.argwhere(bad)[0])
        raise MyogrowthError(Status.BAD_STATE, point, f"{name} = {values[point]:g}: must be > 0")


def update(muscle: Parameters, F: ArrayLike, dt: float, state: State = State(), *, measure: Measure = "cauchy",
           tangent: bool = False, raise_on_failure: bool = True) -> Step:
    """One step of length dt [time] to the deformation gradient F (..., 3, 3), F[..., i, J], at its end.

    dt <= 0 is an elastic step. state: where the points come from, by default unstretched, G = 1, fibre along x.

    ================  ==================  ============================================================================
    measure           stress (..., 3, 3)  tangent (..., 3, 3, 3, 3)
    ================  ==================  ============================================================================
    "cauchy"          sigma[i, j]         c[i, j, k, l]: c:D is the Jaumann rate of J sigma, over J; Abaqus's DDSDDE
    "first_piola"     P[i, J]             dP_dF[i, J, k, L] = dP_iJ/dF_kL
    "second_piola"    S[I, J]             dS_dE[I, J, K, L] = dS_IJ/dE_KL
    ================  ==================  ============================================================================

    The tangent is that of this discrete step, growth included; where the muscle grows it is unsymmetric.

    MyogrowthError names the first point that has no result. With raise_on_failure=False there is none: `status` says
    which points failed, their stress, tangent and energy are NaN and their state is the one that came in.
    """
    if not isinstance(muscle, Parameters):
        raise TypeError(f"muscle: must be Parameters, is {muscle!r}")
    if not isinstance(state, State):
        raise TypeError(f"state: must be a State, is {state!r}")
    if measure not in _MEASURES:
        raise ValueError(f"measure = {measure!r}: must be {' or '.join(map(repr, _MEASURES))}")
    F = _array("F", F)
    if F.shape[-2:] != (3, 3):
        raise ValueError(f"F has shape {F.shape}: must be (..., 3, 3)")
    points = F.shape[:-2]
    before = np.zeros((*points, 8))  # STATEV: G, lambda_e, lambda, J, Je, n0
    before[..., 0] = _over_points("state.G", state.G, points)
    before[..., 2] = _over_points("state.stretch", state.stretch, points)
    before[..., 5:] = _over_points("state.n0", state.n0, (*points, 3))
    _demand_positive("G", before[..., 0])
    _demand_positive("stretch", before[..., 2])

    columns = np.ascontiguousarray(F.swapaxes(-1, -2)).reshape(-1, 9)
    stress, moduli, energy, after, status, message = _core.update(
        muscle._props(), columns, before.reshape(-1, 8), float(dt), _MEASURES[measure], tangent)
    if raise_on_failure and status.any():
        point = np.unravel_index(int(np.argmax(status != 0)), points) if points else ()
        point = tuple(int(i) for i in point)
        first = int(status[status != 0][0])
        why = re.sub(r"^point \d+ \(of .*?\): ", "", message)
        if first == Status.INVERTED:
            why = f"det F = {np.linalg.det(F[point]):g}: must be > 0"
        elif first == Status.NO_FIBRE:
            why = "no fibre: n0 = 0, 0, 0: must have a length > 0"
        raise MyogrowthError(first, point, why)

    if measure == "first_piola":
        stress = stress.reshape(*points, 3, 3).swapaxes(-1, -2)
        if tangent:
            moduli = np.moveaxis(moduli.reshape(*points, 3, 3, 3, 3), (-1, -2, -3, -4), (-4, -3, -2, -1))
    else:
        stress = _full(stress.reshape(*points, 6))
        if tangent:
            moduli = moduli.reshape(*points, 6, 6)[..., _SIX, :][..., _SIX]  # [column, row]
            moduli = np.moveaxis(moduli, (-4, -3), (-2, -1))
    after = after.reshape(*points, 8)
    return Step(stress, moduli, energy.reshape(points), State(G=after[..., 0], stretch=after[..., 2], n0=after[..., 5:]),
                after[..., 1], after[..., 3], after[..., 4], status.reshape(points))


@dataclasses.dataclass(frozen=True)
class History:
    """Result of simulate: arrays of the length of time."""

    time: Floats  #: [time]
    stretch: Floats  #: total fibre stretch lambda [-]
    G: Floats  #: relative serial sarcomere number [-]
    lambda_e: Floats  #: elastic fibre stretch, the relative sarcomere length [-]
    lateral: Floats  #: stretch of the sides, which are free [-]
    force: Floats  #: along the fibre, per reference area: first Piola-Kirchhoff stress [stress]
    cauchy: Floats  #: the same per current area [stress]
    J: Floats  #: volume ratio [-]


def simulate(muscle: Parameters, time: ArrayLike, stretch: ArrayLike, *, G: float = 1.0) -> History:
    """A strip of muscle pulled along its fibre, sides free of force: growth and stress over a history of stretch.

    time: (n,), increasing [time]. stretch: (n,), or one number, the total fibre stretch at these times [-]. The steps
    are those between the times, and the first time is the start: nothing has grown there yet. G: the sarcomere number
    at the start.

    Backward Euler is of first order: halve the steps to see their error, or take integration="midpoint_flow".
    MyogrowthError names the row (`point`) that has no result.
    """
    if not isinstance(muscle, Parameters):
        raise TypeError(f"muscle: must be Parameters, is {muscle!r}")
    time = _array("time", time)
    if time.ndim != 1 or time.size == 0:
        raise ValueError(f"time has shape {time.shape}: must be (n,), n >= 1")
    if not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0):
        raise ValueError("time: must be finite and increase from entry to entry")
    stretch = np.ascontiguousarray(_over_points("stretch", stretch, time.shape))
    for i in np.flatnonzero(~(np.isfinite(stretch) & (stretch > 0))):
        raise MyogrowthError(Status.BAD_ARGUMENT, (int(i),), f"stretch = {stretch[i]:g}: must be finite and > 0")
    _demand_positive("G", _array("G", float(G)))
    rows, status, done = _core.simulate(muscle._props(), np.ascontiguousarray(time), stretch, float(G))
    if status != Status.OK:
        raise MyogrowthError(status, (done,), _core.status_text(status))
    G_, lambda_e, lateral, cauchy, J = rows.T
    return History(time, stretch, G_, lambda_e, lateral, cauchy * J / stretch, cauchy, J)
