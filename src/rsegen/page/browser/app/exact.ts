/* Numbers as they are: JSON in which no integer is rounded, and numbers that people type in any locale.

   A seed has up to 63 bits, a number of JavaScript 53: JSON.parse would silently open another map. */

import type { Json } from "./protocol";

const MARK = "\u0000integer:"; // a recipe has no NUL in its texts
const STRING_OR_NUMBER = /"(?:[^"\\]|\\.)*"|-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?/g;
const LONG = /^-?\d{16,}$/;

/* Parse JSON, with integers of 16 digits or more as bigint. */
export function read<T>(text: string): T {
  if (!/[:,[]\s*-?\d{16}/.test(text)) return JSON.parse(text) as T;
  const marked = text.replace(STRING_OR_NUMBER, (part) => (LONG.test(part) ? JSON.stringify(MARK + part) : part));
  return JSON.parse(marked, (_key, value: unknown) => {
    if (typeof value !== "string" || !value.startsWith(MARK)) return value;
    const number = BigInt(value.slice(MARK.length));
    return Number.isSafeInteger(Number(number)) ? Number(number) : number;
  }) as T;
}

/* Write JSON, with bigint as plain integers. */
export function written(value: object): string {
  const text = JSON.stringify(value, (_key, part: unknown) => (typeof part === "bigint" ? MARK + part : part));
  return text.replace(/"\\u0000integer:(-?\d+)"/g, "$1");
}

const NUMBER = /^[+-]?(\d+([.,]\d*)?|[.,]\d+)(e[+-]?\d+)?$/i;

/* Read a number that somebody typed, with a point or a comma before its decimals; a text says why it cannot be read.

   1,000 is a thousand to one reader and one to another, so it is refused; so is what a number cannot hold. */
export function typed(text: string, whole: boolean): number | bigint | string {
  const given = text.trim().replace("−", "-");
  if (!given) return "enter a number";
  if (!NUMBER.test(given)) return `'${given}' is not a number: write ${whole ? "7" : "7.5 or 7,5"}, without thousands separators`;
  if (whole) {
    if (!/^[+-]?\d+$/.test(given)) return `'${given}' is not a whole number`;
    const number = BigInt(given.replace("+", ""));
    return Number.isSafeInteger(Number(number)) ? Number(number) : number;
  }
  if (/^[+-]?[1-9]\d{0,2},\d{3}$/.test(given)) {
    return `'${given}' can be read in two ways: write ${given.replace(",", "")} or ${given.replace(",", ".")}`;
  }
  const digits = given.replace(/e.*$/i, "").replace(/\D/g, "").replace(/^0+/, "");
  if (digits.replace(/0+$/, "").length > 15) return `'${given}' has more than 15 digits`;
  const number = Number(given.replace(",", "."));
  return Number.isFinite(number) ? number : `'${given}' is too large`;
}

/* Read numbers that are separated by spaces or semicolons; of whole numbers also by commas. */
export function typedList(text: string, whole: boolean): (number | bigint)[] | string {
  const parts = text.trim().split(whole ? /[\s;,]+/ : /\s*;\s*|,?\s+/).filter(Boolean);
  const numbers = parts.map((part) => typed(part, whole));
  const problem = numbers.find((each) => typeof each === "string");
  if (problem !== undefined) return problem as string;
  return numbers as (number | bigint)[];
}

/* Write a value into a text field, with all its digits. */
export function shown(value: Json | undefined): string {
  if (value === null || value === undefined) return "";
  if (Array.isArray(value)) return value.map(shown).join(" ");
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}

/* Multiply a number by a whole one without the dust of binary fractions: 3 x 0.1 is 0.3. */
export function times(value: number, count: number): number {
  return Number((value * count).toPrecision(12));
}

/* Return whether two values of a recipe are equal. */
export function equal(one: Json | undefined, other: Json | undefined): boolean {
  if (one === other) return true;
  return one !== undefined && other !== undefined && written({ value: one }) === written({ value: other });
}
