// The law: the C API of abi/myogrowth.h, compiled to WebAssembly. Every number of the page comes from here.
import {InputError} from "./text.js";

const N_STATE = 9, MESSAGE = 400, FIRST_PIOLA = 1;

/** The names and the order of the parameters of a muscle; the other entries of PROPS are options. */
export const PARAMETERS = ["c1", "c2", "tau", "gamma", "G_max", "lambda_crit", "tau_rev", "gamma_rev", "G_min",
  "lambda_crit_rev"];

/** Compiles the law from base64; a Promise of a Law. */
export async function load(base64) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const module = await WebAssembly.compile(bytes), wasi = {};
  // libc's printf asks for files; there are none here (8: bad file).
  for (const {name} of WebAssembly.Module.imports(module)) wasi[name] = () => 8;
  const instance = await WebAssembly.instantiate(module, {wasi_snapshot_preview1: wasi});
  instance.exports._initialize();
  return new Law(instance.exports);
}

class Law {
  constructor(wasm) {
    this.wasm = wasm;
    const doubles = (n) => wasm.malloc(8 * n);
    this.nProps = wasm.myogrowth_n_props();
    this.at = {props: doubles(this.nProps), state: doubles(N_STATE), F: doubles(9), stress: doubles(9),
      lateral: doubles(1), growth: doubles(4), message: wasm.malloc(MESSAGE), symbol: wasm.malloc(64)};
    this.table = [];
    for (let i = 0; i < this.nProps; ++i) {
      const text = (name) => this.text(wasm["myogrowth_prop_" + name](i));
      this.table.push({symbol: text("symbol"), unit: text("unit"), meaning: text("meaning"), allowed: text("allowed"),
        initial: wasm.myogrowth_prop_default(i)});
    }
    this.index = {};
    this.table.forEach((entry, i) => { this.index[entry.symbol] = i; });
    this.version = this.text(wasm.myogrowth_version_text());
    this.memory = new Float64Array(wasm.memory.buffer);
  }

  /** A text of C. */
  text(address) {
    const bytes = new Uint8Array(this.wasm.memory.buffer);
    return new TextDecoder().decode(bytes.slice(address, bytes.indexOf(0, address)));
  }

  view(address, n) {
    if (this.memory.buffer !== this.wasm.memory.buffer) this.memory = new Float64Array(this.wasm.memory.buffer);
    return this.memory.subarray(address / 8, address / 8 + n);
  }

  /** Writes PROPS of a muscle, {c1: 16, ...}; midpoint: the exact flow instead of backward Euler. */
  setProps(muscle, midpoint) {
    const props = this.view(this.at.props, this.nProps);
    this.table.forEach((entry, i) => { props[i] = Number.isNaN(entry.initial) ? 0 : entry.initial; });
    for (const name of PARAMETERS) if (muscle[name] !== undefined) props[this.index[name]] = muscle[name];
    props[this.index.integration] = midpoint ? 1 : 0;
  }

  /** What is wrong with a muscle, {symbol, text}; null if nothing is. */
  fault(muscle) {
    this.setProps(muscle, true);
    if (this.wasm.myogrowth_check(this.at.props, this.nProps, this.at.message, MESSAGE) === 0) return null;
    const said = this.text(this.at.message), found = /^PROPS\((\d+)\) = (\S+): /.exec(said);
    if (!found) return {symbol: "", text: said};
    const entry = this.table[Number(found[1]) - 1];
    return {symbol: entry.symbol, text: `${entry.symbol} = ${found[2]}: must be finite and ${entry.allowed}.`};
  }

  setState(G, lambda) {
    const state = this.view(this.at.state, N_STATE);
    state.fill(0);
    state[0] = G;
    state[1] = lambda / G;
    state[2] = lambda;
    return state;
  }

  /** One step of a strip with free sides; the state is in memory. Returns the status. */
  uniaxial(stretch, dt) {
    const at = this.at;
    return this.wasm.myogrowth_uniaxial(at.props, this.nProps, stretch, at.state, at.state, N_STATE, dt, at.lateral,
      at.stress, 0, 0, at.message, MESSAGE);
  }

  /** Steps of growth only: a function (G, stretch, dt) that gives the new G. */
  stepper(muscle, midpoint) {
    this.setProps(muscle, midpoint);
    const at = this.at, state = this.setState(1, 1), F = this.view(at.F, 9), update = this.wasm.myogrowth_update;
    F.set([1, 0, 0, 0, 1, 0, 0, 0, 1]);
    return (G, stretch, dt) => {
      state[0] = G;
      state[2] = F[0] = stretch;
      const status = update(at.props, this.nProps, at.F, at.state, at.state, N_STATE, dt, FIRST_PIOLA, at.stress, 0, 0,
        at.message, MESSAGE);
      if (status !== 0) this.fail(`stretch ${stretch}`);
      return state[0];
    };
  }

  fail(what) {
    throw new InputError(`${what}: ${this.text(this.at.message)}`);
  }

  /** A strip with free sides through the points {time, stretch}, by the exact flow at the middle of every step. */
  pull(muscle, points) {
    const n = points.time.length, run = {time: points.time, stretch: points.stretch};
    for (const name of ["G", "lambda_e", "force", "lateral"]) run[name] = new Float64Array(n);
    this.setProps(muscle, true);
    const state = this.setState(1, points.stretch[0]), lateral = this.view(this.at.lateral, 1);
    const stress = this.view(this.at.stress, 1);
    lateral[0] = 1;
    for (let i = 0; i < n; ++i) {
      const dt = i > 0 ? points.time[i] - points.time[i - 1] : 0, lambda = points.stretch[i];
      if (this.uniaxial(lambda, dt) !== 0) this.fail(`stretch ${lambda} on day ${points.time[i]}`);
      run.G[i] = state[0];
      run.lambda_e[i] = state[1];
      run.force[i] = stress[0] * state[3] / lambda;
      run.lateral[i] = lateral[0];
    }
    return run;
  }

  /** G at the points: backward Euler in whole and in half steps, extrapolated, as ./run fit computes it. */
  grow(muscle, points) {
    const n = points.time.length, whole = new Float64Array(n), halves = new Float64Array(n);
    const go = this.stepper(muscle, false);
    whole[0] = halves[0] = 1;
    for (let i = 1; i < n; ++i) {
      const dt = points.time[i] - points.time[i - 1], lambda = points.stretch[i];
      whole[i] = go(whole[i - 1], lambda, dt);
      const half = go(halves[i - 1], (lambda + points.stretch[i - 1]) / 2, dt / 2);
      halves[i] = go(half, lambda, dt / 2);
    }
    return halves.map((G, i) => 2 * G - whole[i]);
  }

  /** G after a time dt at a stretch that is held: the exact flow. */
  flow(muscle, G, stretch, dt) {
    return this.stepper(muscle, true)(G, stretch, dt);
  }

  /** The fastest admissible protocol: G on day t, and the day of a stretch (examples/protocols/ride.hpp). */
  ride(muscle, limit) {
    const set = () => this.view(this.at.growth, 4).set([muscle.tau, muscle.gamma, muscle.G_max, muscle.lambda_crit]);
    return {
      G: (t) => { set(); return this.wasm.ride_G(this.at.growth, limit, t); },
      day: (stretch) => { set(); return this.wasm.ride_day(this.at.growth, limit, stretch); },
    };
  }
}
