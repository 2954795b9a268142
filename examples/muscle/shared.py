"""What all examples share lies in ../common: `from shared import files`."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "common"))
import files  # noqa: E402, F401
