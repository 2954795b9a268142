"""Curves of the law without a finite-element code: six weeks of a muscle strip, and fibres in all directions at once.

    ./run python          # builds the module, then runs this

or, with the module on PYTHONPATH:  python3 six_weeks.py [FOLDER]
"""
import pathlib
import sys

import matplotlib
import numpy as np

import myogrowth

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "common"))
import files  # noqa: E402  shared by all examples

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402


def main(folder):
    picture = files.make_folder(folder) / "six_weeks.png"
    files.remove([picture])
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")

    # A strip pulled by 10 % along its fibre, in ramps of different length, its sides free; days and kPa.
    muscle = myogrowth.Parameters(integration="midpoint_flow")
    time = np.linspace(0, 42, 4201)
    for ramp in (0.5, 1, 2, 7):
        h = myogrowth.simulate(muscle, time, 1 + 0.1 * np.minimum(time / ramp, 1))
        print(f"ramp of {ramp:3g} days: lambda_e peaks at {h.lambda_e.max():.4f} and ends at {h.lambda_e[-1]:.4f}, "
              f"G ends at {h.G[-1]:.4f}, the force at {h.force[-1] / h.force.max():.0%} of its peak")
        left.plot(time, h.lambda_e, label=f"{ramp:g} days")
        middle.plot(time, h.force)
    left.set(xlabel="time [days]", ylabel="relative sarcomere length λe", xlim=(0, 14))
    left.legend(title="ramp to 10 %", frameon=False)
    middle.set(xlabel="time [days]", ylabel="force per reference area [kPa]", xlim=(0, 14))

    # One block of muscle stretched by 10 % along x at constant volume; 91 fibre directions in one call, day by day.
    angle = np.radians(np.arange(91))
    n0 = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    F = np.broadcast_to(np.diag([1.1, 1.1**-0.5, 1.1**-0.5]), (angle.size, 3, 3))
    state = myogrowth.State(n0=n0)
    for day in range(1, 43):
        state = myogrowth.update(muscle, F, 1.0, state).state
        if day in (1, 7, 42):
            right.plot(np.degrees(angle), state.G, label=f"day {day}")
    right.set(xlabel="angle of fibre and pull [degrees]", ylabel="sarcomere number G", xlim=(0, 90))
    right.legend(frameon=False)

    with files.writing(picture) as part:
        figure.savefig(part, dpi=120)
    print(picture)


if __name__ == "__main__":
    with files.faults_in_one_line("six_weeks.py"):
        main(sys.argv[1] if len(sys.argv) > 1 else "out/python")
