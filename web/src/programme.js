// A study among the page's parameters: its muscle, and its file.
import {PARAMETERS} from "./law.js";
import {paper} from "./model.js";
import {InputError, textOf} from "./text.js";

const REMOVAL = ["gamma_rev", "G_min", "lambda_crit_rev"];

/** The muscle of a study: the paper's or the page's parameters, and what the study sets; checked together. */
export function muscleOf(law, study, otherwise) {
  const muscle = Object.assign({}, otherwise, study.set), place = (name) => study.places[name] || study.name;
  const fault = law.fault(muscle);
  if (fault) throw new InputError(`${place(fault.symbol)}: ${fault.text}`);
  if (study.set.tau_rev > 0) {
    for (const name of REMOVAL) {
      if (study.set[name] === undefined)
        throw new InputError(`${place("tau_rev")}: tau_rev = ${textOf(study.set.tau_rev)}: expected ${name} to be set too, ` +
          "as all of removal's parameters");
    }
  }
  return muscle;
}

/**
 * A study as a file that ./run protocol reads: repeated rows are written out. muscle: the parameters that it shall have
 * there, where the paper's stand for what is not set; by default only what the study sets.
 */
export function csvOf(study, muscle = study.set) {
  const lines = [`title, ${study.title}`], standard = paper(), removal = muscle.tau_rev > 0;
  for (const name of PARAMETERS) {
    const wanted = muscle === study.set || muscle[name] !== standard[name] || (removal && REMOVAL.includes(name));
    if (muscle[name] !== undefined && wanted) lines.push(`set, ${name}, ${muscle[name]}`);
  }
  if (study.rest > 0) lines.push(`rest_length, ${study.rest}`);
  for (const m of study.moves) lines.push([m.kind, m.a, m.b, m.c, m.d].filter((x) => x !== undefined).join(", "));
  return lines.join("\n") + "\n";
}
