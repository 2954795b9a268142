// The measurements of examples/identification/example.csv, brought in by web/build.py.
export const EXAMPLE = EXAMPLE_CSV; // eslint-disable-line no-undef
