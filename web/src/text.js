// Texts and numbers: what a text means as a number, and how both look in messages (examples/common/rows.hpp).

/** What is wrong with an input. row, field: where, counted from 0, for editors. */
export class InputError extends Error {}

/** Runs f. Returns what it finds wrong with the inputs; "": nothing. */
export function faultOf(f) {
  try {
    f();
    return "";
  } catch (e) {
    if (!(e instanceof InputError)) throw e;
    return e.message;
  }
}

/** The bytes of a file as a string. */
export function bytesOf(buffer) {
  const parts = [], bytes = new Uint8Array(buffer);
  for (let i = 0; i < bytes.length; i += 8192) parts.push(String.fromCharCode(...bytes.subarray(i, i + 8192)));
  return parts.join("");
}

/** A text as a string whose characters are its bytes in UTF-8. */
export function toBytes(text) {
  let bytes = "";
  for (const b of new TextEncoder().encode(text)) bytes += String.fromCharCode(b);
  return bytes;
}

export function fromBytes(bytes) {
  return new TextDecoder("utf-8", {fatal: true}).decode(Uint8Array.from(bytes, (c) => c.charCodeAt(0)));
}

/** A text as it can be seen in a message. */
export function visible(bytes) {
  let seen = "";
  for (let i = 0; i < bytes.length; ++i) {
    if (i === 60) return `${seen}... (${bytes.length} bytes)`;
    const c = bytes[i];
    if (c === "\t") seen += "\\t";
    else if (c >= " " && c <= "~") seen += c;
    else seen += "\\x" + c.charCodeAt(0).toString(16).padStart(2, "0");
  }
  return seen;
}

/** A number in a message, with at most ten digits. */
export function textOf(x) {
  return String(Number(x.toPrecision(10)));
}

/** A whole text as a finite decimal number; NaN if it is none. */
export function toNumber(text) {
  const digits = text.length > 1 && text[0] === "+" && text[1] !== "-" ? text.slice(1) : text;
  if (!/^-?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(digits)) return NaN;
  const x = Number(digits);
  return isFinite(x) && (x !== 0 || !/[1-9]/.test(digits.split(/e/i)[0])) ? x : NaN;
}

/** What may be meant by a text that is no number, to be put after it. */
export function hint(text) {
  const parts = text.split(",");
  if (parts.length === 2 && !Number.isNaN(toNumber(parts.join(".")))) return `: decimal comma? write ${parts.join(".")}`;
  if (text.includes(";")) return ": semicolons do not separate fields; decimals need a point, as 0.5";
  if (text.includes("\t")) return ": tabs do not separate fields";
  if (text.includes(" ")) return ": blanks do not separate fields";
  if (text.includes('"')) return ": write it without quotes";
  if (/^-?(\d+\.?\d*|\.\d+)e[+-]?\d+$/i.test(text) && Number.isNaN(toNumber(text))) return ": beyond the range of double";
  return "";
}
