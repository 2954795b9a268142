"""Decks for CalculiX of the cylinder: held at one end, pulled at the other, in legs that restart one from another.

Units: mm, kPa, mN, days. A leg ends at a time of output and is a job of its own; it starts from the restart file of
the leg before, so that a run which was interrupted goes on from its last whole leg.
"""
import math
from typing import NamedTuple

import numpy as np

import cylinder_mesh

C1, C2, TAU, GAMMA, G_MAX, LAMBDA_CRIT = 16.0, 4.0, 0.5, 2.0, 1.1, 1.01  # Table 1: kPa, kPa, days, -, -, -
NEVER = 1000.0  # an elastic stretch that the tendon does not reach, so that it does not grow
NEAR = 1e-3  # times of output that differ by less, relatively, are one
WEEKS = (7.0, 14.0, 28.0, 42.0)  # days of output, beside the end of the ramp
STATE = ["G", "lambda_e", "lambda", "J", "Je"]  # the first of STATEV; the fibre comes from PROPS
ENDS = ("clamped", "free", "tendon", "mixed")


class Case(NamedTuple):
    """What is simulated; the defaults are the paper's test."""

    size: str = "coarse"  # of cylinder_mesh.SIZES
    ends: str = "clamped"
    tendon_length: float = 20.0  # mm, of the stiff layer at either end; with ends = tendon
    tendon_stiffness: float = 100.0  # over that of the muscle
    pull: float = 40.0  # mm
    ramp: float = 1.0  # days
    duration: float = 42.0  # days
    tau: float = TAU  # days, time constant of growth
    fibre_angle: float = 0.0  # degrees from the axis, in the x-z plane
    energy: int = 0  # PROPS(11)
    integration: int = 1  # PROPS(12)


class Step(NamedTuple):
    """A *STEP: its length and its first and longest increment, in days; fields are written at its end or not at all."""

    period: float
    first: float
    longest: float
    output: bool


def fibre(case):
    """Unit vector of the fibres before the deformation."""
    angle = math.radians(case.fibre_angle)
    return np.array([math.sin(angle), 0.0, math.cos(angle)])


def tendon(case, mesh):
    """(elements,) true for those of the stiff layers at the ends: whole layers, as many at either end, whose middle is
    nearer to the end than the tendon's length. A middle at that length, to rounding, does not count."""
    layers = np.zeros(len(mesh.levels) - 1, dtype=bool)
    if case.ends == "tendon":
        heights = np.diff(mesh.levels)
        middle = mesh.levels[:-1] + heights / 2
        n = int(np.count_nonzero(middle < case.tendon_length - 1e-6 * heights))
        layers[:n] = layers[len(layers) - n:] = True
    return layers[mesh.layer_of_elements()]


def output_times(case):
    """Days: the end of the ramp, the weeks, the end. A week that is all but one of these would be a leg without length."""
    weeks = {day for day in WEEKS if (1 + NEAR) * case.ramp < day < case.duration / (1 + NEAR)}
    return sorted({case.ramp, case.duration} | weeks)


def leg_times(case):
    """(start, end) of every leg in days."""
    ends = output_times(case)
    return list(zip([0.0] + ends[:-1], ends))


def steps_of_leg(case, start, end, end_layer):
    """The two steps of a leg: all its increments but the last, and the last, the only one that writes the fields.

    end_layer [mm]: height of the last layer. CalculiX starts its iterations with all of the first displacement in that
    layer; a first increment of more than half its height can turn it inside out.
    """
    if start == 0:
        longest = min(case.ramp / 10, 2 * case.tau)  # so that a long ramp does not outrun the growth by a step
        first = min(longest, 0.4 * end_layer / abs(case.pull) * case.ramp)
    else:
        # Growth slows down the longer the muscle is held, and so may the steps.
        first, longest = (0.15 + 0.1 * (t - case.ramp) for t in (start, end))
    last = min(longest, (end - start) / 2)
    before = end - start - last
    first = min(first, before)
    return [Step(before, first, min(max(first, longest), before), False), Step(last, last, last, True)]


def planned_increments(s):
    """How many increments CalculiX takes for a step, by experience: from the third one on each is half as long again."""
    done, increment, count = 0.0, s.first, 0
    while s.period - done > 1e-6 * s.period:
        done += increment
        count += 1
        if count > 1:
            increment = min(1.5 * increment, s.longest)
    return count


def _lines(rows):
    return "\n".join(", ".join(map(str, row)) for row in rows)


def _set_of(kind, name, numbers):
    rows = (numbers[i:i + 12] for i in range(0, len(numbers), 12))
    return f"*{kind}, {kind}={name}\n{_lines(rows)}\n"


def _material(name, set_name, stiffness, lambda_crit, case):
    n = fibre(case)
    return f"""*MATERIAL, NAME={name}
*DEPVAR
{len(STATE)}
** c1, c2 [kPa], tau [days], gamma, G_max, lambda_crit, n0; frame, energy, integration
*USER MATERIAL, CONSTANTS=12
{C1 * stiffness:.12g}, {C2 * stiffness:.12g}, {case.tau:.12g}, {GAMMA:.12g}, {G_MAX:.12g}, {lambda_crit:.12g}, {n[0]:.15g}, {n[1]:.15g}
{n[2]:.15g}, 0., {case.energy}., {case.integration}.
*SOLID SECTION, ELSET={set_name}, MATERIAL={name}
"""


def _fixed(case, mesh):
    """The boundary conditions that stay as they are; the distal end's axial one is the steps'."""
    if case.ends != "free":
        return "PROXIMAL, 1, 3\n" + ("" if case.ends == "mixed" else "DISTAL, 1, 2\n")
    # The ends stay plane and may become thinner; one node holds the axis, another one on the x axis the turn about it.
    on_x = mesh.proximal[np.argmax(mesh.nodes[mesh.proximal, 0])]
    return f"PROXIMAL, 3, 3\n{mesh.proximal[0] + 1}, 1, 2\n{on_x + 1}, 2, 2\n"


def _state_in_restart_files(mesh):
    """CalculiX 2.20 leaves the state variables out of its restart files (G would be 1 again, without a word) unless the
    model has contact: so here is a node that never meets a face, 400 mm away."""
    return f"""** Contact that never happens: without it CalculiX 2.20 forgets the state variables in a restart
*SURFACE, NAME=NOWHERE_NODE, TYPE=NODE
{mesh.proximal[0] + 1}
*SURFACE, NAME=NOWHERE_FACE
{len(mesh.hexes) + len(mesh.wedges)}, S2
*SURFACE INTERACTION, NAME=NOWHERE
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
1., 1.
*CONTACT PAIR, INTERACTION=NOWHERE, TYPE=NODE TO SURFACE
NOWHERE_NODE, NOWHERE_FACE
"""


def model(case, mesh):
    """The part of the deck before the steps."""
    nodes = [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(mesh.nodes.tolist(), 1)]
    text, label = [f"""** myogrowth: biceps femoris as a cylinder, {len(mesh.hexes)} C3D8 and {len(mesh.wedges)} C3D6
** Units: mm, kPa, mN, days
*NODE, NSET=ALL
""", "\n".join(nodes) + "\n"], 1
    for kind, cells in (("C3D8", mesh.hexes), ("C3D6", mesh.wedges)):
        numbered = np.column_stack([label + np.arange(len(cells)), cells + 1]).tolist()
        text.append(f"*ELEMENT, TYPE={kind}, ELSET=ALL\n{_lines(numbered)}\n")
        label += len(cells)
    text.append(_set_of("NSET", "PROXIMAL", (mesh.proximal + 1).tolist()))
    text.append(_set_of("NSET", "DISTAL", (mesh.distal + 1).tolist()))
    stiff = tendon(case, mesh)
    text.append(_set_of("ELSET", "MUSCLE", (np.flatnonzero(~stiff) + 1).tolist()))
    text.append(_material("@ABAQUS_MYOGROWTH_CCX@MUSCLE", "MUSCLE", 1.0, LAMBDA_CRIT, case))
    if stiff.any():
        text.append(_set_of("ELSET", "TENDON", (np.flatnonzero(stiff) + 1).tolist()))
        text.append(_material("@ABAQUS_MYOGROWTH_CCX@TENDON", "TENDON", case.tendon_stiffness, NEVER, case))
    text.append(_state_in_restart_files(mesh))
    text.append(f"""*AMPLITUDE, NAME=PULL, TIME=TOTAL TIME
** time [days], share of the stretch
0., 0., {case.ramp:.10g}, 1., {case.duration + 1:.10g}, 1.
*BOUNDARY
{_fixed(case, mesh)}""")
    return "".join(text)


def step(case, s):
    """One *STEP. FREQUENCY is one setting for all requests in CalculiX, so fields are asked for in steps of their own;
    a card with nothing under it takes back what the step before asked for. The leg's last step writes the restart file."""
    fields = "*NODE FILE\nU, RF\n*EL FILE\nS, SDV\n*RESTART, WRITE\n" if s.output else "*NODE FILE\n*EL FILE\n"
    return f"""*STEP, NLGEOM, INC=1000
*STATIC
{s.first:.10g}, {s.period:.10g}, {1e-6 * s.period:.10g}, {s.longest:.10g}
*BOUNDARY, AMPLITUDE=PULL
DISTAL, 3, 3, {case.pull:.12g}
*EL PRINT, ELSET=ALL
SDV
*NODE PRINT, NSET=DISTAL, TOTALS=ONLY
RF
{fields}*END STEP
"""


def leg(case, mesh, number):
    """The deck of a leg, counted from 0; all but the first read <job>.rin, which is the <job>.rout of the leg before."""
    start, end = leg_times(case)[number]
    head = model(case, mesh) if number == 0 else "*RESTART, READ\n"
    steps = steps_of_leg(case, start, end, mesh.levels[-1] - mesh.levels[-2])
    return f"** Days {start:g} to {end:g}\n" + head + "".join(step(case, s) for s in steps)
