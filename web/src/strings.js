// Every text of the page, in one place. Texts with values are functions.
const g = (x, n = 4) => String(Number(x.toPrecision(n)));

export const S = {
  title: "Muscle growth under stretch",
  lead: "A muscle that is held stretched adds sarcomeres in series until each is back near its normal length. How far, " +
    "how fast, in which steps, for how long? This page computes the model of Javadi et al. (after Zöllner et al. 2012).",
  standing: "This is a model and no medical advice. Its parameters are uncertain, and no curve here is a promise for a " +
    "patient.",
  footer: (version) => `myogrowth ${version}. Computed in your browser by the compiled library; nothing is sent anywhere. ` +
    "BSD-3-Clause. Charts: uPlot, MIT.",
  noLaw: (why) => `The law could not be started: ${why}. This page needs a browser with WebAssembly.`,
  tabs: {play: "Play", compare: "Compare", design: "Design", uncertainty: "Uncertainty", fit: "Fit"},
  views: "Views",
  link: "Copy link",
  linkCopied: "The link is in the address bar and, if the browser allows it, in the clipboard.",
  linkFaults: "This link has entries that are not used:",
  linkEntry: (key, value, expected) => `${key} = ${value}: expected ${expected}.`,
  noTendon: "this page computes muscle without a tendon; ./run protocol and ./run fit take it",
  unknownEntry: "one of the page's names",
  givenTwice: "only once; the first is used",
  fourProgrammes: "at most four programmes",
  linkOrder: "expected LOW < HIGH.",
  linkTooLong: "The inputs are too long for a link: save the programmes as CSV, and keep the measurements in a file.",
  noResult: (why) => `There is no result for these inputs: ${why.replace(/\.$/, "")}.`,
  tooManySteps: (most) => `more than ${most} time steps: expected fewer rows, or less change of stretch`,
  printed: (values) => `Parameters of the muscle: ${values}.`,
  number: (least, most) => `a number from ${g(least, 10)} to ${g(most, 10)}`,
  anyNumber: "a number",
  expected: (label, what, found, hint) => `${label}: expected ${what}, found '${found}'${hint}.`,
  slider: (label) => `${label}, slider`,

  muscle: {
    heading: "Muscle",
    preset: "Parameters of",
    own: "your own values",
    removal: "Removal of sarcomeres (off where tau_rev is 0)",
    source: (text) => `Source: ${text}`,
    symbols: {c1: "c₁", c2: "c₂", tau: "τ", gamma: "γ", G_max: "G_max", lambda_crit: "λ_crit", tau_rev: "τ_rev",
      gamma_rev: "γ_rev", G_min: "G_min", lambda_crit_rev: "λ_crit,rev"},
    units: {stress: "kPa", time: "days", "-": "–"},
  },

  curves: {
    time: "time [days]", stretch: "stretch λ [–]", lambda_e: "elastic stretch λe [–]",
    G: "sarcomeres in series G [–]", force: "force per area [kPa]",
    short: {stretch: "λ", lambda_e: "λe", G: "G", force: "force"},
    dashes: ["———", "– – –", "· · · ·", "— · —"],
    day: "day", band: "5 to 95 %", median: "median", low: "5 %", high: "95 %",
    summary: (title, name, first, last, least, most) => `${title}, ${name}: begins at ${g(first)}, ends at ${g(last)}, ` +
      `between ${g(least)} and ${g(most)}.`,
  },

  play: {
    heading: "One stretch",
    stretch: "Stretch", ramp: "Ramp", hold: "Hold, then release", days: "Duration",
    stretchUnit: "× rest", daysUnit: "days",
    bands: "Show the band of uncertain parameters (ranges: tab Uncertainty)",
    noBand: (why) => `No band, because of a range in the tab Uncertainty: ${why}`,
    numbers: "Exact solution",
    peak: "Peak of λe", peakDay: "reached on day",
    returned: (percent) => `λe below 1 + ${percent} % from day`,
    finalG: "G at the end", finalLambda: "λe at the end",
    never: "not within the duration", always: "always",
    picture: "Sarcomeres in series",
    day: "Day to look at", animate: "Run", stop: "Stop",
    at: (day, lambda, e, G, force) => `Day ${day.toFixed(2)}: λ ${lambda.toFixed(4)}, λe ${e.toFixed(4)}, ` +
      `G ${G.toFixed(4)}, force ${force.toFixed(3)} kPa`,
    drawn: (n, added) => `${n.toFixed(1)} sarcomeres are drawn, 12 at the beginning${added > 0.05
      ? `, ${added.toFixed(1)} of them new` : ""}. The bar is the length at rest.`,
    tooMany: (n, most) => `Of ${g(n)} sarcomeres, 12 at the beginning, ${most} are drawn. The bar is the length at rest.`,
  },

  compare: {
    heading: "Programmes side by side",
    add: "Add a programme", remove: "Remove programme", open: "Open CSV files",
    drop: "Or drop the CSV files of ./run protocol anywhere on this page.",
    programme: (n) => `Programme ${n}`, programmeTitle: "Name", rest: "Length at rest [mm]",
    kinds: {step: "step", ramp: "ramp", hold: "hold", distract: "distract", cycle: "cycle", repeat: "repeat"},
    fields: {
      step: ["to stretch"], ramp: ["to stretch", "within days"], hold: ["days"], distract: ["mm a day", "days"],
      cycle: ["to stretch", "hours", "every days", "for days"],
      repeat: ["last rows", "times in all"],
    },
    kind: "What to do", addRow: "Add a row", removeRow: (n) => `Remove row ${n}`, row: (n) => `Row ${n}`,
    own: (text) => `Its own parameters: ${text}.`, ownOf: (title, text) => `${title}, its own parameters: ${text}.`,
    useMine: "Use the page's parameters",
    limit: "Limit of λe", within: "Returned below 1 +",
    columns: ["programme", "lengthened by day", "peak λe", "on day", "days above limit", "dose above it [days]",
      "returned on day", "peak force [kPa]", "G at the end"],
    never: "never", always: "always",
    csv: "Save curves as CSV", programmes: "Save programmes as CSV", png: "Save PNG", svg: "Save SVG",
    textWithout: "a text without #, which begins a comment in files",
    tooLarge: (most) => `more than ${most} MB: expected a programme as CSV`,
    unreadable: "cannot be read: expected files, not folders",
    full: "There are four programmes already: remove one before you add another.",
    sameName: (name) => `${name}: already here; it was replaced.`,
    example: "1 mm a day for 8 days", stepExample: "at once",
    noRows: "expected a row step, ramp, hold or distract",
    limitLine: "limit", returnLine: "returned",
  },

  design: {
    heading: "The fastest admissible programme",
    target: "Target stretch", limit: "Limit of λe", rest: "Length at rest", mm: "mm",
    result: (mm, rest) => `${g(mm)} mm more than ${g(rest)} mm.`,
    rows: ["programme", "days", "peak λe"],
    fastest: "fastest: at once to the limit, then along it", daily: "in steps once a day, up to the limit each",
    ramp: "at a constant rate, the shortest that is admissible",
    notArrive: "not within 3650", tooSlow: "more than 100 times the fastest",
    schedule: "Schedule, day by day",
    columns: ["day", "fastest: stretch", "mm", "mm this day", "daily steps: stretch", "mm", "mm this day"],
    print: "Print", csv: "Save schedule as CSV",
    nothingGrows: (limit, crit) => `Limit of λe = ${g(limit)}: expected more than 1 and than λ_crit = ${g(crit)}, or ` +
      "nothing grows.",
    tooLong: (days, most) => `The fastest way takes ${days} days, more than the ${most} that are planned here. Allow a ` +
      "larger λe, or ask for less.",
    beyond: (target, limit, G_max, need) => `No programme reaches stretch ${g(target)} with λe ≤ ${g(limit)}: the muscle ` +
      `grows to G_max = ${g(G_max)} at most, and so to stretch ${g(limit * G_max)}. Allow λe > ${need}, or ask for less.`,
    lines: {fastest: "fastest", daily: "daily steps"},
  },

  uncertainty: {
    heading: "What the ranges of the parameters make of one stretch",
    explain: "Every history has its own parameters, drawn evenly and independently from these ranges. The stretch is that " +
      "of the tab Play. The ranges are an assumption: half of each value around the muscle's, 0.01 for λ_crit. Replace them " +
      "by your own.",
    ranges: "Ranges", follow: "Ranges around the muscle's values",
    low: (name) => `${name}, from`, high: (name) => `${name}, to`, parameter: "parameter", from: "from", to: "to",
    histories: "Histories", run: "Compute",
    order: (name, low, high) => `${name}: expected from ≤ to, found ${g(low)} and ${g(high)}.`,
    speed: (n, ms) => `${n} histories in ${(ms / 1000).toFixed(2)} s: ${Math.round(n / ms * 1000)} a second.`,
    working: (done, n) => `${done} of ${n} histories …`,
    columns: ["result", "5 %", "median", "95 %"],
    peak: "peak λe", returned: "λe below 1.03 from day", force: "peak force [kPa]", G: "G at the end",
    never: "not within the duration", always: "always",
  },

  fit: {
    heading: "Which τ and λ_crit do measurements support?",
    data: "Measurements: rows of day, value, standard deviation; or a whole file of ./run fit",
    hint: "value is the relative sarcomere length λe, or a length in µm if the length at rest is given",
    rest: "Sarcomere length at rest", restUnit: "µm; 1: values are relative",
    history: "The history of stretch is that of the tab Play, unless the rows have their own (step, ramp, hold).",
    bounds: "Search between", run: "Fit", example: "Put in the example",
    file: "the rows",
    columns: ["parameter", "estimate", "sd", "95 % by curvature", "95 % by profile", "searched"],
    open: "open", interval: (a, b) => `${a} to ${b}`,
    sum: (n, chi2, agreeing, starts) => `${n} measurements, χ² = ${chi2.toFixed(3)}; ${agreeing} of ${starts} starts end ` +
      "there.",
    use: "Use these values as the muscle's",
    misses: (chi2, n) => `χ² = ${g(chi2)} for ${n} degrees of freedom: the law misses the data by more than their ` +
      "deviations, and the intervals are too narrow.",
    atBound: (name) => `${name} ends at a bound: its interval by curvature means nothing.`,
    unbounded: (name) => `The data do not bound ${name} on both sides of the range that is searched.`,
    few: "Fewer than three measurements can hardly decide two parameters.",
    one: "Only one of the starts ends at this fit: there may be better ones.",
    noMeasurements: (name) => `${name}: expected rows of day, value, standard deviation`,
    noHistory: (name) => `${name}: expected a row step, ramp, hold or distract`,
    tooMany: (n, most) => `${n} measurements: expected at most ${most} here; ./run fit takes more`,
    tooLong: (n, most) => `the history takes ${n} time steps: expected at most ${most} here; ./run fit takes more`,
    bound: (name, why) => `Search between, ${name}: ${why}`,
    order: (name, low, high) => `${name}: expected from < to, found ${g(low)} and ${g(high)}.`,
    beyond: (end, last) => `The history ends on day ${g(end)}, before the last measurement, on day ${g(last)}: its last stretch ` +
      "is taken to stay.",
    onlyTwo: (name) => `${name}: this page fits tau and lambda_crit; ./run fit takes all four`,
    measured: "measured", law: "the law",
  },
};
