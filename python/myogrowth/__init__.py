"""Stretch-driven skeletal-muscle growth over NumPy arrays: the law of myogrowth, one step or a whole history::

    import numpy as np, myogrowth

    muscle = myogrowth.Parameters()                          # the paper's Table 1, in kPa and days
    time = np.linspace(0, 42, 4201)
    history = myogrowth.simulate(muscle, time, np.minimum(1 + 0.1 * time, 1.1))
    history.G[-1], history.lambda_e.max()                    # 1.0869, 1.063

    step = myogrowth.update(muscle, F, dt=0.1, measure="first_piola", tangent=True)   # F: (..., 3, 3)
    step.stress, step.tangent, step.state                    # (..., 3, 3), (..., 3, 3, 3, 3)
    step = myogrowth.update(muscle, F_next, dt=0.1, state=step.state)

    active = myogrowth.Parameters(elastic=myogrowth.law("Blemker", kappa=500))        # another elasticity than eq. 3
    step = myogrowth.update(active, F, dt=0.1, activation=0.5)

Arrays are in NumPy's natural order: F[..., i, J], dP_dF[..., i, J, k, L]. Nothing that comes in is changed; the GIL is
released while the law works, so threads may call it side by side. Units are yours, one for stress and one for time.

Numbers may be floats of any size and byte order, or integers; the law works with doubles. Refused, by the name of the
argument, is what would lose something on the way: masked arrays with hidden values, complex numbers, Booleans, texts,
dates, objects, integers beyond 2**53, floats beyond the range of double, arrays with a unit or another meaning of their own.
"""
from __future__ import annotations

import dataclasses
import enum
import functools
import re
import reprlib
from typing import Any, Dict, Literal, Mapping, NamedTuple, Optional, Tuple, TypeVar, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

__version__: str = _core.version()
__all__ = ["History", "Law", "MyogrowthError", "Parameter", "Parameters", "State", "Status", "Step", "law",
           "law_parameters", "parameters", "simulate", "update"]

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
    NOT_CONVERGED = 7  #: the stretch that frees the stress was not found in 200 iterations


class MyogrowthError(ValueError):
    """A point, or a parameter, that has no result.

    status: why. point: its index in the leading shape of F (for simulate: the row of the history), () for a single
    point, None where it is no point's fault. message: what was wrong and what is allowed.
    """

    def __init__(self, status: int, point: Optional[Tuple[int, ...]], message: str):
        self.status, self.point, self.message = Status(status), point, message
        super().__init__(f"point {', '.join(map(str, point))}: {message}" if point else message)

    def __reduce__(self) -> Any:
        return MyogrowthError, (self.status, self.point, self.message)  # so that it comes back from another process


class Parameter(NamedTuple):
    """One parameter of the law, as the library's own table has it."""

    name: str  #: as in Parameters
    unit: str  #: "stress", "time" or "-"
    meaning: str  #: in words
    allowed: str  #: in words
    default: Any  #: the paper's Table 1 (kPa, days); extensions are off


Points = Tuple[int, ...]


def _shown(value: Any) -> str:
    text = " ".join(reprlib.repr(value).split())
    return text if len(text) <= 80 else text[:80] + "..."


def _demand_plain(name: str, value: Any) -> None:
    """Refuses what np.asarray would drop without a word: masks, other meanings of subclasses, Booleans in lists."""
    if isinstance(value, (list, tuple)):
        for entry in value:
            _demand_plain(name, entry)
    elif isinstance(value, np.ma.MaskedArray):
        hidden = np.ma.count_masked(value)
        if hidden:
            raise ValueError(f"{name}: is masked, with {hidden} hidden values: fill them in, or leave them out")
    elif isinstance(value, np.ndarray) and type(value) not in (np.ndarray, np.matrix, np.memmap):
        raise ValueError(f"{name}: must be a plain array, is a {type(value).__name__}: its unit or other meaning would be lost")
    elif isinstance(value, (bool, int, np.ndarray, np.generic)):
        _demand_exact(name, np.asarray(value), value)


def _demand_exact(name: str, array: NDArray[Any], value: Any) -> None:
    """Refuses Booleans and integers that doubles do not hold: among floats NumPy would round them."""
    if array.dtype.kind == "b":
        raise ValueError(f"{name}: must be numbers, is {_shown(value)} of type bool")
    integers = array if array.dtype.kind in "iu" else np.array(value, dtype=object) if isinstance(value, int) else np.zeros(0)
    if ((integers > 2**53) | (integers < -(2**53))).any():
        raise ValueError(f"{name}: integers must be within +-2**53, which doubles hold exactly, is {_shown(value)}")


def _array(name: str, value: Any) -> Floats:
    """An argument as an array of doubles, or a ValueError that names it."""
    try:
        _demand_plain(name, value)
    except RecursionError:  # a list that contains itself
        raise ValueError(f"{name}: must be numbers, is {_shown(value)}") from None
    try:
        array = np.asarray(value)
    except Exception:  # whatever an object's own conversion raises
        array = None
    if array is None or array.dtype.kind not in "fiucb":
        what = "" if array is None or array.dtype.kind == "U" else f" of type {array.dtype}"
        raise ValueError(f"{name}: must be numbers, is {_shown(value)}{what}")
    if array.dtype.kind == "c":
        raise ValueError(f"{name}: must be real, is {_shown(value)} of type {array.dtype}")
    _demand_exact(name, array, value)
    with np.errstate(over="ignore"):
        doubles = np.asarray(array, dtype=float)
    if doubles is not array and (np.isfinite(array) & ~np.isfinite(doubles)).any():
        raise ValueError(f"{name}: must be within the range of double, is {_shown(value)}")
    return doubles


def _number(name: str, value: Any) -> float:
    array = _array(name, value)
    if array.ndim:
        raise ValueError(f"{name} has shape {array.shape}: must be one number")
    return float(array)


def _switch(name: str, value: Any) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} = {_shown(value)}: must be True or False")
    return bool(value)


def _over_points(name: str, value: Any, points: Points, size: Points = ()) -> Floats:
    """What is given once for all points, with shape `size`, or for each of them; by nothing in between, which is more
    often a mistake than meant."""
    array = _array(name, value)
    if array.shape not in (size, points + size):
        raise ValueError(f"{name} has shape {array.shape}: must broadcast to the points of F from {size}, one for all, or "
                         f"have {points + size}, one for each")
    return np.broadcast_to(array, points + size)


_Class = TypeVar("_Class", bound=type)


def _names_unknown(cls: _Class) -> _Class:
    """Lets a dataclass say which names it knows when it is given one that it does not."""
    made = cls.__init__
    names = [field.name for field in dataclasses.fields(cls)]

    @functools.wraps(made)
    def __init__(self: Any, *values: Any, **given: Any) -> None:
        if values:
            raise TypeError(f"{cls.__name__} takes its values by name, e.g. {names[0]}={_shown(values[0])}")
        for name in given:
            if name not in names:
                raise TypeError(f"{cls.__name__} has no {name!r}: it has {', '.join(names)}")
        made(self, **given)

    cls.__init__ = __init__
    return cls


@dataclasses.dataclass(frozen=True)
class Law:
    """An elastic law other than the neo-Hookean one, made by `law`."""

    name: str  #: "Roehrle", "Blemker" or "Ehret"
    values: Tuple[float, ...]  #: its parameters, in the order of `law_parameters`


_LAWS = {name: table for name, table in _core.laws()}


def _law_table(name: Any) -> Any:
    if not isinstance(name, str) or name not in _LAWS:
        raise ValueError(f"law {_shown(name)}: must be {' or '.join(map(repr, _LAWS))}")
    return _LAWS[name]


def law_parameters(name: str) -> Tuple[Parameter, ...]:
    """Name, unit, meaning, what is allowed, and published default of every parameter of a law."""
    return tuple(Parameter(*entry) for *entry, _ in _law_table(name))


def law(name: str, **values: float) -> Law:
    """An elastic law for Parameters(elastic=...): "Roehrle", "Blemker" or "Ehret", with its published parameters but for
    those given by name: law("Blemker", tendon=1) has those of tendon. `law_parameters(name)` lists them; they are checked
    when the Parameters are made."""
    table = _law_table(name)
    symbols = [symbol for symbol, *_ in table]
    for given in values:
        if given not in symbols:
            raise TypeError(f"law {name!r} has no {given!r}: it has {', '.join(symbols)}")
    numbers = {symbol: _number(symbol, value) for symbol, value in values.items()}
    is_tendon = numbers.get("tendon") == 1
    return Law(name, tuple(numbers.get(symbol, of_tendon if is_tendon else default) for symbol, *_, default, of_tendon in table))


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
    elastic: Optional[Law] = None  #: an elastic law in the place of eq. 3, which c1 and c2 belong to

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            name, value = field.name, getattr(self, field.name)
            if name == "elastic":
                continue
            if name in _CHOICES:
                if not isinstance(value, str) or value not in _CHOICES[name]:
                    raise MyogrowthError(Status.BAD_PARAMETER, None,
                                         f"{name} = {_shown(value)}: must be {' or '.join(map(repr, _CHOICES[name]))}")
                continue
            try:
                object.__setattr__(self, name, _number(name, value))
            except ValueError:
                raise MyogrowthError(Status.BAD_PARAMETER, None,
                                     f"{name} = {_shown(value)}: must be a number, real and in the range of double") from None
        if self.elastic is not None:
            if not isinstance(self.elastic, Law):
                raise TypeError(f"elastic: must be a Law, made by law(name), or None, is {_shown(self.elastic)}")
            if len(self.elastic.values) != len(_law_table(self.elastic.name)):
                raise ValueError(f"elastic: {self.elastic.name} has {len(_law_table(self.elastic.name))} parameters")
            symbols = [symbol for symbol, *_ in _law_table(self.elastic.name)]
            object.__setattr__(self, "elastic", law(self.elastic.name, **dict(zip(symbols, self.elastic.values))))
            for name in ("c1", "c2"):
                if getattr(self, name) != getattr(Parameters, name):
                    raise MyogrowthError(Status.BAD_PARAMETER, None, f"{name} = {getattr(self, name):g}: is of the "
                                         f"neo-Hookean law, and the elastic law is {self.elastic.name}")
        status, message = _core.check(self._props())
        if status != Status.OK:
            raise MyogrowthError(status, None, _by_name(message))

    def _props(self, activation: Any = 0.0) -> Floats:
        """PROPS of the C API. The fibre is left out: it comes with the state, and 0 is then an error."""
        activation = _number("activation", activation)
        if not self.elastic and activation != 0:
            raise MyogrowthError(Status.BAD_PARAMETER, None,
                                 f"activation = {activation:.12g}: must be 0: the neo-Hookean law has no active force")
        props = np.zeros(len(_SYMBOLS))
        for i, symbol in enumerate(_SYMBOLS):
            if hasattr(self, symbol):
                value = getattr(self, symbol)
                props[i] = _CHOICES[symbol].index(value) if symbol in _CHOICES else value
        if self.elastic:
            props[:2] = 0
            props = np.concatenate([props, [1 + list(_LAWS).index(self.elastic.name), activation], self.elastic.values])
            # What rounding may leave beyond 0 and 1 is the library's to say; -1 means a field variable there.
            if not 0 <= activation <= 1 and (activation == -1 or _core.check(props)[0] != Status.OK):
                raise MyogrowthError(Status.BAD_PARAMETER, None, f"activation = {activation:.12g}: must be >= 0 and <= 1")
        return props


_SYMBOLS = [symbol for symbol, *_ in _core.parameters()]


def _by_name(text: str) -> str:
    """What the C API says by numbers, PROPS(5) = 0.9: G_max, ..., by the names that entries have here."""
    text = re.sub(r"PROPS\(\d+\) = (.+?): (\w+), ", r"\2 = \1: ", text)
    return re.sub(r"PROPS\((\d+)\)", lambda m: _SYMBOLS[int(m[1]) - 1], text)


def parameters() -> Tuple[Parameter, ...]:
    """Name, unit, meaning, what is allowed, and default of every parameter."""
    table = {symbol: (unit, meaning, allowed) for symbol, unit, meaning, allowed, _ in _core.parameters()}
    listed = []
    for field in dataclasses.fields(Parameters):
        if field.name == "elastic":  # no number: law_parameters() lists those of a law
            continue
        unit, meaning, allowed = table[field.name]
        if field.name in _CHOICES:
            meaning = {"energy": "volume that psi is counted per", "integration": "of eq. 4 in time"}[field.name]
            allowed = " or ".join(map(repr, _CHOICES[field.name]))
        listed.append(Parameter(field.name, unit, _by_name(meaning), allowed, field.default))
    return tuple(listed)


@_names_unknown
@dataclasses.dataclass(frozen=True)
class State:
    """What points remember from one step to the next, and their fibre: one for all points of F (...), or one for each."""

    G: Union[float, Floats] = 1.0  #: relative serial sarcomere number [-], > 0; a number or (...)
    stretch: Union[float, Floats] = 1.0  #: total fibre stretch lambda [-], > 0, for integration="midpoint_flow"; likewise
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

    @property
    def failed(self) -> NDArray[np.bool_]:
        """(...): the points that have no result. All their numbers are NaN but for the state, which is what came in."""
        return np.asarray(self.status != Status.OK)


def _positive(values: Floats) -> NDArray[np.bool_]:
    return (values > 0) & np.isfinite(values)


def _why(status: int, F: Floats, G: float, stretch: float, n0: Floats) -> str:
    """What is wrong with a point that has no result, by the names of update's arguments."""
    for name, value in (("G", G), ("stretch", stretch)):
        if not _positive(value):
            return f"{name} = {value:g}: must be > 0 and finite"
    for name, array in (("n0", n0), ("F", F)):
        for at in np.argwhere(~np.isfinite(array)):
            return f"{name}[{', '.join(map(str, at))}] = {array[tuple(at)]:g}: must be finite"
    if status == Status.NO_FIBRE:
        return "no fibre: n0 = 0, 0, 0: must have a length > 0"
    if status == Status.INVERTED:
        with np.errstate(all="ignore"):
            det = np.linalg.det(F)
        return f"det F = {det:g}: must be > 0" + (" beyond the rounding of its terms" if det > 0 else "")
    if status == Status.NOT_FINITE:
        return "not finite: a result is beyond the range of double"
    return _by_name(_core.status_text(status))


def _overlap(a: NDArray[Any], b: NDArray[Any]) -> bool:
    try:
        return np.shares_memory(a, b, max_work=10_000)
    except Exception:  # NumPy's TooHardError: it could not tell
        return True


def _outputs(out: Any, shapes: Mapping[str, Points], inputs: Mapping[str, Floats]) -> Dict[str, NDArray[Any]]:
    """The arrays that results are written to: those of `out`, checked, and new ones."""
    given: Dict[str, Any] = {}
    if isinstance(out, Step):
        given = {name: getattr(out.state if name in ("G", "stretch", "n0") else out, name) for name in _OUTPUTS}
        given = {name: array for name, array in given.items() if array is not None}
    elif isinstance(out, Mapping):
        given = dict(out)
    elif out is not None:
        raise TypeError(f"out: must be a Step, or a dict of arrays by the names of its numbers, is {_shown(out)}")
    for name in given:
        if name not in shapes:
            what = f"must be of {', '.join(shapes)}" + (", unless tangent=True" if name == "tangent" else "")
            raise ValueError(f"out: has {_shown(name)}: {what}")
    arrays = {}
    for name, shape in shapes.items():
        dtype = np.dtype(np.intc if name == "status" else np.float64)
        if name not in given:
            arrays[name] = np.empty(shape, dtype)
            continue
        array = given[name]
        if type(array) not in (np.ndarray, np.memmap):
            raise ValueError(f"out: {name} must be a NumPy array, is {_shown(array)}")
        if array.dtype != dtype:
            raise ValueError(f"out: {name} must have dtype {dtype}, has {array.dtype}")
        if array.shape != shape:
            raise ValueError(f"out: {name} must have shape {shape}, has {array.shape}")
        if not (array.flags.c_contiguous and array.flags.aligned):
            raise ValueError(f"out: {name} must be C-contiguous and aligned, and is not")
        if not array.flags.writeable:
            raise ValueError(f"out: {name} is read-only")
        for other, values in (*inputs.items(), *arrays.items()):
            if _overlap(array, values):
                raise ValueError(f"out: {name} overlaps {other}: must have memory of its own")
        arrays[name] = array
    return arrays


_OUTPUTS = ("stress", "tangent", "energy", "G", "stretch", "n0", "lambda_e", "J", "Je", "status")


def update(muscle: Parameters, F: ArrayLike, dt: float, state: State = State(), *, measure: Measure = "cauchy",
           tangent: bool = False, raise_on_failure: bool = True, activation: float = 0.0,
           out: Union[Step, Mapping[str, NDArray[Any]], None] = None, threads: int = 1) -> Step:
    """One step of length dt [time] to the deformation gradient F (..., 3, 3), F[..., i, J], at its end.

    dt <= 0 is an elastic step. state: where the points come from, by default unstretched, G = 1, fibre along x.

    ================  ==================  ============================================================================
    measure           stress (..., 3, 3)  tangent (..., 3, 3, 3, 3)
    ================  ==================  ============================================================================
    "cauchy"          sigma[i, j]         c[i, j, k, l]: c:D is the Jaumann rate of J sigma, over J; Abaqus's DDSDDE
    "first_piola"     P[i, J]             dP_dF[i, J, k, L] = dP_iJ/dF_kL
    "second_piola"    S[I, J]             dS_dE[I, J, K, L] = dS_IJ/dE_KL
    ================  ==================  ============================================================================

    The tangent is that of this discrete step, growth included; where the muscle grows it is unsymmetric. activation: of
    an elastic law, from 0 to 1, constant over the step, for all points.

    MyogrowthError names the first point that has no result. With raise_on_failure=False there is none: `status` and
    `failed` say which points failed; their state is the one that came in and all else of them is NaN.

    Doubles are read where they lie, in any memory order; other numbers are converted first. out: an earlier Step of the
    same points, measure and tangent, whose arrays are written over and returned; or a dict of arrays by the names of a
    Step's numbers ("stress", "tangent", "energy", "G", "stretch", "n0", "lambda_e", "J", "Je", "status"), the others are
    made. They must be C-contiguous and not overlap what comes in. threads: how many work on the points; results are the
    same bits for any number.
    """
    if not isinstance(muscle, Parameters):
        raise TypeError(f"muscle: must be Parameters, is {_shown(muscle)}")
    if not isinstance(state, State):
        raise TypeError(f"state: must be a State, is {_shown(state)}")
    if not isinstance(measure, str) or measure not in _MEASURES:
        raise ValueError(f"measure = {_shown(measure)}: must be {' or '.join(map(repr, _MEASURES))}")
    tangent, raise_on_failure = _switch("tangent", tangent), _switch("raise_on_failure", raise_on_failure)
    if isinstance(threads, (bool, np.bool_)) or not isinstance(threads, (int, np.integer)):
        raise TypeError(f"threads = {_shown(threads)}: must be a whole number")
    if not 1 <= threads <= 1024:
        raise ValueError(f"threads = {_shown(threads)}: must be from 1 to 1024")
    dt = _number("dt", dt)
    if not np.isfinite(dt):
        raise MyogrowthError(Status.NOT_FINITE, None, f"dt = {dt:g}: must be finite")
    F = _array("F", F)
    if F.shape[-2:] != (3, 3):
        raise ValueError(f"F has shape {F.shape}: must be (..., 3, 3)")
    points = F.shape[:-2]
    G, stretch = (_over_points(f"state.{name}", getattr(state, name), points) for name in ("G", "stretch"))
    n0 = _over_points("state.n0", state.n0, points, (3,))
    F, G, stretch, n0 = (array if array.flags.aligned else array.copy() for array in (F, G, stretch, n0))

    shapes = {name: points for name in _OUTPUTS}
    shapes.update(stress=(*points, 3, 3), tangent=(*points, 3, 3, 3, 3), n0=(*points, 3))
    if not tangent:
        del shapes["tangent"]
    to = _outputs(out, shapes, {"F": F, "state.G": G, "state.stretch": stretch, "state.n0": n0})
    failures = _core.update(
        muscle._props(activation), F, G, stretch, n0, dt, _MEASURES[measure], int(threads), to["stress"],
        to.get("tangent"), *(to[name] for name in _OUTPUTS[2:]))
    if failures and raise_on_failure:
        status = to["status"]
        point = tuple(int(i) for i in np.unravel_index(int((status != Status.OK).argmax()), points))
        more = f" ({failures - 1} more of {status.size} points failed)" if failures > 1 else ""
        raise MyogrowthError(int(status[point]), point, _why(int(status[point]), F[point], G[point], stretch[point],
                                                             n0[point]) + more)
    return Step(to["stress"], to.get("tangent"), to["energy"], State(G=to["G"], stretch=to["stretch"], n0=to["n0"]),
                to["lambda_e"], to["J"], to["Je"], to["status"])


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


def simulate(muscle: Parameters, time: ArrayLike, stretch: ArrayLike, *, G: float = 1.0,
             activation: float = 0.0) -> History:
    """A strip of muscle pulled along its fibre, sides free of force: growth and stress over a history of stretch.

    time: (n,), increasing [time]. stretch: (n,), or one number, the total fibre stretch at these times [-]. The steps
    are those between the times, and the first time is the start: nothing has grown there yet. G: the sarcomere number
    at the start. activation: of an elastic law, from 0 to 1, constant over the history.

    Backward Euler is of first order: halve the steps to see their error, or take integration="midpoint_flow".
    MyogrowthError names the row (`point`) that has no result.
    """
    if not isinstance(muscle, Parameters):
        raise TypeError(f"muscle: must be Parameters, is {_shown(muscle)}")
    time = _array("time", time).copy()  # the history keeps its own
    if time.ndim != 1 or time.size == 0:
        raise ValueError(f"time has shape {time.shape}: must be (n,), n >= 1")
    wrong = ~np.isfinite(time)
    wrong[1:] |= ~(time[1:] > time[:-1])
    for i in np.flatnonzero(wrong):
        after = f" after {time[i - 1]:g}" if i else ""
        raise ValueError(f"time: must be finite and increase from entry to entry, is {time[i]:g}{after} in entry {i}")
    stretch = _array("stretch", stretch)
    if stretch.shape not in ((), time.shape):
        raise ValueError(f"stretch has shape {stretch.shape}: must be one number, or {time.shape} as time")
    stretch = np.ascontiguousarray(np.broadcast_to(stretch, time.shape))
    for i in np.flatnonzero(~_positive(stretch)):
        raise MyogrowthError(Status.BAD_ARGUMENT, (int(i),), f"stretch = {stretch[i]:g}: must be finite and > 0")
    G = _number("G", G)
    if not _positive(G):
        raise MyogrowthError(Status.BAD_STATE, None, f"G = {G:g}: must be > 0 and finite")
    rows, status, done = _core.simulate(muscle._props(activation), np.ascontiguousarray(time), stretch, G)
    if status != Status.OK:
        text = "a result is beyond the range of double" if status == Status.NOT_FINITE else _core.status_text(status)
        raise MyogrowthError(status, (done,), f"stretch = {stretch[done]:g} at time {time[done]:g}: {_by_name(text)}")
    G_, lambda_e, lateral, cauchy, J = rows.T
    return History(time, stretch, G_, lambda_e, lateral, cauchy * J / stretch, cauchy, J)
